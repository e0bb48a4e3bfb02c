"""Where the joints of a skeleton are from each other, and which offsets have a direction."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array

_ZERO = 1e-6  # of the skeleton's height: shorter offsets have no direction
_SHIFT = 1e-2  # of OFFSET's length: positions so short are shifts from it or rounding, no bone


def has_length(skeleton: Skeleton, offset: Array) -> bool:
    """True if a vector, or one of some, is long enough for a direction; (3,) or (frames, 3)."""
    return bool(np.linalg.norm(offset, axis=-1).max() > shortest(skeleton))


def bone_offset(motion: Motion, joint: int) -> Array:
    """Where a joint is from its parent: (3,) from OFFSET, (frames, 3) from position channels.

    Position channels next to zero are shifts from OFFSET, or rounding: then OFFSET counts.
    """
    rest, offset = motion.skeleton.offsets[joint], motion.translation(joint)
    length, longest = np.linalg.norm(rest), np.linalg.norm(offset, axis=-1).max()
    smallest = shortest(motion.skeleton)
    shifts = length > smallest and longest <= max(smallest, _SHIFT * length)  # never of OFFSET
    return np.asarray(rest) if shifts else offset


def shortest(skeleton: Skeleton) -> float:
    """The length, in the file's unit, up to which an offset has no direction."""
    return _ZERO * skeleton.height


def ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """Joints above one, the nearest first."""
    out = []
    while (joint := int(skeleton.parents[joint])) >= 0:
        out.append(joint)
    return out
