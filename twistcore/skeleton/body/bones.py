"""Divide a limb into bones, and find the pieces into which a bone is divided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from twistcore.skeleton.body.parts import Bone
from twistcore.skeleton.body.shape import Shape

_NUMBERED = np.radians(5.0)  # a joint that is named like a piece but bends more is not a piece
_UNKNOWN = np.radians(1.0)  # a joint with an unknown name that bends more is not a piece
_BENT = np.radians(10.0)  # pieces are distinguished from joints only if a joint bends more
_FOOT = 0.35  # share of the longest bone; the limb ends before a shorter bone
_NEARLY = 0.8  # share of the longest pair of bones; of longer pairs, the outermost is chosen
_SEGMENT_OF: Mapping[tuple[str, ...], str] = {
    ("shoulder",): "Shoulder",
    ("arm",): "Arm",
    ("forearm",): "ForeArm",
    ("upleg",): "UpLeg",
    ("leg",): "Leg",
}


def limb_bones_by_name(shape: Shape, path: Sequence[int], segments: Sequence[str]) -> list[Bone]:
    """Return the bones of a limb with known joint names, from the trunk outwards.

    Parameters
    ----------
    shape
        The person's skeleton.
    path
        The joints from the limb's hand or foot up to the root.
    segments
        Names of the limb's bones, from the trunk outwards.
    """
    pieces = _pieces(shape, path)
    left = list(segments)
    bones: list[list[Bone]] = [[]]
    for child, parent in pairwise(path):
        if not left:
            break
        if not shape.solid[child]:  # the joint is at its parent's position
            continue
        segment = _SEGMENT_OF.get(shape.names[parent].roles) if parent in shape.said else None
        if segment in segments:
            left = [*segments[: segments.index(segment) + 1]]
        bones[-1].append(Bone(parent, child, left[-1]))
        if parent not in pieces:
            bones.append([])
            left.pop()
    return [
        replace(bone, ends=k == 0, pieces=len(one)) for one in bones for k, bone in enumerate(one)
    ][::-1]


def _pieces(shape: Shape, path: Sequence[int]) -> set[int]:
    """Return the joints that divide a bone into pieces, such as twist bones in a row.

    `path` lists the joints from the limb's hand or foot up to the root.
    """
    out: set[int] = set()
    triples = list(zip(path, path[1:], path[2:], strict=False))
    named = [shape.first_role(j, shape.names[j].side) for j in path]
    known = [k for k, role in enumerate(named) if role]
    highest = max((k for k in known if named[k] != "shoulder"), default=-1)
    evident = any(shape.bend(here, below) > _BENT for below, here, _ in triples[: highest + 1])

    def known_below(k: int) -> list[str]:
        """Return the known roles of the joints between the limb's end and the k-th joint of `path`.

        Joints that divide a bone into pieces are skipped.
        """
        return [r for j, r in zip(path[1:k], named[1:k], strict=True) if r and j not in out]

    for k, (below, here, above) in enumerate(triples, 1):
        name = shape.names[here]
        bend = shape.bend(here, below)
        if name.helper:
            out.add(here)
        elif name.number and shape.is_same_word(here, above):
            if bend < _NUMBERED if evident else not _ambiguous(shape, path[:k], here):
                out.add(here)
        elif evident and bend < _UNKNOWN:
            # In clavicle → shoulder01 → upper arm → forearm, one of the two collar bones is a
            # piece.
            collars = {shape.first_role(j, name.side) for j in (here, above)} == {"shoulder"}
            if (collars and len(known_below(k)) > 1) or (not name.roles and k < highest):
                out.add(here)
    return out


def _ambiguous(shape: Shape, below: Sequence[int], joint: int) -> bool:
    """Return True if a joint's name may mean two bones, and lower joints do not show which one.

    `below` lists the limb's joints below `joint`, beginning with the hand or foot.
    """
    name = shape.names[joint]
    inner = (shape.names[j] for j in below[1:])
    return len(name.roles) > 1 and all(n.helper or n.stem == name.stem for n in inner)


def limb_bones_by_shape(
    shape: Shape, joints: Sequence[int], segments: Sequence[str] = ()
) -> list[Bone]:
    """Return the bones of a limb, given the line of joints that contains it.

    The foot or hand is not included. However, a long foot, such as a horse's, is included if
    `segments` is empty.

    Parameters
    ----------
    shape
        The person's skeleton.
    joints
        The line of joints from the trunk outwards. Each joint is the parent of the next.
    segments
        Names of an arm's or a leg's bones. If given, the limb ends with its two longest bones.
    """
    pairs = [(p, c) for p, c in pairwise(joints) if shape.solid[c]]
    if len(pairs) < 2:
        return []
    inner = [(c, d) for (_, c), (_, d) in pairwise(pairs)]
    evident = any(shape.bend(c, d) > _BENT for c, d in inner)
    pieces = {c for c, d in inner if shape.names[c].helper}
    if evident:
        single = (pair for pair in inner if len(shape.children[pair[0]]) == 1)
        pieces |= {c for c, d in single if shape.bend(c, d) < _UNKNOWN}
    whole: list[list[tuple[int, int]]] = []
    for pair in pairs:
        if whole and pair[0] in pieces:
            whole[-1].append(pair)
        else:
            whole.append([pair])
    size = [sum(shape.lengths[c] for _, c in bone) for bone in whole]
    end = (
        outermost_long_bone_pair_index([a + b for a, b in pairwise(size)]) + 1
        if len(size) > 1
        else 0
    )
    if not segments:  # include a long foot, such as a horse's
        while end + 1 < len(whole) and size[end + 1] > _FOOT * max(size):
            end += 1
    limb = whole[: end + 1][-len(segments) :] if segments else whole[: end + 1]
    named = segments[-len(limb) :] or [""] * len(limb)
    return [
        Bone(p, c, segment, k == len(bone) - 1, len(bone))
        for bone, segment in zip(limb, named, strict=True)
        for k, (p, c) in enumerate(bone)
    ]


def outermost_long_bone_pair_index(sums: Sequence[float]) -> int:
    """Return the index of the pair of bones that form the limb, such as thigh and shin.

    `sums` contains the total length of each pair of neighbouring bones, starting at the trunk. The
    longest pair is chosen. Among pairs that are nearly as long, the outermost is chosen, because a
    collar bone may be as long as a forearm.
    """
    return max(k for k, both in enumerate(sums) if both >= _NEARLY * max(sums))
