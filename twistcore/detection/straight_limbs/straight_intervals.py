"""Convert errors of straight limbs to intervals with evidence."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from twistcore.detection.interval import Interval
from twistcore.detection.straight_limbs.straight_spells import StraightError

STRAIGHT = "a straight limb"  # the value of "follows" in the evidence


def straight_limb_interval(chain: str, error: StraightError) -> Interval:
    """Convert an error of a straight limb to an interval of the named chain."""
    return Interval(
        chain,
        error.start,
        error.stop,
        error.offset,
        confidence=straight_confidence(error),
        explain=partial(_explained, error),
    )


def straight_confidence(error: StraightError) -> float:
    """Return the probability that the correction of a straight limb's error is right, 0…1."""
    turn, answer = (abs(t) for t in error.turns)
    score = math.log(error.strength / math.radians(8.0)) + 3.0 * min(turn, answer) / max(
        turn, answer
    )
    return 1.0 / (1.0 + math.exp(-score))


def _explained(error: StraightError) -> dict[str, Any]:
    """Return the evidence for an error, keyed by name, with angles in degrees."""
    turn, answer = error.turns
    return {
        "follows": STRAIGHT,
        "bent_sides": error.closed,
        "transition": error.peak,
        "transition_x_deg": math.degrees(turn),
        "transition_y_deg": math.degrees(answer),
        "transition_deg": math.degrees(error.strength),
    }
