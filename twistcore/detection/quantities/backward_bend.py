"""The curve of a backward bend: the flexion of the knee or elbow."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.backward_bends import hinge_of
from twistcore.detection.evidence import ChainSignals
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.detection.quantity import Quantity


def flexion_of_hinge(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the curve of the joint's flexion, which is negative for a backward bend.

    The limit of the curve is the largest natural hyperextension. The result is None if the hinge is
    unknown.
    """
    joint = search.joint_of(interval)
    chain = next((c for c in search.chains if c.child == joint and c.ends), None)
    if chain is None:
        return None
    motion = search.corrected_motion()
    if (hinge := hinge_of(ChainSignals.of(motion, chain))) is None:
        return None
    return Quantity(
        f"Flexion of {interval.joint}, negative if backward",
        hinge.flexion,
        np.full(motion.frames, -hinge.limit),
        -math.degrees(interval.size),
    )
