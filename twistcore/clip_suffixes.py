"""How files of each format end: known without loading any reader, or numpy."""

from __future__ import annotations

from pathlib import PurePath

CLIP_SUFFIXES = (".bvh", ".npz", ".amc")


def clip_suffix(name: PurePath | str) -> str:
    """The suffix of a clip's name, in small letters; '' where it is none of a clip."""
    suffix = PurePath(name).suffix.lower()
    return suffix if suffix in CLIP_SUFFIXES else ""
