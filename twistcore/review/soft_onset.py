"""Describe the onset of a soft error in words."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import Array

SOFT = "a soft onset"  # marks the evidence of an interval with a soft onset
BEGUN, THERE = 0.05, 0.9  # shares of the largest offset at the start and end of the onset


def is_soft(interval: Interval) -> bool:
    """True if the interval was found as a soft error, which begins and ends gradually."""
    offset = interval.offset  # constant between jumps: most intervals need no evidence here
    if not len(offset) or (offset[0] == offset).all():
        return False
    return (interval.evidence or {}).get("follows") == SOFT


def soft_onset(interval: Interval) -> str:
    """Describe the onset and the size of a soft error, or return '' for other errors."""
    if not is_soft(interval):
        return ""
    sigma = (interval.evidence or {})["sigma_deg"]
    largest = math.degrees(interval.largest)
    times = abs(largest) / sigma
    rises, falls = onset_frames(interval.offset)
    frames = "1 frame" if rises == 1 else f"{rises} frames"
    return (
        f"begins over {frames} and ends over {falls}; within {interval.frames} frames, the "
        f"twist of P deviates from natural motion by up to {largest:+.1f}°, "
        f"{times:.{0 if times >= 10.0 else 1}f} times the usual {sigma:.2f}°"
    ).replace("-", "−")


def onset_frames(offset: Array) -> tuple[int, int]:
    """Return the durations, in frames, of an offset's rise to its maximum and of its fall."""
    size = np.abs(offset)
    if not size.any():
        return 0, 0
    begun, there = (np.flatnonzero(size >= share * size.max()) for share in (BEGUN, THERE))
    return int(there[0] - begun[0]) + 1, int(begun[-1] - there[-1]) + 1
