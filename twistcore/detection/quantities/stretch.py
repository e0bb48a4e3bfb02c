"""The curve of a stretch: the roll of the joint about its own bone, relative to the usual roll."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import Quantity
from twistcore.detection.stretches import OFF, roll_off
from twistcore.skeleton.rotation import wrap


def roll_from_usual(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the difference from the usual roll, with the smallest listed difference as limit.

    If the joint has no usual roll, the mean roll outside the interval is used instead.
    """
    off = roll_off(search, search.joint_of(interval), (interval.start, interval.stop))
    if off is None:
        return None
    middle = 0.5 * interval.residual  # of the angle range, so that no level is near its ends
    return Quantity(
        f"Roll of {interval.joint} relative to its usual roll",
        np.degrees(middle + wrap(off - middle)),
        np.full(len(off), math.copysign(math.degrees(OFF), interval.residual)),
        math.degrees(interval.size),
    )
