"""The parts of a body: bones, limbs, and the limbs that were not found."""

from __future__ import annotations

from functools import cached_property

from twistcore.skeleton.joint_names import JointName
from twistcore.skeleton.motion import Skeleton
from twistcore.work.frozen import dataclass

# The names of a limb's bones, from the trunk outwards. A bone is named after its first joint.
BONES = {"arm": ("Shoulder", "Arm", "ForeArm"), "leg": ("UpLeg", "Leg")}
SIDES = ("Left", "Right")
LIMBS = tuple((side, kind) for side in SIDES for kind in BONES)


@dataclass(frozen=True)
class Bone:
    """A bone of a limb, or a piece of one.

    Attributes
    ----------
    parent, child
        Indices of the joints at which the bone begins and ends.
    segment
        'Arm', 'Leg' etc., or '' if unknown.
    ends
        True if another bone begins at `child`, False if another piece of this bone does.
    pieces
        Number of pieces into which the whole bone is divided.
    """

    parent: int
    child: int
    segment: str = ""
    ends: bool = True
    pieces: int = 1


@dataclass(frozen=True)
class LimbLine:
    """The bones of one limb.

    Attributes
    ----------
    side
        'Left', 'Right', or '' if unknown.
    kind
        'arm', 'leg', or '' if unknown.
    bones
        The bones, from the trunk outwards.
    below
        Index of the joint to which a foot points, such as a toe, or −1.
    by_shape
        True if the limb was found by the shape of the skeleton.
    person
        Name of the person, or '' if there is only one person.
    """

    side: str
    kind: str
    bones: tuple[Bone, ...]
    below: int = -1
    by_shape: bool = False
    person: str = ""

    @property
    def joints(self) -> tuple[int, ...]:
        """Return all joints of the limb, from the trunk outwards."""
        return (*(bone.parent for bone in self.bones), self.bones[-1].child)


@dataclass(frozen=True)
class Unexamined:
    """A limb or a part of a limb that cannot be analysed, and the reason for this.

    Attributes
    ----------
    limb
        Name of the limb or the part, such as 'left arm' or 'left forearm'.
    why
        The reason, as a clause.
    side, kind, person
        The same as in :class:`LimbLine`.
    """

    limb: str
    why: str
    side: str = ""
    kind: str = ""
    person: str = ""

    def __str__(self) -> str:
        limb, whose, why = self.limb, self.person, self.why
        if limb.endswith("s"):
            if whose:
                return f"The {limb} of {whose} were not examined: {why}."
            return f"The {limb} were not examined: {why}."
        if whose:
            return f"The {limb} of {whose} was not examined: {why}."
        return f"The {limb} was not examined: {why}."

    @property
    def title(self) -> str:
        """Return the limb's name, with the person's name if there is one: 'left arm of B'."""
        return " of ".join(word for word in (self.limb, self.person) if word)

    def to_json(self) -> dict[str, str]:
        """Return the limb, its side, its person and the reason as a dict for JSON."""
        entry = {"limb": self.limb, "side": self.side, "why": self.why}
        return entry | ({"person": self.person} if self.person else {})


@dataclass(frozen=True, eq=False)
class Body:
    """The limbs of all people in a skeleton, and the meanings of its joint names.

    Attributes
    ----------
    skeleton
        The skeleton.
    names
        Meaning of each joint's name.
    lines
        The limbs, person by person.
    missing
        Arms, legs and parts of them that were not found.
    """

    skeleton: Skeleton
    names: tuple[JointName, ...]
    lines: tuple[LimbLine, ...]
    missing: tuple[Unexamined, ...] = ()

    @cached_property
    def joint_roles(self) -> tuple[str, ...]:
        """Return the role of each joint: 'Left Arm', 'Left Hand', 'piece of Left Arm' or ''."""
        out = [""] * len(self.skeleton)
        for line in self.lines:
            for bone in reversed(line.bones):
                whole = f"{line.side} {bone.segment}".strip() or "limb"
                out[bone.parent] = whole
                if not bone.ends:
                    out[bone.child] = f"piece of {whole}"
            tip = {"arm": "Hand", "leg": "Foot"}.get(line.kind, "end")
            last = line.bones[-1]
            segments = BONES.get(line.kind, ("",))
            later = [*segments[segments.index(last.segment) + 1 :], tip]
            out[last.child] = f"{line.side} {later[0]}".strip()
            if line.below >= 0:
                out[line.below] = f"{line.side} Toe".strip() if line.kind else "below the end"
        return tuple(out)
