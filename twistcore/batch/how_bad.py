"""How bad a clip is."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from twistcore.detection import Interval
from twistcore.rotation import wrap
from twistcore.twist_removal import applied_unasked


def severity(intervals: Iterable[Interval], frames: int) -> float:
    """How bad a clip is: the mean error a frame, degrees summed over all chains.

    Each interval counts by its confidence, so that doubtful ones do not push a clip to the top.
    """
    total = sum(
        float(np.degrees(np.abs(wrap(i.offset))).sum())
        * (1.0 if i.confidence is None else i.confidence)
        for i in applied_unasked(intervals, 0.0)
    )
    return total / max(frames, 1)


def percent_affected(affected: int, frames: int) -> float:
    """The share of a clip's or a batch's frames in which anything is wrong, percent; 0 of none."""
    return 100.0 * affected / frames if frames else 0.0
