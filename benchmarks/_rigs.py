"""Convert CMU motion to other common rigs, whose joints are at the same positions.

A rig renames the joints of CMU's skeleton, divides bones into pieces that share the roll of the
bone, and adds helpers: twist bones next to the chain, fingers and props.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import (
    Array,
    exponential,
    logarithm,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    twist_angle,
)

# CMU's names of the trunk's joints, and of the limbs' joints without 'Left' or 'Right'.
TRUNK = ("Hips", "LowerBack", "Spine", "Spine1", "Neck", "Neck1", "Head")
LIMBS = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
# The joint at the end of each bone that may be divided or have helpers.
BELOW = {
    "Shoulder": "Arm",
    "Arm": "ForeArm",
    "ForeArm": "Hand",
    "Hand": "HandIndex1",
    "UpLeg": "Leg",
    "Leg": "Foot",
    "Foot": "ToeBase",
}
CHAINED = ("Shoulder", "Arm", "ForeArm", "UpLeg", "Leg")  # bones with a chain
# Bones whose pieces have some roll of the joint below, as in pronation of the forearm.
ROLLED = ("ForeArm", "Leg")
_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
_STILL = 1e-9  # radians


@dataclass(frozen=True)
class Helper:
    """An additional joint that is not part of any chain.

    Attributes
    ----------
    name, parent
        Names of the helper and of its parent, with {s} for the side.
    bone
        The bone in LIMBS that gives the helper its direction and roll.
    at
        The distance from the parent along the bone, as a share of the bone's length.
    aside
        The distance perpendicular to the bone, as a share of the bone's length.
    undo
        The share of the bone's roll that the helper undoes.
    follow
        The share of the next joint's roll that the helper follows.
    bend
        The share of the next joint's whole rotation that the helper follows.
    """

    name: str
    parent: str
    bone: str
    at: float = 0.0
    aside: float = 0.0
    undo: float = 0.0
    follow: float = 0.0
    bend: float = 0.0


@dataclass(frozen=True)
class Rig:
    """A rig. Joints with {s} in their names exist on both sides.

    Attributes
    ----------
    name, group
        Name of the rig and of its group in the table.
    trunk
        Names for the joints in TRUNK, fewer if the head has fewer joints.
    limbs
        Names for the joints in LIMBS. A bone in pieces has several names.
    sides
        The two values of {s}.
    helpers
        The helpers. A parent comes before its children.
    pelvis
        Name of a joint between the first joint and the legs, or ''.
    share
        The share of a bone's roll in its first piece. The last piece lacks the same share of the
        next joint's roll.
    source
        The origin of the names and the hierarchy.
    as_is
        True for the rig of CMU itself.
    """

    name: str
    group: str
    trunk: tuple[str, ...]
    limbs: tuple[str | tuple[str, ...], ...]
    sides: tuple[str, str] = ("L", "R")
    helpers: tuple[Helper, ...] = ()
    pelvis: str = ""
    share: float = 1.0
    source: str = ""
    as_is: bool = False

    @property
    def in_pieces(self) -> bool:
        """Whether any bone of the rig is divided into pieces."""
        return any(not isinstance(names, str) for names in self.limbs)

    def pieces(self, role: str, side: int) -> tuple[str, ...]:
        """Return the names of a bone's pieces on a side (0 or 1), from the first piece to the last.

        `role` is the bone's name in LIMBS.
        """
        names = self.limbs[LIMBS.index(role)]
        names = (names,) if isinstance(names, str) else names
        return tuple(name.format(s=self.sides[side]) for name in names)


@dataclass
class _Making:
    """A rig under construction, with the joints created so far."""

    motion: Motion
    rig: Rig
    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[Array] = field(default_factory=list)
    rotations: list[Array] = field(default_factory=list)
    ends: list[tuple[int, tuple[float, float, float]]] = field(default_factory=list)

    def add(self, name: str, parent: int, offset: Array, rotation: Array) -> int:
        if name in self.names:
            raise ValueError(f"the rig {self.rig.name} has two joints {name!r}")
        self.names.append(name)
        self.parents.append(parent)
        self.offsets.append(offset)
        self.rotations.append(np.broadcast_to(rotation, (self.motion.frames, 4)))
        return len(self.names) - 1


def rigged(motion: Motion, rig: Rig) -> Motion:
    """Convert the motion of a CMU clip to another rig.

    Joints that both rigs have are at the same positions.
    """
    if rig.as_is:
        return motion
    made = _Making(motion, rig)
    _descend(made, 0, -1, np.zeros(3), None)
    skeleton = Skeleton(
        tuple(made.names), np.array(made.parents), np.array(made.offsets), tuple(made.ends)
    )
    return Motion(skeleton, np.stack(made.rotations, 1), (0,), motion.positions, motion.frame_time)


def shared_joints(motion: Motion, rig: Rig) -> dict[str, str]:
    """Return the CMU names of the joints that a rig shares with CMU, keyed by the rig's names."""
    found = {name: cmu for cmu, name in zip(TRUNK, rig.trunk, strict=False)}
    for side, long in enumerate(("Left", "Right")):
        found |= {rig.pieces(role, side)[0]: long + role for role in LIMBS}
    return {name: cmu for name, cmu in found.items() if cmu in motion.skeleton.names}


def _descend(made: _Making, joint: int, parent: int, offset: Array, turn: Array | None) -> None:
    """Create the joints of the new rig for a CMU joint and for all joints below it.

    `turn` is the part of the joint's rotation that the pieces of its parent's bone have, or None.
    """
    skeleton, rig = made.motion.skeleton, made.rig
    cmu = skeleton.names[joint]
    q = made.motion.rotations[:, joint]
    if turn is not None:
        q = normalise(multiply(turn, q))
    side, role = _role(cmu)
    given: dict[int, Array] = {}
    if cmu in TRUNK:
        at = TRUNK.index(cmu)
        if at >= len(rig.trunk):
            return
        last = made.add(rig.trunk[at], parent, offset, q)
    elif role in LIMBS:
        last, given = _bone(made, joint, parent, offset, q)
    elif skeleton.children[joint] and np.abs(logarithm(q)).max() < _STILL:  # CMU's LHipJoint
        for child in skeleton.children[joint]:
            _descend(made, child, parent, offset + skeleton.offsets[child], None)
        return
    else:  # fingers, which differ between rigs
        return
    hips = made.add(rig.pelvis, last, np.zeros(3), _IDENTITY) if rig.pelvis and joint == 0 else last
    if joint in skeleton.end_offsets:
        made.ends.append((last, tuple(skeleton.end_offsets[joint])))
    for child in skeleton.children[joint]:
        legs = joint == 0 and skeleton.names[child] != TRUNK[1]
        below = skeleton.offsets[child]
        pieces = len(rig.pieces(role, side)) if role in LIMBS else 1
        _descend(made, child, hips if legs else last, below / pieces, given.get(child))
    if joint == 0:
        _add_helpers(made, TRUNK[0], 0, skeleton.offsets[skeleton.index(TRUNK[2])])


def _bone(
    made: _Making, joint: int, parent: int, offset: Array, q: Array
) -> tuple[int, dict[int, Array]]:
    """Create the pieces and helpers of a bone.

    Returns the index of the last piece, and the rotations that its children must undo, keyed by the
    child's index.
    """
    motion, rig = made.motion, made.rig
    skeleton = motion.skeleton
    side, role = _role(skeleton.names[joint])
    names = rig.pieces(role, side)
    child = _child(skeleton, joint, role)
    if child < 0:
        return made.add(names[0], parent, offset, q), {}
    bone = skeleton.offsets[child]
    if len(names) == 1:
        last = made.add(names[0], parent, offset, q)
        _add_helpers(made, role, side, bone, joint)
        return last, {}
    axis, steps = normalise(bone), len(names) - 1
    own = _roll(q, axis)
    below = _roll(motion.rotations[:, child], axis) if role in ROLLED else np.zeros(motion.frames)
    each = (1.0 - rig.share) / steps
    first = normalise(multiply(q, quaternion_from_axis_angle(axis, (rig.share - 1.0) * own)))
    last = made.add(names[0], parent, offset, first)
    for name in names[1:]:
        piece = quaternion_from_axis_angle(axis, each * (own + below))
        last = made.add(name, last, bone / len(names), piece)
    _add_helpers(made, role, side, bone, joint)
    return last, {child: quaternion_from_axis_angle(axis, -(1.0 - rig.share) * below)}


def _add_helpers(made: _Making, role: str, side: int, bone: Array, joint: int = -1) -> None:
    """Create the helpers of a bone in order."""
    motion = made.motion
    if np.linalg.norm(bone) < _STILL:
        return
    axis = normalise(bone)
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    across = normalise(across - (across @ axis) * axis)
    own = below = np.zeros(motion.frames)
    bend: Array = np.zeros((motion.frames, 3))
    if joint >= 0 and (child := _child(motion.skeleton, joint, role)) >= 0:
        own = _roll(motion.rotations[:, joint], axis)
        below = _roll(motion.rotations[:, child], axis)
        bend = logarithm(motion.rotations[:, child])
    for helper in made.rig.helpers:
        if helper.bone != role:
            continue
        for k in (side,) if joint >= 0 else (0, 1):
            word = made.rig.sides[k]
            name, above = helper.name.format(s=word), helper.parent.format(s=word)
            if name in made.names and joint < 0:  # a trunk helper, shared by both sides
                continue
            roll = helper.follow * below - helper.undo * own
            rotation = quaternion_from_axis_angle(axis, roll)
            if helper.bend:
                rotation = exponential(helper.bend * bend)
            length = float(np.linalg.norm(bone))
            # On a bone of the trunk, the helper of the second side is mirrored.
            out = helper.aside * (1.0 if k == 0 or joint >= 0 else -1.0)
            offset = helper.at * bone + out * length * across
            made.add(name, made.names.index(above), offset, rotation)


def _role(cmu: str) -> tuple[int, str]:
    """Return the side (0 or 1) and the role of a CMU joint, such as (0, 'Arm') for 'LeftArm'.

    The role is '' for a joint of the trunk.
    """
    for side, word in enumerate(("Left", "Right")):
        if cmu.startswith(word):
            return side, cmu.removeprefix(word)
    return 0, ""


def _child(skeleton: Skeleton, joint: int, role: str) -> int:
    """Return the index of the joint at the end of a CMU bone, or −1 if there is none."""
    side = skeleton.names[joint].removesuffix(role)
    name = side + BELOW.get(role, "")
    return skeleton.names.index(name) if role in BELOW and name in skeleton.names else -1


def _roll(q: Array, axis: Array) -> Array:
    """Return the twist about an axis in radians, (frames,), unwrapped."""
    return np.unwrap(twist_angle(q, axis))


def bone_pairs(motion: Motion, rig: Rig) -> dict[tuple[int, str], tuple[int, int]]:
    """Return the joints into which errors are injected, keyed by the bone's side and role.

    Each value is the index of a joint C at the end of a limb's bone and, before it, of its parent
    P. In a bone with several pieces, P is the last piece.
    """
    skeleton = motion.skeleton
    pairs = {}
    for side in (0, 1):
        for role in CHAINED:
            child = skeleton.index(rig.pieces(BELOW[role], side)[0])
            pairs[side, role] = int(skeleton.parents[child]), child
    return pairs


def piece_pairs(motion: Motion, rig: Rig) -> list[tuple[tuple[int, int], tuple[int, bool]]]:
    """Return the indices of each two neighbouring pieces of a bone, with the bone's limb."""
    index = motion.skeleton.index
    found = []
    for side in (0, 1):
        for role in CHAINED:
            pieces = rig.pieces(role, side)
            limb = side, role in LIMBS[4:]
            found += [((index(a), index(b)), limb) for a, b in pairwise(pieces)]
    return found
