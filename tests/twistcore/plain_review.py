"""A review of five intervals made here: no clip is read."""

from dataclasses import replace

import numpy as np

from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.review import Decision, Review, start_review

ARM, LEG = "Arm", "Leg"
JUMP = Kind.LONE_JUMP


def made(chain, start, stop, degrees=10.0, **more):
    return replace(new_constant_offset_interval(chain, start, stop, np.radians(degrees)), **more)


FOUND = (
    made(LEG, 5, 9, confidence=0.9),
    made(ARM, 50, 60, confidence=0.3),
    made(ARM, 10, 20, confidence=0.5),
    made(ARM, 30, 31, kind=JUMP, residual=1.0, confidence=0.9),
    made(LEG, 40, 44, confidence=0.8, open=True),
)


def review():
    """Ids by chain order and start: Arm 3, 4, 2, Leg 1, 5."""
    return Review(start_review("own", {ARM: 0.1, LEG: 0.2}, FOUND, (ARM, LEG)))


def decided(state):
    return {j.id: j.decision.value for j in state.intervals if j.decision != Decision.UNDECIDED}
