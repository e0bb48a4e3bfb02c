"""The curve of a place jump: the distance of the position from its path."""

from __future__ import annotations

from twistcore.detection.all_joints.body_steps import path_distance_and_jump_limit
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import ENDS, OwnFrames, Quantity


def way_off_path(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the curve of the joint's distance from its path.

    Distances are percentages of the skeleton's height. The limit of the curve is the smallest
    distance that counts as a jump. The result is None for a joint without position channels.
    """
    own = OwnFrames.of(search.motion)
    start, stop = own.span(interval)
    found = path_distance_and_jump_limit(own.motion, search.joint_of(interval), start)
    if found is None:
        return None
    ways, least = 100.0 * found[0], 100.0 * found[1]
    return Quantity(
        f"Distance of {interval.joint} from its path, relative to the height",
        own.examined(ways, interval, around=2, ends=ENDS),
        own.level(least),
        float(ways[start:stop].max()),
        " %",
    )
