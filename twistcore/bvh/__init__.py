"""BVH files: reading without guessing, writing without touching what was not judged."""

from twistcore.bvh.clip import Clip
from twistcore.bvh.compose import write_motion
from twistcore.bvh.lower_rate import thinned
from twistcore.bvh.patch import EulerJump, changed_rotations, patch_rotations, write_bvh
from twistcore.bvh.reader import parse_bvh, read_bvh

__all__ = [
    "Clip",
    "EulerJump",
    "changed_rotations",
    "parse_bvh",
    "patch_rotations",
    "read_bvh",
    "thinned",
    "write_bvh",
    "write_motion",
]
