"""Find twist bones next to a chain, as in Unreal rigs.

Such a *helper* distributes the roll of a bone. It is a child of the joint where the bone begins,
and it rotates about the bone. If a helper rotates by a wrong angle, the skin twists like a candy
wrapper, although every joint of the limb is correct.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from twistcore.skeleton.body import Body, Bone, LimbLine, bone_offset, has_bone_offset_direction
from twistcore.skeleton.chain import Chain, make_chain
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import normalise
from twistcore.work.frozen import dataclass

_IN_LINE = np.cos(np.radians(5.0))  # a helper without a known name must be within 5° of the bone


@dataclass(frozen=True, eq=False, repr=False)
class Helper(Chain):
    """A twist bone next to a chain, treated as a chain whose parent is the helper.

    Attributes
    ----------
    parent
        Index of the helper.
    child
        Index of the joint at the end of the bone whose roll the helper distributes.
    axis
        Direction of that bone, in the coordinates of the joint where it begins.
    """

    def __repr__(self) -> str:
        return f"<Helper {self.name}: joint {self.parent} next to {self.child}>"

    @property
    def part(self) -> str:
        """Return the names of the bone and the helper: 'Left Arm · upperarm_twist_01_l'."""
        bone = f"{self.side} {self.segment}"
        return f"{bone} · {self.name}" if self.segment else self.name

    @property
    def list_label(self) -> str:
        """Return the label for a list that contains chains and limbs."""
        return f"{self.label} · helper"

    def changed_joints(self, skeleton: Skeleton, *, carried: bool = False) -> tuple[int, ...]:
        """Return the joints that a correction changes: the helper and its children."""
        del carried
        return self.parent, *skeleton.children[self.parent]


def find_helpers(motion: Motion, body: Body) -> tuple[Helper, ...]:
    """Find the twist bones next to the bones of a body's limbs."""
    return tuple(
        helper
        for line in body.lines
        for bone in line.bones
        for helper in _next_to(motion, body, line, bone)
    )


def _next_to(motion: Motion, body: Body, line: LimbLine, bone: Bone) -> Iterator[Helper]:
    """Yield the helpers of a bone.

    A helper is a child of the bone's first joint. Either it has a helper's name, or it is on the
    bone and has no children.
    """
    skeleton, parent, child = motion.skeleton, bone.parent, bone.child
    chain = make_chain(motion, parent, child, side=line.side, segment=bone.segment)
    if chain is None:
        return
    chain = replace(chain, person=line.person, warnings=())
    for joint in skeleton.children[parent]:
        name = body.names[joint]
        if joint == child or name.other or not (name.helper or _lies_on(motion, joint, child)):
            continue
        fields = vars(replace(chain, name=skeleton.names[joint], parent=joint))
        yield Helper(**fields)


def _lies_on(motion: Motion, joint: int, child: int) -> bool:
    """Return True if a joint has no children and is on the bone that ends at `child`."""
    if motion.skeleton.children[joint]:
        return False
    place, bone = (bone_offset(motion, j).reshape(-1, 3).mean(axis=0) for j in (joint, child))
    if not (
        has_bone_offset_direction(motion.skeleton, place)
        and has_bone_offset_direction(motion.skeleton, bone)
    ):
        return False
    inside = np.linalg.norm(place) < np.linalg.norm(bone)
    return bool(inside and normalise(place) @ normalise(bone) > _IN_LINE)
