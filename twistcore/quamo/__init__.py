"""QuaMo: causal quaternion tracking of noisy motion [Le26], after the twist review, on request."""

from twistcore.quamo.stability import UnstableGainsError, check_stability
from twistcore.quamo.state_space import Gains, Parts
from twistcore.quamo.tracker import (
    Controller,
    HandGains,
    State,
    Step,
    Track,
    Tracker,
    snap_sentences,
    track,
)

__all__ = [
    "Controller",
    "Gains",
    "HandGains",
    "Parts",
    "State",
    "Step",
    "Track",
    "Tracker",
    "UnstableGainsError",
    "check_stability",
    "snap_sentences",
    "track",
]
