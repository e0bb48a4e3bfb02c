"""BVH files: reading without guessing, writing without touching what was not judged."""

from twistcore.bvh.bvh_clip import BvhClip
from twistcore.bvh.compose import write_motion
from twistcore.bvh.lower_rate import thinned
from twistcore.bvh.reader import parse_bvh, read_bvh

__all__ = ["BvhClip", "parse_bvh", "read_bvh", "thinned", "write_motion"]
