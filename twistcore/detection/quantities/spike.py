"""The curve of a spike: how far the joint is off the path between the frames around it."""

from __future__ import annotations

import math

from twistcore.detection.all_joints.finders import limits_of
from twistcore.detection.all_joints.joint_steps import path_curve
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import ENDS, OwnFrames, Quantity


def angle_off_path(search: KindSearch, interval: Interval) -> Quantity:
    """Return the angle between the joint and the slerp of its neighbours, with the least spike."""
    own, joint = OwnFrames.of(search.motion), search.joint_of(interval)
    limits = limits_of(own.motion, search.chains)
    off, least = path_curve(own.motion.rotations, joint, *own.span(interval), limits)
    return Quantity(
        f"{interval.joint} off its path",
        own.examined(off, interval, around=limits.longest, ends=ENDS),
        own.level(least),
        math.degrees(interval.size),
    )
