"""How late hand gains let a causal pass be, and by how much it shoots over: what it does not do."""

from __future__ import annotations

import numpy as np

from twistcore.quamo.state_space import Gains
from twistcore.quamo.tracker import HandGains, track
from twistcore.skeleton.rotation import quaternion_from_axis_angle

_STEP = np.radians(30.0)  # small enough to be linear, and what a joint may well do
_FRAMES = 200


def steady_lags(gains: Gains, dt: float) -> tuple[float, float]:
    """Seconds by which what moves steadily is followed late: (a joint, the root's place).

    2κD/κP − Δt, since the error of a rotation is sin(θ/2), and κD/κP − Δt; the largest of gains
    that differ, infinite where κP is 0.
    """
    with np.errstate(divide="ignore"):
        joint = 2.0 * np.divide(gains.kd, gains.kp) - dt
        place = np.divide(gains.root_kd, gains.root_kp) - dt
    return float(np.max(joint)), float(np.max(place))


def overshoots(gains: Gains, dt: float) -> tuple[float, float]:
    """By how much of a step a causal pass shoots over: (a joint that steps by 30°, the root).

    Gains are numbers, the same for every joint. Raises UnstableGainsError where they diverge.
    """
    angle = np.where(np.arange(_FRAMES) > 0, _STEP, 0.0)
    q = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), angle)[:, None]
    r = (angle / _STEP)[:, None] * np.array([1.0, 0.0, 0.0])
    found = track(q, r, dt, HandGains(gains))
    turned = 2.0 * np.arctan2(found.q[:, 0, 1], found.q[:, 0, 0])
    return max(float(turned.max() / _STEP) - 1.0, 0.0), max(float(found.r.max()) - 1.0, 0.0)


def response_words(name: str, late: float, over: float) -> str:
    """What a causal pass of hand gains does to `name`: its lag in seconds and overshoot, in words.

    At a few frames a second it runs ahead of what moves steadily, where κP is 0 it does not follow.
    """
    if not np.isfinite(late):
        return f"{name} does not follow, because κP is 0"
    ms = round(1000.0 * abs(late))
    way = f"lags {ms} ms" if late > 0.0 or ms == 0 else f"runs {ms} ms ahead"
    return f"{name} {way} and overshoots a step by {100.0 * over:.0f} %"
