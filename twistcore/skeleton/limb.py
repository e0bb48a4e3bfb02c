"""Find limbs: whole arms and legs of three joints.

A limb flip rotates a limb about the line from its first joint to its end. In inverse kinematics,
the angle of the middle joint about this line is called the *swivel angle*.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from twistcore.skeleton.body import outermost_long_bone_pair_index
from twistcore.skeleton.chain import Chain, find_chains, group_connected_chains
from twistcore.skeleton.motion import HasMotion, Motion, Skeleton, motion_of
from twistcore.skeleton.rotation import Array, rotate, vector_lengths
from twistcore.work.frozen import dataclass

_SEGMENTS = {"Arm": "arm", "UpLeg": "leg"}
_MIDDLES = {"Arm": "elbow", "UpLeg": "knee"}
_ENDS = {"Arm": "hand", "UpLeg": "foot"}
# Minimum length of the shorter bone, as a share of the longer one. If the bone is shorter, the
# middle joint is not a knee or an elbow.
_SHORTEST = 0.3


@dataclass(frozen=True, eq=False, repr=False)
class Limb(Chain):
    """A whole leg or arm: hip P, knee C and ankle E, or shoulder P, elbow C and wrist E.

    A limb flip rotates the limb about the line from P to E, not about the bone from P to C.

    Parameters
    ----------
    name : str
        Names of P and E, such as 'LeftUpLeg-LeftFoot'. This differs from a chain's name, which is
        the name of P.
    parent, child, grandchild : int
        Indices of P, C and E.
    axis, arm, side, segment, warnings, pieces, ends, person
        The same as in :class:`Chain`.

    Examples
    --------
    >>> import twistcore as tc
    >>> limb = tc.find_limbs(tc.read_clip("assets/walk.bvh"))[1]
    >>> limb, limb.label, limb.middle_word
    (<Limb LeftUpLeg-LeftFoot: joints 2 → 3 → 4>, 'Left leg', 'knee')
    """

    def __repr__(self) -> str:
        return f"<Limb {self.name}: joints {self.parent} → {self.child} → {self.end}>"

    @property
    def end(self) -> int:
        """Return the index of E, the end of the limb, whose position a flip does not change."""
        return self.grandchild

    def changed_joints(self, skeleton: Skeleton, *, carried: bool = False) -> tuple[int, ...]:
        """Return the joints whose local rotation a flip or its correction changes: P and E.

        P is the limb's first joint, and E is its end. `carried` is True if E rotated with the limb.
        In this case, only P changes.
        """
        del skeleton
        return (self.parent,) if carried else (self.parent, self.end)

    @property
    def part(self) -> str:
        """Return the limb's name, such as 'Left arm', or the names of its joints if unknown."""
        return f"{self.side} {_SEGMENTS[self.segment]}" if self.segment else self.name

    @property
    def list_label(self) -> str:
        """Return the label for lists of chains and limbs, such as 'Right leg · limb'."""
        return f"{self.label} · limb"

    @property
    def middle_word(self) -> str:
        """Return the word for the middle joint: 'knee', 'elbow', or 'middle joint' if unknown."""
        return _MIDDLES.get(self.segment, "middle joint")

    @property
    def end_word(self) -> str:
        """Return the word for the part below the limb: 'foot', 'hand', or 'end' if unknown."""
        return _ENDS.get(self.segment, "end")


def find_limbs(clip: Motion | HasMotion, chains: Sequence[Chain] | None = None) -> tuple[Limb, ...]:
    """Find the arms and legs of a clip, by names or by the shape of the skeleton.

    A limb has two bones of similar lengths, and the pieces of a bone count as one bone. In a line
    of joints without known names, the limb is the longest pair of neighbouring bones.

    Parameters
    ----------
    clip : Clip or Motion
        The clip to search.
    chains : sequence of Chain, optional
        The chains of the limbs. By default, :func:`find_chains` of the clip.

    Returns
    -------
    tuple of Limb
        The limbs, in the order of the chains. Empty if there is none.

    Raises
    ------
    TypeError
        If `clip` is neither a clip nor a motion.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk.bvh")
    >>> [limb.label for limb in tc.find_limbs(clip)]
    ['Left arm', 'Left leg', 'Right arm', 'Right leg']
    """
    motion = motion_of(clip)
    chains = find_chains(motion) if chains is None else chains
    found = []
    for line in group_connected_chains(motion.skeleton, chains):
        own = [c for c in _of_two_bones(line) if _has_two_bones(motion, c)]
        if any(c.segment for c in line):
            own = [c for c in own if c.segment in _SEGMENTS]
        elif own:
            own = [own[outermost_long_bone_pair_index([sum(bone_lengths(motion, c)) for c in own])]]
        found += [as_limb(motion, c) for c in own]
    order = {c.name: k for k, c in enumerate(chains)}
    names = motion.skeleton.names
    return tuple(sorted(found, key=lambda limb: order[names[limb.parent]]))


def _of_two_bones(line: Sequence[Chain]) -> Iterator[Chain]:
    """Yield, for each pair of successive bones of a limb, a chain of their three joints.

    A bone that is divided into pieces counts as one. `line` contains the limb's chains.
    """
    by_parent = {c.parent: c for c in line}
    inner = {c.child for c in line if not c.ends}
    for chain in line:
        if chain.parent in inner:  # it is not the first piece of its bone
            continue
        last = _last_piece(chain, by_parent)
        below = by_parent.get(last.child)
        end = last.grandchild if below is None else _last_piece(below, by_parent).child
        if last.ends and last.grandchild >= 0:
            yield replace(last, parent=chain.parent, axis=chain.axis, grandchild=end)


def _last_piece(chain: Chain, by_parent: Mapping[int, Chain]) -> Chain:
    """Return the chain of a bone's last piece, given the chain of its first piece."""
    while not chain.ends and chain.child in by_parent:
        chain = by_parent[chain.child]
    return chain


def joint_path(skeleton: Skeleton, above: int, below: int) -> tuple[int, ...]:
    """Return the joints on the path from `above` (excluded) down to its descendant `below`."""
    out = [below]
    while (joint := int(skeleton.parents[out[-1]])) != above:
        out.append(joint)
    return tuple(out[::-1])


def limb_middle_and_end_positions(motion: Motion, limb: Limb) -> tuple[Array, Array]:
    """Return the positions of the limb's middle joint and end relative to its first joint.

    Both have the shape (frames, 3), in the file's unit and in the coordinates of the first joint's
    parent.
    """
    upper = joint_path(motion.skeleton, limb.parent, limb.child)
    lower = joint_path(motion.skeleton, limb.child, limb.end)
    to_end = path_end_position(motion, lower)
    to_child = path_end_position(motion, upper)
    for joint in upper[::-1]:
        to_end = motion.translation(joint) + rotate(motion.rotations[:, joint], to_end)
    hip = motion.rotations[:, limb.parent]
    return rotate(hip, to_child), rotate(hip, to_end)


def path_end_position(motion: Motion, joints: Sequence[int]) -> Array:
    """Return the position of a path's last joint, (frames, 3), in the file's unit.

    The position is relative to the parent of the first joint, in the parent's coordinates. `joints`
    is a path down the hierarchy.
    """
    place = np.zeros((motion.frames, 3))
    for joint in joints[::-1]:
        if joint != joints[-1]:
            place = rotate(motion.rotations[:, joint], place)
        place = motion.translation(joint) + place
    return place


def as_limb(motion: Motion, chain: Chain) -> Limb:
    """Return a chain of three joints as a limb."""
    names = motion.skeleton.names
    name = f"{names[chain.parent]}-{names[chain.grandchild]}"
    fields = {k: v for k, v in vars(chain).items() if k != "name"}
    return Limb(name=name, **fields)


def bone_lengths(motion: Motion, chain: Chain) -> tuple[float, float]:
    """Return the lengths of a chain's two bones, in the file's unit."""
    upper = joint_path(motion.skeleton, chain.parent, chain.child)
    lower = joint_path(motion.skeleton, chain.child, chain.grandchild)
    return _length(motion, upper), _length(motion, lower)


def _length(motion: Motion, joints: Sequence[int]) -> float:
    return sum(float(vector_lengths(motion.translation(j)).mean()) for j in joints)


def _has_two_bones(motion: Motion, chain: Chain) -> bool:
    upper, lower = bone_lengths(motion, chain)
    return min(upper, lower) > _SHORTEST * max(upper, lower)
