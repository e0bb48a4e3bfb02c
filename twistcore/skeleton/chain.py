"""Find the chains of parent, child and grandchild in which twist errors are visible.

In equations, the joints of a chain are P, C and G [Choi26 §3.1, §4.1.1]. P is always the direct
parent of C, because in a twist error the children of P rotate back. If a bone is divided into
pieces, there is one chain for each piece.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.skeleton.body import (
    BONES,
    Body,
    LimbLine,
    bone_offset,
    find_body,
    has_bone_offset_direction,
    minimum_bone_length_for_direction,
)
from twistcore.skeleton.motion import HasMotion, Motion, Skeleton, motion_of
from twistcore.skeleton.rotation import Array, normalise, vector_lengths
from twistcore.work.frozen import dataclass

SEGMENTS = tuple(segment for bones in BONES.values() for segment in bones)

_NEAR = 0.75  # minimum ratio of difflib for suggesting a name in place of a mistyped one
_COLLINEAR = np.cos(np.radians(20.0))
# If a bone's direction varies more, the chain stores the direction of every frame.
VARYING = np.cos(np.radians(1.0))


@dataclass(frozen=True, eq=False)
class Chain:
    """A parent joint P, its child C and the grandchild G, with the directions of both bones.

    Parameters
    ----------
    name : str
        Name of P.
    parent, child, grandchild : int
        Indices of P, C and G. `grandchild` is −1 if `arm` is an axis of C or points to an End Site.
    axis : ndarray, shape (3,) or (frames, 3)
        Bone axis a: unit vector (x, y, z) from P to C, in P's coordinates. There is one for each
        frame if position channels change it.
    arm : ndarray, shape (3,) or (frames, 3)
        Direction b: unit vector (x, y, z) from C to G, in C's coordinates.
    side : {'Left', 'Right', ''}
        Side of the body, or '' if unknown.
    segment : str
        'Shoulder', 'Arm', 'ForeArm', 'UpLeg' or 'Leg', or '' if unknown.
    warnings : tuple of str
        Assumptions made for this chain, as sentences.
    pieces : int
        Number of pieces into which the bone from P is divided. Each piece has a chain.
    ends : bool
        False if the next piece of the same bone begins at C.
    person : str
        Name of the person, or '' if there is only one person.

    Examples
    --------
    >>> import twistcore as tc
    >>> chain = tc.find_chains(tc.read_clip("assets/walk.bvh"))[1]
    >>> chain, chain.label
    (<Chain LeftArm: joints 18 → 19 → 20>, 'Left Arm')
    >>> chain.axis.shape
    (3,)
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
    pieces: int = 1
    ends: bool = True
    person: str = ""

    def __repr__(self) -> str:
        joints = (j for j in (self.parent, self.child, self.grandchild) if j >= 0)
        return f"<Chain {self.name}: joints {' → '.join(map(str, joints))}>"

    @property
    def label(self) -> str:
        """Return the label for tables, such as 'Left ForeArm'.

        If there are several people, the label begins with the person's name: 'B · Left ForeArm'.
        """
        return f"{self.person} · {self.part}" if self.person else self.part

    @property
    def part(self) -> str:
        """Return the part of the body, such as 'Left ForeArm', or the joint's name if unknown.

        If the bone is divided into pieces, the joint's name is added: 'Left Arm · upperarm02.L'.
        """
        if not self.segment:
            return self.name
        piece = f" · {self.name}" if self.pieces > 1 else ""
        return f"{self.side} {self.segment}{piece}"

    @property
    def list_label(self) -> str:
        """Return the label for a list that contains chains and limbs."""
        return self.label

    def sliced(self, start: int, stop: int) -> Chain:
        """Return the chain with its bone directions restricted to frames [start, stop)."""
        axis, arm = (v if v.ndim == 1 else v[start:stop] for v in (self.axis, self.arm))
        return replace(self, axis=axis, arm=arm)

    def at(self, frames: NDArray[np.intp] | slice) -> Chain:
        """Return the chain with its bone directions restricted to the given frames."""
        axis, arm = (v if v.ndim == 1 else v[frames] for v in (self.axis, self.arm))
        return replace(self, axis=axis, arm=arm)

    def changed_joints(self, skeleton: Skeleton, *, carried: bool = False) -> tuple[int, ...]:
        """Return the joints that an error or its correction changes: the parent P and its children.

        `carried` has no effect on a chain. Only :class:`Limb` uses it.
        """
        del carried
        return self.parent, *skeleton.children[self.parent]


SomeChain = TypeVar("SomeChain", bound="Chain")


def find_chains(clip: Motion | HasMotion, body: Body | None = None) -> tuple[Chain, ...]:
    """Find the chains of a clip, one for each bone of a limb or for each piece of a bone.

    Parameters
    ----------
    clip : Clip or Motion
        The clip to search.
    body : Body, optional
        The limbs. By default, they are searched for in the clip.

    Returns
    -------
    tuple of Chain
        The chains, limb by limb, each from the trunk outwards. Empty if no limb was found.

    Raises
    ------
    TypeError
        If `clip` is neither a clip nor a motion.

    See Also
    --------
    find_limbs : Find whole arms and legs.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk.bvh")
    >>> [chain.name for chain in tc.find_chains(clip)][:3]
    ['LeftShoulder', 'LeftArm', 'LeftForeArm']
    """
    motion = motion_of(clip)
    lines = (find_body(motion) if body is None else body).lines
    return tuple(chain for line in lines for chain in _chains_of(motion, line))


def _chains_of(motion: Motion, line: LimbLine) -> Iterator[Chain]:
    """Yield the chains of a limb from the trunk outwards. Bones of length 0 are skipped."""
    below = [*(bone.child for bone in line.bones[1:]), line.below]
    for bone, grandchild in zip(line.bones, below, strict=True):
        # Pieces of a bone are collinear, so the direction to G would not show how far C rotates.
        # The chain of a piece uses an axis of C instead.
        joints = bone.parent, bone.child, grandchild if bone.ends else -1
        chain = make_chain(motion, *joints, line.side, bone.segment)
        if chain is not None:
            yield replace(chain, pieces=bone.pieces, ends=bone.ends, person=line.person)


def make_chain(
    motion: Motion, parent: int, child: int, grandchild: int = -1, side: str = "", segment: str = ""
) -> Chain | None:
    """Return the chain of three joints, or None if the bone from P to C has no length.

    Without a grandchild, the direction b is chosen as follows. For a foot, b points to the End
    Site. For a hand, b is C's Z axis [Choi26 §4.1.3] or, if Z is within 20° of the bone axis, the
    axis of C that is least parallel to the bone axis.
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
        if end is not None and has_bone_offset_direction(skeleton, end):
            arm = normalise(end)
        else:
            # Cosine of the angle between each axis of C and the bone axis.
            along = np.abs(np.atleast_2d(axis)[0])
            arm = np.eye(3)[2 if along[2] <= _COLLINEAR else int(np.argmin(along))]
    name = skeleton.names[parent]
    return Chain(name, parent, child, grandchild, axis, arm, side, segment, tuple(warnings))


def group_connected_chains(
    skeleton: Skeleton, chains: Sequence[Chain]
) -> tuple[tuple[Chain, ...], ...]:
    """Group chains whose corrections change the same joints, directly or through other chains.

    An error in one group does not affect other groups. The groups are ordered by their last chain.
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
    return tuple(tuple(chains[k] for k in group) for group in sorted(groups, key=lambda g: g[-1]))


def uncorrectable_joints(motion: Motion, chain: Chain, *, carried: bool = False) -> tuple[str, ...]:
    """Return the names of the joints that a correction would change but that cannot be rotated.

    These joints lack rotation channels. The result is empty if the chain can be corrected.
    `carried` is True for a limb flip in which the foot or hand rotated with the limb. In this case,
    the local rotation of the foot or hand needs no correction.
    """
    skeleton = motion.skeleton
    rotatable, joints = skeleton.rotatable, chain.changed_joints(skeleton, carried=carried)
    if rotatable is None:
        return ()
    return tuple(motion.skeleton.names[j] for j in joints if not rotatable[j])


_NAME, _LABELS = ("name",), ("label", "list_label")


def chain_named(chains: Iterable[SomeChain], name: str, where: str) -> SomeChain:
    """Return the chain or limb with the given name or label.

    Case and spaces are ignored unless two chains differ only in these.

    Parameters
    ----------
    chains
        Chains and limbs, in the order in which `twistcore info` lists them.
    name
        The name or label to look for.
    where
        The clip's name, for messages.

    Raises
    ------
    TwistError
        If no chain, or more than one, has the name. The message lists similar names.
    """
    chains = tuple(chains)
    for key, attributes in (
        (str, _NAME),
        (str, _LABELS),
        (str.casefold, _NAME),  # names before labels: 'leftleg' is LeftLeg, not the limb 'Left leg'
        (_without_spaces, (*_NAME, *_LABELS)),
        (_folded, (*_NAME, *_LABELS)),
    ):
        alike = [c for c in chains if key(name) in {key(getattr(c, a)) for a in attributes}]
        if len({c.parent for c in alike}) == 1:
            return alike[0]  # a chain comes before the limb that begins with it
        if alike:
            listed = " or ".join(c.name for c in alike)
            raise TwistError(f"{where}: the chain name {name!r} is ambiguous; choose {listed}")
    # If a limb and its first chain have the same label, the chain has priority.
    known = {_folded(word): c.name for c in reversed(chains) for word in (c.label, c.name)}
    from difflib import get_close_matches  # slow to load, and rarely needed

    near = get_close_matches(_folded(name), known, cutoff=_NEAR)
    if near:
        listed = " or ".join(dict.fromkeys(known[word] for word in near))
        raise TwistError(f"{where}: there is no chain {name!r}; did you mean {listed}?")
    listed = ", ".join(sorted(c.name for c in chains)) or "–"
    raise TwistError(f"{where}: there is no chain {name!r}; expected one of {listed}")


def _without_spaces(name: str) -> str:
    return "".join(name.split())


def _folded(name: str) -> str:
    return _without_spaces(name).casefold()


def group_chains_by_person(chains: Iterable[SomeChain]) -> dict[str, list[SomeChain]]:
    """Group chains by the name of the person. Within each group, the order does not change."""
    own: dict[str, list[SomeChain]] = {}
    for chain in chains:
        own.setdefault(chain.person, []).append(chain)
    return own


def chain_warnings(chains: Iterable[Chain]) -> tuple[str, ...]:
    """Return the warnings of all chains, without duplicates."""
    return tuple(dict.fromkeys(warning for chain in chains for warning in chain.warnings))


def bone_direction(motion: Motion, joint: int, warnings: list[str]) -> Array | None:
    """Return the unit vector from a joint's parent to the joint, or None if the bone has no length.

    The shape is (3,), or (frames, 3) if the direction varies by more than 1°. Assumptions are
    appended to `warnings`.
    """
    skeleton = motion.skeleton
    offset = bone_offset(motion, joint)
    if joint in motion.positioned and offset.ndim == 1:
        warnings.append(
            f"{skeleton.names[joint]}: the position channels are close to zero; the OFFSET is used."
        )
        return normalise(offset)
    lengths, smallest = vector_lengths(offset), minimum_bone_length_for_direction(skeleton)
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


def chain_limb_name(chain: Chain) -> str:
    """Return the name of a chain's limb, such as 'left arm', or '' for a chain in the trunk."""
    if not chain.side:
        return ""
    kind = "leg" if chain.segment in ("UpLeg", "Leg") else "arm"
    whose = f" of {chain.person}" if chain.person else ""
    return f"{chain.side.lower()} {kind}{whose}"
