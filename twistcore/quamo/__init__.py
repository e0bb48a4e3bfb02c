"""QuaMo: tracking and smoothing of noisy motion [Le26], also of poses on SMPL's skeleton.

The tracker runs causally, on a stream (`Tracker`) or on a clip (`track`), or without lag over a
whole clip (`track_both_ways`).
"""

from twistcore.quamo.both_ways import track_both_ways
from twistcore.quamo.stability import UnstableGainsError, check_stability
from twistcore.quamo.state_space import Gains
from twistcore.quamo.stream import Tracker
from twistcore.quamo.tracker import HandGains, Stepper, track

__all__ = [
    "Gains",
    "HandGains",
    "Stepper",
    "Tracker",
    "UnstableGainsError",
    "check_stability",
    "track",
    "track_both_ways",
]
