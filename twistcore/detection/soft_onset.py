"""Describe how gradually a soft error begins and ends."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import Array

SOFT = "a soft onset"  # value of the evidence "follows" of a soft error
BEGUN, THERE = 0.05, 0.9  # shares of the largest offset at which the rise begins and ends


def is_soft_error(interval: Interval) -> bool:
    """Return True if the interval was found as a soft error, which begins and ends gradually."""
    offset = interval.offset  # usually constant; then the evidence need not be computed
    if not len(offset) or (offset[0] == offset).all():
        return False
    return (interval.evidence or {}).get("follows") == SOFT


def describe_soft_onset(interval: Interval) -> str:
    """Describe the onset and the size of a soft error in words, or return '' for other errors."""
    if not is_soft_error(interval):
        return ""
    sigma = (interval.evidence or {})["sigma_deg"]
    largest = math.degrees(interval.largest)
    times = abs(largest) / sigma
    rises, falls = rise_and_fall_frames(interval.offset)
    frames = "1 frame" if rises == 1 else f"{rises} frames"
    return (
        f"begins over {frames} and ends over {falls}; within {interval.frames} frames, the "
        f"twist of P deviates from natural motion by up to {largest:+.1f}°, "
        f"{times:.{0 if times >= 10.0 else 1}f} times the usual {sigma:.2f}°"
    ).replace("-", "−")


def rise_and_fall_frames(offset: Array) -> tuple[int, int]:
    """Return the number of frames in which an offset rises, and the number in which it falls."""
    size = np.abs(offset)
    if not size.any():
        return 0, 0
    begun, there = (np.flatnonzero(size >= share * size.max()) for share in (BEGUN, THERE))
    return int(there[0] - begun[0]) + 1, int(begun[-1] - there[-1]) + 1
