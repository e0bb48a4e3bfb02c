"""Errors between the pieces of one bone, which must appear in P's own twist, not only in its swing.

In some rigs the last piece of a bone has all the roll, and the first piece only swings. If the path
of the swing is curved, the first piece still turns about its bone from frame to frame, and the next
piece turns back by the same angle. This is natural motion: θp of the first piece does not change,
whereas an error δ changes it by exactly δ.
"""

from __future__ import annotations

import numpy as np

from twistcore.detection.interval import Interval
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.medians import medians
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, twist_angle, wrap

_SHOWN = 0.5  # share of an interval's steps that P's own twist must show
_NEAR = 3  # frames on either side: their median is the twist's natural pace


def own_twist(motion: Motion, chain: Chain) -> Array:
    """Return the increments of θp minus the median of nearby frames, in radians, (frames,)."""
    angle = twist_angle(motion.rotations[:, chain.parent], chain.axis)
    steps = wrap(np.diff(angle, prepend=angle[:1]))
    padded = np.pad(steps, _NEAR, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEAR + 1)
    return np.asarray(wrap(steps - medians(windows)))


def shows(twist: Array, interval: Interval) -> bool:
    """True if P's own twist contains at least half of an interval's steps.

    `twist` are the increments from :func:`own_twist`.
    """
    level = np.zeros(len(twist) + 1)
    level[interval.start : interval.stop] = interval.offset
    steps = wrap(np.diff(level, prepend=0.0))[: len(twist)]
    steps[:1] = 0.0  # the clip's first frame has no step
    both = float(steps @ steps)
    return both == 0.0 or float(twist @ steps) >= _SHOWN * both
