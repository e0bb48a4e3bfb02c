"""An exercise: errors hidden by a seed, and the score of a review that looked for them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from twistcore.chain import Chain, uncorrectable_joints
from twistcore.detection import Interval
from twistcore.motion import Motion
from twistcore.review import Decision, Judged
from twistcore.signals import twist_signals
from twistcore.study.evaluation import match_intervals
from twistcore.synthesis import PROTOCOLS, InjectedError, draw_errors, generator, inject

_LONGEST = 20  # frames of a decoy, as of an error of P0
_APART = 4  # frames between two of a chain
_CHOICE = 10  # one of so many liveliest moments, not always the very liveliest


@dataclass(frozen=True)
class Score:
    """What a review came to against the hidden errors.

    hits: errors accepted; misses: errors that no accepted interval covers; false_accepted:
    accepted where nothing was hidden; false_rejected: errors that were listed and rejected (these
    are misses as well); left: intervals without a verdict.
    """

    hits: tuple[InjectedError, ...]
    misses: tuple[InjectedError, ...]
    false_accepted: tuple[Interval, ...]
    false_rejected: tuple[Interval, ...]
    left: int

    @property
    def false_verdicts(self) -> int:
        """Verdicts that the truth contradicts."""
        return len(self.false_accepted) + len(self.false_rejected)


def hide_errors(
    motion: Motion, chains: Sequence[Chain], seed: int
) -> tuple[Motion, tuple[InjectedError, ...]]:
    """The motion with errors of the paper's kind in two chains that share no joint.

    The same seed hides the same errors in the same clip. Chains that could not be corrected are
    left out; a motion without any comes back as it is.
    """
    rng = generator(seed, "exercise")
    free = [c for c in chains if not uncorrectable_joints(motion, c)]
    targets: list[Chain] = []
    for k in rng.permutation(len(free)):
        joints = {j for c in targets for j in (c.parent, c.child)}
        if len(targets) < 2 and not joints & {free[k].parent, free[k].child}:
            targets.append(free[k])
    errors = draw_errors(motion, targets, rng, PROTOCOLS["P0"])
    return inject(motion, chains, errors), errors


def decoys(
    motion: Motion, chains: Sequence[Chain], errors: Sequence[InjectedError], seed: int
) -> tuple[Interval, ...]:
    """Intervals where nothing is wrong, to be told apart from the errors, and as many as those.

    Each begins where the parent of a chain without errors truly twists fast, so that a glance at
    θp alone is not enough; its length and its offset are drawn as those of an error. A clip too
    short for them gets fewer.
    """
    rng = generator(seed, "decoys")
    free = [c for c in chains if c.name not in {e.chain for e in errors}]
    out: list[Interval] = []
    for _ in errors if free else ():
        chain = free[int(rng.integers(len(free)))]
        speed = np.abs(twist_signals(motion, chain).dtheta_p)
        speed[:2] = speed[max(len(speed) - _LONGEST, 0) :] = -1.0
        for other in (i for i in out if i.chain == chain.name):
            speed[max(other.start - _LONGEST - _APART, 0) : other.stop + _APART] = -1.0
        lively = np.argsort(speed)[-_CHOICE:]
        lively = lively[speed[lively] >= 0.0]
        if not len(lively):
            continue
        start = int(rng.choice(lively))
        length = int(rng.integers(1, _LONGEST + 1))
        angle = np.radians(rng.uniform(5.0, 180.0)) * rng.choice([-1.0, 1.0])
        out.append(Interval(chain.name, start, start + length, np.full(length, angle)))
    return tuple(sorted(out, key=lambda i: (i.chain, i.start)))


def score(errors: Sequence[InjectedError], review: Iterable[Judged]) -> Score:
    """Compare verdicts with the truth: one interval answers for one error of its chain."""
    judged = tuple(review)
    accepted = [j.interval for j in judged if j.decision == Decision.ACCEPTED]
    rejected = [j.interval for j in judged if j.decision == Decision.REJECTED]
    found = _matched(errors, accepted)
    missed = _matched(errors, rejected)
    return Score(
        hits=tuple(e for k, e in enumerate(errors) if k in found),
        misses=tuple(e for k, e in enumerate(errors) if k not in found),
        false_accepted=tuple(i for k, i in enumerate(accepted) if k not in found.values()),
        false_rejected=tuple(rejected[i] for k, i in missed.items() if k not in found),
        left=sum(j.decision == Decision.UNDECIDED for j in judged),
    )


def _matched(errors: Sequence[InjectedError], intervals: Sequence[Interval]) -> dict[int, int]:
    """Index of an error → index of the interval that is the same, chain by chain."""
    out: dict[int, int] = {}
    for chain in {e.chain for e in errors}:
        mine = [k for k, e in enumerate(errors) if e.chain == chain]
        theirs = [k for k, i in enumerate(intervals) if i.chain == chain]
        pairs = match_intervals(
            [(errors[k].start, errors[k].stop) for k in mine],
            [(intervals[k].start, intervals[k].stop) for k in theirs],
        )
        out |= {mine[a]: theirs[b] for a, b in pairs.items()}
    return out
