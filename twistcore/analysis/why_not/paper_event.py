"""Why the paper's detector has no interval at a frame: any event opens one, so there is none."""

from __future__ import annotations

import math

from twistcore.analysis.why_not.reason import AskedFrame, Reason, Why, signed_degrees
from twistcore.skeleton.signals import TwistSignals


def no_event(place: AskedFrame, signals: TwistSignals) -> Reason:
    """Why m(t) is no event; with its numbers."""
    p, c = float(signals.dtheta_p[place.frame]), float(signals.dtheta_c[place.frame])
    parent, child = place.joints
    numbers = {"dtheta_p_deg": math.degrees(p), "dtheta_c_deg": math.degrees(c)}
    turns = f"{parent} twists {signed_degrees(p)}, the azimuth of {child} {signed_degrees(c)}"
    if place.strength >= place.tau:  # a review with other intervals than the detector's
        return place.reason(Why.NO_PARTNER, f"no interval of it is left: {turns}", **numbers)
    if p * c < 0.0:
        return place.reason(Why.BELOW, turns, **numbers)
    alike = "not against each other"
    return place.reason(Why.BELOW, f"{turns}, {alike}", **numbers)
