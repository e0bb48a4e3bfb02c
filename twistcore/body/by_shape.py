"""Limbs whose joints have no known names, by the shape of the skeleton."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from twistcore.body.bones import unnamed_bones
from twistcore.body.by_names import Path, lines_of
from twistcore.body.parts import BONES, SIDES, LimbLine
from twistcore.body.shape import Shape
from twistcore.rotation import Array, normalise, rotate

_SMALL_LIMB = 0.35  # of the longest bone: a line of shorter ones is a neck, an ear


def unnamed_lines(shape: Shape, lines: Sequence[Sequence[int]]) -> tuple[LimbLine, ...]:
    """The limbs along lines of joints whose names say nothing; next to legs a neck is none."""
    found = [limb for line in lines if (limb := unnamed_line(shape, line))]
    sizes = [max(shape.lengths[b.child] for b in line.bones) for line in found]
    least = _SMALL_LIMB * max(sizes, default=0.0)
    return tuple(line for line, size in zip(found, sizes, strict=True) if size > least)


def unnamed_line(shape: Shape, joints: Sequence[int]) -> LimbLine | None:
    """The limb along a line of joints whose names say nothing; None without two bones."""
    bones = unnamed_bones(shape, joints)
    if not bones:
        return None
    end = bones[-1].child
    below = shape.below[2].get(end, -1)
    return LimbLine("", "", tuple(bones), _pointed_at(shape, end, below), by_shape=True)


def _pointed_at(shape: Shape, end: int, below: int) -> int:
    """The joint below a limb's end if the end is bent as a foot is; a hand is straight."""
    if below < 0 or not (shape.solid[below] and shape.solid[end]):
        return -1
    along = rotate(shape.motion.rotations[:, end], normalise(shape.offsets[below]))
    above = np.broadcast_to(normalise(shape.offsets[end]), along.shape)
    cosine = float(np.median(np.einsum("...i,...i->...", along, above)))
    return below if abs(cosine) < np.cos(np.radians(30.0)) else -1


def lines_by_shape(
    shape: Shape, lines: Sequence[Sequence[int]], known: Mapping[tuple[str, str], LimbLine]
) -> dict[tuple[str, str], LimbLine]:
    """Limbs without a known name that stand opposite to a known one, or on the bare trunk."""
    paths: dict[tuple[str, str], Path] = {}
    left = [list(line) for line in lines if unnamed_bones(shape, line)]
    across = _across(shape, known)
    for kind in BONES:
        wanted = [side for side in SIDES if (side, kind) not in known]
        if not wanted:
            continue
        here = _candidates(shape, left, kind, known)
        for side in wanted:
            own = [s for s in here if _side(shape, s, across) == side]
            if len(own) != 1:
                continue
            bones = unnamed_bones(shape, own[0])
            joints = own[0][: own[0].index(bones[-1].child) + 1]
            paths[side, kind] = (joints[::-1], len(BONES[kind]) - 1)
            left.remove(own[0])
    return lines_of(shape, paths, by_shape=True)


def _candidates(
    shape: Shape,
    lines: Sequence[list[int]],
    kind: str,
    known: Mapping[tuple[str, str], LimbLine],
) -> list[list[int]]:
    """Lines that may be arms or legs: those on the joint that the limb of the other side has.

    Without one: those on the trunk above the legs for arms, on the root's side for legs.
    """
    anchors = {k: _anchors(shape, known, k) for k in BONES}
    if anchors[kind]:
        return [s for s in lines if shape.parents[s[0]] in anchors[kind]]
    other = next(k for k in BONES if k != kind)
    return [s for s in lines if shape.parents[s[0]] not in anchors[other]]


def _anchors(shape: Shape, known: Mapping[tuple[str, str], LimbLine], kind: str) -> set[int]:
    """Joints that the limbs of a kind hang on."""
    return {shape.parents[line.bones[0].parent] for (_, k), line in known.items() if k == kind}


def _across(shape: Shape, known: Mapping[tuple[str, str], LimbLine]) -> Array | None:
    """The direction from right to left at rest, (3,), by a pair of known limbs."""
    for kind in BONES:
        pair = [known.get((side, kind)) for side in SIDES]
        if all(pair):
            left, right = (shape.rest[line.bones[-1].child] for line in pair if line)
            return np.asarray(left - right)
    return None


def _side(shape: Shape, line: Sequence[int], across: Array | None) -> str:
    """The side that the names of a line say, or its place at rest; '' where neither does."""
    named = {shape.names[j].side for j in line} - {""}
    if len(named) == 1:
        return named.pop()
    if across is None or named:
        return ""
    middle = shape.rest[shape.parents[line[0]]]
    far = (shape.rest[list(line)] - middle) @ across
    widest = float(far[np.abs(far).argmax()])
    span = float(np.abs(across @ across))
    if abs(widest) < 0.05 * span:
        return ""
    return "Left" if widest > 0.0 else "Right"
