"""The curve of a spike: the angle between the joint's rotation and its path."""

from __future__ import annotations

import math

from twistcore.detection.all_joints.finders import limits_of
from twistcore.detection.all_joints.joint_steps import path_deviation_and_spike_limit
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import ENDS, OwnFrames, Quantity


def angle_off_path(search: KindSearch, interval: Interval) -> Quantity:
    """Return the curve of the angle between the joint's rotation and its path.

    The path is interpolated between neighbouring frames. The limit of the curve is the
    smallest angle that counts as a spike.
    """
    own, joint = OwnFrames.of(search.motion), search.joint_of(interval)
    limits = limits_of(own.motion, search.chains)
    off, least = path_deviation_and_spike_limit(
        own.motion.rotations, joint, *own.span(interval), limits
    )
    return Quantity(
        f"Angle of {interval.joint} from its path",
        own.examined(off, interval, around=limits.longest, ends=ENDS),
        own.level(least),
        math.degrees(interval.size),
    )
