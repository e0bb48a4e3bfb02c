"""Find the arms and legs of a skeleton, by joint names or by the skeleton's shape.

Each limb is searched for separately. Its hand or foot is found by name, and the joints above it by
the hierarchy, because a name such as 'Shoulder' means the collar bone in one rig and the upper arm
in another. If the name of the hand or foot is unknown, the limb is found by its other known names,
and without any known name by its shape.

A bone may be divided into *pieces*: twist bones in a row (`upperarm01 → upperarm02`) that
distribute the bone's roll. Pieces of one bone never bend relative to each other.
"""

from twistcore.skeleton.body.bones import outermost_long_bone_pair_index
from twistcore.skeleton.body.finding import find_body
from twistcore.skeleton.body.offsets import (
    ancestors,
    bone_offset,
    has_bone_offset_direction,
    minimum_bone_length_for_direction,
)
from twistcore.skeleton.body.parts import BONES, Body, Bone, LimbLine, Unexamined

__all__ = [
    "BONES",
    "Body",
    "Bone",
    "LimbLine",
    "Unexamined",
    "ancestors",
    "bone_offset",
    "find_body",
    "has_bone_offset_direction",
    "minimum_bone_length_for_direction",
    "outermost_long_bone_pair_index",
]
