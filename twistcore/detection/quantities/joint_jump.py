"""The curve of a joint jump: the rotation of the joint per frame."""

from __future__ import annotations

import math

from twistcore.detection.all_joints.finders import limits_of
from twistcore.detection.all_joints.joint_steps import joint_rotation_and_jump_limit
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import ENDS, OwnFrames, Quantity


def turn_per_frame(search: KindSearch, interval: Interval) -> Quantity:
    """Return the curve of the joint's rotation per frame about any axis.

    The limit of the curve is the smallest rotation that counts as a jump.
    """
    own, joint = OwnFrames.of(search.motion), search.joint_of(interval)
    limits = limits_of(own.motion, search.chains)
    turns, least = joint_rotation_and_jump_limit(
        own.motion.rotations, joint, own.span(interval)[0], limits
    )
    return Quantity(
        f"Turn of {interval.joint} per frame",
        own.examined(turns, interval, ends=ENDS),
        own.level(least),
        math.degrees(interval.size),
    )
