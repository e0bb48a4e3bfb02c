"""Ease the correction of a stretch at an end at which the jump differs from the joint's wrong roll.

For example, a foot may begin to roll before the jump, or swing at the same time. If the joint is
rotated back by the same angle in all frames, a large part of the jump remains. If the angle begins
with the angle of the jump, less remains.
"""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.interval import eased_offset
from twistcore.detection.lone_jumps import own_bone_axis
from twistcore.detection.roll_levels import jump_angle_about
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
)

EASE = 0.25  # seconds from the angle of the jump to the angle of the other frames
# The smallest decrease of the largest remaining rotation per frame, in radians
GAIN = math.radians(10.0)


def ease_frame_count(fps: float) -> int:
    """Return the number of frames over which a correction is eased."""
    return round(EASE * fps)


def correction_end_angles(
    motion: Motion, joint: int, edges: tuple[int, int], delta: float
) -> tuple[float, float]:
    """Return the angles in radians with which the correction of a stretch should begin and end.

    At each end, this is `delta` unless easing it to the angle of the jump clearly reduces the
    largest rotation of the joint per frame that remains near this end.

    Parameters
    ----------
    motion
        The motion with the stretch.
    joint
        The index of the joint.
    edges
        The first frame of the stretch, and the frame after the last one.
    delta
        The angle of the correction in the other frames, in radians.
    """
    axis = own_bone_axis(motion.skeleton, joint)
    assert axis is not None
    (start, stop), ends = edges, [delta, delta]
    if not (ease := min(ease_frame_count(motion.fps), (stop - start) // 4)):
        return delta, delta
    near = (start - 1, start + ease), (stop - ease, stop + 1)
    for k, (at, sign) in enumerate(zip(edges, (1.0, -1.0), strict=True)):
        if not 0 < at < motion.frames:
            continue
        low, high = near[k]
        tried = list(ends)
        tried[k] = sign * jump_angle_about(motion, joint, axis, at)
        left = []
        for first, last in (ends, tried):
            offset = np.zeros(high - low)
            inside = slice(start - low, None) if k == 0 else slice(0, stop - low)
            whole = eased_offset(delta, (first, last), stop - start, ease)
            offset[inside] = whole[:ease] if k == 0 else whole[len(whole) - ease :]
            left.append(_largest_step(motion.rotations[low:high, joint], axis, offset))
        if left[0] - left[1] >= GAIN:
            ends = tried
    return ends[0], ends[1]


def _largest_step(rotations: Array, axis: Array, offset: Array) -> float:
    """Return the largest rotation per frame after removing an offset about an axis, in radians."""
    after = multiply(rotations, quaternion_from_axis_angle(axis, -offset))
    return float(geodesic_angle(after[:-1], after[1:]).max())
