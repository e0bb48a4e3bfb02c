"""Read scene files of other programs as clips, using a separate Blender process."""

from twistcore.formats.blender.process import TIME_LIMIT, Handover, find_blender, read_scene
from twistcore.formats.blender.scene_motion import SUFFIXES, Converted, converted

__all__ = [
    "SUFFIXES",
    "TIME_LIMIT",
    "Converted",
    "Handover",
    "converted",
    "find_blender",
    "read_scene",
]
