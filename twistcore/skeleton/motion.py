"""Skeletons, their motion, and forward kinematics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, wraps
from typing import Protocol, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

Of = TypeVar("Of")  # a motion or a skeleton
Known = TypeVar("Known")

_ELEMENTS = 1 << 16  # maximum number of rotations that are computed in one block of frames


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A hierarchy of joints in file order, in which every parent precedes its children.

    Parameters
    ----------
    names : tuple of str
        Names of the joints, without duplicates.
    parents : ndarray of int, shape (joints,)
        Index of each joint's parent, or −1 for a root.
    offsets : ndarray, shape (joints, 3)
        Offset (x, y, z) of each joint from its parent, in the parent's coordinates and in the
        file's length unit.
    ends : tuple of (int, (float, float, float))
        For each End Site, the joint to which it belongs and its offset from that joint.
    rotatable : ndarray of bool, shape (joints,), optional
        True for a joint with rotation channels about three axes. None if all joints have them.

    Examples
    --------
    >>> import twistcore as tc
    >>> skeleton = tc.read_clip("assets/walk.bvh").skeleton
    >>> skeleton
    <Skeleton: 31 joints from Hips>
    >>> joint = skeleton.index("LeftForeArm")
    >>> skeleton.names[skeleton.parents[joint]]
    'LeftArm'
    """

    names: tuple[str, ...]
    parents: NDArray[np.int64]
    offsets: Array
    ends: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    rotatable: NDArray[np.bool_] | None = None

    def __repr__(self) -> str:
        roots = (name for name, parent in zip(self.names, self.parents, strict=True) if parent < 0)
        return f"<Skeleton: {len(self)} joints from {', '.join(roots)}>"

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """Return each joint's children, in file order."""
        found: list[list[int]] = [[] for _ in self.names]
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                found[parent].append(joint)
        return tuple(tuple(c) for c in found)

    @cached_property
    def end_offsets(self) -> dict[int, Array]:
        """Return the offset of each joint's first End Site, shape (3,), keyed by joint.

        Joints without an End Site have no entry.
        """
        return {joint: np.array(offset) for joint, offset in reversed(self.ends)}

    @cached_property
    def levels(self) -> tuple[NDArray[np.int64], ...]:
        """Return the joints grouped by depth, roots first."""
        depth = np.zeros(len(self), dtype=np.int64)
        for joint, parent in enumerate(self.parents):
            depth[joint] = depth[parent] + 1 if parent >= 0 else 0
        order = np.argsort(depth, kind="stable")
        return tuple(np.split(order, np.cumsum(np.bincount(depth))[:-1]))

    @cached_property
    def height(self) -> float:
        """Return the largest extent of the rest pose along an axis, in the file's unit.

        The result is 1 if all joints are at the same position.
        """
        rest = np.zeros((len(self), 3))
        for joint, parent in enumerate(self.parents):
            rest[joint] = self.offsets[joint] + (rest[parent] if parent >= 0 else 0.0)
        tips = [rest[joint] + offset for joint, offset in self.ends]
        every = np.vstack([rest, *(t[None] for t in tips)])
        extent = float(np.ptp(every, axis=0).max())
        return extent if extent > 0.0 else 1.0

    def index(self, name: str) -> int:
        """Return the index of the joint with this name, or raise KeyError if there is none."""
        try:
            return self.names.index(name)
        except ValueError:
            raise KeyError(name) from None


@dataclass(frozen=True, eq=False)
class Motion:
    """A skeleton's local rotations and translations in every frame.

    Parameters
    ----------
    skeleton : Skeleton
        The joints.
    rotations : ndarray, shape (frames, joints, 4)
        Unit quaternions (w, x, y, z) that convert a joint's coordinates to its parent's.
    positioned : tuple of int
        Indices of the joints that have position channels.
    positions : ndarray, shape (frames, len(positioned), 3)
        Translations (x, y, z) of these joints, in the file's length unit.
    frame_time : float
        Seconds from one frame to the next.
    angle_step : float
        Step to which the file's angles are rounded, in radians. 0 if it is too fine to matter.

    Examples
    --------
    >>> import twistcore as tc
    >>> motion = tc.read_clip("assets/walk.bvh").motion
    >>> motion
    <Motion: 344 frames at 120 fps, 31 joints>
    >>> motion.rotations.shape, round(motion.duration, 2)
    ((344, 31, 4), 2.87)
    """

    skeleton: Skeleton
    rotations: Array
    positioned: tuple[int, ...]
    positions: Array
    frame_time: float
    angle_step: float = 0.0

    def __repr__(self) -> str:
        return f"<Motion: {self.frames} frames at {self.fps:g} fps, {len(self.skeleton)} joints>"

    @property
    def frames(self) -> int:
        """Return the number of frames."""
        return len(self.rotations)

    @property
    def fps(self) -> float:
        """Return the number of frames per second."""
        return 1.0 / self.frame_time

    @property
    def duration(self) -> float:
        """Return the duration in seconds, which is the number of frames times the frame time."""
        return self.frames * self.frame_time

    @property
    def times(self) -> Array:
        """Return the time of each frame in seconds, counted from the first frame, (frames,)."""
        return np.arange(self.frames, dtype=np.float64) * self.frame_time

    @cached_property
    def _places(self) -> dict[int, int]:
        return {joint: place for place, joint in enumerate(self.positioned)}

    def translation(self, joint: int) -> Array:
        """Return a joint's translation from its parent, in the file's unit.

        The shape is (frames, 3) for a joint with position channels, and (3,) for others.
        """
        if (place := self._places.get(joint)) is not None:
            return self.positions[:, place]
        offset: Array = self.skeleton.offsets[joint]
        return offset

    def with_rotations(self, rotations: Array) -> Motion:
        """Return a copy with different local rotations, shape (frames, joints, 4)."""
        return replace(self, rotations=rotations)

    def at(self, frames: NDArray[np.intp]) -> Motion:
        """Return the motion at the given frames only."""
        return replace(self, rotations=self.rotations[frames], positions=self.positions[frames])

    def sliced(self, start: int, stop: int) -> Motion:
        """Return the motion in frames [start, stop)."""
        return replace(
            self, rotations=self.rotations[start:stop], positions=self.positions[start:stop]
        )


class HasMotion(Protocol):
    """A clip, or any other object with a motion."""

    @property
    def motion(self) -> Motion:
        """Return the motion."""
        ...


def motion_of(clip: Motion | HasMotion) -> Motion:
    """Return the motion of a clip or, for a motion, the motion itself.

    Raises TypeError for anything else.
    """
    motion = clip if isinstance(clip, Motion) else getattr(clip, "motion", None)
    if isinstance(motion, Motion):
        return motion
    raise TypeError(f"expected a clip or a motion, found {type(clip).__name__} {clip!r:.80}")


def cache_per_object(work: Callable[[Of], Known]) -> Callable[[Of], Known]:
    """Cache a function's result for each motion or skeleton, as long as that object exists.

    Callers share the result, so they must not change it. The result must not refer to the motion or
    skeleton, because then neither would ever be released.
    """
    known: WeakKeyDictionary[Of, Known] = WeakKeyDictionary()

    @wraps(work)
    def kept(of: Of) -> Known:
        try:
            return known[of]
        except KeyError:
            return known.setdefault(of, work(of))

    return kept


def check_motion(thing: object) -> None:
    """Raise TypeError if `thing` is not a motion. For a clip, the message suggests `.motion`."""
    if not isinstance(thing, Motion):
        inside = isinstance(getattr(thing, "motion", None), Motion)
        its = "; pass its .motion instead" if inside else ""
        raise TypeError(f"expected a Motion, found {thing!r:.80}{its}")


def forward_kinematics(motion: Motion) -> tuple[Array, Array]:
    """Return the global rotations and positions of all joints.

    Returns
    -------
    rotations : ndarray, shape (frames, joints, 4)
        Unit quaternions (w, x, y, z) that convert a joint's coordinates to global ones.
    positions : ndarray, shape (frames, joints, 3)
        Positions (x, y, z), in the file's length unit.
    """
    joints = len(motion.skeleton)
    positions = np.empty((motion.frames, joints, 3))
    rotations = np.empty((motion.frames, joints, 4))
    offsets = np.ascontiguousarray(motion.skeleton.offsets.T)[..., None]
    # Frames are processed in blocks that fit into the processor's cache. Frames are the last axis,
    # so that all operations use contiguous memory.
    step = max(64, _ELEMENTS // max(joints, 1))
    for a in range(0, motion.frames, step):
        q = np.ascontiguousarray(motion.rotations[a : a + step].transpose(2, 1, 0))
        p = np.empty((3, joints, q.shape[2]))
        p[:] = offsets
        if motion.positioned:
            p[:, list(motion.positioned)] = motion.positions[a : a + step].transpose(2, 1, 0)
        for level in motion.skeleton.levels[1:]:
            _descend(q, p, level, motion.skeleton.parents[level])
        rotations[a : a + step] = q.transpose(2, 1, 0)
        positions[a : a + step] = p.transpose(2, 1, 0)
    return rotations, positions


def _descend(q: Array, p: Array, level: NDArray[np.int64], above: NDArray[np.int64]) -> None:
    """Convert local values to global ones, in place, for the joints of one level of the hierarchy.

    Parameters
    ----------
    q
        Rotations, shape (4, joints, frames).
    p
        Positions, shape (3, joints, frames).
    level, above
        Indices of the joints and of their parents.
    """
    aw, ax, ay, az = q[:, above]
    bw, bx, by, bz = q[:, level]
    q[0, level] = aw * bw - ax * bx - ay * by - az * bz
    q[1, level] = aw * bx + ax * bw + ay * bz - az * by
    q[2, level] = aw * by - ax * bz + ay * bw + az * bx
    q[3, level] = aw * bz + ax * by - ay * bx + az * bw
    px, py, pz = p[:, level]
    # The rotated vector is v + w·t + u × t with t = 2 u × v.
    tx, ty, tz = ay * pz - az * py, az * px - ax * pz, ax * py - ay * px
    tx, ty, tz = tx + tx, ty + ty, tz + tz
    p[0, level] = p[0, above] + (px + aw * tx + (ay * tz - az * ty))
    p[1, level] = p[1, above] + (py + aw * ty + (az * tx - ax * tz))
    p[2, level] = p[2, above] + (pz + aw * tz + (ax * ty - ay * tx))
