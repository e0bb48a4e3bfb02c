"""Find counter-twists of straight limbs, which joint positions do not reveal."""

from __future__ import annotations

from twistcore.detection.straight_limbs.straight_claims import (
    Jumps,
    find_straight_limb_errors,
    remove_twist_errors,
)
from twistcore.detection.straight_limbs.straight_intervals import STRAIGHT, straight_limb_interval
from twistcore.detection.straight_limbs.straight_spells import StraightError

__all__ = [
    "STRAIGHT",
    "Jumps",
    "StraightError",
    "find_straight_limb_errors",
    "remove_twist_errors",
    "straight_limb_interval",
]
