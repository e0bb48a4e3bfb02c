"""A clip that was read from a file: its bytes, its motion, and how to rewrite its numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.files.atomic import is_stream, same_file, write_atomically, write_companions
from twistcore.formats.suffixes import clip_suffix, not_written
from twistcore.skeleton.motion import Motion, Skeleton, check_motion
from twistcore.skeleton.notation import angle_step
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SHORTEST, LONGEST = 1e-4, 1.0  # seconds: range of plausible frame times
_WARNINGS = 40
_POSES = 1 << 20  # joints × frames up to which every file can be read
_JOINTS_A_NUMBER = 2  # the limit for larger files; a real figure has nearly three numbers per joint


@dataclass(frozen=True)
class ClipWarning:
    """An assumption made while reading a file.

    The warning has a sentence and, if known, the line in the file, counted from 1.
    """

    text: str
    line: int | None = None

    def __str__(self) -> str:
        return self.text if self.line is None else f"Line {self.line}: {self.text}"


def some_of(warnings: Sequence[ClipWarning]) -> list[ClipWarning]:
    """Return the first warnings, and one that counts the rest. A file may have thousands."""
    if (left := len(warnings) - _WARNINGS) <= 1:
        return list(warnings)
    return [*warnings[:_WARNINGS], ClipWarning(f"{left} more warnings are not shown.")]


def too_few_numbers(joints: int, frames: int, columns: int) -> str | None:
    """Return a message if a file has far too few numbers for its joints and frames, or None.

    A damaged or malicious file can declare many joints and many frames in a few bytes each, but the
    poses need memory in proportion to the product of both numbers.
    """
    if joints * frames <= _POSES or joints <= _JOINTS_A_NUMBER * columns:
        return None
    return (
        f"expected more joints with channels: {frames} frames of {joints} joints have only "
        f"{columns} numbers each"
    )


@dataclass(frozen=True)
class ChannelJump:
    """A step of more than 180° in a written channel that no choice of equivalent angles avoids.

    The pose is right in every frame, but a program that interpolates the channels between frames
    shows a spin.

    Parameters
    ----------
    frame
        The frame after the step.
    channel
        The channel's name, such as 'Zrotation'.
    """

    joint: str
    frame: int
    channel: str

    def __str__(self) -> str:
        return f"{self.joint} {self.channel} jumps by a full turn at frame {self.frame}"


@dataclass(frozen=True, eq=False)
class Patch:
    """The bytes to write, and the channel jumps that remain in them."""

    data: bytes = field(repr=False)
    jumps: tuple[ChannelJump, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class Clip(ABC):
    """A motion file as returned by `read_clip`.

    Every format has its own subclass, which rewrites the numbers of that format.

    Parameters
    ----------
    path : Path
        The file that was read.
    data : bytes
        The contents of the file, which never change.
    skeleton : Skeleton
        The joints.
    frame_time : float
        Seconds from one frame to the next.
    warnings : tuple of ClipWarning
        Assumptions made while reading the file.
    declared_frames : int, optional
        The number of frames in the file's header; None if the format has no such number.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk.bvh")
    >>> clip
    <Clip walk.bvh: 344 frames at 120 fps, 31 joints>
    >>> clip.frames, round(clip.fps), round(clip.duration, 2), clip.format
    (344, 120, 2.87, 'bvh')
    """

    format: ClassVar[str]  # in lower case, like the file suffix

    path: Path
    data: bytes = field(repr=False)
    skeleton: Skeleton
    frame_time: float
    warnings: tuple[ClipWarning, ...] = ()
    declared_frames: int | None = None

    def __repr__(self) -> str:
        size = f"{self.frames} frames at {self.fps:g} fps"
        return f"<Clip {self.name}: {size}, {len(self.skeleton)} joints>"

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

    @property
    def companions(self) -> Mapping[str, bytes]:
        """Other files in the same folder that are needed to read this one, keyed by name.

        The values are the bytes of the files.
        """
        return {}

    @property
    @abstractmethod
    def frames(self) -> int:
        """Number of frames."""

    @property
    def fps(self) -> float:
        """Frames per second."""
        return 1.0 / self.frame_time

    @property
    def duration(self) -> float:
        """Duration in seconds: the number of frames times the frame time."""
        return self.frames * self.frame_time

    @property
    def missing_frames(self) -> int:
        """Number of frames that are declared in the header but missing in the file."""
        return max(0, (self.declared_frames or 0) - self.frames)

    @property
    @abstractmethod
    def columns(self) -> int:
        """The number of motion values in a frame."""

    @cached_property
    def motion(self) -> Motion:
        """The motion in the file, computed on first use."""
        angles = (self.angles(joint) for joint in range(len(self.skeleton)))
        return replace(self.read_motion(), angle_step=angle_step(angles))

    @abstractmethod
    def read_motion(self) -> Motion:
        """Compute the motion for :attr:`motion`."""

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the file's bytes, with which a session identifies its clip."""
        import hashlib  # slow to load; few commands need it

        return hashlib.sha256(self.data).hexdigest()

    @abstractmethod
    def angles(self, joint: int) -> Array:
        """Return a joint's rotation channels as written, in degrees, (frames, channels)."""

    @abstractmethod
    def euler(self, joint: int) -> tuple[str, Array] | None:
        """Return a joint's Euler order and angles in radians, (frames, 3), or None.

        The result is None for a joint without three channels. The axes are those of
        :meth:`as_written`.
        """

    def as_written(self, joint: int, q: Array) -> Array:
        """Convert a joint's rotation q, (…, 4), to the axes of the angles of :meth:`euler`."""
        del joint
        return q

    @abstractmethod
    def patched(
        self, motion: Motion, changed: NDArray[np.bool_], *, positions: bool = False
    ) -> Patch:
        """Return the file's bytes with the rotations of `motion` at `changed`, (frames, joints).

        If `positions` is True, positions that differ are also rewritten. All other bytes stay the
        same. Raises ValueError for a joint without channels for three axes in the file.
        """


def changed_rotations(clip: Clip, motion: Motion) -> NDArray[np.bool_]:
    """Return a mask of local rotations that differ from the clip's in any bit, (frames, joints)."""
    if motion.rotations is clip.motion.rotations:
        return np.zeros(motion.rotations.shape[:2], dtype=np.bool_)
    differs = motion.rotations != clip.motion.rotations
    # Viewing four flags as one number is several times faster than any() along so short an axis.
    changed: NDArray[np.bool_] = differs.view(np.uint32)[..., 0] != 0
    return changed


def rewritten(clip: Clip, motion: Motion) -> Patch:
    """Return the file's bytes with the rotations and positions of `motion` wherever they differ."""
    check_motion(motion)
    moved = motion.positions is not clip.motion.positions
    return clip.patched(motion, changed_rotations(clip, motion), positions=moved)


def check_ending(clip: Clip, path: Path) -> None:
    """Raise TwistError if the path has the suffix of a format other than the clip's."""
    if refused := not_written(path, f".{clip.format}"):
        raise TwistError(f"{path}: {refused}")
    if clip_suffix(path) not in ("", f".{clip.format}"):
        raise TwistError(
            f"{path}: expected a name that ends in .{clip.format}, because {clip.name} is written "
            "in its own format"
        )


def write_clip(
    clip: Clip, motion: Motion, path: str | Path, *, replace_source: bool = False
) -> tuple[ChannelJump, ...]:
    """Write a clip with new rotations and positions, in the format of the file it was read from.

    Only numbers that differ are rewritten; all other bytes stay the same. The file is written
    atomically. Other files that are needed to read it are written next to it.

    Parameters
    ----------
    clip : Clip
        The clip as it was read.
    motion : Motion
        The new rotations and positions, as returned by :func:`refine`.
    path : str or Path
        The file to write. An existing file is replaced.
    replace_source : bool
        True to allow overwriting the file that the clip was read from.

    Returns
    -------
    tuple of ChannelJump
        Steps of more than 180° between written angles that could not be avoided.

    Raises
    ------
    TypeError
        If `motion` is not a Motion.
    TwistError
        If the clip's source file would be replaced, or `path` has the suffix of another format.
    ValueError
        If a changed joint cannot be turned about three axes in the file.
    OSError
        If the file cannot be written.

    See Also
    --------
    write_motion : Write a motion that does not come from a file.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk_injected.bvh")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "walk_refined.bvh"
    ...     jumps = tc.write_clip(clip, tc.detect(clip).refined(), path)
    ...     len(tc.detect(tc.read_clip(path)))
    0
    """
    path = Path(path)
    check_ending(clip, path)
    if not replace_source and not is_stream(path) and same_file(path, clip.path):
        raise TwistError(
            f"{path}: expected a file other than the clip's own source (set "
            "replace_source=True to replace it)"
        )
    patch = rewritten(clip, motion)
    if not is_stream(path):
        write_companions(clip.companions, path.parent)
    write_atomically(path, patch.data)
    return patch.jumps
