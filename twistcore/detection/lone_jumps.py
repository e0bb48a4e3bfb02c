"""Find lone jumps, in which a joint rotates about its own axis faster than any body can.

No body segment rotates about its own axis faster than about 7,500°/s; a pitcher's shoulder reaches
7,000°/s. A faster rotation is an error. If no other error explains it, it is reported as a lone
jump, for which no correction is known.
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
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.joint_owners import chain_of_joint
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notation import DistinctFrames, without_repeated_frames
from twistcore.skeleton.own_axis import (
    joint_world_rotations,
    own_bone_axis,
    twist_since_previous_frame,
)
from twistcore.skeleton.rotation import Array, conjugate, multiply, twist_angle
from twistcore.skeleton.runs import runs_of_true

FASTEST = math.radians(7500.0)  # per second
LEAST = math.radians(60.0)  # per frame; smaller turns may be noise at a high frame rate
# Below SLOW frames per second, one frame is weak evidence, and the limit per frame is LEAST_SLOW.
SLOW, LEAST_SLOW = 50.0, math.radians(120.0)
_BLOCK = 4_096  # frames
_Frames = Callable[[int, int], Motion]
# A joint whose turn relative to its parent is below this share of the limit only follows a joint
# above it.
_OWN_SHARE = 0.5


def largest_natural_turn(fps: float) -> float:
    """Return the largest natural rotation of a joint about its axis per frame, in radians."""
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
    """Return the lone jumps of chains, keyed by chain name and sorted by start.

    In a lone jump, the joint rotates too fast both in world space and relative to its parent. A
    child that only follows its parent does not jump, and neither does a child that keeps its
    orientation while its parent rotates. Jumps at a cut are excluded.

    The `residual` of an interval is the rotation angle in the fastest frame of the jump, in
    radians. The offset is 0, because no correction is known.

    Parameters
    ----------
    motion
        The clip.
    chains
        The chains to search.
    refined
        A function that returns the frames [start, stop) of the motion without known errors, so that
        their jumps are not listed a second time. By default, the motion itself is searched.
    """
    if motion.frames < 2 or not chains:
        return {chain.name: () for chain in chains}
    if without_repeated_frames(motion) is not None:
        whole = motion if refined is None else refined(0, motion.frames)
        if (held := without_repeated_frames(whole)) is not None:
            found = lone_jumps(held.motion, [chain.at(held.first) for chain in chains])
            return {
                name: tuple(_in_clip_frames(i, held) for i in own) for name, own in found.items()
            }
    names = motion.skeleton.names
    jumps: dict[str, list[Interval]] = {chain.name: [] for chain in chains}
    owner = chain_of_joint(chains)
    among = ~find_cuts(motion)
    for joint, turn in _turns_too_fast(
        motion, list(owner), among, refined or motion.sliced
    ).items():
        chain = owner[joint]
        for start, stop in runs_of_true(turn != 0.0):
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
    """Return the impossibly fast rotations of joints about their axes, keyed by joint.

    The angles are in radians, shape (frames,), and 0 in all other frames. `among` is the mask of
    the frames to examine, shape (frames,), and `refined` has the same meaning as in
    :func:`lone_jumps`. The clip is processed in blocks, because `refined` copies the rotations.
    """
    axes = {joint: own_bone_axis(motion.skeleton, joint) for joint in joints}
    found: dict[int, Array] = {}
    for low in range(0, motion.frames, _BLOCK):
        first, stop = max(low - 1, 0), min(low + _BLOCK, motion.frames)
        block = refined(first, stop)
        for joint, axis in axes.items():
            if axis is None:
                continue
            own = twist_since_previous_frame(block.rotations[:, joint], axis)
            at = np.flatnonzero(possibly_too_fast_mask(own, motion.fps) & among[first:stop])
            if not len(at):
                continue
            before, after = (
                joint_world_rotations(block, joint, at - 1),
                joint_world_rotations(block, joint, at),
            )
            turn = twist_angle(multiply(conjugate(before), after), axis)
            fast = impossibly_fast_mask(turn, own[at], motion.fps)
            if fast.any():
                found.setdefault(joint, np.zeros(motion.frames))[first + at[fast]] = turn[fast]
    return found


def _in_clip_frames(jump: Interval, held: DistinctFrames) -> Interval:
    """Convert a jump to frame numbers of the whole clip, including held frames."""
    start, stop = held.end(jump.start), held.end(jump.stop - 1) + 1
    return replace(jump, start=start, stop=stop, offset=np.zeros(stop - start))


def impossibly_fast_mask(in_world: Array, own: Array, fps: float) -> NDArray[np.bool_]:
    """Return a mask of the frames in which a joint rotates about its axis impossibly fast.

    `in_world` and `own` are the rotation angles per frame in world space and relative to the
    joint's parent, from :func:`twist_since_previous_frame`, each of shape (frames,).
    """
    return np.asarray(
        (np.abs(in_world) > largest_natural_turn(fps)) & possibly_too_fast_mask(own, fps)
    )


def possibly_too_fast_mask(own: Array, fps: float) -> NDArray[np.bool_]:
    """Return a mask of the frames in which a joint may rotate too fast, (frames,).

    In these frames, the rotations `own` relative to the parent are large. In all other frames, any
    fast rotation in world space comes from a joint above.
    """
    return np.asarray(np.abs(own) > _OWN_SHARE * largest_natural_turn(fps))


def _explained(joint: str, turn: float, fps: float) -> dict[str, float | str]:
    """Return the evidence for a jump, keyed by name. Angles are in degrees, speeds in degrees/s."""
    return {
        "joint": joint,
        "turn_deg": math.degrees(turn),
        "speed_deg_s": abs(math.degrees(turn)) * fps,
        "limit_deg_s": math.degrees(largest_natural_turn(fps)) * fps,
    }
