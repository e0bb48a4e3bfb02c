"""BVH files: reading without guessing, writing without touching what was not judged."""

from twistcore.bvh.clip import BvhWarning, Clip, JointChannels
from twistcore.bvh.patch import changed_rotations, patch_rotations, write_bvh
from twistcore.bvh.reader import parse_bvh, read_bvh
from twistcore.bvh.thin import thinned

__all__ = [
    "BvhWarning",
    "Clip",
    "JointChannels",
    "changed_rotations",
    "parse_bvh",
    "patch_rotations",
    "read_bvh",
    "thinned",
    "write_bvh",
]
