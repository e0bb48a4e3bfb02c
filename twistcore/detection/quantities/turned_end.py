"""The curve of a turned end: the angle of the joint from its rotation before the flip."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import Quantity
from twistcore.detection.turned_ends import SMALLEST
from twistcore.skeleton.rotation import geodesic_angle


def angle_from_before(search: KindSearch, interval: Interval) -> Quantity:
    """Return the angle of a joint from its rotation in the frame before the interval.

    The limit is the smallest angle that is listed.
    """
    own = search.corrected_motion().rotations[:, search.joint_of(interval)]
    return Quantity(
        f"Rotation of {interval.joint} relative to the frame before the flip",
        np.degrees(geodesic_angle(own, own[max(interval.start - 1, 0)])),
        np.full(len(own), math.degrees(SMALLEST)),
        math.degrees(interval.size),
    )
