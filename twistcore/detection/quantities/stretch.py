"""The curve of a stretch: the roll of the joint about its own bone, relative to the usual roll."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import OwnFrames, Quantity
from twistcore.detection.stretches import OFF, defined_roll, usual_roll
from twistcore.skeleton.rotation import wrap


def roll_from_usual(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the difference from the usual roll, with the smallest listed difference as limit.

    If the joint has no usual roll, the mean roll outside the interval is used instead.
    """
    own, joint = OwnFrames.of(search.corrected_motion()), search.joint_of(interval)
    roll = defined_roll(own.motion, joint)
    start, stop = own.span(interval)
    outside = np.delete(roll, slice(start, stop))
    outside = outside[np.isfinite(outside)]
    if not len(outside):
        return None
    usual = usual_roll(own.motion, search.chains, joint)
    if usual is None:
        usual = float(np.angle(np.exp(1j * outside).sum()))
    middle = 0.5 * interval.residual  # of the angle range, so that no level is near its ends
    degrees = np.degrees(middle + wrap(roll - usual - middle))
    return Quantity(
        f"Roll of {interval.joint} relative to its usual roll",
        degrees[own.at],
        own.level(math.copysign(math.degrees(OFF), interval.residual)),
        math.degrees(interval.size),
    )
