"""How bad a clip is, and what of it was not examined."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from twistcore.body import Unexamined
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


def limbs_left_out(result: Mapping[str, Any]) -> tuple[str, ...]:
    """The limbs of a clip's result that no chain examines, as 'left arm of B not examined: …'."""
    return tuple(
        f"{_limb(entry)} not examined: {entry['why']}" for entry in result.get("unexamined") or ()
    )


def _limb(entry: Mapping[str, str]) -> str:
    return Unexamined(entry["limb"], entry["why"], person=entry.get("person", "")).title
