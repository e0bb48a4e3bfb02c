"""Find the arms and legs of a body, by the names of joints or by the skeleton's shape.

The hands and feet are found by name, and the joints above them by the hierarchy. So 'Shoulder' may
mean the collar in one rig and the upper arm in another. Each limb is searched for separately. A
limb whose hand or foot has an unknown name is found by its known joints, and a limb without any
known name by its shape.

A bone may be divided into *pieces*, which are twist bones in the chain (`upperarm01 → upperarm02`).
They distribute the roll of the bone and, unlike other joints, never bend relative to each other.
"""

from twistcore.skeleton.body.bones import lower_pair
from twistcore.skeleton.body.finding import find_body
from twistcore.skeleton.body.offsets import ancestors, bone_offset, has_length, shortest
from twistcore.skeleton.body.parts import BONES, LIMBS, SIDES, Body, Bone, LimbLine, Unexamined

__all__ = [
    "BONES",
    "LIMBS",
    "SIDES",
    "Body",
    "Bone",
    "LimbLine",
    "Unexamined",
    "ancestors",
    "bone_offset",
    "find_body",
    "has_length",
    "lower_pair",
    "shortest",
]
