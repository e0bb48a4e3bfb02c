"""Events of a clip's own: what a detector must not be charged with, nor credited for.

The rule, stated once. In a clip where nothing was injected an event is

* an *interval* that a detector finds at its automatic τ, an *open* one too: P and C turn against
  each other;
* a *flip*, by what the consistency detector expects: P or C alone turns about the bone by
  FLIP_DEGREES and FLIP_SIGMA local scales more in one frame than its neighbours let expect. No limb
  does that; the capture's solver does, or Euler angles that pass a gimbal lock. The other joint
  does not make up for it, so it is no twist error in the sense of [Choi26], never an interval;
* a *limb flip* that is found at the automatic τ: P turns about the line to the limb's end E.

A chain or limb is *audited* in a clip if it has no event there. A limb's flip counts for the chains
that share P or E with it as well, and an event of theirs for the limb: it alters the same joints.
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
# Of 40 CMU clips: the arms' fastest swings reach 38° (05_02, 661); flips are of 60-180°.
FLIP_DEGREES, FLIP_SIGMA = 60.0, 10.0


@dataclass(frozen=True)
class NaturalEvent:
    """An event that nobody injected: frames [start, stop) of a chain or limb.

    kind: 'interval', 'open', 'flip' or 'limb flip'; degrees: of the flip about the bone, or the
    interval's offset; joint: P or C, whichever flips, or P for an interval or a limb.
    """

    chain: str
    kind: str
    start: int
    stop: int
    degrees: float
    joint: int

    def to_json(self) -> dict[str, Any]:
        """The event by name."""
        return {k: v for k, v in vars(self).items() if k != "joint"}


def natural_events(chains: Sequence[Chain], analysis: Analysis) -> list[NaturalEvent]:
    """All events of an un-injected clip by the rule above, by chain."""
    events: list[NaturalEvent] = []
    for chain in chains:
        for i in analysis.intervals(chain.name, analysis.automatic_tau(chain.name)):
            kind, degrees = "open" if i.open else "interval", _degrees(i.delta)
            events.append(NaturalEvent(chain.name, kind, i.start, i.stop, degrees, chain.parent))
        if isinstance(analysis, ConsistencyAnalysis):
            events += flips(chain, analysis.chains[chain.name])
        if isinstance(analysis, NotatedAnalysis):
            kept = analysis.kept
            events += [
                replace(e, start=kept.end(e.start), stop=kept.end(e.start) + 1)
                for e in flips(chain, analysis.coarse.chains[chain.name])
            ]
    return events


def limb_flips(limbs: Sequence[Limb], found: Iterable[Interval]) -> list[NaturalEvent]:
    """Flips of limbs among the intervals found in an un-injected clip."""
    parent = {limb.name: limb.parent for limb in limbs}
    return [
        NaturalEvent(i.chain, i.kind.value, i.start, i.stop, _degrees(i.delta), parent[i.chain])
        for i in found
        if i.kind == Kind.LIMB_FLIP
    ]


def with_events(
    skeleton: Skeleton,
    chains: Sequence[Chain],
    limbs: Sequence[Limb],
    events: Iterable[NaturalEvent],
) -> frozenset[str]:
    """Names of the chains and limbs that are not audited, by the rule above."""
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


def flips(chain: Chain, analysis: ChainAnalysis) -> Iterator[NaturalEvent]:
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
            yield NaturalEvent(chain.name, FLIP, t, t + 1, _degrees(residual[t]), joint)


def _degrees(angle: float) -> float:
    return round(float(np.degrees(angle)), 3)
