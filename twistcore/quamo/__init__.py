"""QuaMo: track or smooth noisy motion [Le26], with gains set by hand or by a network.

`Tracker` tracks a stream of poses, and `track` tracks a clip, both causally. `track_both_ways`
tracks a whole clip without lag.
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
