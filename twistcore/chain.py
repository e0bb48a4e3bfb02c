"""Chains parent-child-grandchild in which a twist error can show itself [Choi26 §3.1, §4.1.1].

Names only find the hands and feet; the joints above them follow from the hierarchy. So 'Shoulder'
may mean the collar in one rig and the upper arm in another without harm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from twistcore.joint_names import FEET, HANDS, TOES, JointName, is_helper, understood
from twistcore.motion import Motion, Skeleton, check_motion
from twistcore.rotation import Array, normalise

# Parent, child and grandchild of each segment's chain, by what they are in a limb.
_ROLES = {
    "Shoulder": ("shoulder", "arm", "forearm"),
    "Arm": ("arm", "forearm", "hand"),
    "ForeArm": ("forearm", "hand", ""),
    "UpLeg": ("upleg", "leg", "foot"),
    "Leg": ("leg", "foot", "toe"),
}
SEGMENTS = tuple(_ROLES)
# What names give away of a limb, by which words, and what the joints above are, nearest first.
_TIPS = (("hand", HANDS, ("forearm", "arm", "shoulder")), ("foot", FEET, ("leg", "upleg")))

_ZERO = 1e-6  # of the skeleton's height: shorter offsets have no direction
_DELTA = 1e-2  # of OFFSET's length: positions so short are deltas from it or rounding, no bone
_COLLINEAR = np.cos(np.radians(20.0))
VARYING = np.cos(np.radians(1.0))  # bones that do so have an axis a frame


@dataclass(frozen=True, eq=False)
class Chain:
    """Parent P, child C, grandchild G by joint index, and their bone directions.

    name: the parent joint's name; axis: unit a, P→C in P's coordinates, (3,) or (frames, 3) where
    position channels make it vary; arm: unit b, C→G in C's coordinates, likewise; grandchild: −1
    where b is C's own axis or an End Site; side: 'Left', 'Right' or ''; segment: one of SEGMENTS
    or ''; warnings: what was assumed.
    """

    name: str
    parent: int
    child: int
    grandchild: int
    axis: Array
    arm: Array
    side: str = ""
    segment: str = ""
    warnings: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        joints = (j for j in (self.parent, self.child, self.grandchild) if j >= 0)
        return f"<Chain {self.name}: joints {' → '.join(map(str, joints))}>"

    @property
    def label(self) -> str:
        """What a table shows: 'Left ForeArm', or the joint's name where the limb is unknown."""
        return f"{self.side} {self.segment}" if self.segment else self.name

    @property
    def list_label(self) -> str:
        """The label in a list of chains and limbs."""
        return self.label

    def sliced(self, start: int, stop: int) -> Chain:
        """The chain in frames [start, stop)."""
        axis, arm = (v if v.ndim == 1 else v[start:stop] for v in (self.axis, self.arm))
        return replace(self, axis=axis, arm=arm)

    def changed_joints(self, skeleton: Skeleton, *, carried: bool = False) -> tuple[int, ...]:
        """P and its children: what an error in the chain, or its correction, turns otherwise.

        carried: of a limb only, whose end may have turned along.
        """
        del carried
        return self.parent, *skeleton.children[self.parent]


def find_chains(motion: Motion) -> tuple[Chain, ...]:
    """All chains of a clip: the five limb chains of either side, or by topology.

    Empty where no joint has a child and a grandchild at a distance.
    """
    check_motion(motion)
    found: list[Chain] = []
    for side, limb in _limb_joints(motion.skeleton).items():
        for segment, (parent, child, below) in _ROLES.items():
            if parent in limb and child in limb:
                joints = limb[parent], limb[child], limb.get(below, -1)
                chain = make_chain(motion, *joints, side, segment)
                if chain is not None:
                    found.append(chain)
    return tuple(found) if found else _chains_by_topology(motion)


def make_chain(
    motion: Motion, parent: int, child: int, grandchild: int = -1, side: str = "", segment: str = ""
) -> Chain | None:
    """The chain of three joints, or None where P→C has no length and so no axis.

    Without a grandchild b is, for a hand, the unit Z of C's frame [Choi26 §4.1.3] (or the axis of
    C least parallel to a, if Z lies within 20° of it); for a foot its End Site.
    """
    skeleton = motion.skeleton
    warnings: list[str] = []
    axis = bone_direction(motion, child, warnings)
    if axis is None:
        return None
    arm = bone_direction(motion, grandchild, warnings) if grandchild >= 0 else None
    if arm is None:
        grandchild = -1
        end = skeleton.end_offsets.get(child) if segment != "ForeArm" else None
        if end is not None and _has_length(skeleton, end):
            arm = normalise(end)
        else:
            along = np.abs(np.atleast_2d(axis)[0])  # of each axis of C the cosine to a
            arm = np.eye(3)[2 if along[2] <= _COLLINEAR else int(np.argmin(along))]
    name = skeleton.names[parent]
    return Chain(name, parent, child, grandchild, axis, arm, side, segment, tuple(warnings))


def limbs(skeleton: Skeleton, chains: Sequence[Chain]) -> tuple[tuple[Chain, ...], ...]:
    """Chains that change a joint in common, directly or through others, belong together.

    So an error in one limb changes nothing in another.
    """
    changers: dict[int, list[int]] = {}
    changed = [chain.changed_joints(skeleton) for chain in chains]
    for k, joints in enumerate(changed):
        for joint in joints:
            changers.setdefault(joint, []).append(k)
    groups: list[list[int]] = []
    seen: set[int] = set()
    for first in range(len(chains)):
        todo, group = [first], []
        while todo:
            if (k := todo.pop()) not in seen:
                seen.add(k)
                group.append(k)
                todo += (other for joint in changed[k] for other in changers.pop(joint, ()))
        if group:
            groups.append(sorted(group))
    # As they are completed when chains are gone through: the group of the earliest last one first.
    return tuple(tuple(chains[k] for k in group) for group in sorted(groups, key=lambda g: g[-1]))


def uncorrectable_joints(motion: Motion, chain: Chain, *, carried: bool = False) -> tuple[str, ...]:
    """Names of joints that it turns and that lack three rotation channels; empty: correctable.

    carried: of a limb, by a flip in which the end turned along, whose own rotation then stays.
    """
    skeleton = motion.skeleton
    rotatable, joints = skeleton.rotatable, chain.changed_joints(skeleton, carried=carried)
    if rotatable is None:
        return ()
    return tuple(motion.skeleton.names[j] for j in joints if not rotatable[j])


def bone_direction(motion: Motion, joint: int, warnings: list[str]) -> Array | None:
    """Unit direction from the parent, (3,), (frames, 3) where it varies, or None at no length."""
    skeleton = motion.skeleton
    smallest = _shortest(skeleton)
    rest, offset = skeleton.offsets[joint], motion.translation(joint)
    length, lengths = np.linalg.norm(rest), np.linalg.norm(offset, axis=-1)
    if length > smallest and lengths.max() <= max(smallest, _DELTA * length):  # never of OFFSET
        warnings.append(
            f"{skeleton.names[joint]}: the position channels are next to zero; its OFFSET is used."
        )
        return normalise(rest)
    if lengths.min() <= smallest:
        return None
    directions = normalise(offset)
    if directions.ndim == 1:
        return directions
    mean = normalise(directions.mean(axis=0))
    if (directions @ mean).min() >= VARYING:
        return mean
    warnings.append(f"{skeleton.names[joint]}: the bone's direction varies by more than 1°.")
    return directions


def _shortest(skeleton: Skeleton) -> float:
    """What is no longer than this, in the file's unit, has no direction."""
    return _ZERO * skeleton.height


def _has_length(skeleton: Skeleton, offset: Array) -> bool:
    """Whether a vector, or one of some, has a direction; (3,) or (frames, 3)."""
    return bool(np.linalg.norm(offset, axis=-1).max() > _shortest(skeleton))


def _limb_joints(skeleton: Skeleton) -> dict[str, dict[str, int]]:
    """Joint index by side and role, for the limbs whose hand or foot the names give away."""
    names = understood(skeleton.names)
    limbs: dict[str, dict[str, int]] = {"Left": {}, "Right": {}}
    trunk: set[int] = set()  # above both hands or both feet: no shoulder and no thigh
    for tip, words, above in _TIPS:
        lines = []
        for side, limb in limbs.items():
            joint = _named(names, side, words)
            if joint is not None:
                limb[tip] = joint
                bones = _bones_above(skeleton, names, joint)
                limb.update(zip(above, bones, strict=False))  # whichever ends first
                lines.append(set(_ancestors(skeleton, joint)))
        if len(lines) == len(limbs):
            trunk.update(set.intersection(*lines))
    for side, limb in limbs.items():
        if "foot" in limb:
            below = _below(skeleton, limb["foot"])
            toes = [
                j
                for j in below
                if names[j].side == side and any(word in names[j].stem for word in TOES)
            ]
            if toes:
                limb["toe"] = toes[0]
    return {
        side: {role: joint for role, joint in limb.items() if joint not in trunk}
        for side, limb in limbs.items()
    }


def _named(names: list[JointName], side: str, words: tuple[str, ...]) -> int | None:
    """First joint of a side that is called exactly one of the words, the first word first."""
    for word in words:
        for joint, name in enumerate(names):
            if name.side == side and name.stem == word:
                return joint
    return None


def _bones_above(skeleton: Skeleton, names: list[JointName], joint: int) -> list[int]:
    """Ancestors that end a bone of some length, nearest first, helper joints skipped.

    Of a bone in pieces (upperarm01, upperarm02) only the first counts.
    """
    out = []
    here = joint
    while (parent := int(skeleton.parents[here])) >= 0:
        above = int(skeleton.parents[parent])
        piece = (
            above >= 0
            and names[parent].number != ""
            and (names[parent].side, names[parent].stem) == (names[above].side, names[above].stem)
        )
        helper = is_helper(skeleton.names[parent])
        if _has_length(skeleton, skeleton.offsets[here]) and not (piece or helper):
            out.append(parent)
        here = parent
    return out


def _below(skeleton: Skeleton, joint: int) -> list[int]:
    """All descendants, nearest first."""
    out = list(skeleton.children[joint])
    for j in out:
        out.extend(skeleton.children[j])
    return out


def _ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    out = []
    while (joint := int(skeleton.parents[joint])) >= 0:
        out.append(joint)
    return out


def _chains_by_topology(motion: Motion) -> tuple[Chain, ...]:
    """Every limb bone that has a bone below it; limbs hang from a branching of long lines.

    Heads, fingers and what is carried are left out where the names say so.
    """
    skeleton = motion.skeleton
    parents = skeleton.parents.tolist()
    out_of_it = [name.no_limb for name in understood(skeleton.names)]
    for joint, parent in enumerate(parents):
        out_of_it[joint] |= parent >= 0 and out_of_it[parent]
    children = [[c for c in below if not out_of_it[c]] for below in skeleton.children]
    reach = [0] * len(skeleton)  # bones below, along the longest line
    main: dict[int, int] = {}  # the child along that line
    trunk = {joint for joint, parent in enumerate(parents) if parent < 0}
    for joint in reversed(range(len(skeleton))):
        for child in children[joint]:
            bones = reach[child] + _has_length(skeleton, motion.translation(child))
            if bones > reach[joint] or joint not in main:
                reach[joint], main[joint] = bones, child
        if sum(reach[child] >= 2 for child in children[joint]) >= 2:
            trunk.update((joint, *_ancestors(skeleton, joint)))
    found = []
    for joint, child in sorted(main.items()):
        if joint in trunk or child not in main:
            continue
        above = parents[joint]
        if above in trunk or main[above] == joint:
            chain = make_chain(motion, joint, child, main[child])
            if chain is not None:
                found.append(chain)
    return tuple(found)
