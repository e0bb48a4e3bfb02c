"""Joints that turn about their own axis faster than any body can, with no other explanation.

No segment of a body turns about itself faster than about 7,500°/s (a pitcher's shoulder reaches
7,000). Any faster turn is an error and is reported, whether or not it can be corrected.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.runs import runs
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.notation import DistinctFrames, without_held
from twistcore.skeleton.rotation import Array, conjugate, multiply, twist_angle

FASTEST = math.radians(7500.0)  # per second
LEAST = math.radians(60.0)  # per frame; smaller turns may be noise at a high frame rate
# frames a second below which a single frame is weak evidence
SLOW, LEAST_SLOW = 50.0, math.radians(120.0)
_BLOCK = 4_096  # frames
_Frames = Callable[[int, int], Motion]
_OWN_SHARE = 0.5  # share of the limit; a joint that turns less only follows a joint above it


def limit(fps: float) -> float:
    """Return the largest natural turn about a joint's axis from frame to frame, in radians."""
    return LEAST_SLOW if fps < SLOW else max(LEAST, FASTEST / fps)


def find_lone_jumps(search: KindSearch) -> Found:
    """Return the lone jumps that remain after the automatic corrections, keyed by chain name."""
    as_captured = search.captured if search.corrected() is None else None
    return (as_captured or search).once(_in_all_chains)


def _in_all_chains(search: KindSearch) -> Found:
    return lone_jumps(search.motion, search.chains, search.corrected())


def lone_jumps(
    motion: Motion, chains: Sequence[Chain], refined: _Frames | None = None
) -> dict[str, tuple[Interval, ...]]:
    """Return the lone jumps, keyed by chain name and sorted by start.

    `refined` is a function that returns the frames [start, stop) of the motion without the known
    errors, so that a jump that belongs to one of them is not listed a second time. A joint must
    jump both in world space and relative to its parent: a child that only follows its parent does
    not jump, and neither does a child that keeps its orientation while its parent turns. Jumps at a
    cut are left out.

    `residual` is the turn in the fastest frame of the jump. The offset is 0, because no correction
    is known.
    """
    if motion.frames < 2 or not chains:
        return {chain.name: () for chain in chains}
    if without_held(motion) is not None:
        whole = motion if refined is None else refined(0, motion.frames)
        if (held := without_held(whole)) is not None:
            found = lone_jumps(held.motion, [chain.at(held.first) for chain in chains])
            return {
                name: tuple(_in_clip_frames(i, held) for i in own) for name, own in found.items()
            }
    cut = find_cuts(motion)
    cut[:1] = True
    names = motion.skeleton.names
    jumps: dict[str, list[Interval]] = {chain.name: [] for chain in chains}
    owner = chain_of_joint(chains)
    for joint, turn in _turns_too_fast(motion, list(owner), ~cut, refined or motion.sliced).items():
        chain = owner[joint]
        for start, stop in runs(turn != 0.0):
            most = max(turn[start:stop].tolist(), key=abs)
            jumps[chain.name].append(
                Interval(
                    chain.name,
                    start,
                    stop,
                    np.zeros(stop - start),
                    open=True,
                    residual=most,
                    explain=partial(_explained, names[joint], most, motion.fps),
                    kind=Kind.LONE_JUMP,
                    joint=names[joint],
                )
            )
    return {name: tuple(sorted(own, key=lambda i: i.start)) for name, own in jumps.items()}


def _turns_too_fast(
    motion: Motion, joints: Sequence[int], among: NDArray[np.bool_], refined: _Frames
) -> dict[int, Array]:
    """Return the impossibly fast turns of joints, in radians, (frames,), keyed by joint.

    The value is 0 in all other frames. `among` is the mask of the frames to examine, shape
    (frames,). The clip is processed in blocks, so that no copy of all its rotations is needed.
    """
    axes = {joint: own_axis(motion.skeleton, joint) for joint in joints}
    found: dict[int, Array] = {}
    for low in range(0, motion.frames, _BLOCK):
        first, stop = max(low - 1, 0), min(low + _BLOCK, motion.frames)
        block = refined(first, stop)
        counted = among[first:stop].copy()
        counted[0] = False  # the step into this frame belongs to the previous block
        for joint, axis in axes.items():
            if axis is None:
                continue
            own = turns_about(block.rotations[:, joint], axis)
            at = np.flatnonzero(may_be_too_fast(own, motion.fps) & counted)
            if not len(at):
                continue
            before, after = _in_room(block, joint, at - 1), _in_room(block, joint, at)
            turn = twist_angle(multiply(conjugate(before), after), axis)
            fast = too_fast(turn, own[at], motion.fps)
            if fast.any():
                found.setdefault(joint, np.zeros(motion.frames))[first + at[fast]] = turn[fast]
    return found


def _in_clip_frames(jump: Interval, held: DistinctFrames) -> Interval:
    """Convert a jump to frame numbers of the whole clip, including held frames."""
    start, stop = held.end(jump.start), held.end(jump.stop - 1) + 1
    return replace(jump, start=start, stop=stop, offset=np.zeros(stop - start))


def own_axis(skeleton: Skeleton, joint: int) -> Array | None:
    """Return the unit direction from a joint to its farthest child or End Site, (3,), or None.

    If all children are at the joint's position, as in the hands of some rigs, the axis of the first
    child that has one is returned.
    """
    ends = [skeleton.offsets[child] for child in skeleton.children[joint]]
    if joint in skeleton.end_offsets:
        ends.append(skeleton.end_offsets[joint])
    lengths = [float(np.linalg.norm(end)) for end in ends]
    if lengths and max(lengths) > 1e-6 * skeleton.height:
        axis: Array = ends[int(np.argmax(lengths))] / max(lengths)
        return axis
    below = (own_axis(skeleton, child) for child in skeleton.children[joint])
    return next((axis for axis in below if axis is not None), None)


def chain_of_joint(chains: Sequence[Chain]) -> dict[int, Chain]:
    """Return the chain of each joint, keyed by joint.

    If a joint is the parent of one chain and the child of another, the former is returned.
    """
    owner = {chain.child: chain for chain in reversed(chains)}
    return owner | {chain.parent: chain for chain in chains}


def too_fast(in_room: Array, own: Array, fps: float) -> NDArray[np.bool_]:
    """Return a mask of the frames in which a joint turns about its axis faster than any body can.

    `in_room` and `own` are the turns from :func:`turns_about` in world space and relative to the
    parent, both (frames,).
    """
    return np.asarray((np.abs(in_room) > limit(fps)) & may_be_too_fast(own, fps))


def may_be_too_fast(own: Array, fps: float) -> NDArray[np.bool_]:
    """Return a mask, (frames,), of the frames in which the turn relative to the parent is large.

    Only in these frames can a turn in world space be an impossibly fast turn of the joint itself.
    """
    return np.asarray(np.abs(own) > _OWN_SHARE * limit(fps))


def turns_in_room(motion: Motion, joint: int) -> Array:
    """Return the turn of a joint about its own axis since the previous frame, in world space.

    The turns are in radians, (frames,), and 0 for a joint without an axis.
    """
    turns, axis = np.zeros(motion.frames), own_axis(motion.skeleton, joint)
    if axis is not None:
        rotations = _in_room(motion, joint, np.arange(motion.frames))
        turns = turns_about(rotations, axis)
    return turns


def _in_room(motion: Motion, joint: int, at: NDArray[np.intp]) -> Array:
    """Return the global rotations of a joint at the given frames, (n, 4)."""
    line = [joint]
    while (above := int(motion.skeleton.parents[line[-1]])) >= 0:
        line.append(above)
    found: Array = motion.rotations[at, line.pop()]
    while line:
        found = multiply(found, motion.rotations[at, line.pop()])
    return found


def turns_about(rotations: Array, axis: Array) -> Array:
    """Return the turn about an axis since the previous frame, without swing, in radians.

    `rotations` has the shape (frames, …, 4), `axis` is a unit vector, (…, 3), and the result has
    the shape (frames, …).
    """
    out = np.zeros(rotations.shape[:-1])
    out[1:] = twist_angle(multiply(conjugate(rotations[:-1]), rotations[1:]), axis)
    return out


def _explained(joint: str, turn: float, fps: float) -> dict[str, float | str]:
    """Return the evidence for a jump, keyed by name, in degrees and seconds."""
    return {
        "joint": joint,
        "turn_deg": math.degrees(turn),
        "speed_deg_s": abs(math.degrees(turn)) * fps,
        "limit_deg_s": math.degrees(limit(fps)) * fps,
    }
