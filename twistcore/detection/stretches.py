"""Find stretches, in which a joint rotates suddenly about its bone and stays wrong for a while.

For example, a foot may jump to an upside-down position and stay there until the end of the clip.
The jump itself is reported as a lone jump. The stretch may end at any sudden rotation of the joint
if the roll differs before and after this rotation.

Frames in which a foot or hand is rotated during a limb flip are reported as a turned end instead.

A stretch is never corrected automatically. If a person accepts it, the correction angle is measured
at the jumps. The correction also rotates the joints below if they jumped together with the joint.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.all_joints.finders import find_joint_jumps
from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.lone_jumps import largest_natural_turn
from twistcore.detection.roll_levels import (
    RollLevel,
    is_calm_around,
    is_jump_confirmed_by_roll,
    jump_angle_about,
    levels_without_natural_motion,
    own_bone_jump_angles,
    undoes_any,
)
from twistcore.detection.turned_ends import turned_limb_end_spans
from twistcore.skeleton.angles import circular_mean
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.joint_owners import chain_of_joint
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notation import without_repeated_frames
from twistcore.skeleton.own_axis import (
    own_bone_axis,
    roll_about_own_bone,
    twist_since_previous_frame,
)
from twistcore.skeleton.rotation import (
    Array,
    geodesic_angle,
    multiply,
    wrap,
)
from twistcore.work.frozen import dataclass

# Minimum turn per frame at an edge of a stretch. In slow captures, the limit of lone jumps applies.
JUMP = math.radians(60.0)
# A smaller difference from the usual roll may be motion. If the angles of the jumps are known, the
# limit is JUMP.
OFF = math.radians(75.0)
ALIKE = math.radians(45.0)  # maximum difference between rolls that are considered equal
TURNED = math.radians(120.0)  # no joint rolls farther than this from its rest pose
MOST = 0.6  # minimum share of the frames with the usual roll
_ENOUGH = 0.1  # minimum share of the clip in which a joint has a roll that may be the right one
SHORTEST, FEWEST = 0.1, 3  # minimum duration in seconds and in frames; a shorter one is a spike
MOST_JUMPS = 8  # if a joint jumps more often, only its jumps are listed
# Slower jumps are examined, and the rolls between jumps are linked, only if there are at most this
# many, because each jump is compared with all others.
MOST_COMPARED = 32


@dataclass(frozen=True, eq=False)
class _Clip:
    """A clip's corrected motion without held (repeated) frames, and the jumps of its joints.

    Attributes
    ----------
    motion
        The corrected motion without held frames.
    at
        For each frame of the clip, the index of the corresponding frame of `motion`, shape (frames
        of the clip,).
    owner
        The chain of each joint, keyed by joint.
    listed
        The first frame of each detected joint jump, as an index into `motion`, keyed by joint.
    """

    motion: Motion
    at: NDArray[np.intp]
    owner: Mapping[int, Chain]
    listed: Mapping[int, Sequence[int]]

    @staticmethod
    def of(search: KindSearch) -> _Clip:
        """Collect the motion and the jumps for a search for stretches."""
        motion = search.corrected_motion()
        at = np.arange(motion.frames)
        if (held := without_repeated_frames(motion)) is not None:
            motion, at = held.motion, np.searchsorted(held.first, at, side="right") - 1
        listed: dict[int, list[int]] = {}
        for own in find_joint_jumps(search).values():
            for jump in own:
                listed.setdefault(search.joint_of(jump), []).append(int(at[jump.start]))
        return _Clip(motion, at, chain_of_joint(search.chains), listed)

    def jumps(self, joint: int) -> list[int]:
        """Return the first frames of a joint's jumps about its own bone.

        In slow captures, they include slower jumps in calm motion, and the jumps that undo them.
        """
        axis = own_bone_axis(self.motion.skeleton, joint)
        if axis is None:
            return []
        turns = twist_since_previous_frame(self.motion.rotations[:, joint], axis)
        jumps = self._too_fast(turns)
        slow = self._too_fast(turns, OFF) if largest_natural_turn(self.motion.fps) > OFF else []
        if 0 < len(slow) <= MOST_COMPARED:
            roll, fps = roll_about_own_bone(self.motion, joint), self.motion.fps
            slower = own_bone_jump_angles(self.motion, joint, slow)
            sure = {
                at: turn
                for at, turn in slower.items()
                if at in jumps
                or (is_calm_around(turns, at) and is_jump_confirmed_by_roll(roll, at, turn, fps))
            }
            undone = [at for at, turn in slower.items() if undoes_any(turn, sure.values())]
            jumps = sorted({*jumps, *sure, *undone})
        return jumps

    def may_have_stretches(self, joint: int) -> bool:
        """Return True if a joint jumps about its own bone, but not often too fast for a body."""
        if not self.jumps(joint):
            return False
        axis = own_bone_axis(self.motion.skeleton, joint)
        assert axis is not None
        turns = twist_since_previous_frame(self.motion.rotations[:, joint], axis)
        return len(self._too_fast(turns)) <= MOST_JUMPS

    def levels(self, joint: int) -> list[RollLevel]:
        """Return the levels (frames of nearly constant roll) between the jumps of a joint.

        The joint may jump about any axis. The levels are sorted by start. The result is empty if
        the joint has no bone.

        A hand may roll as far by itself as by the error. If the angle of a jump about the bone is
        known, the rolls before and after it are therefore assumed to differ by exactly this angle.
        The angle is known if a later jump undoes the jump, or if the roll shortly before and after
        the jump confirms it.
        """
        rotations = self.motion.rotations[:, joint]
        jumps = self._too_fast(np.append(0.0, geodesic_angle(rotations[:-1], rotations[1:])))
        own = self.jumps(joint)
        borders = {0, *jumps, *own, *self.listed.get(joint, ()), self.motion.frames}
        roll = roll_about_own_bone(self.motion, joint)
        defined = np.isfinite(roll)
        levels = [
            RollLevel(start, stop, circular_mean(roll[start:stop][defined[start:stop]]))
            for start, stop in pairwise(sorted(borders))
            if defined[start:stop].any()
        ]
        if len(own) > MOST_COMPARED:
            return levels
        turns = own_bone_jump_angles(self.motion, joint, own)
        sure = [
            at
            for at, turn in turns.items()
            if is_jump_confirmed_by_roll(roll, at, turn, self.motion.fps)
        ]
        return levels_without_natural_motion(
            levels, turns, sure, shortest=self.shortest, frames=self.motion.frames
        )

    def _too_fast(self, turns: Array, limit: float | None = None) -> list[int]:
        """Return the frames, except at cuts, in which a joint rotates faster than `limit`.

        `turns` contains the rotation angles since the previous frame, in radians, (frames,). By
        default, the limit is the fastest rotation of a body.
        """
        fast = np.abs(turns) > (limit or max(JUMP, largest_natural_turn(self.motion.fps)))
        fast &= ~find_cuts(self.motion) if fast.any() else True
        found: list[int] = np.flatnonzero(fast).tolist()
        return found

    @property
    def shortest(self) -> float:
        """The minimum length of a stretch in frames."""
        return max(SHORTEST * self.motion.fps, FEWEST)

    def expected(self, joint: int) -> tuple[float | None, bool]:
        """Return a joint's correct roll in radians, and True if it is derived from the rest pose.

        The roll is None if it is unknown.
        """
        levels = self.levels(joint)
        usual = _usual(levels)
        if usual is None or abs(usual) > TURNED:
            rest = _near_rest(levels)
            if rest is not None and self._has_mirrored(joint, rest):
                return rest, True
        return usual, False

    def wrong(self, joint: int) -> tuple[float, bool, list[RollLevel]]:
        """Return the result of :meth:`expected`, and the levels whose roll is wrong.

        The levels are sorted by start. There are none if the correct roll is unknown.
        """
        usual, by_rest = self.expected(joint)
        if usual is None:
            return 0.0, False, []
        return usual, by_rest, list(_wrong(self.levels(joint), usual, self.shortest))

    def _has_mirrored(self, joint: int, roll: float) -> bool:
        """Return True if the opposite joint of the body has the mirrored roll in enough frames."""
        if (own := self.owner.get(joint)) is None:
            return False
        is_parent = own.parent == joint
        for other, chain in self.owner.items():
            same = chain.segment == own.segment and chain.person == own.person
            if same and chain.side != own.side and (chain.parent == other) == is_parent:
                levels = self.levels(other)
                alike = sum(one.frames for one in levels if abs(wrap(one.roll + roll)) <= ALIKE)
                return alike >= _ENOUGH * self.motion.frames
        return False


def find_stretches(search: KindSearch) -> Found:
    """Return the stretches of all joints in chains, keyed by chain name."""
    if search.motion.frames < 4 or not search.chains:
        return {}
    found: Found = search.once(_in_all_chains)
    return found


def _in_all_chains(search: KindSearch) -> dict[str, list[Interval]]:
    clip, ends = search.once(_Clip.of), turned_limb_end_spans(search)
    found: dict[str, list[Interval]] = {}
    for joint, chain in clip.owner.items():
        if not clip.may_have_stretches(joint):
            continue
        usual, by_rest, wrong = clip.wrong(joint)
        for level in wrong:
            start, stop = np.searchsorted(clip.at, (level.start, level.stop)).tolist()
            if (joint, start, stop) in ends:
                continue
            turn = float(wrap(level.roll - usual))
            one = wrongly_rolled_joint_interval(search, chain.name, joint, (start, stop), turn)
            explain = partial(_explained, one.joint, turn, one.residual, by_rest=by_rest)
            one = replace(one, offset=np.zeros(one.frames), explain=explain)
            found.setdefault(chain.name, []).append(one)
    return found


def wrongly_rolled_joint_interval(
    search: KindSearch, chain: str, joint: int, span: tuple[int, int], turn: float
) -> Interval:
    """Return a stretch of a joint over frames [start, stop), with its offset.

    Parameters
    ----------
    search
        The clip.
    chain
        The name of the chain to which the joint belongs.
    joint
        The index of the joint.
    span
        The frames (start, stop).
    turn
        The difference of the joint's roll from its usual roll in these frames, in radians. It is
        used as the offset if the jumps at both edges disagree with it. If not, the offset is
        measured at these jumps.
    """
    clip, (start, stop) = search.once(_Clip.of), span
    edges = int(clip.at[start]), int(clip.at[stop - 1]) + 1
    delta = roll_error_angle_at_jumps(clip.motion, joint, edges, turn)
    return Interval(
        chain,
        start,
        stop,
        np.full(stop - start, delta),
        open=True,
        residual=delta,
        kind=Kind.STRETCH,
        carried=is_followed_by_children(clip.motion, joint, edges),
        joint=clip.motion.skeleton.names[joint],
    )


def roll_deviation(search: KindSearch, joint: int, span: tuple[int, int]) -> Array | None:
    """Return the difference of a joint's roll from its usual roll, in radians, (frames,), or None.

    If the usual roll is unknown, the mean roll outside the frames `span`, (start, stop), is used
    instead. The result is None if the mean roll is unknown as well. It is NaN in frames in which
    the roll is undefined.
    """
    clip = search.once(_Clip.of)
    roll = roll_about_own_bone(clip.motion, joint)[clip.at]
    usual = clip.expected(joint)[0]
    if usual is None:
        outside = np.delete(roll, slice(*span))
        if not np.isfinite(outside).any():
            return None
        usual = circular_mean(outside[np.isfinite(outside)])
    return wrap(roll - usual)


def _usual(levels: Sequence[RollLevel]) -> float | None:
    """Return the roll that a joint has in most frames, in radians, or None if the roll varies."""
    rolls = np.array([level.roll for level in levels])
    frames = np.array([level.frames for level in levels])
    for k in np.argsort(-frames, kind="stable").tolist():
        alike = np.abs(wrap(rolls - rolls[k])) <= ALIKE
        if frames[alike].sum() >= MOST * frames.sum():
            return float(rolls[k])
    return None


def _near_rest(levels: Sequence[RollLevel]) -> float | None:
    """Return the roll of the longest level near the rest pose, in radians.

    The result is None if there is no such level or if the level is too short.
    """
    near = [level for level in levels if abs(level.roll) <= OFF]
    longest = max(near, key=lambda level: level.frames, default=None)
    total = sum(level.frames for level in levels)
    return longest.roll if longest and longest.frames >= _ENOUGH * total else None


def _wrong(levels: Sequence[RollLevel], usual: float, shortest: float) -> Iterator[RollLevel]:
    """Yield levels with a roll far from the usual roll, after joining adjacent similar levels.

    `shortest` is the minimum length of a level in frames.
    """
    found: list[RollLevel] = []
    for level in levels:
        if abs(wrap(level.roll - usual)) < (JUMP if level.sure else OFF):
            continue
        if found and found[-1].stop == level.start and _alike(found[-1], level):
            level = RollLevel(found.pop().start, level.stop, level.roll)
        found.append(level)
    return (level for level in found if level.frames >= shortest)


def _alike(a: RollLevel, b: RollLevel) -> bool:
    return bool(abs(wrap(a.roll - b.roll)) <= ALIKE)


def roll_error_angle_at_jumps(
    motion: Motion, joint: int, edges: tuple[int, int], turn: float
) -> float:
    """Return the angle of a stretch in radians, measured at the jumps at its edges.

    `edges` contains the first frame of the stretch and the frame after the last. At each edge, the
    smallest rotation in the frames next to the jump is subtracted as natural motion. Jumps that
    differ from the expected angle `turn` by more than 45° are ignored. If no jump remains, `turn`
    is returned.
    """
    axis = own_bone_axis(motion.skeleton, joint)
    assert axis is not None
    jumps = []
    for at, sign in zip(edges, (1.0, -1.0), strict=True):
        if not 0 < at < motion.frames:
            continue
        jump = sign * jump_angle_about(motion, joint, axis, at)
        if abs(wrap(jump - turn)) <= ALIKE:
            jumps.append(jump)
    return circular_mean(np.array(jumps)) if jumps else turn


def is_followed_by_children(motion: Motion, joint: int, edges: tuple[int, int]) -> bool:
    """Return True if the children of a joint jump with it at the edges of a stretch.

    In this case, their local rotations jump less than their orientation relative to the joint's
    parent. The result is also True if a child has no rotation channels, because the rotation of
    such a child cannot be corrected.
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


def _explained(joint: str, roll: float, turn: float, *, by_rest: bool) -> dict[str, float | str]:
    """Return the evidence for a stretch, keyed by name.

    `roll` is the difference from the correct roll and `turn` is the angle of the correction, both
    in radians. `by_rest` is True if the correct roll is derived from the rest pose.
    """
    compared = "the rest pose and the other side" if by_rest else "the rest of the clip"
    return {
        "joint": joint,
        "turn_deg": math.degrees(turn),
        "roll_deg": math.degrees(roll),
        "compared_with": compared,
        "correction_deg": math.degrees(turn),  # the field's name in the first version
    }
