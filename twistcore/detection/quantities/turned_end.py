"""The curve of a turned end: the rotation relative to the frame before the flip."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import Quantity
from twistcore.detection.turned_ends import SMALLEST
from twistcore.skeleton.rotation import geodesic_angle


def angle_from_before(search: KindSearch, interval: Interval) -> Quantity:
    """Return the curve of a joint's rotation angle relative to the frame before an interval.

    The angle is computed after all automatic corrections, in degrees. The limit of the curve is the
    smallest angle of a turned end.

    Parameters
    ----------
    search
        The clip with its known errors and corrections.
    interval
        The turned end.
    """
    own = search.corrected_motion().rotations[:, search.joint_of(interval)]
    return Quantity(
        f"Rotation of {interval.joint} relative to the frame before the flip",
        np.degrees(geodesic_angle(own, own[max(interval.start - 1, 0)])),
        np.full(len(own), math.degrees(SMALLEST)),
        math.degrees(interval.size),
    )
