"""QuaMo: optional tracking of noisy motion with quaternions [Le26], after the review of twist
errors.

The tracker runs causally, frame by frame (`Tracker`, `track`), or without lag over a whole clip
(`track_both_ways`).
"""

from twistcore.quamo.both_ways import track_both_ways
from twistcore.quamo.stability import UnstableGainsError, check_stability
from twistcore.quamo.state_space import Gains
from twistcore.quamo.tracker import HandGains, Tracker, track

__all__ = [
    "Gains",
    "HandGains",
    "Tracker",
    "UnstableGainsError",
    "check_stability",
    "track",
    "track_both_ways",
]
