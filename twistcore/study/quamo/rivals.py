"""What a tracker has to beat: the input itself, a constant offset, One-Euro, Butterworth.

All are causal. Their settings are ordinary choices for human motion, made once and not fitted to
anything here.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.signal import butter, sosfilt, sosfilt_zi

from twistcore.quamo.state_space import aligned
from twistcore.rotation import Array, conjugate, exponential, logarithm, multiply, normalise
from twistcore.study.benchmark.baselines import continuous

ONE_EURO = (1.5, 0.5, 1.0)  # lowest cut-off Hz, Hz a rad/s (or m/s), cut-off of the speed Hz
BUTTERWORTH = (2, 4.0)  # order, cut-off Hz


def one_euro(q_hat: Array, r_hat: Array, dt: float) -> tuple[Array, Array]:
    """One-Euro filter [Casiez12] of rotations, along the geodesic, and of places."""
    q, r = q_hat.copy(), r_hat.copy()
    turning = np.zeros((*q_hat.shape[1:-1], 3))
    moving = np.zeros(r_hat.shape[1:])
    lowest, slope, cutoff = ONE_EURO
    a_speed = _share(cutoff, dt)
    for t in range(1, len(q)):
        reference = aligned(q_hat[t], q_hat[t - 1])
        rate = logarithm(multiply(reference, conjugate(q_hat[t - 1]))) / dt
        turning = turning + a_speed * (rate - turning)
        moving = moving + a_speed * ((r_hat[t] - r_hat[t - 1]) / dt - moving)
        a = _share(lowest + slope * np.linalg.norm(turning, axis=-1), dt)
        step = logarithm(multiply(q_hat[t], conjugate(q[t - 1])))
        q[t] = multiply(exponential(a[..., None] * step), q[t - 1])
        a = _share(lowest + slope * np.linalg.norm(moving, axis=-1), dt)
        r[t] = r[t - 1] + a[..., None] * (r_hat[t] - r[t - 1])
    return q, r


def butterworth(q_hat: Array, r_hat: Array, dt: float) -> tuple[Array, Array]:
    """Causal Butterworth low-pass of quaternion components, renormalised, and of places."""
    order, cutoff = BUTTERWORTH
    sos = butter(order, cutoff, fs=1.0 / dt, output="sos")
    start = sosfilt_zi(sos)

    def filtered(x: Array) -> Array:
        state = np.multiply.outer(start, x[0])
        smooth: Array = sosfilt(sos, x, axis=0, zi=state)[0]
        return smooth

    return normalise(filtered(continuous(q_hat))), filtered(r_hat)


def mean_offset(pairs: Iterable[tuple[Array, Array]]) -> Array:
    """Mean rotation vector from the input to the truth of each joint, (joints, 3).

    pairs: (q̂, q) of training clips; what a systematic error common to all clips would show as.
    """
    each = [logarithm(multiply(q, conjugate(q_hat))) for q_hat, q in pairs]
    mean: Array = np.concatenate(each).mean(axis=0)
    return mean


def constant_offset(q_hat: Array, offset: Array) -> Array:
    """The input with a constant rotation taken from training clips put on every joint."""
    return multiply(exponential(offset), q_hat)


def _share(cutoff: Array | float, dt: float) -> Array:
    tau = 2.0 * np.pi * np.asarray(cutoff) * dt
    return tau / (1.0 + tau)
