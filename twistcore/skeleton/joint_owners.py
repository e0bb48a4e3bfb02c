"""The chain to which each joint belongs, and the joints below a joint, a hand or a foot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import vector_lengths

_LAST_BONES = ("ForeArm", "Leg")


def chain_of_joint(chains: Sequence[Chain]) -> dict[int, Chain]:
    """Return the chain to which each joint belongs, keyed by joint.

    A joint that is the parent of one chain and the child of another belongs to the former.
    """
    owner = {chain.child: chain for chain in reversed(chains)}
    return owner | {chain.parent: chain for chain in chains}


def farthest_descendant_distance(skeleton: Skeleton, joint: int) -> float:
    """Return the distance from a joint to the farthest joint or End Site below it.

    The distance is measured in the rest pose, as a fraction of the skeleton's height.
    """
    place = {joint: np.zeros(3)}
    for below in range(joint + 1, len(skeleton)):  # a parent comes before its children
        if (above := int(skeleton.parents[below])) in place:
            place[below] = place[above] + skeleton.offsets[below]
    tips = [*place.values(), *(place[j] + offset for j, offset in skeleton.ends if j in place)]
    return float(vector_lengths(tips).max()) / skeleton.height


def nearest_chain_by_joint(skeleton: Skeleton, chains: Sequence[Chain]) -> dict[int, Chain]:
    """Return the chain under which each joint is listed, keyed by joint.

    A joint outside all chains is listed under the nearest chain of the same person. Joints that are
    not connected to any chain are omitted.
    """
    people = find_people(skeleton)
    owner: dict[int, Chain] = {}
    for person in people:
        own = [chain for chain in chains if chain.person == person.name]
        nearest = _nearest(skeleton, own)
        joints = nearest if len(people) == 1 else person.joints
        owner |= {joint: nearest[joint] for joint in joints if joint in nearest}
    return owner


def _nearest(skeleton: Skeleton, chains: Sequence[Chain]) -> dict[int, Chain]:
    owner = chain_of_joint(chains)
    below: dict[int, tuple[int, Chain]] = {}  # the nearest chain below a joint
    for chain in chains:
        joint, way = int(skeleton.parents[chain.parent]), 1
        while joint >= 0:
            if joint not in below or way < below[joint][0]:
                below[joint] = way, chain
            joint, way = int(skeleton.parents[joint]), way + 1
    for joint, above in enumerate(skeleton.parents.tolist()):
        if joint in owner:
            continue
        if joint in below:
            owner[joint] = below[joint][1]
        elif above in owner:
            owner[joint] = owner[above]
    return owner


def joints_below_hands_and_feet(skeleton: Skeleton, chains: Sequence[Chain]) -> set[int]:
    """Return the indices of all joints below the hands and feet."""
    last = {c.child for c in chains if c.ends and c.segment in _LAST_BONES}
    last = last or {c.child for c in chains} - {c.parent for c in chains}
    small: set[int] = set()
    for joint, above in enumerate(skeleton.parents.tolist()):
        if above in last or above in small:
            small.add(joint)
    return small
