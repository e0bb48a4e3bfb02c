"""The curve of a stretch: the joint's roll about its own bone, from its usual roll."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import OwnFrames, Quantity
from twistcore.detection.stretches import OFF, defined_roll, usual_roll
from twistcore.skeleton.rotation import wrap


def roll_from_usual(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the roll, with the difference from the usual roll that makes a stretch as the limit.

    If no roll is usual, the roll is compared with the frames outside the interval.
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
    middle = 0.5 * interval.residual  # of the range, so that neither level is near its ends
    degrees = np.degrees(middle + wrap(roll - usual - middle))
    return Quantity(
        f"Roll of {interval.joint} from its usual roll",
        degrees[own.at],
        own.level(math.copysign(math.degrees(OFF), interval.residual)),
        math.degrees(interval.size),
    )
