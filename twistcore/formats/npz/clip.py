"""A clip of SMPL poses, read from a file with named arrays."""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.clip import ChannelJump, Clip, Patch
from twistcore.formats.npz.pose_names import PosePart
from twistcore.formats.npz.stored_arrays import Arrays
from twistcore.formats.npz.vector_branch import continuous_npz_rotation_vectors
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, exponential
from twistcore.work.frozen import dataclass


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class NpzClip(Clip):
    """A clip read from an .npz file of poses, such as AMASS's (docs/amass.md).

    Parameters
    ----------
    archive
        The file's arrays.
    poses
        Rotation vectors of all joints, in radians and the file's dtype, shape (frames, 3 · joints).
    parts
        The arrays that together contain each number of `poses` once.
    place
        Name of the array with the root's position, or '' if there is none.
    trans
        The array `place`: the root's position minus `rest`, shape (frames, 3).
    scale
        Units of `trans` per metre.
    rest
        The root's rest position, metres, shape (3,).
    repeated
        Arrays that repeat numbers of `poses` and are rewritten with them.
    """

    format = "npz"

    archive: Arrays = field(repr=False)
    poses: NDArray[Any]
    parts: tuple[PosePart, ...]
    place: str
    trans: NDArray[Any]
    scale: float = 1.0
    rest: Array
    repeated: tuple[PosePart, ...] = ()

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.poses)

    @property
    def columns(self) -> int:
        """Number of values per frame, in the pose and the position."""
        return int(self.poses.shape[1]) + 3

    def read_motion(self) -> Motion:
        """Return the motion, in the file's axes and in metres."""
        rotations = exponential(self._vectors(slice(None)))
        places = np.asarray(self.trans, dtype=np.float64) / self.scale + self.rest
        return Motion(self.skeleton, rotations, (0,), places[:, None], self.frame_time)

    def _vectors(self, joint: int | slice) -> Array:
        vectors = self.poses.reshape(self.frames, -1, 3)[:, joint]
        return np.asarray(vectors, dtype=np.float64)

    def angles(self, joint: int) -> Array:
        """Return a joint's rotation vector in degrees, (frames, 3)."""
        return np.degrees(self._vectors(joint))

    def euler(self, joint: int) -> tuple[str, Array] | None:
        """Return None, because the file has rotation vectors instead of Euler angles."""
        del joint
        return None

    def patched(
        self, motion: Motion, changed: NDArray[np.bool_], *, positions: bool = False
    ) -> Patch:
        """Return the file's bytes, with the rotations in `changed` replaced by those of `motion`.

        All other numbers and arrays stay identical, except that arrays that repeat the poses are
        updated.

        Parameters
        ----------
        motion
            The motion to write.
        changed
            Mask of the rotations to write, shape (frames, joints).
        positions
            True to also write root positions in frames in which they differ.
        """
        arrays: dict[str, NDArray[Any]] = {}
        jumps: list[ChannelJump] = []
        if changed.any():
            poses = self.poses.copy()
            for joint in np.flatnonzero(changed.any(axis=0)).tolist():
                found, jumped = self._turned(joint, changed[:, joint], motion.rotations[:, joint])
                poses[changed[:, joint], 3 * joint : 3 * joint + 3] = found
                jumps += jumped
            for part in (*self.parts, *self.repeated):
                here = slice(part.start, part.stop)
                if changed[:, part.start // 3 : part.stop // 3].any():
                    # A part may have a narrower dtype than `poses`. Values that did not change fit
                    # into it.
                    own = self.archive.array(part.name).dtype
                    arrays[part.name] = poses[:, here].astype(own)
        if positions and self.place:
            there, now = self.motion.positions[:, 0], motion.positions[:, 0]
            if (moved := there != now).any():
                arrays[self.place] = trans = self.trans.copy()
                trans[moved] = self.scale * (now - self.rest)[moved]
        return Patch(self.archive.with_arrays(arrays) if arrays else self.data, tuple(jumps))

    def _turned(
        self, joint: int, changed: NDArray[np.bool_], q: Array
    ) -> tuple[Array, list[ChannelJump]]:
        """Return a joint's changed rotation vectors, (n, 3), and its steps above half a turn.

        `changed` is a mask of frames, and `q` are the joint's new rotations in all frames, (frames,
        4).
        """
        own, out, jumps = self._vectors(joint), [], []
        edges = np.flatnonzero(np.diff(changed, prepend=False, append=False)).reshape(-1, 2)
        for start, stop in edges.tolist():
            before = own[start - 1] if start > 0 else None
            after = own[stop] if stop < len(own) else None
            found = continuous_npz_rotation_vectors(q[start:stop], own[start:stop], before, after)
            out.append(found)
            line = np.stack([v for v in (before, *found, after) if v is not None])
            first = start - (before is not None)
            steps = np.abs(np.diff(line, axis=0))
            for row, axis in np.argwhere(steps > np.pi).tolist():
                name = self.skeleton.names[joint]
                jumps.append(ChannelJump(name, first + row + 1, f"{'xyz'[axis]} rotation"))
        return np.concatenate(out), jumps


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class PklClip(NpzClip):
    """A clip read from a pickle of poses, such as AIST++'s, without executing the pickle."""

    format = "pkl"
