"""BVH files: reading without guessing, writing without touching what was not judged."""

from twistcore.bvh.clip import BvhWarning, Clip, JointChannels
from twistcore.bvh.compose import write_motion
from twistcore.bvh.lower_rate import thinned
from twistcore.bvh.patch import (
    EulerJump,
    Patch,
    changed_rotations,
    patch_rotations,
    patched,
    write_bvh,
)
from twistcore.bvh.reader import parse_bvh, read_bvh

__all__ = [
    "BvhWarning",
    "Clip",
    "EulerJump",
    "JointChannels",
    "Patch",
    "changed_rotations",
    "parse_bvh",
    "patch_rotations",
    "patched",
    "read_bvh",
    "thinned",
    "write_bvh",
    "write_motion",
]
