"""QuaMo: causal quaternion tracking of noisy motion [Le26], after the twist review, on request."""

from twistcore.quamo.stability import UnstableGainsError, check_stability
from twistcore.quamo.state_space import Gains
from twistcore.quamo.tracker import HandGains, Tracker, track

__all__ = ["Gains", "HandGains", "Tracker", "UnstableGainsError", "check_stability", "track"]
