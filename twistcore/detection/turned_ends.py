"""Turned ends: in a limb flip, the foot or hand turns by a rotation of its own and turns back.

A solver that places the knee on the wrong side often turns the foot as well. The correction of the
flip then keeps or carries the foot, but neither makes its motion continuous: its local rotation
jumps in the first frame of the flip and jumps back in the frame after the last. If both jumps are
the same rotation, up to its direction, the foot was turned by this rotation in all frames of the
flip. The foot must also jump as captured, since a correction of natural motion would turn it.

A turned end is never corrected automatically.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from twistcore.detection.all_joints.finders import owners
from twistcore.detection.all_joints.joint_steps import LONGEST
from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.rotation import Array, conjugate, geodesic_angle, multiply, slerp

SMALLEST = math.radians(45.0)  # of the turns at both edges
APART = math.radians(25.0)  # largest angle between the first turn and the inverse of the second


def find_turned_ends(search: KindSearch) -> Found:
    """Return the ends of limbs that are turned during a flip, keyed by chain name."""
    if not search.chains:
        return {}
    found: Found = search.once(_in_all_flips)
    return found


def turns_of_end(rotations: Array) -> tuple[Array, Array]:
    """Return the rotation by which a joint turns at the start of an interval, and back at its stop.

    `rotations` are the joint's local rotations in the frames start − 1, start, stop − 1 and stop,
    (4, 4). Each result is a quaternion in the joint's own frame, (4,). The second is inverted, so
    that both are equal if the joint turns back by the same rotation.
    """
    before, first, last, after = rotations
    return multiply(conjugate(before), first), multiply(conjugate(after), last)


def common_turn(turns: tuple[Array, Array]) -> Array:
    """Return the rotation halfway between the two results of :func:`turns_of_end`, (4,)."""
    return slerp(*turns, 0.5)


def turned_spans(search: KindSearch) -> frozenset[tuple[int, int, int]]:
    """Return the joint, start and stop of each turned end."""
    every = (one for own in find_turned_ends(search).values() for one in own)
    return frozenset((search.joint_of(one), one.start, one.stop) for one in every)


def _in_all_flips(search: KindSearch) -> dict[str, list[Interval]]:
    found: dict[str, list[Interval]] = {}
    for one in _turned_ends(search):
        found.setdefault(one.chain, []).append(one)
    return found


def _turned_ends(search: KindSearch) -> Iterator[Interval]:
    """Yield the turned ends of all flips that are longer than a spike."""
    motion, limbs = search.motion, {c.name: c for c in search.named if isinstance(c, Limb)}
    flips = [
        error
        for error in search.errors()
        if error.kind == Kind.LIMB_FLIP and error.frames > LONGEST * motion.fps
    ]
    if not flips or search.without is None:
        return
    owner, cut = owners(motion.skeleton, search.chains), find_cuts(motion)
    for flip in flips:
        start, stop, end = flip.start, flip.stop, limbs[flip.chain].end
        inside = start > 0 and stop < motion.frames
        if not inside or cut[start] or cut[stop] or end not in owner:
            continue
        edges = motion.rotations[[start - 1, start, stop - 1, stop], end]
        if _smaller(turns_of_end(edges)) < SMALLEST:
            continue  # the flip may be a false alarm, whose correction would turn the end
        frames = search.without([flip])
        edges = np.concatenate([frames(at - 1, at + 1).rotations[:, end] for at in (start, stop)])
        turns = turns_of_end(edges)
        apart = float(geodesic_angle(*turns))
        if _smaller(turns) < SMALLEST or apart > APART:
            continue
        turn = float(geodesic_angle(common_turn(turns), _STILL))
        joint = motion.skeleton.names[end]
        evidence = {
            "joint": joint,
            "turn_deg": math.degrees(turn),
            "apart_deg": math.degrees(apart),
        }
        yield Interval(
            owner[end].name,
            start,
            stop,
            np.zeros(stop - start),
            open=True,
            residual=turn,
            explain=partial(dict, evidence),
            kind=Kind.TURNED_END,
            carried=True,
            joint=joint,
        )


def _smaller(turns: tuple[Array, Array]) -> float:
    return min(float(geodesic_angle(turn, _STILL)) for turn in turns)


_STILL = np.array([1.0, 0.0, 0.0, 0.0])
