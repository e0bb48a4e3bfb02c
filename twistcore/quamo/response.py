"""Compute the lag and the overshoot of causal tracking with hand-tuned gains."""

from __future__ import annotations

import numpy as np

from twistcore.quamo.state_space import Gains
from twistcore.quamo.tracker import HandGains, track
from twistcore.skeleton.rotation import quaternion_from_axis_angle

_STEP = np.radians(30.0)  # small enough for a linear response, and realistic for a joint
_FRAMES = 200  # length of the simulated step response


def steady_tracking_lags(gains: Gains, dt: float) -> tuple[float, float]:
    """Return the lags of a joint and of the root's position behind steady motion, in seconds.

    A joint lags by 2κD/κP − Δt, since the error of a rotation by θ is sin(θ/2), and the root's
    position lags by κD/κP − Δt. If the gains of joints differ, the largest lag is returned. The lag
    is infinite if κP is 0. `dt` is the frame time Δt in seconds.
    """
    with np.errstate(divide="ignore"):
        joint = 2.0 * np.divide(gains.kd, gains.kp) - dt
        place = np.divide(gains.root_kd, gains.root_kp) - dt
    return float(np.max(joint)), float(np.max(place))


def tracking_overshoots(gains: Gains, dt: float) -> tuple[float, float]:
    """Return the overshoots of a joint and of the root's position after a step, as fractions.

    The step of the joint is 30°. The gains must be numbers, the same for every joint. `dt` is the
    frame time in seconds. Raises UnstableGainsError if the gains diverge.
    """
    angle = np.where(np.arange(_FRAMES) > 0, _STEP, 0.0)
    q = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), angle)[:, None]
    r = (angle / _STEP)[:, None] * np.array([1.0, 0.0, 0.0])
    found = track(q, r, dt, HandGains(gains))
    turned = 2.0 * np.arctan2(found.q[:, 0, 1], found.q[:, 0, 0])
    return max(float(turned.max() / _STEP) - 1.0, 0.0), max(float(found.r.max()) - 1.0, 0.0)


def describe_tracker_lag_and_overshoot(name: str, late: float, over: float) -> str:
    """Describe the lag and the overshoot of a causal pass in words.

    `name` is the name of the tracked quantity, `late` is its lag in seconds, and `over` is its
    overshoot as a fraction. At very low frame rates, the lag is negative.
    """
    if not np.isfinite(late):
        return f"{name} does not follow the input, because κP is 0"
    ms = round(1000.0 * abs(late))
    way = f"lags {ms} ms" if late > 0.0 or ms == 0 else f"runs {ms} ms ahead"
    return f"{name} {way} and overshoots a step by {100.0 * over:.0f} %"
