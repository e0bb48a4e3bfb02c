"""Stretches: a joint turns suddenly about its own bone and is wrong until it turns back.

For example, a foot may jump to an upside-down position and stay there until the end of the clip.
The jump itself is listed as a lone jump. The roll about the bone in most frames of the clip is
assumed to be right, which shows which side of the jump is wrong. If a joint is turned by more than
120° from its rest pose in most frames, the roll near the rest pose is used instead, provided that
the same joint on the other side of the body has that roll as well.

A stretch is never corrected automatically. For a person who accepts it, the correction angle is
measured at the jumps. The joints below turn back with the joint if they jumped together with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.lone_jumps import chain_of_joint, limit, own_axis, turns_about
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notation import without_held
from twistcore.skeleton.rotation import (
    Array,
    geodesic_angle,
    multiply,
    twist_angle,
    twist_reliability,
    wrap,
)
from twistcore.work.frozen import dataclass

JUMP = math.radians(60.0)  # per frame, in a fast capture: a possible edge of a stretch
OFF = math.radians(75.0)  # from the usual roll; a smaller difference may be motion
ALIKE = math.radians(45.0)  # maximum difference between rolls that count as equal
TURNED = math.radians(120.0)  # from the rest pose; no joint rolls so far about its bone
MOST = 0.6  # minimum share of the frames with the usual roll
_ENOUGH = 0.1  # minimum share of the frames for a level that may be the right one
SHORTEST, FEWEST = 0.1, 3  # seconds and frames; a shorter level is a spike
MOST_JUMPS = 8  # of a joint; a joint with more is too restless, and only its jumps are listed
_DEFINED = 0.5  # minimum of :func:`twist_reliability`, which is low near a swing of 180°


@dataclass(frozen=True)
class _Level:
    """Frames [start, stop) between two jumps, with the mean roll in them, in radians."""

    start: int
    stop: int
    roll: float

    @property
    def frames(self) -> int:
        """The number of frames."""
        return self.stop - self.start


def find_stretches(search: KindSearch) -> Found:
    """Return the stretches of the joints of all chains, keyed by chain name."""
    if search.motion.frames < 4 or not search.chains:
        return {}
    found: Found = search.once(_in_all_chains)
    return found


def _in_all_chains(search: KindSearch) -> dict[str, list[Interval]]:
    motion = search.corrected_motion()
    if (held := without_held(motion)) is not None:
        motion = held.motion
    owner = chain_of_joint(search.chains)
    found: dict[str, list[Interval]] = {}
    for joint, chain in owner.items():
        levels = _levels(motion, joint)
        if not 2 <= len(levels) <= 1 + MOST_JUMPS:
            continue
        usual, by_rest = _expected(motion, owner, joint, levels)
        if usual is None:
            continue
        for level in _wrong(levels, usual, max(SHORTEST * motion.fps, FEWEST)):
            turn = float(wrap(level.roll - usual))
            jump = turn_at_jumps(motion, joint, (level.start, level.stop), turn)
            along = goes_along(motion, joint, (level.start, level.stop))
            if held is not None:
                level = _Level(held.begin(level.start), held.end(level.stop), level.roll)
            name = motion.skeleton.names[joint]
            explain = partial(_explained, name, turn, jump, by_rest=by_rest)
            one = Interval(
                chain.name,
                level.start,
                level.stop,
                np.zeros(level.frames),
                open=True,
                residual=turn,
                explain=explain,
                kind=Kind.STRETCH,
                carried=along,
                joint=name,
            )
            found.setdefault(chain.name, []).append(one)
    return found


def usual_roll(motion: Motion, chains: Sequence[Chain], joint: int) -> float | None:
    """Return the roll of a joint that serves as the reference for its stretches, radians, or None.

    `motion` is the motion without held frames.
    """
    return _expected(motion, chain_of_joint(chains), joint, _levels(motion, joint))[0]


def _expected(
    motion: Motion, owner: Mapping[int, Chain], joint: int, levels: Sequence[_Level]
) -> tuple[float | None, bool]:
    """Return the expected roll of a joint in radians, and True if it follows from the rest pose.

    The roll is None if it is unknown.
    """
    usual = _usual(levels)
    if usual is None or abs(usual) > TURNED:
        rest = _near_rest(levels)
        if rest is not None and _has_mirrored(motion, owner, joint, rest):
            return rest, True
    return usual, False


def defined_roll(motion: Motion, joint: int) -> Array:
    """Return the roll of a joint about its own bone, in radians, (frames,).

    The roll is NaN in frames with a swing near 180°, where it is undefined, and in all frames if
    the joint has no bone.
    """
    axis = own_axis(motion.skeleton, joint)
    if axis is None:
        return np.full(motion.frames, np.nan)
    rotations = motion.rotations[:, joint]
    defined = twist_reliability(rotations, axis) > _DEFINED
    return np.where(defined, twist_angle(rotations, axis), np.nan)


def _levels(motion: Motion, joint: int) -> list[_Level]:
    """Return the levels (frames of nearly constant roll) between a joint's jumps, sorted by start.

    The result is empty if the joint has no bone.
    """
    axis = own_axis(motion.skeleton, joint)
    if axis is None:
        return []
    rotations = motion.rotations[:, joint]
    jumps = np.abs(turns_about(rotations, axis)) > max(JUMP, limit(motion.fps))
    jumps &= ~find_cuts(motion) if jumps.any() else True
    borders = [0, *np.flatnonzero(jumps).tolist(), motion.frames]
    roll = defined_roll(motion, joint)
    defined = np.isfinite(roll)
    return [
        _Level(start, stop, _mean(roll[start:stop][defined[start:stop]]))
        for start, stop in pairwise(borders)
        if stop > start and defined[start:stop].any()
    ]


def _mean(angles: Array) -> float:
    """Return the circular mean of angles, in radians."""
    return float(np.arctan2(np.sin(angles).sum(), np.cos(angles).sum()))


def _usual(levels: Sequence[_Level]) -> float | None:
    """Return the roll of most frames in radians, or None if there is no such roll."""
    total = sum(level.frames for level in levels)
    for level in sorted(levels, key=lambda one: -one.frames):
        alike = [one for one in levels if abs(wrap(one.roll - level.roll)) <= ALIKE]
        if sum(one.frames for one in alike) >= MOST * total:
            return level.roll
    return None


def _near_rest(levels: Sequence[_Level]) -> float | None:
    """Return the roll of the longest level near the rest pose, in radians.

    The result is None if that level covers less than 10 % of the clip.
    """
    near = [level for level in levels if abs(level.roll) <= OFF]
    longest = max(near, key=lambda level: level.frames, default=None)
    total = sum(level.frames for level in levels)
    return longest.roll if longest and longest.frames >= _ENOUGH * total else None


def _has_mirrored(motion: Motion, owner: Mapping[int, Chain], joint: int, roll: float) -> bool:
    """Return True if the same joint on the other side has the mirrored roll in part of the clip."""
    own = owner[joint]
    is_parent = own.parent == joint
    for other, chain in owner.items():
        same = chain.segment == own.segment and chain.person == own.person
        if same and chain.side != own.side and (chain.parent == other) == is_parent:
            levels = _levels(motion, other)
            alike = sum(one.frames for one in levels if abs(wrap(one.roll + roll)) <= ALIKE)
            return alike >= _ENOUGH * motion.frames
    return False


def _wrong(levels: Sequence[_Level], usual: float, shortest: float) -> Iterator[_Level]:
    """Yield the levels that are far from the usual roll; adjacent levels are joined.

    `shortest` is the length of the shortest level to yield, in frames.
    """
    found: list[_Level] = []
    for level in levels:
        if abs(wrap(level.roll - usual)) < OFF:
            continue
        if found and found[-1].stop == level.start and _alike(found[-1], level):
            level = _Level(found.pop().start, level.stop, level.roll)
        found.append(level)
    return (level for level in found if level.frames >= shortest)


def _alike(a: _Level, b: _Level) -> bool:
    return bool(abs(wrap(a.roll - b.roll)) <= ALIKE)


def turn_at_jumps(motion: Motion, joint: int, edges: tuple[int, int], turn: float) -> float:
    """Return the angle of a stretch, in radians, measured at the jumps at its two edges.

    `edges` are the first frame of the stretch and the frame after it. At each edge, the smaller of
    the adjacent turns is subtracted as natural motion. Jumps that differ from `turn` by more than
    45° are ignored; if none remains, `turn` is returned.
    """
    axis = own_axis(motion.skeleton, joint)
    assert axis is not None
    jumps = []
    for at, sign in zip(edges, (1.0, -1.0), strict=True):
        if not 0 < at < motion.frames:
            continue
        first, last = max(at - 2, 0), min(at + 2, motion.frames)
        turns = turns_about(motion.rotations[first:last, joint], axis)[1:]
        own = at - 1 - first
        natural = min(np.delete(turns, own).tolist(), key=abs, default=0.0)
        jump = wrap(sign * (turns[own] - natural))
        if abs(wrap(jump - turn)) <= ALIKE:
            jumps.append(float(jump))
    return _mean(np.array(jumps)) if jumps else turn


def goes_along(motion: Motion, joint: int, edges: tuple[int, int]) -> bool:
    """Return True if the joints below a joint jump with it at the edges of a stretch.

    In this case, their local rotations jump less than their orientation relative to the joint's
    parent. The result is also True if a joint below has no rotation channels and so cannot be
    turned back.
    """
    children, rotatable = motion.skeleton.children[joint], motion.skeleton.rotatable
    if rotatable is not None and not all(rotatable[child] for child in children):
        return True
    own = seen = 0.0
    for at in edges:
        if 0 < at < motion.frames:
            above = motion.rotations[at - 1 : at + 1, joint]
            for child in children:
                below = motion.rotations[at - 1 : at + 1, child]
                own += float(geodesic_angle(*below))
                seen += float(geodesic_angle(*multiply(above, below)))
    return own <= seen


def _explained(joint: str, turn: float, jump: float, *, by_rest: bool) -> dict[str, float | str]:
    """Return the evidence: the angle of a stretch, its reference, and the correction angle."""
    reference = "the rest pose and the other side" if by_rest else "the rest of the clip"
    return {
        "joint": joint,
        "turn_deg": math.degrees(turn),
        "compared_with": reference,
        "correction_deg": math.degrees(jump),
    }
