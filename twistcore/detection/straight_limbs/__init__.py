"""Find counter-twists of straight limbs, which joint positions do not reveal."""

from __future__ import annotations

from twistcore.detection.straight_limbs.straight_claims import (
    Jumps,
    straight_limb,
    without_errors,
)
from twistcore.detection.straight_limbs.straight_intervals import STRAIGHT, interval_of
from twistcore.detection.straight_limbs.straight_spells import StraightError

__all__ = ["STRAIGHT", "Jumps", "StraightError", "interval_of", "straight_limb", "without_errors"]
