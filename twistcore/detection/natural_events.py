"""Events of a clip's own: what a detector must not be charged with, nor credited for.

The rule, stated once. In a clip where nothing was injected an event is

* an *interval* that the consistency detector finds at its automatic τ, open ones included: P and C
  turn against each other;
* a *flip*: P or C alone turns about the bone by FLIP_DEGREES and FLIP_SIGMA local scales more in
  one frame than its neighbours let expect. No limb does that; the capture's solver does, or Euler
  angles that pass a gimbal lock. The other joint does not make up for it, so it is no twist error
  in the sense of [Choi26], and never an interval.

Evidence that is not the detector's: the joint's whole turn in that frame, beside the usual one.
A chain is *audited* in a clip if it has no event there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from twistcore.chain import Chain
from twistcore.detection.consistency import ChainAnalysis, ConsistencyDetector
from twistcore.motion import Motion
from twistcore.rotation import geodesic_angle

INTERVAL, FLIP = "interval", "flip"
# Of 40 CMU clips: the arms' fastest swings reach 38° (05_02, 661); flips are of 60-180°.
FLIP_DEGREES, FLIP_SIGMA = 60.0, 10.0
_USUAL_SECONDS = 0.1


@dataclass(frozen=True)
class NaturalEvent:
    """An event that nobody injected: frames [start, stop) of a chain; degrees.

    joint: P or C, whichever flips, or P for an interval; degrees: of the flip about the bone, or
    the interval's offset; turn: of the joint from frame start − 1 to start, about any axis;
    usual_turn: its median within 0.1 s; kind: 'interval' or 'flip'.
    """

    chain: str
    joint: int
    start: int
    stop: int
    degrees: float
    turn: float
    usual_turn: float
    kind: str


def natural_events(motion: Motion, chains: Sequence[Chain]) -> tuple[NaturalEvent, ...]:
    """All events of an un-injected clip by the rule above, by chain and frame."""
    analysis = ConsistencyDetector().analyse(motion, chains)
    events: list[NaturalEvent] = []
    for chain in chains:
        found = [
            Event(chain.parent, i.start, i.stop, i.delta, INTERVAL)
            for i in analysis.intervals(chain.name, analysis.automatic_tau(chain.name))
        ]
        found += flips(chain, analysis.chains[chain.name])
        events += [
            NaturalEvent(
                chain.name,
                joint,
                start,
                stop,
                float(np.degrees(angle)),
                *_turns(motion, joint, start),
                kind,
            )
            for joint, start, stop, angle, kind in sorted(found, key=lambda e: (e.start, e.stop))
        ]
    return tuple(events)


class Event(NamedTuple):
    """Joint, frames [start, stop), angle in radians, kind."""

    joint: int
    start: int
    stop: int
    angle: float
    kind: str


def flips(chain: Chain, analysis: ChainAnalysis) -> Iterator[Event]:
    """Flips of P, then of C, by the rule above."""
    c, row = analysis.limb, analysis.row
    alone = np.zeros(c.x.shape[1], dtype=bool)
    for table in analysis.tables:  # a cut is no flip
        alone[table.low + 1 : table.high] = True
    alone &= ~c.event[row]
    for joint, residual, sigma in (
        (chain.parent, c.rx[row], c.sigma_x[row]),
        (chain.child, c.ry[row], c.sigma_y[row]),
    ):
        least = np.maximum(np.radians(FLIP_DEGREES), FLIP_SIGMA * sigma)
        for t in np.flatnonzero(alone & (np.abs(residual) >= least)).tolist():
            yield Event(joint, t, t + 1, float(residual[t]), FLIP)


def _turns(motion: Motion, joint: int, t: int) -> tuple[float, float]:
    """Degrees that a joint turns into frame t, and the median of that within 0.1 s."""
    around = max(1, round(_USUAL_SECONDS * motion.fps))
    low, high = max(0, t - 1 - around), min(motion.frames, t + 1 + around)
    q = motion.rotations[low:high, joint]
    turns = np.degrees(geodesic_angle(q[:-1], q[1:]))
    if not len(turns):
        return 0.0, 0.0
    return float(turns[t - 1 - low]) if t > 0 else 0.0, float(np.median(turns))
