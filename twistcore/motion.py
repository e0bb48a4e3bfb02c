"""A skeleton and its motion, and forward kinematics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.rotation import Array, multiply, rotate


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints in file order: a parent always comes before its children.

    names: unique; parents: index of the parent or −1, shape (joints,); offsets: from the parent in
    the parent's coordinates, the file's length unit, shape (joints, 3); ends: End Sites as
    (joint, offset); rotatable: True where the joint has rotation channels about three axes.
    """

    names: tuple[str, ...]
    parents: NDArray[np.int64]
    offsets: Array
    ends: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    rotatable: NDArray[np.bool_] | None = None

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """Children of every joint, in file order."""
        found: list[list[int]] = [[] for _ in self.names]
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                found[parent].append(joint)
        return tuple(tuple(c) for c in found)

    @cached_property
    def end_offsets(self) -> dict[int, Array]:
        """Offset of the first End Site of every joint that has one, (3,) by joint."""
        return {joint: np.array(offset) for joint, offset in reversed(self.ends)}

    @cached_property
    def levels(self) -> tuple[NDArray[np.int64], ...]:
        """Joints grouped by depth, the roots first."""
        depth = np.zeros(len(self), dtype=np.int64)
        for joint, parent in enumerate(self.parents):
            depth[joint] = depth[parent] + 1 if parent >= 0 else 0
        return tuple(np.flatnonzero(depth == d) for d in range(int(depth.max()) + 1))

    @cached_property
    def height(self) -> float:
        """Largest extent of the rest pose along one axis, the file's length unit; never 0."""
        rest = np.zeros((len(self), 3))
        for joint, parent in enumerate(self.parents):
            rest[joint] = self.offsets[joint] + (rest[parent] if parent >= 0 else 0.0)
        tips = [rest[joint] + offset for joint, offset in self.ends]
        every = np.vstack([rest, *(t[None] for t in tips)])
        extent = float(np.ptp(every, axis=0).max())
        return extent if extent > 0.0 else 1.0

    def index(self, name: str) -> int:
        """Index of a joint by name; KeyError where there is none."""
        try:
            return self.names.index(name)
        except ValueError:
            raise KeyError(name) from None


@dataclass(frozen=True, eq=False)
class Motion:
    """Local rotations and translations over time.

    rotations: unit quaternions (w, x, y, z), child's into parent's coordinates, shape
    (frames, joints, 4); positioned: the joints whose translation comes from position channels;
    positions: those translations, shape (frames, len(positioned), 3); frame_time: seconds.
    """

    skeleton: Skeleton
    rotations: Array
    positioned: tuple[int, ...]
    positions: Array
    frame_time: float

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.rotations)

    @property
    def fps(self) -> float:
        """Frames a second."""
        return 1.0 / self.frame_time

    def translation(self, joint: int) -> Array:
        """Translation from the parent: (3,) from OFFSET, (frames, 3) from position channels."""
        if joint in self.positioned:
            return self.positions[:, self.positioned.index(joint)]
        offset: Array = self.skeleton.offsets[joint]
        return offset

    def with_rotations(self, rotations: Array) -> Motion:
        """The same motion with other local rotations, shape (frames, joints, 4)."""
        return replace(self, rotations=rotations)

    def sliced(self, start: int, stop: int) -> Motion:
        """Frames [start, stop)."""
        return replace(
            self, rotations=self.rotations[start:stop], positions=self.positions[start:stop]
        )


def global_rotations(motion: Motion) -> Array:
    """Rotations of every joint into the world, shape (frames, joints, 4)."""
    out = motion.rotations.copy()
    for level in motion.skeleton.levels[1:]:
        out[:, level] = multiply(out[:, motion.skeleton.parents[level]], out[:, level])
    return out


def forward_kinematics(motion: Motion) -> tuple[Array, Array]:
    """Global rotations (frames, joints, 4) and positions (frames, joints, 3) of every joint."""
    skeleton = motion.skeleton
    rotations = global_rotations(motion)
    positions = np.broadcast_to(skeleton.offsets, (motion.frames, len(skeleton), 3)).copy()
    if motion.positioned:
        positions[:, list(motion.positioned)] = motion.positions
    for level in skeleton.levels[1:]:
        above = skeleton.parents[level]
        positions[:, level] = positions[:, above] + rotate(rotations[:, above], positions[:, level])
    return rotations, positions
