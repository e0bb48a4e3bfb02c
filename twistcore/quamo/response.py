"""Lag and overshoot of causal tracking with hand-tuned gains."""

from __future__ import annotations

import numpy as np

from twistcore.quamo.state_space import Gains
from twistcore.quamo.tracker import HandGains, track
from twistcore.skeleton.rotation import quaternion_from_axis_angle

_STEP = np.radians(30.0)  # small enough for a linear response, and a realistic step of a joint
_FRAMES = 200


def steady_lags(gains: Gains, dt: float) -> tuple[float, float]:
    """Return the lags in seconds of a joint and of the root's position behind a steady motion.

    A joint lags by 2κD/κP − Δt, since the error of a rotation is sin(θ/2), and the root's position
    by κD/κP − Δt. If gains differ, the largest lag is returned. The lag is infinite if κP is 0.
    """
    with np.errstate(divide="ignore"):
        joint = 2.0 * np.divide(gains.kd, gains.kp) - dt
        place = np.divide(gains.root_kd, gains.root_kp) - dt
    return float(np.max(joint)), float(np.max(place))


def overshoots(gains: Gains, dt: float) -> tuple[float, float]:
    """Return the overshoots of a joint and of the root at a step in a causal pass, as fractions.

    The joint makes a step of 30°. Gains must be numbers that are the same for every joint. Raises
    UnstableGainsError if they diverge.
    """
    angle = np.where(np.arange(_FRAMES) > 0, _STEP, 0.0)
    q = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), angle)[:, None]
    r = (angle / _STEP)[:, None] * np.array([1.0, 0.0, 0.0])
    found = track(q, r, dt, HandGains(gains))
    turned = 2.0 * np.arctan2(found.q[:, 0, 1], found.q[:, 0, 0])
    return max(float(turned.max() / _STEP) - 1.0, 0.0), max(float(found.r.max()) - 1.0, 0.0)


def response_words(name: str, late: float, over: float) -> str:
    """Describe the lag and overshoot of `name` in a causal pass.

    `late` is the lag in seconds, and `over` is the overshoot. A pass at a few frames per second
    runs ahead of a steady motion. With κP = 0, it does not follow.
    """
    if not np.isfinite(late):
        return f"{name} does not follow, because κP is 0"
    ms = round(1000.0 * abs(late))
    way = f"lags {ms} ms" if late > 0.0 or ms == 0 else f"runs {ms} ms ahead"
    return f"{name} {way} and overshoots a step by {100.0 * over:.0f} %"
