"""Find turned ends: feet or hands that are additionally rotated during a limb flip.

A solver that places the knee on the wrong side often rotates the foot by an additional angle. The
correction of the flip either keeps the orientation of the foot or rotates the foot with the leg. It
does not remove the additional rotation: after the correction, the local rotation of the foot jumps
in the first frame of the flip and jumps back in the frame after the last. If the second jump is
nearly the inverse of the first jump, the foot was rotated by the first jump in all frames of the
flip.

The captured rotation of the foot must jump in the same frames. If only the corrected rotation
jumps, the flip may be a false alarm, and the jump may come from its correction.

A turned end is never corrected automatically.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from twistcore.detection.all_joints.joint_steps import LONGEST
from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind, create_interval_without_offset
from twistcore.skeleton.joint_owners import nearest_chain_by_joint
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.rotation import Array, conjugate, geodesic_angle, multiply, slerp

SMALLEST = math.radians(45.0)  # smallest jump at the start and at the end of a flip, radians
# Largest angle between the first jump and the inverse of the second jump, radians
APART = math.radians(25.0)
_STILL = np.array([1.0, 0.0, 0.0, 0.0])  # the identity as a quaternion (w, x, y, z)


def find_turned_ends(search: KindSearch) -> Found:
    """Return the turned ends of a clip as intervals, keyed by chain name."""
    if not search.chains:
        return {}
    found: Found = search.once(_in_all_flips)
    return found


def jump_rotations_at_edges(rotations: Array) -> tuple[Array, Array]:
    """Return the rotations by which a joint jumps at the start and the end of an interval.

    Parameters
    ----------
    rotations
        The local rotations of the joint in the frames start − 1, start, stop − 1 and stop, (4, 4),
        as quaternions (w, x, y, z). The interval is from `start` to `stop` − 1.

    Returns
    -------
    first, second
        Quaternions (w, x, y, z) in the coordinates of the joint, (4,): the jump from the frame
        before the interval to its first frame, and the inverse of the jump from its last frame to
        the frame after the interval. The two are equal if the second jump undoes the first.
    """
    before, first, last, after = rotations
    return multiply(conjugate(before), first), multiply(conjugate(after), last)


def mean_edge_jump(turns: tuple[Array, Array]) -> Array:
    """Return the rotation, (4,), halfway between the rotations at both ends of an interval.

    `turns` are the results of :func:`jump_rotations_at_edges`.
    """
    return slerp(*turns, 0.5)


def turned_limb_end_spans(search: KindSearch) -> frozenset[tuple[int, int, int]]:
    """Return (joint index, start, stop) for each turned end."""
    every = (one for own in find_turned_ends(search).values() for one in own)
    return frozenset((search.joint_of(one), one.start, one.stop) for one in every)


def _in_all_flips(search: KindSearch) -> dict[str, list[Interval]]:
    found: dict[str, list[Interval]] = {}
    for one in _turned_ends(search):
        found.setdefault(one.chain, []).append(one)
    return found


def _turned_ends(search: KindSearch) -> Iterator[Interval]:
    """Yield the turned ends in all limb flips that last longer than a spike."""
    motion, limbs = search.motion, {c.name: c for c in search.named if isinstance(c, Limb)}
    flips = [
        error
        for error in search.errors()
        if error.kind == Kind.LIMB_FLIP and error.frames > LONGEST * motion.fps
    ]
    if not flips or search.without is None:
        return
    owner, cut = nearest_chain_by_joint(motion.skeleton, search.chains), find_cuts(motion)
    for flip in flips:
        start, stop, end = flip.start, flip.stop, limbs[flip.chain].end
        inside = start > 0 and stop < motion.frames
        if not inside or cut[start] or cut[stop] or end not in owner:
            continue
        edges = motion.rotations[[start - 1, start, stop - 1, stop], end]
        if _smaller(jump_rotations_at_edges(edges)) < SMALLEST:
            continue  # the captured end does not jump: the flip may be a false alarm
        frames = search.without([flip])
        edges = np.concatenate([frames(at - 1, at + 1).rotations[:, end] for at in (start, stop)])
        turns = jump_rotations_at_edges(edges)
        apart = float(geodesic_angle(*turns))
        if _smaller(turns) < SMALLEST or apart > APART:
            continue
        turn = float(geodesic_angle(mean_edge_jump(turns), _STILL))
        evidence = {
            "joint": motion.skeleton.names[end],
            "turn_deg": math.degrees(turn),
            "apart_deg": math.degrees(apart),
        }
        one = create_interval_without_offset(
            Kind.TURNED_END, owner[end].name, start, stop, turn, evidence
        )
        yield replace(one, carried=True)


def _smaller(turns: tuple[Array, Array]) -> float:
    return min(float(geodesic_angle(turn, _STILL)) for turn in turns)
