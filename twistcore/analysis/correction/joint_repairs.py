"""Repair errors of single joints, which are corrected only if a person accepts them.

A kind of error names its repair in :attr:`KindInfo.repairer`. Repairs are applied after twists and
flips have been removed, in the order of the kinds. They change nothing outside the intervals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from importlib import import_module

import numpy as np

from twistcore.detection.interval import Interval, Kind
from twistcore.detection.turned_ends import (
    jump_rotations_at_edges,
    mean_edge_jump,
)
from twistcore.errors import TwistError
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    slerp,
    vector_lengths,
    wrap,
)
from twistcore.skeleton.runs import runs_of_true
from twistcore.work.frozen import dataclass

# Share of the skeleton's height. A child that is farther than this from its parent's bone axis
# moves if the parent rotates about that axis.
_ASIDE = 1e-4


@dataclass(frozen=True)
class JointRepair:
    """The repair of one kind of error.

    Attributes
    ----------
    repaired
        A function that takes a motion and the intervals of this kind, and returns the corrected
        motion.
    neighbours
        Number of frames on either side of an interval that the function needs.
    """

    repaired: Callable[[Motion, Sequence[Interval]], Motion]
    neighbours: int = 0


@cache
def repair_of(kind: Kind) -> JointRepair | None:
    """Return the repair of a kind of error, or None if the kind has no repair.

    Raises TwistError if the module of the repair cannot be loaded.
    """
    module, _, name = kind.info.repairer.partition(":")
    if not module:
        return None
    try:
        repair: JointRepair = getattr(import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise TwistError(
            f"the correction for the error kind {kind.value!r} cannot be loaded: {error}"
        ) from error
    return repair


class JointRepairs:
    """The repairs of single-joint errors in a clip. Intervals of other kinds are ignored."""

    def __init__(self, intervals: Iterable[Interval]) -> None:
        own = (i for i in intervals if i.kind.info.repairer)
        self.intervals = tuple(sorted(own, key=lambda i: i.kind.info.place))

    def at(self, start: int, stop: int) -> tuple[Interval, ...]:
        """Return the intervals that overlap frames [start, stop)."""
        return tuple(i for i in self.intervals if i.start < stop and start < i.stop)

    def needed(self, start: int, stop: int, frames: int) -> tuple[int, int]:
        """Return the range of frames that is needed to repair frames [start, stop).

        `frames` is the number of frames in the clip.
        """
        low, high = start, stop
        known: tuple[Interval, ...] = ()
        while (there := self.at(low, high)) != known:  # adjacent intervals are interpolated as one
            known = there
            for interval in there:
                repair = repair_of(interval.kind)
                if repair is not None and repair.neighbours:
                    low = min(low, max(interval.start - repair.neighbours, 0))
                    high = max(high, min(interval.stop + repair.neighbours, frames))
        return low, high

    def applied(self, motion: Motion, low: int = 0) -> Motion:
        """Return a part of the clip's motion with all repairs applied.

        `low` is the index of the part's first frame in the clip.
        """
        here = self.at(low, low + motion.frames)
        for kind in dict.fromkeys(i.kind for i in here):
            if (repair := repair_of(kind)) is not None:
                own = [i.within(low, low + motion.frames) for i in here if i.kind == kind]
                motion = repair.repaired(motion, own)
        return motion


def repaired_joints(skeleton: Skeleton, interval: Interval) -> tuple[int, ...]:
    """Return the joints whose local rotation a repair changes.

    These are the interval's joint and, unless they rotated with it, its children. Raises TwistError
    if the skeleton does not have the joint.
    """
    joint = interval_joint_index(skeleton, interval)
    return (joint,) if interval.carried else (joint, *skeleton.children[joint])


def repair_moves_joints(motion: Motion, interval: Interval) -> bool:
    """Return True if the repair of an interval moves other joints.

    A rotation about the joint's own bone usually does not.
    """
    skeleton, joint = motion.skeleton, interval_joint_index(motion.skeleton, interval)
    children = skeleton.children[joint]
    axis = own_bone_axis(skeleton, joint)
    if axis is None or not interval.kind.by_angle:
        return bool(children)
    places = [np.atleast_2d(motion.translation(child)) for child in children]
    aside = [float(vector_lengths(np.cross(p, axis)).max()) for p in places]
    ends = any(skeleton.children[child] for child in children)
    return max(aside, default=0.0) > _ASIDE * skeleton.height or (interval.carried and ends)


def interval_joint_index(skeleton: Skeleton, interval: Interval) -> int:
    """Return the index of an interval's joint.

    Raises TwistError if the skeleton does not have the joint.
    """
    try:
        return skeleton.index(interval.joint)
    except KeyError:
        raise TwistError(
            f"expected an interval on one of the clip's joints, found {interval.joint!r}"
        ) from None


def remove_joint_roll(motion: Motion, intervals: Sequence[Interval]) -> Motion:
    """Remove the offset δ from joints by a rotation about their bone b: q' = q ⊗ R_b(−δ).

    A child c that did not rotate with the joint keeps its orientation: q'_c = R_b(δ) ⊗ q_c. The
    joint at the end of the bone keeps its position.
    """
    skeleton, rotations = motion.skeleton, motion.rotations.copy()
    for joint, own in _by_joint(skeleton, intervals):
        if (axis := own_bone_axis(skeleton, joint)) is None:
            continue
        offset = _sum_of_offsets(own, motion.frames)
        at = np.flatnonzero(offset)
        back = quaternion_from_axis_angle(axis, -offset[at])
        rotations[at, joint] = normalise(multiply(rotations[at, joint], back))
        kept = _sum_of_offsets([i for i in own if not i.carried], motion.frames)
        at = np.flatnonzero(kept)
        ahead = quaternion_from_axis_angle(axis, kept[at])
        for child in skeleton.children[joint]:
            rotations[at, child] = normalise(multiply(ahead, rotations[at, child]))
    return motion.with_rotations(rotations)


def interpolate_joint_rotations(motion: Motion, intervals: Sequence[Interval]) -> Motion:
    """Interpolate joints' rotations between the frames before and after each interval (slerp).

    All descendants of a joint move with it. If an interval begins or ends the clip, the rotation of
    its only neighbouring frame is used. Frames with an offset of 0 do not change.
    """
    rotations = motion.rotations.copy()
    for joint, own in _by_joint(motion.skeleton, intervals):
        wrong = np.zeros(motion.frames, dtype=np.bool_)
        for interval in own:
            wrong[interval.start : interval.stop] |= interval.offset != 0.0
        for start, stop in runs_of_true(wrong):
            ends = [t for t in (start - 1, stop) if 0 <= t < motion.frames]
            if ends:
                share = np.arange(1, stop - start + 1) / (stop - start + 1)
                before, after = rotations[ends[0], joint], rotations[ends[-1], joint]
                rotations[start:stop, joint] = normalise(slerp(before, after, share))
    return motion.with_rotations(rotations)


def undo_constant_rotation(motion: Motion, intervals: Sequence[Interval]) -> Motion:
    """Undo a constant rotation of a joint in each interval, measured at the interval's edges.

    All descendants of the joint move with it. Intervals that begin or end the clip, and frames with
    an offset of 0, are not changed.
    """
    rotations = motion.rotations.copy()
    for joint, own in _by_joint(motion.skeleton, intervals):
        for interval in own:
            start, stop = interval.start, interval.stop
            if not (start > 0 and stop < motion.frames):
                continue
            edges = motion.rotations[[start - 1, start, stop - 1, stop], joint]
            back = conjugate(mean_edge_jump(jump_rotations_at_edges(edges)))
            at = start + np.flatnonzero(interval.offset)
            rotations[at, joint] = normalise(multiply(rotations[at, joint], back))
    return motion.with_rotations(rotations)


def _by_joint(
    skeleton: Skeleton, intervals: Iterable[Interval]
) -> Iterator[tuple[int, list[Interval]]]:
    own: dict[int, list[Interval]] = {}
    for interval in intervals:
        own.setdefault(interval_joint_index(skeleton, interval), []).append(interval)
    return iter(own.items())


def _sum_of_offsets(intervals: Iterable[Interval], frames: int) -> Array:
    total = np.zeros(frames)
    for interval in intervals:
        total[interval.start : interval.stop] += interval.offset
    return wrap(total)


TURN_BACK = JointRepair(remove_joint_roll)
BRIDGE = JointRepair(interpolate_joint_rotations, neighbours=1)
PUT_BACK = JointRepair(undo_constant_rotation, neighbours=1)
