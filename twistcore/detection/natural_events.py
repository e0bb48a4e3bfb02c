"""Find events in clips without injected errors, which must not be counted in a detector's score.

Such an event is

* an *interval* that a detector finds at its automatic τ, even an *open* one: a parent P and its
  child C twist in opposite directions;
* a *flip*: in one frame, P or C alone rotates about the bone by far more than the consistency
  detector expects from the neighbouring frames (by at least FLIP_DEGREES and FLIP_SIGMA times the
  local scale). No limb can do this, but the solver of a capture or Euler angles at a gimbal lock
  can. The other joint does not compensate for the rotation, so a flip is not a twist error in the
  sense of [Choi26] and is never an interval;
* a *limb flip* that is found at the automatic τ: the first joint P of a limb rotates about the line
  to the limb's end E.

A chain or limb is *audited* in a clip if it has no event there. A limb flip is also an event of the
chains that share P or E with the limb, and vice versa, since the same joints are affected.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from twistcore.detection import Analysis, Interval, Kind
from twistcore.detection.consistency.chain_analysis import ChainAnalysis, ConsistencyAnalysis
from twistcore.detection.consistency.notated import NotatedAnalysis
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton

FLIP = "flip"
# In 40 CMU clips, the fastest swings of arms reach 38° (clip 05_02, frame 661); flips have 60-180°.
FLIP_DEGREES, FLIP_SIGMA = 60.0, 10.0


@dataclass(frozen=True)
class NaturalEvent:
    """An event in a clip without injected errors, in frames [start, stop) of a chain or limb.

    Attributes
    ----------
    kind
        'interval', 'open', 'flip' or 'limb flip'.
    degrees
        The unexpected rotation in a flip, or the median offset of an interval or limb flip.
    joint
        The index of the joint that flips; for an interval or a limb flip, the parent joint.
    """

    chain: str
    kind: str
    start: int
    stop: int
    degrees: float
    joint: int

    def to_json(self) -> dict[str, Any]:
        """Return the event as a dict for JSON."""
        return {k: v for k, v in vars(self).items() if k != "joint"}


def natural_events(chains: Sequence[Chain], analysis: Analysis) -> list[NaturalEvent]:
    """Return the intervals and flips in a clip without injected errors as events, sorted by chain.

    Flips are found only with the analysis of the consistency detector.
    """
    events: list[NaturalEvent] = []
    for chain in chains:
        for i in analysis.intervals(chain.name, analysis.automatic_tau(chain.name)):
            kind, degrees = "open" if i.open else "interval", _degrees(i.delta)
            events.append(NaturalEvent(chain.name, kind, i.start, i.stop, degrees, chain.parent))
        if isinstance(analysis, ConsistencyAnalysis):
            events += chain_flip_events(chain, analysis.chains[chain.name])
        if isinstance(analysis, NotatedAnalysis):
            kept = analysis.kept
            events += [
                replace(e, start=kept.end(e.start), stop=kept.end(e.start) + 1)
                for e in chain_flip_events(chain, analysis.coarse.chains[chain.name])
            ]
    return events


def limb_flip_events(limbs: Sequence[Limb], found: Iterable[Interval]) -> list[NaturalEvent]:
    """Return the limb flips among the intervals `found`, as events."""
    parent = {limb.name: limb.parent for limb in limbs}
    return [
        NaturalEvent(i.chain, i.kind.value, i.start, i.stop, _degrees(i.delta), parent[i.chain])
        for i in found
        if i.kind == Kind.LIMB_FLIP
    ]


def chains_and_limbs_with_events(
    skeleton: Skeleton,
    chains: Sequence[Chain],
    limbs: Sequence[Limb],
    events: Iterable[NaturalEvent],
) -> frozenset[str]:
    """Return the names of chains and limbs that are affected by an event, so not audited."""
    own = {e.chain for e in events}
    out = set(own)
    for limb in limbs:
        ends = set(limb.changed_joints(skeleton))
        near = {c.name for c in chains if ends.intersection(c.changed_joints(skeleton))}
        if limb.name in own:
            out |= near
        elif near & own:
            out.add(limb.name)
    return frozenset(out)


def chain_flip_events(chain: Chain, analysis: ChainAnalysis) -> Iterator[NaturalEvent]:
    """Yield the flips of a chain's parent, then of its child (see the module docstring)."""
    c, row = analysis.limb, analysis.row
    alone = np.zeros(c.x.shape[1], dtype=bool)
    for table in analysis.tables:  # a cut is not a flip
        alone[table.low + 1 : table.high] = True
    alone &= ~c.event[row]
    for joint, residual, sigma in (
        (chain.parent, c.rx[row], c.sigma_x[row]),
        (chain.child, c.ry[row], c.sigma_y[row]),
    ):
        least = np.maximum(np.radians(FLIP_DEGREES), FLIP_SIGMA * sigma)
        for t in np.flatnonzero(alone & (np.abs(residual) >= least)).tolist():
            yield NaturalEvent(chain.name, FLIP, t, t + 1, _degrees(residual[t]), joint)


def _degrees(angle: float) -> float:
    return round(float(np.degrees(angle)), 3)
