"""An exercise: seeded errors are hidden in a clip, and a review of the clip is scored."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from twistcore.detection import Interval
from twistcore.review import Decision, Judged
from twistcore.skeleton.chain import Chain, uncorrectable_joints
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.signals import twist_signals
from twistcore.study.evaluation import match_intervals
from twistcore.synthesis import PROTOCOLS, InjectedError, draw_errors, generator, inject

_LONGEST = 20  # frames of a decoy, the same as for an error of P0
_APART = 4  # frames between two decoys of a chain
_CHOICE = 10  # number of the liveliest moments from which one is drawn


@dataclass(frozen=True)
class ExerciseScore:
    """The score of a review compared with the hidden errors.

    Attributes
    ----------
    hits
        Number of errors accepted.
    misses
        Errors that no accepted interval covers.
    false_accepted
        Accepted intervals without a hidden error.
    false_rejected
        Errors that were listed and rejected (also counted as misses).
    left
        Intervals without a verdict.
    """

    hits: tuple[InjectedError, ...]
    misses: tuple[InjectedError, ...]
    false_accepted: tuple[Interval, ...]
    false_rejected: tuple[Interval, ...]
    left: int

    @property
    def false_verdicts(self) -> int:
        """Number of verdicts that contradict the truth."""
        return len(self.false_accepted) + len(self.false_rejected)


def hide_errors(
    motion: Motion, chains: Sequence[Chain], seed: int
) -> tuple[Motion, tuple[InjectedError, ...]]:
    """Return the motion with errors of the paper's kind in two chains that share no joint.

    The same seed hides the same errors in the same clip. Chains that cannot be corrected are never
    used; a motion without correctable chains is returned unchanged.
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
    """Return 2 to 5 intervals without an error per chain, as many as there can be errors.

    `motion` is the clean motion. Decoys are in the same chains as the errors but do not overlap
    them, so that neither the chain nor the number of intervals reveals the errors. Each decoy
    begins where the chain's parent really twists fast, so that θp alone does not show the
    difference. Lengths and offsets are drawn as for errors. A clip that is too short has fewer
    decoys.
    """
    rng = generator(seed, "decoys")
    out: list[Interval] = []
    for chain in chains:
        taken = [(e.start, e.stop) for e in errors if e.chain == chain.name]
        for _ in range(int(rng.integers(2, 6)) if taken else 0):
            if (start := _lively(motion, chain, taken, rng)) is None:
                break
            length = int(rng.integers(1, _LONGEST + 1))
            angle = np.radians(rng.uniform(5.0, 180.0)) * rng.choice([-1.0, 1.0])
            out.append(Interval(chain.name, start, start + length, np.full(length, angle)))
            taken.append((start, start + length))
    return tuple(sorted(out, key=lambda i: (i.chain, i.start)))


def _lively(
    motion: Motion, chain: Chain, taken: Sequence[tuple[int, int]], rng: np.random.Generator
) -> int | None:
    """Return a frame in which the parent twists fast and a decoy would overlap nothing.

    `taken` are the spans that are in use. The result is None if there is no such frame.
    """
    speed = np.abs(twist_signals(motion, chain).dtheta_p)
    speed[:2] = speed[max(len(speed) - _LONGEST, 0) :] = -1.0
    for start, stop in taken:
        speed[max(start - _LONGEST - _APART, 0) : stop + _APART] = -1.0
    lively = np.argsort(speed)[-_CHOICE:]
    lively = lively[speed[lively] >= 0.0]
    return int(rng.choice(lively)) if len(lively) else None


def score_exercise(errors: Sequence[InjectedError], review: Iterable[Judged]) -> ExerciseScore:
    """Return the score of a review. Each interval can match at most one error of its chain."""
    judged = tuple(review)
    accepted = [j.interval for j in judged if j.decision == Decision.ACCEPTED]
    rejected = [j.interval for j in judged if j.decision == Decision.REJECTED]
    found = _matched(errors, accepted)
    missed = _matched(errors, rejected)
    return ExerciseScore(
        hits=tuple(e for k, e in enumerate(errors) if k in found),
        misses=tuple(e for k, e in enumerate(errors) if k not in found),
        false_accepted=tuple(i for k, i in enumerate(accepted) if k not in found.values()),
        false_rejected=tuple(rejected[i] for k, i in missed.items() if k not in found),
        left=sum(j.decision == Decision.UNDECIDED for j in judged),
    )


def _matched(errors: Sequence[InjectedError], intervals: Sequence[Interval]) -> dict[int, int]:
    """Match errors with intervals chain by chain, as {index of error: index of interval}."""
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
