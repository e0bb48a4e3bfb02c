"""Find limbs without known joint names, by the shape of the skeleton."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from twistcore.skeleton.body.bones import limb_bones_by_shape
from twistcore.skeleton.body.by_names import toe_of
from twistcore.skeleton.body.parts import BONES, SIDES, LimbLine
from twistcore.skeleton.body.shape import Shape
from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array, normalise, rotate

_SMALL_LIMB = 0.35  # share of the longest limb bone; a line of shorter bones is a neck or an ear


def limbs_from_joint_lines(shape: Shape, lines: Sequence[Sequence[int]]) -> tuple[LimbLine, ...]:
    """Return the limbs formed by lines of joints without known names.

    Lines of short bones, such as a neck, are omitted.
    """
    found = [limb for line in lines if (limb := limb_from_joint_line(shape, line))]
    sizes = [max(shape.lengths[b.child] for b in line.bones) for line in found]
    least = _SMALL_LIMB * max(sizes, default=0.0)
    return tuple(line for line, size in zip(found, sizes, strict=True) if size > least)


def limb_from_joint_line(shape: Shape, joints: Sequence[int]) -> LimbLine | None:
    """Return the limb formed by a line of unnamed joints, or None if it has fewer than 2 bones."""
    bones = limb_bones_by_shape(shape, joints)
    if not bones:
        return None
    end = bones[-1].child
    below = shape.below[2].get(end, -1)
    return LimbLine("", "", tuple(bones), _pointed_at(shape, end, below), by_shape=True)


def _pointed_at(shape: Shape, end: int, below: int) -> int:
    """Return the joint to which a foot points, or −1 if the limb's end is not a foot.

    A foot is at an angle to the shin, but a hand is roughly in line with the forearm. `below` is
    the joint below the end, or −1.
    """
    if below < 0 or not (shape.solid[below] and shape.solid[end]):
        return -1
    along = rotate(shape.motion.rotations[:, end], normalise(shape.offsets[below]))
    above = np.broadcast_to(normalise(shape.offsets[end]), along.shape)
    cosine = median(np.einsum("...i,...i->...", along, above))
    return below if abs(cosine) < np.cos(np.radians(30.0)) else -1


def find_limbs_by_shape(
    shape: Shape, lines: Sequence[Sequence[int]], known: Mapping[tuple[str, str], LimbLine]
) -> dict[tuple[str, str], LimbLine]:
    """Find the limbs without known joint names in a body in which other limbs are known.

    Such a limb begins on the trunk, either opposite a known limb or elsewhere. The dict is keyed by
    (side, kind).
    """
    found: dict[tuple[str, str], LimbLine] = {}
    left = [list(line) for line in lines if limb_bones_by_shape(shape, line)]
    across = _across(shape, known)
    for kind, segments in BONES.items():
        wanted = [side for side in SIDES if (side, kind) not in known]
        here = _candidates(shape, left, kind, known) if wanted else []
        for side in wanted:
            own = [line for line in here if _side(shape, line, across) == side]
            if len(own) == 1:
                bones = tuple(limb_bones_by_shape(shape, own[0], segments))
                toe = _toe(shape, side, bones[-1].child) if kind == "leg" else -1
                found[side, kind] = LimbLine(side, kind, bones, toe, by_shape=True)
                left.remove(own[0])
    return found


def _toe(shape: Shape, side: str, foot: int) -> int:
    """Return the joint to which a foot points: a named toe, the next joint, or −1."""
    named = toe_of(shape, side, foot)
    return named if named >= 0 else _pointed_at(shape, foot, shape.below[2].get(foot, -1))


def _candidates(
    shape: Shape,
    lines: Sequence[list[int]],
    kind: str,
    known: Mapping[tuple[str, str], LimbLine],
) -> list[list[int]]:
    """Return the lines of joints that may be an arm or a leg.

    A candidate begins at the same joint as the known limb of that kind on the other side. If that
    limb is unknown too, a candidate begins at any joint at which no limb of the other kind begins.
    """
    anchors = {k: _anchors(shape, known, k) for k in BONES}
    if anchors[kind]:
        return [s for s in lines if shape.parents[s[0]] in anchors[kind]]
    other = next(k for k in BONES if k != kind)
    return [s for s in lines if shape.parents[s[0]] not in anchors[other]]


def _anchors(shape: Shape, known: Mapping[tuple[str, str], LimbLine], kind: str) -> set[int]:
    """Return the trunk joints at which the known limbs of the given kind begin."""
    return {shape.parents[line.bones[0].parent] for (_, k), line in known.items() if k == kind}


def _across(shape: Shape, known: Mapping[tuple[str, str], LimbLine]) -> Array | None:
    """Return the vector from right to left in the rest pose, (3,), or None if it is unknown.

    The vector connects the ends of two known limbs.
    """
    for kind in BONES:
        pair = [known.get((side, kind)) for side in SIDES]
        if all(pair):
            left, right = (shape.rest[line.bones[-1].child] for line in pair if line)
            return np.asarray(left - right)
    return None


def _side(shape: Shape, line: Sequence[int], across: Array | None) -> str:
    """Return the side of a line of joints, from names or the rest pose, or '' if unknown."""
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
