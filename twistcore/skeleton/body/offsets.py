"""Offsets between joints, and whether an offset is long enough to have a direction."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array

_ZERO = 1e-6  # share of the skeleton's height; shorter offsets have no direction
_SHIFT = 1e-2  # share of OFFSET's length; shorter positions are shifts from it or rounding errors


def has_length(skeleton: Skeleton, offset: Array) -> bool:
    """True if any vector, (3,) or (frames, 3), is long enough to have a direction."""
    return bool(np.linalg.norm(offset, axis=-1).max() > shortest(skeleton))


def bone_offset(motion: Motion, joint: int) -> Array:
    """Return a joint's offset from its parent, (3,) from OFFSET or (frames, 3) from channels.

    Position channels near zero are shifts from OFFSET or rounding errors, so OFFSET is used
    instead.
    """
    rest, offset = motion.skeleton.offsets[joint], motion.translation(joint)
    length, longest = np.linalg.norm(rest), np.linalg.norm(offset, axis=-1).max()
    smallest = shortest(motion.skeleton)
    shifts = length > smallest and longest <= max(smallest, _SHIFT * length)  # never from OFFSET
    return np.asarray(rest) if shifts else offset


def shortest(skeleton: Skeleton) -> float:
    """Return the length, in the file's unit, up to which an offset has no direction."""
    return _ZERO * skeleton.height


def ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """Return the joints above a joint, the nearest first."""
    out = []
    while (joint := int(skeleton.parents[joint])) >= 0:
        out.append(joint)
    return out
