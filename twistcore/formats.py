"""The formats that clips come in: one way to read them all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from twistcore.amc import read_amc
from twistcore.bvh import read_bvh
from twistcore.clip import Clip
from twistcore.npz import read_npz
from twistcore.npz.archive import names_in
from twistcore.npz.npz_clip import POSES
from twistcore.progress import Tell, nobody

_READERS: Mapping[str, Callable[..., Clip]] = {
    ".bvh": read_bvh,
    ".npz": read_npz,
    ".amc": read_amc,
}
CLIP_SUFFIXES = tuple(_READERS)
CLIP_PATTERNS = " ".join(f"*{suffix}" for suffix in CLIP_SUFFIXES)  # as file dialogs have them


def is_clip(path: str | Path) -> bool:
    """Whether a file is a clip by its name, in capitals or not."""
    return Path(path).suffix.lower() in _READERS


def is_other_data(path: str | Path) -> bool:
    """Whether a file is an .npz without poses: a body's shape, say, as lie beside AMASS's clips.

    Reads its directory; a damaged file is none, so that reading it says what is wrong, and no
    device is, which to open might wait for good.
    """
    if Path(path).suffix.lower() != ".npz" or not Path(path).is_file():
        return False
    names = names_in(Path(path))
    return names is not None and POSES not in names


def read_clip(path: str | Path, *, fps: float | None = None, tell: Tell = nobody) -> Clip:
    """Read a clip in the format that its name ends in, a BVH where that says nothing.

    fps: instead of the rate in the file; tell: how far it is. Raises the format's own TwistError
    for what cannot be read without a guess that would move a joint; what was assumed harmlessly is
    in Clip.warnings.
    """
    read = _READERS.get(Path(path).suffix.lower(), read_bvh)
    return read(path, fps=fps, tell=tell)
