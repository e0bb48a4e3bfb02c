"""The curve of a noise burst: the noise of the noisiest joint in every frame."""

from __future__ import annotations

import math

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.noise_bursts import joint_noise_and_burst_threshold
from twistcore.detection.quantity import OwnFrames, Quantity


def noise_of_joint(search: KindSearch, interval: Interval) -> Quantity:
    """Return the curve of the joint's noise σ near each frame.

    The limit of the curve is the smallest σ of a burst.
    """
    own = OwnFrames.of(search.motion)
    sigma, least = joint_noise_and_burst_threshold(own.motion, search.joint_of(interval))
    return Quantity(
        f"Noise σ of {interval.joint}",
        sigma[own.at],
        own.level(least),
        math.degrees(interval.size),
    )
