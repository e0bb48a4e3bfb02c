"""The curve of a body step: the median rotation per frame of the joints that jump."""

from __future__ import annotations

import math

from twistcore.detection.all_joints.body_steps import body_rotation_curve_and_limit
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import ENDS, OwnFrames, Quantity
from twistcore.skeleton.notation import find_keys_of_linear_motion, without_repeated_frames
from twistcore.skeleton.people import find_people


def turn_of_body(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the curve of the median rotation per frame of the joints that jump.

    The limit of the curve is the largest natural rotation. The result is None if no joint jumps.
    """
    motion, kept = search.motion, without_repeated_frames(search.motion)
    if kept is None and (keys := find_keys_of_linear_motion(motion)) is not None:
        kept = keys.alone(motion)
    own = OwnFrames.of(motion, kept)
    person = next(c.person for c in search.chains if c.name == interval.chain)
    joints = next(p.joints for p in find_people(motion.skeleton) if p.name == person)
    found = body_rotation_curve_and_limit(own.motion, joints, *own.span(interval))
    if found is None:
        return None
    turns, limit = found
    return Quantity(
        "Median rotation of jumping joints",
        own.examined(turns, interval, ends=ENDS),
        own.examined(limit, interval, around=1, ends=ENDS),
        math.degrees(interval.size),
    )
