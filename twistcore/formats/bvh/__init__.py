"""Read BVH files without guessing, and write them with only the corrected numbers changed."""

from twistcore.formats.bvh.clip import BvhClip
from twistcore.formats.bvh.compose import write_motion
from twistcore.formats.bvh.lower_rate import decimated
from twistcore.formats.bvh.reader import parse_bvh, read_bvh

__all__ = ["BvhClip", "decimated", "parse_bvh", "read_bvh", "write_motion"]
