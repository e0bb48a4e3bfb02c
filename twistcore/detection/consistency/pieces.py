"""Use the twist of the first piece of a bone to check errors between it and the next piece.

In some rigs, only the last piece of a bone rolls, and the first piece only swings. If the path of
the swing is curved, the first piece still rotates about its bone from frame to frame, and the next
piece rotates back by the same angle. This is natural motion, because the twist θp of the first
piece does not change. An error δ changes θp by exactly δ.
"""

from __future__ import annotations

import numpy as np

from twistcore.detection.interval import Interval
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.medians import medians, pad_with_edge_values
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, twist_angle, wrap

_SHOWN = 0.5  # minimum share of an interval's steps that θp must contain
_NEAR = 3  # number of frames on either side whose median is the natural pace of the twist


def detrended_twist_increments(motion: Motion, chain: Chain) -> Array:
    """Return the increments of a chain's θp minus their running median, in radians, (frames,)."""
    angle = twist_angle(motion.rotations[:, chain.parent], chain.axis)
    steps = wrap(np.diff(angle, prepend=angle[:1]))
    padded = pad_with_edge_values(steps, _NEAR, _NEAR)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEAR + 1)
    return np.asarray(wrap(steps - medians(windows)))


def shows_in_twist(twist: Array, interval: Interval) -> bool:
    """Return True if the twist θp shows at least half of the changes of an interval's offset.

    `twist` is the result of :func:`detrended_twist_increments`.
    """
    level = np.zeros(len(twist) + 1)
    level[interval.start : interval.stop] = interval.offset
    steps = wrap(np.diff(level, prepend=0.0))[: len(twist)]
    steps[:1] = 0.0  # the clip's first frame has no step
    both = float(steps @ steps)
    return both == 0.0 or float(twist @ steps) >= _SHOWN * both
