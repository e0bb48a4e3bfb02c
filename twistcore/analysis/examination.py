"""Find the parts of a motion that cannot be examined, and the reasons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from twistcore.detection.cuts import (
    SHORTEST_SEGMENT,
    count_leading_rest_frames,
    count_trailing_rest_frames,
    find_cuts,
    segments_between,
)
from twistcore.skeleton.body import Body, Unexamined, ancestors
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion

FEWEST_FRAMES = 5
_STILL = 1e-6  # a quaternion component that varies less does so only by rounding
_MOST_PIECES = 5  # maximum number of segments listed in a note


def why_not_examined(motion: Motion, chains: Sequence[Chain]) -> str:
    """Return the reason why a motion cannot be examined at all, as a clause, or ''."""
    if not chains:
        return "no arm or leg was found in its skeleton"
    if motion.frames < max(FEWEST_FRAMES, round(SHORTEST_SEGMENT * motion.fps)):
        if motion.frames == 1:
            return "1 frame is not enough to tell errors from motion"
        return f"{motion.frames} frames are not enough to tell errors from motion"
    joints = sorted({j for c in chains for j in (c.parent, c.child)})
    if all(np.ptp(motion.rotations[:, j], axis=0).max() < _STILL for j in joints):
        return "no joint in the arms or legs moves"
    if not segments_between(find_cuts(motion), motion.fps):
        return "every piece between two cuts is too short to tell errors from motion"
    return ""


def unexamined_segments_note(motion: Motion) -> str:
    """Return a sentence about segments between cuts that are too short to examine, or ''.

    T-poses at the ends of the clip, and blends from or to them, are not examined either. The
    sentence does not mention them.
    """
    frames = unexamined_frames(motion)
    if not frames:
        return ""
    count = sum(stop - start for start, stop in frames)
    some = [str(a) if b - a == 1 else f"{a}–{b - 1}" for a, b in frames[:_MOST_PIECES]]
    listed = ", ".join(some) + (" …" if len(frames) > len(some) else "")
    if count == 1:
        return f"Frame {listed} was not examined for twists, because it is alone between two cuts."
    return (
        f"{count} frames were not examined for twists, because the pieces between cuts that "
        f"contain them are too short: {listed}."
    )


def unexamined_frames(motion: Motion) -> tuple[tuple[int, int], ...]:
    """Return the frames [start, stop) of segments that are too short to examine.

    T-poses at the ends of the clip are not included.
    """
    left_out = np.ones(motion.frames, dtype=bool)
    for start, stop in segments_between(find_cuts(motion), motion.fps):
        left_out[start:stop] = False
    left_out[: count_leading_rest_frames(motion)] = False
    left_out[motion.frames - count_trailing_rest_frames(motion) :] = False
    edges = np.flatnonzero(np.diff(left_out, prepend=False, append=False)).tolist()
    return tuple((a, b) for k, (a, b) in enumerate(pairwise(edges)) if k % 2 == 0)


def unexamined_limbs(body: Body, chains: Sequence[Chain]) -> tuple[Unexamined, ...]:
    """Return the limbs of a body that no chain examines.

    `chains` may include chains that the user added.
    """
    found = {(bone.parent, bone.child) for line in body.lines for bone in line.bones}
    covered = {
        (c.person, body.names[c.parent].side or body.names[c.child].side, _kind_of(body, c))
        for c in chains
        if not (c.segment or isinstance(c, Helper)) and (c.parent, c.child) not in found
    }
    return tuple(u for u in body.missing if (u.person, u.side, u.kind) not in covered)


def unexamined_joints_by_body_part(
    body: Body, chains: Sequence[Chain]
) -> Mapping[str, tuple[str, ...]]:
    """Return the names of the joints that no chain examines, keyed by body part.

    The parts are the root, the trunk (all joints above a limb), the joints below the hands or the
    feet (or below the limbs, if names are unknown), and the others, such as neck and head.
    """
    skeleton = body.skeleton
    inside = {j for c in chains for j in (c.parent, c.child)}
    inside.update(c.end for c in chains if isinstance(c, Limb))
    parts: list[str] = []
    ends = {line.bones[-1].child: _BELOW.get(line.kind, "below the limbs") for line in body.lines}
    trunk = {j for line in body.lines for j in ancestors(skeleton, line.bones[0].parent)}
    for joint, parent in enumerate(skeleton.parents.tolist()):
        part = "trunk" if joint in trunk else "others"
        if parent < 0:
            part = "root"
        elif parent in ends:
            part = ends[parent]
        elif parts[parent].startswith("below"):
            part = parts[parent]
        parts.append(part)
    found: dict[str, list[str]] = {}
    for joint, part in enumerate(parts):
        if joint not in inside:
            found.setdefault(part, []).append(skeleton.names[joint])
    return {part: tuple(found[part]) for part in _PARTS if part in found}


_BELOW = {"arm": "below the hands", "leg": "below the feet"}
_PARTS = ("root", "trunk", *_BELOW.values(), "below the limbs", "others")


def _kind_of(body: Body, chain: Chain) -> str:
    """Return 'arm' or 'leg' according to the names of a chain's joints, or '' if unknown."""
    roles = {role for j in (chain.parent, chain.child) for role in body.names[j].roles}
    if roles & {"shoulder", "arm", "forearm", "hand"}:
        return "arm"
    return "leg" if roles & {"upleg", "leg", "foot", "toe"} else ""
