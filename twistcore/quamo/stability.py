"""Check that tracking with given gains does not diverge."""

from __future__ import annotations

import numpy as np

from twistcore.errors import TwistError
from twistcore.quamo.state_space import Gains
from twistcore.skeleton.rotation import Array


class UnstableGainsError(TwistError):
    """Raised for gains with which the tracker would diverge at the given frame time."""


def check_stability(gains: Gains, dt: float) -> None:
    """Raise UnstableGainsError unless 0 < κDΔt < 2 and 0 ≤ cΔt² < 4 − 2κDΔt.

    These bounds follow from Jury's stability criterion for the discrete step, linearised about the
    reference. The stiffness c is κP/2 for rotations, whose error is sin(θ/2), and κP for the root's
    position. The frame time Δt, `dt` in seconds, must be above 0, and all gains must be finite.
    """
    if not (np.isfinite(dt) and dt > 0.0):
        raise UnstableGainsError(f"expected a frame time above 0 seconds, found {dt:g}")
    if not (np.isfinite(gains.clip) and gains.clip > 0.0):
        raise UnstableGainsError(f"expected a bound of ω above 0 rad/s, found {gains.clip:g}")
    _check("rotation", np.asarray(gains.kp) / 2.0, "κP/2", np.asarray(gains.kd), dt)
    _check("translation", np.asarray(gains.root_kp), "κP", np.asarray(gains.root_kd), dt)
    for name, value in (("κA", gains.ka), ("bias", gains.bias), ("root bias", gains.root_bias)):
        if not np.isfinite(value).all():
            raise UnstableGainsError(f"{name}: expected a finite number")


def _check(what: str, stiffness: Array, symbol: str, damping: Array, dt: float) -> None:
    stiffness, damping = np.broadcast_arrays(stiffness, damping)
    d, s = damping * dt, stiffness * dt * dt
    with np.errstate(invalid="ignore"):
        if not ((d > 0.0) & (d < 2.0)).all():
            worst = float(d.flat[int(np.argmax(np.abs(d - 1.0)))])
            raise UnstableGainsError(
                f"{what} gains are unstable at {1.0 / dt:g} Hz: expected 0 < κD·Δt < 2, "
                f"found {worst:g}"
            )
        if not ((s >= 0.0) & (s < 4.0 - 2.0 * d)).all():
            k = int(np.argmax(s - (4.0 - 2.0 * d)))
            raise UnstableGainsError(
                f"{what} gains are unstable at {1.0 / dt:g} Hz: expected {symbol}·Δt² < "
                f"4 − 2κD·Δt = {4.0 - 2.0 * float(d.flat[k]):g}, found {float(s.flat[k]):g}"
            )
