"""An error that sets in softly, in words."""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.interval import Interval
from twistcore.rotation import Array

SOFT = "a soft onset"  # what the evidence of such an interval follows
THERE = 0.9  # of the largest offset: from there on it has set in


def soft_onset(interval: Interval) -> str:
    """How an error sets in, how far it goes, and what that is to its scale; '' for all others."""
    evidence = interval.evidence or {}
    if evidence.get("follows") != SOFT:
        return ""
    sigma = evidence["sigma_deg"]
    largest = math.degrees(interval.largest)
    times = abs(largest) / sigma
    rises, falls = onset_frames(interval.offset)
    frames = f"{rises} frame{'' if rises == 1 else 's'}"
    return (
        f"sets in over {frames}, ends over {falls}; P's level departs from natural motion by up to "
        f"{largest:+.1f}° over the {interval.frames}, {times:.{0 if times >= 10.0 else 1}f}× its "
        f"natural {sigma:.2f}°"
    ).replace("-", "−")


def onset_frames(offset: Array) -> tuple[int, int]:
    """Frames until an offset, (frames,), is nearly at its largest, and from there to its end."""
    size = np.abs(offset)
    there = np.flatnonzero(size >= THERE * size.max(initial=0.0))
    return (int(there[0]) + 1, len(offset) - int(there[-1])) if len(there) else (0, 0)
