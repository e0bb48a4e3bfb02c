"""A clip that was read from a file: its bytes, its motion, and how to rewrite it."""

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
from twistcore.files.atomic import (
    is_stream,
    same_file,
    write_atomically,
    write_missing_companion_files,
)
from twistcore.formats.suffixes import clip_suffix, unsupported_suffix_message
from twistcore.skeleton.motion import Motion, Skeleton, check_motion
from twistcore.skeleton.notation import rounding_step_of_angles
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SHORTEST, LONGEST = 1e-4, 1.0  # range of plausible frame times, seconds
_WARNINGS = 40
_POSES = 1 << 20  # every file with at most this many joints × frames can be read
_JOINTS_A_NUMBER = 2  # limit for larger files; real figures have nearly three numbers per joint


@dataclass(frozen=True)
class ClipWarning:
    """An assumption made while reading a file.

    Attributes
    ----------
    text
        The assumption, as a sentence.
    line
        Line in the file, counted from 1, or None if it is unknown.
    """

    text: str
    line: int | None = None

    def __str__(self) -> str:
        return self.text if self.line is None else f"Line {self.line}: {self.text}"


def shorten_warning_list(warnings: Sequence[ClipWarning]) -> list[ClipWarning]:
    """Return the first warnings and, if there are more, one that counts the rest.

    A file may have thousands of warnings.
    """
    if (left := len(warnings) - _WARNINGS) <= 1:
        return list(warnings)
    return [*warnings[:_WARNINGS], ClipWarning(f"{left} more warnings are not shown.")]


def too_few_numbers_message(joints: int, frames: int, columns: int) -> str | None:
    """Return an error message if a file has too few numbers for its joints and frames, or None.

    A damaged or malicious file can declare many joints and many frames in a few bytes, but the
    memory for poses is proportional to the product of these numbers.
    """
    if joints * frames <= _POSES or joints <= _JOINTS_A_NUMBER * columns:
        return None
    return (
        f"expected more joints with channels: {frames} frames of {joints} joints have only "
        f"{columns} numbers each"
    )


@dataclass(frozen=True)
class ChannelJump:
    """A step of more than 180° in a written channel that equivalent angles cannot avoid.

    The pose is right in every frame, but a program that interpolates channels between frames shows
    a spin.

    Parameters
    ----------
    joint
        The joint's name.
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
    """The bytes to write, and the channel jumps in them that could not be avoided."""

    data: bytes = field(repr=False)
    jumps: tuple[ChannelJump, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class Clip(ABC):
    """A motion file, as returned by :func:`read_clip`.

    Each file format has a subclass.

    Parameters
    ----------
    path : Path
        The file that was read.
    data : bytes
        The file's contents.
    skeleton : Skeleton
        The joints.
    frame_time : float
        Seconds from one frame to the next.
    warnings : tuple of ClipWarning
        Assumptions made while reading the file.
    declared_frames : int, optional
        Number of frames in the file's header. None if the format has no such number.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk.bvh")
    >>> clip
    <Clip walk.bvh: 344 frames at 120 fps, 31 joints>
    >>> clip.frames, round(clip.fps), round(clip.duration, 2), clip.format
    (344, 120, 2.87, 'bvh')
    """

    format: ClassVar[str]  # the format's file suffix, in lower case and without a dot

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
        """The bytes of other files that are needed to read this one, keyed by file name.

        These files are in the same folder.
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
        """Duration in seconds, which is the number of frames times the frame time."""
        return self.frames * self.frame_time

    @property
    def missing_frames(self) -> int:
        """Number of frames that the header declares but the file does not contain."""
        return max(0, (self.declared_frames or 0) - self.frames)

    @property
    @abstractmethod
    def columns(self) -> int:
        """Number of motion values per frame."""

    @cached_property
    def motion(self) -> Motion:
        """The clip's motion, computed on first use."""
        angles = (self.angles(joint) for joint in range(len(self.skeleton)))
        return replace(self.read_motion(), angle_step=rounding_step_of_angles(angles))

    @abstractmethod
    def read_motion(self) -> Motion:
        """Compute the motion from the numbers of the file. Its `angle_step` is not set."""

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the file's bytes, by which a session identifies its clip."""
        import hashlib  # slow to load; few commands need it

        return hashlib.sha256(self.data).hexdigest()

    @abstractmethod
    def angles(self, joint: int) -> Array:
        """Return a joint's rotation channels as written, in degrees, (frames, channels)."""

    @abstractmethod
    def euler(self, joint: int) -> tuple[str, Array] | None:
        """Return a joint's Euler order and its angles in radians, (frames, 3), or None.

        The angles refer to the axes of :meth:`as_written`. The result is None for a joint without
        three rotation channels.
        """

    def as_written(self, joint: int, q: Array) -> Array:
        """Convert a joint's rotation q, (…, 4), to the axes to which the file's angles refer."""
        del joint
        return q

    @abstractmethod
    def patched(
        self, motion: Motion, changed: NDArray[np.bool_], *, positions: bool = False
    ) -> Patch:
        """Return the file's bytes, with the rotations in `changed` replaced by those of `motion`.

        Other bytes stay the same.

        Parameters
        ----------
        motion
            The motion to write.
        changed
            Mask of the rotations to write, shape (frames, joints).
        positions
            True to also write positions in frames in which they differ.

        Raises
        ------
        ValueError
            If a changed joint has no rotation channels about three axes.
        """


def changed_rotations(clip: Clip, motion: Motion) -> NDArray[np.bool_]:
    """Return a mask of the local rotations that are not exactly equal to the clip's.

    The shape is (frames, joints).
    """
    if motion.rotations is clip.motion.rotations:
        return np.zeros(motion.rotations.shape[:2], dtype=np.bool_)
    differs = motion.rotations != clip.motion.rotations
    # Viewing four flags as one number is several times faster than any() along such a short axis.
    changed: NDArray[np.bool_] = differs.view(np.uint32)[..., 0] != 0
    return changed


def create_file_patch_for_motion(clip: Clip, motion: Motion) -> Patch:
    """Return the file's bytes, with all rotations and positions replaced by those of `motion`.

    Numbers that do not differ keep their bytes.
    """
    check_motion(motion)
    moved = motion.positions is not clip.motion.positions
    return clip.patched(motion, changed_rotations(clip, motion), positions=moved)


def check_clip_suffix(clip: Clip, path: Path) -> None:
    """Raise TwistError if the path's suffix belongs to a format other than the clip's."""
    if refused := unsupported_suffix_message(path, f".{clip.format}"):
        raise TwistError(f"{path}: {refused}")
    if clip_suffix(path) not in ("", f".{clip.format}"):
        raise TwistError(
            f"{path}: expected a name that ends in .{clip.format}, because {clip.name} is saved "
            "in its original format"
        )


def write_clip(
    clip: Clip, motion: Motion, path: str | Path, *, replace_source: bool = False
) -> tuple[ChannelJump, ...]:
    """Write a clip with new rotations and positions, in the format of its file.

    Only numbers that differ are rewritten; all other bytes stay the same. The file is written
    atomically. Other files that are needed to read it, such as a skeleton, are written next to it.

    Parameters
    ----------
    clip : Clip
        The clip as it was read.
    motion : Motion
        The new rotations and positions, as returned by :func:`refine`.
    path : str or Path
        The file to write. An existing file is replaced.
    replace_source : bool
        True to allow replacing the file that the clip was read from.

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
        If a changed joint has no rotation channels about three axes.
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
    check_clip_suffix(clip, path)
    if not replace_source and not is_stream(path) and same_file(path, clip.path):
        raise TwistError(
            f"{path}: expected a file other than the clip's own source (set "
            "replace_source=True to replace it)"
        )
    patch = create_file_patch_for_motion(clip, motion)
    if not is_stream(path):
        write_missing_companion_files(clip.companions, path.parent)
    write_atomically(path, patch.data)
    return patch.jumps
