"""An error that sets in softly, in words."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import Array

SOFT = "a soft onset"  # what the evidence of such an interval follows
BEGUN, THERE = 0.05, 0.9  # of the largest offset: it sets in from the first to the second


def soft_onset(interval: Interval) -> str:
    """How an error sets in, how far it goes, and what that is to its scale; '' for all others."""
    evidence = interval.evidence or {}
    if evidence.get("follows") != SOFT:
        return ""
    sigma = evidence["sigma_deg"]
    largest = math.degrees(interval.largest)
    times = abs(largest) / sigma
    rises, falls = onset_frames(interval.offset)
    frames = "1 frame" if rises == 1 else f"{rises} frames"
    return (
        f"begins over {frames} and ends over {falls}; the level of P departs from natural "
        f"motion by up to {largest:+.1f}° over the {interval.frames}, "
        f"{times:.{0 if times >= 10.0 else 1}f} times its natural {sigma:.2f}°"
    ).replace("-", "−")


def onset_frames(offset: Array) -> tuple[int, int]:
    """Frames that an offset, (frames,), takes to be nearly at its largest, and to be gone."""
    size = np.abs(offset)
    if not size.any():
        return 0, 0
    begun, there = (np.flatnonzero(size >= share * size.max()) for share in (BEGUN, THERE))
    return int(there[0] - begun[0]) + 1, int(begun[-1] - there[-1]) + 1
