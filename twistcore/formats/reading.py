"""The formats that clips come in: one way to read them all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from twistcore.errors import AmcError, ClipError
from twistcore.files.ordinary import is_file, open_to_read
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip
from twistcore.formats.suffixes import CLIP_SUFFIXES, clip_suffix
from twistcore.work.progress import Tell


# What reads the other formats is loaded when such a clip comes: most clips are BVH.
def _read_npz(path: str | Path, **how: Any) -> Clip:
    from twistcore.formats.npz import read_npz

    return read_npz(path, **how)


def _read_pkl(path: str | Path, **how: Any) -> Clip:
    from twistcore.formats.npz import read_pkl

    return read_pkl(path, **how)


def _read_amc(path: str | Path, **how: Any) -> Clip:
    from twistcore.formats.amc import read_amc

    return read_amc(path, **how)


_READERS: Mapping[str, Callable[..., Clip]] = {
    ".bvh": read_bvh,
    ".npz": _read_npz,
    ".amc": _read_amc,
    ".pkl": _read_pkl,
}
_HEAD = 1 << 16  # bytes of a pickle in which its names are looked for
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
    return path.stem if _reader(path) is read_bvh and not is_clip(path.stem) else path.name


def same_format(one: str | Path, other: str | Path) -> bool:
    """Whether two files are of one format by their names."""
    return _reader(one) is _reader(other)


def _reader(path: str | Path) -> Callable[..., Clip]:
    """By the name; a BVH's where that says nothing."""
    return _READERS.get(Path(path).suffix.lower(), read_bvh)


def is_other_data(path: str | Path) -> bool:
    """Whether a file is an .npz or a pickle without poses: a body's shape, say, or a model.

    Reads an archive's directory and a pickle's beginning; a damaged archive is none, so that
    reading it says what is wrong, and no device is, which to open might wait for good.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (".npz", ".pkl") or not is_file(path):
        return False
    from twistcore.formats.npz.archive import names_in
    from twistcore.formats.npz.pose_names import SMPL_POSES, has_pose_names

    if suffix == ".npz":
        names = names_in(Path(path))
        return names is not None and not has_pose_names(names)
    try:
        with open_to_read(path) as file:
            return SMPL_POSES.encode() not in file.read(_HEAD)
    except OSError:
        return False


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
        raise ClipError(str(path), "expected a clip, found a folder; `batch` takes folders")
    return _reader(path)(path, fps=fps, tell=tell)
