"""The formats that clips come in: one way to read them all."""

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

CLIP_PATTERNS = " ".join(f"*{suffix}" for suffix in CLIP_SUFFIXES)  # as file dialogs have them


def is_clip(path: str | Path) -> bool:
    """Whether a file is a clip by its name, in capitals or not."""
    return bool(clip_suffix(path))


def own_name(path: str | Path) -> str:
    """How the names of files about a clip begin, so that no two clips of a folder share them.

    A BVH's name without its ending; of another format the whole, since a BVH may lie beside it:
    05_05.bvh has 05_05.twist.json, 05_05.amc has 05_05.amc.twist.json. A BVH called
    05_05.amc.bvh keeps its ending, too.
    """
    path = Path(path)
    return path.stem if _format(path) is _format("") and not is_clip(path.stem) else path.name


def same_format(one: str | Path, other: str | Path) -> bool:
    """Whether two files are of one format by their names."""
    return _format(one) is _format(other)


def _format(path: str | Path) -> FormatInfo:
    """Return the format of a name; BVH where the name says nothing."""
    formats = known_formats()
    return formats.get(Path(path).suffix.lower(), formats[".bvh"])


def _named(function: str) -> Callable[..., Any]:
    """Return a function by 'module:function', loaded when it is needed."""
    module, _, name = function.partition(":")
    found: Callable[..., Any] = getattr(import_module(module), name)
    return found


def is_other_data(path: str | Path) -> bool:
    """Whether a file named as a clip holds none: a body's shape in an .npz, say, or a model.

    Reads an archive's directory and a pickle's beginning; a damaged archive is none, so that
    reading it says what is wrong, and no device is, which to open might wait for good.
    """
    asked = _format(path).without_motion
    return bool(asked) and is_file(path) and bool(_named(asked)(Path(path)))


def read_clip(path: str | Path, *, fps: float | None = None, tell: Tell | None = None) -> Clip:
    """Read a motion file: BVH, AMASS and SMPL (.npz, .pkl) or ASF/AMC, by the name's ending.

    Parameters
    ----------
    path : str or Path
        The file; a BVH if its ending is unknown.
    fps : float, optional
        Frames a second in place of the rate in the file.
    tell : callable, optional
        Called now and then with the share of the work that is done, 0…1.

    Returns
    -------
    Clip
        The clip. What was assumed without harm is in its `warnings`.

    Raises
    ------
    TwistError
        If the file cannot be read without a guess that would move a joint. The format's own error,
        with the line where there is one.

    See Also
    --------
    write_clip : Write it back.

    Examples
    --------
    >>> import twistcore as tc
    >>> tc.read_clip("assets/walk.bvh")
    <Clip walk.bvh: 344 frames at 120 fps, 31 joints>
    >>> tc.read_clip("assets/walk.bvh", fps=60).duration
    5.733333333333333
    """
    if Path(path).suffix.lower() == ".asf":
        raise AmcError(str(path), "expected a clip, found a skeleton without motion; open its .amc")
    if Path(path).is_dir():
        raise ClipError(str(path), "expected a clip, found a folder; use `batch` for folders")
    clip: Clip = _named(_format(path).read)(path, fps=fps, tell=tell)
    return clip
