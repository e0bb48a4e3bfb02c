"""Offsets between joints, and the minimum length of an offset that defines a direction."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array, vector_lengths

_ZERO = 1e-6  # share of the skeleton's height; shorter offsets have no direction
_SHIFT = 1e-2  # share of OFFSET's length; smaller position channels do not replace OFFSET


def has_bone_offset_direction(skeleton: Skeleton, offset: Array) -> bool:
    """Return True if any of the vectors is long enough to have a direction.

    `offset` has the shape (3,) or (frames, 3).
    """
    return bool(vector_lengths(offset).max() > minimum_bone_length_for_direction(skeleton))


def bone_offset(motion: Motion, joint: int) -> Array:
    """Return a joint's offset from its parent, (3,), or (frames, 3) if it has position channels.

    If the position channels are close to zero, they contain only rounding errors or are relative to
    OFFSET. In this case, OFFSET is used instead.
    """
    rest, offset = motion.skeleton.offsets[joint], motion.translation(joint)
    if offset.ndim == 1:
        return offset
    length, longest = np.linalg.norm(rest), vector_lengths(offset).max()
    smallest = minimum_bone_length_for_direction(motion.skeleton)
    shifts = length > smallest and longest <= max(smallest, _SHIFT * length)  # near OFFSET
    return np.asarray(rest) if shifts else offset


def minimum_bone_length_for_direction(skeleton: Skeleton) -> float:
    """Return the minimum length of an offset that defines a direction, in the file's unit."""
    return _ZERO * skeleton.height


def ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """Return the joints above a joint, nearest first."""
    out = []
    while (joint := int(skeleton.parents[joint])) >= 0:
        out.append(joint)
    return out
