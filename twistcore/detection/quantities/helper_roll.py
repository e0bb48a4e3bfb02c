"""The curve of a helper roll: the twist bone's roll relative to the frame before the interval."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.helper_rolls import SMALLEST_ROLL, accumulated_helper_roll
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import Quantity
from twistcore.skeleton.helper import Helper


def roll_of_helper(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the curve of the twist bone's roll relative to the frame before the interval.

    The limit of the curve is the smallest roll that is reported. The result is None if the twist
    bone does not exist.
    """
    own = (h for h in search.named if isinstance(h, Helper) and h.name == interval.chain)
    if (helper := next(own, None)) is None:
        return None
    roll, frames = accumulated_helper_roll(search.motion, helper), search.motion.frames
    before = interval.start - 1 if interval.start else min(interval.stop, frames - 1)
    return Quantity(
        f"Roll of {interval.chain} relative to the frame before the interval",
        np.degrees(roll - roll[before]),
        np.full(frames, math.copysign(math.degrees(SMALLEST_ROLL), interval.shown)),
        math.degrees(interval.shown),
    )
