"""The bones of a limb, and the pieces into which a bone may be divided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from twistcore.skeleton.body.parts import Bone
from twistcore.skeleton.body.shape import Shape

_NUMBERED = np.radians(5.0)  # smallest bend of a joint that has a piece's name but another number
_UNKNOWN = np.radians(1.0)  # smallest bend of a joint whose name is unknown
_BENT = np.radians(10.0)  # largest bend up to which pieces and other joints look the same
_FOOT = 0.35  # share of the longest bone; a shorter bone below shin or forearm ends the limb
_NEARLY = 0.8  # share of the longest pair of bones; such a pair is preferred farther from the trunk
_SEGMENT_OF: Mapping[tuple[str, ...], str] = {
    ("shoulder",): "Shoulder",
    ("arm",): "Arm",
    ("forearm",): "ForeArm",
    ("upleg",): "UpLeg",
    ("leg",): "Leg",
}


def named_bones(shape: Shape, path: Sequence[int], segments: Sequence[str]) -> list[Bone]:
    """Return the bones of a limb, from the trunk outwards.

    `path` lists the limb's joints, from the end back to the trunk.
    """
    pieces = _pieces(shape, path)
    left = list(segments)
    bones: list[list[Bone]] = [[]]
    for child, parent in pairwise(path):
        if not left:
            break
        if not shape.solid[child]:  # at its parent's position: no bone
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
    """Return the joints that begin another piece of the bone above them.

    `path` lists the joints, from the end to the trunk.
    """
    out: set[int] = set()
    triples = list(zip(path, path[1:], path[2:], strict=False))
    named = [shape.first_role(j, shape.names[j].side) for j in path]
    known = [k for k, role in enumerate(named) if role]
    highest = max((k for k in known if named[k] != "shoulder"), default=-1)
    evident = any(shape.bend(here, below) > _BENT for below, here, _ in triples[: highest + 1])

    def known_below(k: int) -> list[str]:
        """Return the roles of the joints between the limb's end and the k-th, without pieces."""
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
            # Clavicle → shoulder01 → upper arm → forearm: one of the two collars is a piece.
            collars = {shape.first_role(j, name.side) for j in (here, above)} == {"shoulder"}
            if (collars and len(known_below(k)) > 1) or (not name.roles and k < highest):
                out.add(here)
    return out


def _ambiguous(shape: Shape, below: Sequence[int], joint: int) -> bool:
    """True if a joint's name may mean two bones and no joint below it is the lower of the two.

    `below` lists the joints of the limb below it, from the end back to the joint.
    """
    name = shape.names[joint]
    inner = (shape.names[j] for j in below[1:])
    return len(name.roles) > 1 and all(n.helper or n.stem == name.stem for n in inner)


def unnamed_bones(shape: Shape, joints: Sequence[int], segments: Sequence[str] = ()) -> list[Bone]:
    """Return the bones from the trunk to the end of a limb, without the foot or hand.

    `segments` are the names of the bones of an arm or leg. If they are given, the limb ends with
    its two longest bones. If not, a long foot is included.
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
    end = lower_pair([a + b for a, b in pairwise(size)]) + 1 if len(size) > 1 else 0
    if not segments:  # a horse has a long foot
        while end + 1 < len(whole) and size[end + 1] > _FOOT * max(size):
            end += 1
    limb = whole[: end + 1][-len(segments) :] if segments else whole[: end + 1]
    named = segments[-len(limb) :] or [""] * len(limb)
    return [
        Bone(p, c, segment, k == len(bone) - 1, len(bone))
        for bone, segment in zip(limb, named, strict=True)
        for k, (p, c) in enumerate(bone)
    ]


def lower_pair(sums: Sequence[float]) -> int:
    """Return the index of thigh and shin, or of arm and forearm, among a limb's pairs of bones.

    `sums` are the total lengths of each pair of neighbouring bones, starting at the trunk. The
    longest pair is chosen. If several pairs are nearly as long, the one farthest from the trunk is
    chosen, since a collar bone may be as long as a forearm.
    """
    return max(k for k, both in enumerate(sums) if both >= _NEARLY * max(sums))
