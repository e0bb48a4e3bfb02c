"""Read scene files of other programs as clips, using a separate Blender process."""

from twistcore.formats.blender.process import (
    SUFFIXES,
    TIME_LIMIT,
    Handover,
    find_blender,
    read_scene,
)

__all__ = ["SUFFIXES", "TIME_LIMIT", "Handover", "find_blender", "read_scene"]
