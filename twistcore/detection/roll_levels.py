"""Compute a joint's roll between its jumps, without natural motion.

The mean roll of two levels (frames between jumps) differs by the jump between them and by the
natural motion of the joint. If the angle of the jump is known, only this angle is kept.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from twistcore.skeleton.motion import Motion
from twistcore.skeleton.own_axis import own_bone_axis, twist_since_previous_frame
from twistcore.skeleton.rotation import (
    Array,
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    wrap,
)
from twistcore.work.frozen import dataclass

UNDONE = math.radians(20.0)  # largest difference between two jumps that undo each other
SWING = math.radians(30.0)  # largest swing in a jump about the bone
NEAR, FAR = 0.025, 0.1  # seconds before and after a jump in which the roll may confirm its angle
CONFIRMED = math.radians(20.0)  # largest difference between a jump and the roll around it
# Largest natural difference of the mean rolls of two levels, unless another jump undoes the jump
NATURAL = math.radians(90.0)
CALM = 0.25  # largest rotation in the frames around a jump, as a share of the jump


@dataclass(frozen=True)
class RollLevel:
    """Frames [start, stop) between two jumps of a joint, and its roll there.

    Attributes
    ----------
    start, stop
        The first frame, and the frame after the last one.
    roll
        The mean roll in radians, without natural motion as far as the jumps tell.
    sure
        True if the frames begin and end with jumps whose angle is known, or with the clip.
    """

    start: int
    stop: int
    roll: float
    sure: bool = False

    @property
    def frames(self) -> int:
        """The number of frames between the two jumps."""
        return self.stop - self.start


def own_bone_jump_angles(motion: Motion, joint: int, jumps: Sequence[int]) -> dict[int, float]:
    """Return the angles in radians of jumps about the joint's own bone, keyed by frame.

    Jumps with a large swing are omitted. The smallest rotation in the frames next to a jump is
    subtracted as natural motion.
    """
    found: dict[int, float] = {}
    if (axis := own_bone_axis(motion.skeleton, joint)) is None:
        return found
    for at in jumps:
        turn = jump_angle_about(motion, joint, axis, at)
        before, after = motion.rotations[at - 1 : at + 1, joint]
        back = multiply(after, quaternion_from_axis_angle(axis, -turn))
        if geodesic_angle(before, back) <= SWING:
            found[at] = turn
    return found


def jump_angle_about(motion: Motion, joint: int, axis: Array, at: int) -> float:
    """Return the angle of a joint's jump in frame `at` about an axis, without natural motion."""
    first, last = max(at - 2, 0), min(at + 2, motion.frames)
    turns = twist_since_previous_frame(motion.rotations[first:last, joint], axis)[1:]
    own = at - 1 - first
    natural = min(np.delete(turns, own).tolist(), key=abs, default=0.0)
    return float(wrap(turns[own] - natural))


def undoes_any(turn: float, others: Iterable[float]) -> bool:
    """Return True if a jump undoes one of the other jumps. All angles are in radians."""
    return any(abs(wrap(turn + other)) <= UNDONE for other in others)


def is_calm_around(turns: Array, at: int) -> bool:
    """Return True if a joint rotates by less than a quarter of a jump in the frames around it.

    `turns` contains the rotation angles about the bone since the previous frame, (frames,).
    """
    around = [turns[t] for t in (at - 2, at - 1, at + 1, at + 2) if 0 < t < len(turns)]
    return bool(np.abs(around).max(initial=0.0) <= CALM * abs(turns[at]))


def is_jump_confirmed_by_roll(roll: Array, at: int, turn: float, fps: float) -> bool:
    """Return True if the roll on either side of a jump, continued to it, differs by its angle.

    Parameters
    ----------
    roll
        The joint's roll in radians, (frames,), NaN where it is undefined.
    at
        The frame of the jump.
    turn
        The angle of the jump in radians.
    fps
        Frames per second.
    """
    near, far = round(NEAR * fps), max(round(FAR * fps), 3)
    before = _continued(roll, range(max(at - far, 0), at - near), at - 0.5)
    after = _continued(roll, range(at + near, min(at + far, len(roll))), at - 0.5)
    # A comparison with NaN is False
    return bool(abs(wrap(after - before - turn)) <= CONFIRMED)


def _continued(roll: Array, frames: range, time: float) -> float:
    """Return the value at `time` of a line through the defined rolls in some frames, or NaN."""
    at = np.array([t for t in frames if np.isfinite(roll[t])])
    if len(at) < 2:
        return math.nan
    line = np.polyfit(at - time, np.unwrap(roll[at]), 1)
    return float(line[-1])


def levels_without_natural_motion(
    levels: Sequence[RollLevel],
    turns: Mapping[int, float],
    sure: Sequence[int],
    *,
    shortest: float,
    frames: int,
) -> list[RollLevel]:
    """Return the levels with rolls that differ by exactly the jumps whose angle is known.

    Parameters
    ----------
    levels
        The levels, sorted by start.
    turns
        The angle of each jump about the bone in radians, keyed by frame.
    sure
        The frames of the jumps whose angle is confirmed. If two jumps undo each other, their angles
        are known as well.
    shortest
        The minimum number of frames between two jumps that undo each other.
    frames
        The number of frames of the clip.
    """
    begins = {level.start: k for k, level in enumerate(levels)}
    ends = {level.stop: k for k, level in enumerate(levels)}
    pairs = _undone(turns, shortest)
    known = {at for at in sure if at in ends and at in begins}
    for at in [*known]:
        natural = levels[begins[at]].roll - levels[ends[at]].roll - turns[at]
        if abs(wrap(natural)) > NATURAL:
            known.remove(at)
    known |= {at for pair in pairs for at in pair}
    links = [(ends[at], begins[at], turns[at]) for at in known if at in ends and at in begins]
    links += [(ends[a], begins[b], 0.0) for a, b in pairs if a in ends and b in begins]
    if links:
        known |= {0, frames}
    return [
        replace(level, sure=level.start in known and level.stop in known)
        for level in _linked(levels, links)
    ]


def _undone(turns: Mapping[int, float], shortest: float) -> list[tuple[int, int]]:
    """Return pairs of jumps that undo each other, the most similar ones first."""
    left = sorted(turns)
    found: list[tuple[int, int]] = []
    while True:
        pairs = [
            (abs(wrap(turns[a] + turns[b])), (a, b)) for a, b in pairwise(left) if b - a >= shortest
        ]
        apart, pair = min(pairs, default=(math.inf, (0, 0)))
        if apart > UNDONE:
            return found
        found.append(pair)
        left = [at for at in left if at not in pair]


def _linked(
    levels: Sequence[RollLevel], links: Sequence[tuple[int, int, float]]
) -> list[RollLevel]:
    """Return levels in which the roll of level b is the roll of level a plus an angle.

    `links` contains tuples (a, b, angle in radians). Natural motion is averaged over all levels
    that are linked directly or indirectly.
    """
    shift: dict[int, float] = {}
    rolls = [level.roll for level in levels]
    for first in range(len(levels)):
        if first in shift:
            continue
        group, shift[first] = [first], 0.0
        for one in group:
            for a, b, turn in (*links, *((b, a, -turn) for a, b, turn in links)):
                if a == one and b not in shift:
                    shift[b] = shift[a] + turn
                    group.append(b)
        if len(group) > 1:
            weights = np.array([levels[k].frames for k in group])
            own = np.array([levels[k].roll - shift[k] for k in group])
            centre = math.atan2((weights * np.sin(own)).sum(), (weights * np.cos(own)).sum())
            for k in group:
                rolls[k] = float(wrap(centre + shift[k]))
    return [RollLevel(one.start, one.stop, roll) for one, roll in zip(levels, rolls, strict=True)]
