"""Compute the offset of an injected error in each frame, and choose frames by the pose."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, rotate
from twistcore.synthesis.protocol import Protocol, parent_and_child_twist_increments

Place: TypeAlias = tuple[int, int]

# A limb that is bent by less is straight: it does not show which of its joints twists.
STRAIGHT = float(np.radians(18.0))
# The shortest interval, and the shortest gap between two.
SPELL_SECONDS, BETWEEN_SECONDS = 0.067, 0.1
_REACH = 2.5  # number of periods of the cut-off frequency in which a filtered step settles


def injected_offset_over_time(
    delta: float,
    length: int,
    onset: bool,
    end: bool,
    rng: np.random.Generator,
    protocol: Protocol,
    fps: float,
) -> Array:
    """Return the offset in each frame of an error, radians, (length,).

    A low-pass filter makes the error longer at both ends.

    Parameters
    ----------
    delta
        The offset δ, radians.
    length
        Number of frames.
    onset, end
        True if the error begins, or ends, inside the clip.
    rng
        The random generator.
    protocol
        The protocol.
    fps
        Frames per second.
    """
    offset = np.full(length, delta)
    if protocol.drift:
        offset *= _drift(length, protocol)
    ramp = protocol.ramp
    if protocol.straight:
        low, high = (max(round(seconds * fps), 1) for seconds in protocol.straight)
        ramp = min(int(rng.integers(low, high + 1)), (length - 1) // 2)
    if ramp:
        rise = np.arange(1, ramp + 1) / (ramp + 1)
        if onset:
            offset[:ramp] *= rise
        if end:
            offset[-ramp:] *= rise[::-1]
    if protocol.stairs > 1:
        offset *= (1 + np.arange(length) * protocol.stairs // length) / protocol.stairs
    if protocol.flicker:
        offset[1::2] = 0.0
    if protocol.jitter:
        offset = offset + np.radians(protocol.jitter) * rng.standard_normal(length)
    if protocol.low_pass:
        # scipy.signal takes longer to load than all other imports of this package.
        from scipy.signal import butter, sosfiltfilt

        reach = frames_added_by_offset_filter(protocol, fps)
        sections = butter(2, min(protocol.low_pass / (0.5 * fps), 0.9), output="sos")
        offset = sosfiltfilt(sections, np.pad(offset, 3 * reach))[2 * reach : -2 * reach]
    return offset


def _drift(length: int, protocol: Protocol) -> Array:
    at = np.arange(length)
    if protocol.jump_out:
        course = at / max(length - 1, 1)
    else:
        course = np.interp(at, [0, (length - 1) / 2, length - 1], [0.0, 1.0, 0.0])
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * course) if protocol.eased else course)


def frames_added_by_offset_filter(protocol: Protocol, fps: float) -> int:
    """Return the number of frames that a low-pass filter adds at each end of an offset."""
    return math.ceil(_REACH / protocol.low_pass * fps) if protocol.low_pass else 0


def gap_filling_offset(motion: Motion, chain: Chain, place: Place, how: str) -> Array:
    """Return the offset caused by filling a gap in the parent's twist, radians, one per frame.

    `place` is the gap, and `how` is 'held' or 'interpolated'.
    """
    start, stop = place
    twist = np.cumsum(parent_and_child_twist_increments(motion, chain)[0])[start - 1 : stop + 1]
    given = np.full(len(twist), twist[0])
    if how == "interpolated":
        given = np.linspace(twist[0], twist[-1], len(twist))
    return np.asarray((given - twist)[1:-1])


def spans_with_straight_chain(motion: Motion, chain: Chain, first: int = 0) -> Iterator[Place]:
    """Yield the intervals [start, stop) in which the child's bone is in line with its parent's.

    Nothing is yielded for a chain that is straight in every frame.
    """
    if chain.grandchild < 0:
        return
    v = rotate(motion.rotations[:, chain.child], chain.arm)
    cosine = np.einsum("fi,fi->f", v, np.broadcast_to(chain.axis, v.shape))
    at = np.flatnonzero(cosine > math.cos(STRAIGHT))
    at = at[at >= first]
    between = max(1, round(BETWEEN_SECONDS * motion.fps))
    for run in np.split(at, np.flatnonzero(np.diff(at) > between) + 1) if len(at) else ():
        start, stop = int(run[0]), int(run[-1]) + 1
        long_enough = stop - start >= max(2, SPELL_SECONDS * motion.fps)
        if long_enough and (start > first or stop < motion.frames):
            yield start, stop
