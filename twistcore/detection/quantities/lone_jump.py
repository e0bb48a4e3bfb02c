"""The curve of a lone jump: the rotation of the joint about its own axis per frame."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.lone_jumps import largest_natural_turn
from twistcore.detection.quantity import OwnFrames, Quantity
from twistcore.skeleton.own_axis import world_turns_about_own_bone


def turn_about_axis(search: KindSearch, interval: Interval) -> Quantity:
    """Return the curve of the joint's rotation per frame about its own axis, in world space.

    The limit of the curve is the largest natural rotation.
    """
    own, joint = OwnFrames.of(search.corrected_motion()), search.joint_of(interval)
    most = math.copysign(math.degrees(largest_natural_turn(own.motion.fps)), interval.residual)
    return Quantity(
        f"Roll of {interval.joint} per frame",
        own.examined(np.degrees(world_turns_about_own_bone(own.motion, joint)), interval),
        own.level(most),
        math.degrees(interval.size),
    )
