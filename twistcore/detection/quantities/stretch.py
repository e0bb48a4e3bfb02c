"""The curve of a stretch: the difference of the joint's roll from its usual roll."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import Quantity
from twistcore.detection.stretches import JUMP, OFF, roll_deviation
from twistcore.skeleton.rotation import wrap


def roll_from_usual(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the curve of the difference between the joint's roll and its usual roll.

    If the usual roll is unknown, the mean roll outside the interval is used instead. The limit of
    the curve is the smallest difference that is reported, which is smaller if the angles of the
    jumps are known. The result is None if both rolls are unknown.
    """
    off = roll_deviation(search, search.joint_of(interval), (interval.start, interval.stop))
    if off is None:
        return None
    # Wrap about an angle midway between the usual roll and the roll in the stretch.
    middle = 0.5 * interval.residual
    limit = OFF if abs(interval.residual) > OFF else JUMP
    return Quantity(
        f"Roll of {interval.joint} relative to its usual roll",
        np.degrees(middle + wrap(off - middle)),
        np.full(len(off), math.copysign(math.degrees(limit), interval.residual)),
        math.degrees(interval.size),
    )
