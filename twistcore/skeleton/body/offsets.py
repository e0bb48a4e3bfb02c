"""Offsets between joints, and whether an offset is long enough to have a direction."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array

_ZERO = 1e-6  # share of the skeleton's height; shorter offsets have no direction
_SHIFT = 1e-2  # share of OFFSET's length; a shorter position is added to OFFSET or a rounding error


def has_length(skeleton: Skeleton, offset: Array) -> bool:
    """True if any vector, (3,) or (frames, 3), is long enough to have a direction."""
    return bool(np.linalg.norm(offset, axis=-1).max() > shortest(skeleton))


def bone_offset(motion: Motion, joint: int) -> Array:
    """Return a joint's offset from its parent, (3,) from OFFSET or (frames, 3) from channels.

    If the position channels are near zero, they are relative to OFFSET or only rounding errors, and
    OFFSET is used.
    """
    rest, offset = motion.skeleton.offsets[joint], motion.translation(joint)
    length, longest = np.linalg.norm(rest), np.linalg.norm(offset, axis=-1).max()
    smallest = shortest(motion.skeleton)
    shifts = length > smallest and longest <= max(smallest, _SHIFT * length)  # near OFFSET
    return np.asarray(rest) if shifts else offset


def shortest(skeleton: Skeleton) -> float:
    """Return the smallest length, in the file's unit, at which an offset has a direction."""
    return _ZERO * skeleton.height


def ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """Return the joints above a joint, the nearest first."""
    out = []
    while (joint := int(skeleton.parents[joint])) >= 0:
        out.append(joint)
    return out
