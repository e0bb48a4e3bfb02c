"""Read clips of any format."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from twistcore.errors import AmcError, ClipError
from twistcore.files.ordinary import is_file
from twistcore.formats.clip import Clip
from twistcore.formats.suffixes import CLIP_SUFFIXES, FormatInfo, clip_suffix, known_formats
from twistcore.work.progress import Tell

CLIP_PATTERNS = " ".join(f"*{suffix}" for suffix in CLIP_SUFFIXES)  # for the filter of file dialogs


def is_clip(path: str | Path) -> bool:
    """Return True if a file name has the suffix of a clip. Case is ignored."""
    return bool(clip_suffix(path))


def companion_file_prefix(path: str | Path) -> str:
    """Return a prefix for the names of files that belong to a clip, unique in the clip's folder.

    For a BVH file, the prefix is the name without its suffix, so the session of 05_05.bvh is
    05_05.twist.json. For other formats, the prefix is the whole name, because a BVH of the same
    name may be in the folder: the session of 05_05.amc is 05_05.amc.twist.json. A BVH called
    05_05.amc.bvh also keeps its suffix.
    """
    path = Path(path)
    return path.stem if _format(path) is _format("") and not is_clip(path.stem) else path.name


def same_format(one: str | Path, other: str | Path) -> bool:
    """Return True if two file names have suffixes of the same format."""
    return _format(one) is _format(other)


def _format(path: str | Path) -> FormatInfo:
    """Return the file format given by the suffix, or BVH if the suffix is unknown."""
    formats = known_formats()
    return formats.get(Path(path).suffix.lower(), formats[".bvh"])


def _named(function: str) -> Callable[..., Any]:
    """Import and return the function given as 'module:function'."""
    module, _, name = function.partition(":")
    found: Callable[..., Any] = getattr(import_module(module), name)
    return found


def is_clip_without_motion(path: str | Path) -> bool:
    """Return True if a file has a clip's suffix but no motion, like an .npz with a body's shape.

    Only the archive's directory or the beginning of the pickle is read. The result is False for a
    damaged archive, so that reading it reports an error, and for a device, because opening it might
    block forever.
    """
    test = _format(path).without_motion
    return bool(test) and is_file(path) and bool(_named(test)(Path(path)))


def read_clip(path: str | Path, *, fps: float | None = None, tell: Tell | None = None) -> Clip:
    """Read a motion file: BVH, AMASS or SMPL (.npz, .pkl), or ASF/AMC.

    The file's suffix determines the format.

    Parameters
    ----------
    path : str or Path
        The file. If its suffix is unknown, it is read as BVH.
    fps : float, optional
        The frame rate, in frames per second, to use instead of the file's.
    tell : callable, optional
        Called repeatedly with the progress, 0…1.

    Returns
    -------
    Clip
        The clip. Harmless assumptions are listed in its `warnings`.

    Raises
    ------
    TwistError
        If the file is invalid or cannot be read without a guess that would move a joint. Each
        format has a subclass, with the line number if it is known.

    See Also
    --------
    write_clip : Write a corrected clip.

    Examples
    --------
    >>> import twistcore as tc
    >>> tc.read_clip("assets/walk.bvh")
    <Clip walk.bvh: 344 frames at 120 fps, 31 joints>
    >>> tc.read_clip("assets/walk.bvh", fps=60).duration
    5.733333333333333
    """
    if Path(path).suffix.lower() == ".asf":
        raise AmcError(
            str(path), "expected a clip, found a skeleton without motion; open its .amc instead"
        )
    if Path(path).is_dir():
        raise ClipError(str(path), "expected a clip, found a folder; use `batch` for folders")
    clip: Clip = _named(_format(path).read)(path, fps=fps, tell=tell)
    return clip
