"""Create an exercise by hiding random errors in a clip, and score a student's review of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from twistcore.detection import Interval
from twistcore.review import Decision, Judged
from twistcore.skeleton.chain import Chain, uncorrectable_joints
from twistcore.skeleton.motion import Motion
from twistcore.study.evaluation import match_intervals
from twistcore.synthesis import InjectedError, clip_random_generator, inject

_JUMPS = 4, 6  # numbers of jumps in a chain; even, so that the first and the last stretch are alike
_SHORTEST = 6  # minimum number of frames of a stretch
_SIZES = 50.0, 150.0  # smallest and largest angle, degrees; they are visible on the striped skin


@dataclass(frozen=True)
class ExerciseScore:
    """The score of a student's review of an exercise.

    Attributes
    ----------
    hits
        Errors that were accepted.
    misses
        Errors that no accepted interval matches.
    false_accepted
        Accepted intervals that match no error.
    false_rejected
        Intervals that were rejected although they match an error. Their errors are also misses.
    left
        Number of intervals without a verdict.
    """

    hits: tuple[InjectedError, ...]
    misses: tuple[InjectedError, ...]
    false_accepted: tuple[Interval, ...]
    false_rejected: tuple[Interval, ...]
    left: int

    @property
    def false_verdicts(self) -> int:
        """Return the number of wrong verdicts."""
        return len(self.false_accepted) + len(self.false_rejected)


def hide_exercise_errors(
    motion: Motion, chains: Sequence[Chain], seed: int
) -> tuple[Motion, tuple[InjectedError, ...]]:
    """Return the motion with random errors in two chains that share no joint, and these errors.

    The frames of each chain are divided into an odd number of stretches. In every other stretch,
    the chain is rotated by the same wrong angle. Whether this begins with the first or the second
    stretch is random. The curves therefore look the same on both sides of each jump, and only the
    figure shows which side is wrong.

    The same seed always hides the same errors in a clip. Chains that cannot be corrected are not
    used. If no chain can be used, the motion does not change.
    """
    rng = clip_random_generator(seed, "exercise")
    free = [c for c in chains if not uncorrectable_joints(motion, c)]
    targets: list[Chain] = []
    for k in rng.permutation(len(free)):
        joints = {j for c in targets for j in (c.parent, c.child)}
        if len(targets) < 2 and not joints & {free[k].parent, free[k].child}:
            targets.append(free[k])
    errors: list[InjectedError] = []
    for chain in targets:
        stretches = _stretches(motion.frames, rng)
        angle = np.radians(rng.uniform(*_SIZES)) * rng.choice([-1.0, 1.0])
        for start, stop in stretches[int(rng.integers(2)) :: 2] if len(stretches) > 1 else ():
            errors.append(InjectedError(chain.name, start, stop, np.full(stop - start, angle)))
    return inject(motion, chains, errors), tuple(errors)


def _stretches(frames: int, rng: np.random.Generator) -> list[tuple[int, int]]:
    """Return an odd number of stretches [start, stop) of random lengths that cover the clip."""
    jumps = min(int(rng.choice(_JUMPS)), (frames // _SHORTEST - 1) // 2 * 2)
    if jumps < 2:
        return [(0, frames)]
    slack = frames - (jumps + 1) * _SHORTEST
    steps = np.sort(rng.integers(0, slack + 1, jumps)) + _SHORTEST * np.arange(1, jumps + 1)
    ends = [0, *map(int, steps), frames]
    return list(pairwise(ends))


def exercise_intervals_between_errors(
    errors: Sequence[InjectedError], frames: int
) -> tuple[Interval, ...]:
    """Return the correct stretches between the errors of each chain, as more intervals to judge.

    Their offset is the opposite of the errors' offset. If it were removed, these stretches would
    look like the wrong stretches around them. Thus, neither the number nor the offsets of the
    intervals reveal the errors.
    """
    out: list[Interval] = []
    for chain in dict.fromkeys(e.chain for e in errors):
        own = sorted((e for e in errors if e.chain == chain), key=lambda e: e.start)
        starts, stops = [0, *(e.stop for e in own)], [*(e.start for e in own), frames]
        angle = -float(own[0].offset[0])
        for start, stop in zip(starts, stops, strict=True):
            if start < stop:
                out.append(Interval(chain, start, stop, np.full(stop - start, angle)))
    return tuple(sorted(out, key=lambda i: (i.chain, i.start)))


def score_review_of_hidden_errors(
    errors: Sequence[InjectedError], review: Iterable[Judged]
) -> ExerciseScore:
    """Return the score of a review. An interval can match at most one error of its chain."""
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
    """Match errors with intervals of their chains. Return {index of error: index of interval}."""
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
