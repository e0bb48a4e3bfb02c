"""Read and write clips. Each file format has a subpackage."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from twistcore.formats.clip import Clip, write_clip
    from twistcore.formats.reading import (
        CLIP_PATTERNS,
        file_prefix,
        is_clip,
        is_other_data,
        read_clip,
        same_format,
    )

__all__ = [
    "CLIP_PATTERNS",
    "Clip",
    "file_prefix",
    "is_clip",
    "is_other_data",
    "read_clip",
    "same_format",
    "write_clip",
]

if not TYPE_CHECKING:
    # Loaded on first use: checking the suffix of a file name needs neither a reader nor numpy.
    _HOMES = {
        "clip": "Clip write_clip",
        "reading": "CLIP_PATTERNS file_prefix is_clip is_other_data read_clip same_format",
    }

    def __getattr__(name: str) -> object:
        for module, names in _HOMES.items():
            if name in names.split():
                globals()[name] = value = getattr(import_module(f"{__name__}.{module}"), name)
                return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
