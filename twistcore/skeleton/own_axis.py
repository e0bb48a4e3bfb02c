"""The axis along a joint's own bone, and how the joint turns about it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array, conjugate, multiply, twist_angle, twist_reliability

_DEFINED = 0.5  # minimum of :func:`twist_reliability`, which is low near a swing of 180°


def own_bone_axis(skeleton: Skeleton, joint: int) -> Array | None:
    """Return the direction of a joint's own bone as a unit vector, (3,), or None.

    The bone points to the farthest child or End Site. If all children are at the joint's position,
    as in the hands of some rigs, the axis of the first child with an axis is returned.
    """
    ends = [skeleton.offsets[child] for child in skeleton.children[joint]]
    if joint in skeleton.end_offsets:
        ends.append(skeleton.end_offsets[joint])
    lengths = [float(np.linalg.norm(end)) for end in ends]
    if lengths and max(lengths) > 1e-6 * skeleton.height:
        axis: Array = ends[int(np.argmax(lengths))] / max(lengths)
        return axis
    below = (own_bone_axis(skeleton, child) for child in skeleton.children[joint])
    return next((axis for axis in below if axis is not None), None)


def twist_since_previous_frame(rotations: Array, axis: Array) -> Array:
    """Return the twist about an axis since the previous frame, for each frame, in radians.

    `rotations` has the shape (frames, …, 4), `axis` is a unit vector, (…, 3), and the result has
    the shape (frames, …).
    """
    out = np.zeros(rotations.shape[:-1])
    out[1:] = twist_angle(multiply(conjugate(rotations[:-1]), rotations[1:]), axis)
    return out


def world_turns_about_own_bone(motion: Motion, joint: int) -> Array:
    """Return the rotations of a joint about its own axis in world space, in radians, (frames,).

    Each angle is relative to the previous frame. For a joint without an axis, all angles are 0.
    """
    turns, axis = np.zeros(motion.frames), own_bone_axis(motion.skeleton, joint)
    if axis is not None:
        rotations = joint_world_rotations(motion, joint, np.arange(motion.frames))
        turns = twist_since_previous_frame(rotations, axis)
    return turns


def joint_world_rotations(motion: Motion, joint: int, at: NDArray[np.intp]) -> Array:
    """Return the global rotations of a joint at the given frames, (n, 4)."""
    line = [joint]
    while (above := int(motion.skeleton.parents[line[-1]])) >= 0:
        line.append(above)
    found: Array = motion.rotations[at, line.pop()]
    while line:
        found = multiply(found, motion.rotations[at, line.pop()])
    return found


def roll_about_own_bone(motion: Motion, joint: int) -> Array:
    """Return the roll of a joint about its own bone, in radians, (frames,).

    The roll is NaN in frames with a swing near 180°, where it is undefined, and in all frames if
    the joint has no bone.
    """
    axis = own_bone_axis(motion.skeleton, joint)
    if axis is None:
        return np.full(motion.frames, np.nan)
    rotations = motion.rotations[:, joint]
    defined = twist_reliability(rotations, axis) > _DEFINED
    return np.where(defined, twist_angle(rotations, axis), np.nan)
