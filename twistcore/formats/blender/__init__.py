"""Read scene files of other programs through a separate Blender process."""

from twistcore.formats.blender.process import (
    SUFFIXES,
    TIME_LIMIT,
    Handover,
    find_blender,
    read_scene,
)

__all__ = ["SUFFIXES", "TIME_LIMIT", "Handover", "find_blender", "read_scene"]
