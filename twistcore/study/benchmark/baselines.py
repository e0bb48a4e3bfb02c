"""Common alternatives to the detectors: filters, projection and interpolation [Choi26 §2].

For the joints of the chains, these methods make the signs of the quaternions continuous, filter
their components, and renormalise them. They do not use the joint hierarchy, so they cannot
distinguish a twist error from motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import interpolate, signal

from twistcore.skeleton.rotation import (
    Array,
    continuous_quaternion_signs,
    slerp,
)

CUTOFF = 6.0  # Hz; the usual choice for gait
SAVGOL_SECONDS, SAVGOL_DEGREE = 0.1, 3
# The acceleration of quaternion components, which are half angles, per s².
KALMAN_ACCELERATION = np.radians(2000.0) / 2.0
KALMAN_NOISE = np.radians(1.0) / 2.0
PCA_VARIANCE = 0.99

Gap = tuple[int, int]
Correct = Callable[[Array, float, Sequence[Gap]], Array]


@dataclass(frozen=True)
class Baseline:
    """A method in the benchmark that is not a detector.

    Attributes
    ----------
    name
        The method's name in commands.
    label
        The method's name in tables.
    why
        A one-line description of the method.
    correct
        A function that takes quaternions with continuous signs, (frames, joints, 4), the frame rate
        and the frame ranges with errors. It returns corrected quaternions of the same shape.
    oracle
        True if the method is given the true error intervals and changes only the joints with
        errors.
    whole_body
        True if the result for a joint depends on other joints.
    """

    name: str
    label: str
    why: str
    correct: Correct
    oracle: bool = False
    whole_body: bool = False


def _butterworth_causal(q: Array, fps: float, _gaps: Sequence[Gap]) -> Array:
    sections = signal.butter(4, _cutoff(fps), fs=fps, output="sos")
    settled = signal.sosfilt_zi(sections)[:, :, None, None] * q[0]
    smooth: Array = signal.sosfilt(sections, q, axis=0, zi=settled)[0]
    return smooth


def _butterworth_zero_phase(q: Array, fps: float, _gaps: Sequence[Gap]) -> Array:
    sections = signal.butter(2, _cutoff(fps), fs=fps, output="sos")
    return signal.sosfiltfilt(sections, q, axis=0, padlen=min(9, len(q) - 1))


def _cutoff(fps: float) -> float:
    return min(CUTOFF, 0.45 * fps)


def _savgol(q: Array, fps: float, _gaps: Sequence[Gap]) -> Array:
    window = max(2 * round(SAVGOL_SECONDS * fps / 2.0) + 1, SAVGOL_DEGREE + 2)
    if window > len(q):
        return q
    return signal.savgol_filter(q, window, SAVGOL_DEGREE, axis=0)


def _kalman(q: Array, fps: float, _gaps: Sequence[Gap]) -> Array:
    """Apply a steady-state constant-velocity Kalman filter (α-β filter)."""
    index = KALMAN_ACCELERATION / (fps * fps * KALMAN_NOISE)
    r = (4.0 + index - np.sqrt(8.0 * index + index * index)) / 4.0
    alpha = 1.0 - r * r
    beta = 2.0 * (2.0 - alpha) - 4.0 * np.sqrt(1.0 - alpha)
    b, a = [alpha, beta - alpha, 0.0], [1.0, alpha + beta - 2.0, 1.0 - alpha]
    settled = signal.lfilter_zi(b, a)[:, None, None] * q[0]
    smooth: Array = signal.lfilter(b, a, q, axis=0, zi=settled)[0]
    return smooth


def _pca(q: Array, _fps: float, _gaps: Sequence[Gap]) -> Array:
    flat = q.reshape(len(q), -1)
    mean = flat.mean(axis=0)
    values, vectors = np.linalg.eigh(np.cov(flat - mean, rowvar=False))
    held = np.cumsum(values[::-1]) / max(values.sum(), 1e-300)
    basis = vectors[:, ::-1][:, : int(np.searchsorted(held, PCA_VARIANCE)) + 1]
    projected: Array = ((flat - mean) @ basis @ basis.T + mean).reshape(q.shape)
    return projected


def _pchip(q: Array, _fps: float, gaps: Sequence[Gap]) -> Array:
    good = _outside(len(q), gaps)
    if len(good) < 2 or len(good) == len(q):
        return q
    at = np.setdiff1d(np.arange(len(q)), good)
    known = continuous_quaternion_signs(q[good])
    out = q.copy()
    inside = np.clip(at, good[0], good[-1])  # gaps at the clip's ends have the nearest good pose
    out[at] = interpolate.PchipInterpolator(good, known, axis=0)(inside)
    return out


def _slerp(q: Array, _fps: float, gaps: Sequence[Gap]) -> Array:
    out = q.copy()
    good = _outside(len(q), gaps)
    if not len(good):
        return out
    for start, stop in gaps:
        at = np.arange(start, stop)
        after = np.searchsorted(good, at)
        left, right = good[np.maximum(after - 1, 0)], good[np.minimum(after, len(good) - 1)]
        left, right = np.where(after == 0, right, left), np.where(after == len(good), left, right)
        share = (at - left) / np.maximum(right - left, 1)
        out[at] = slerp(q[left], q[right], share[:, None])
    return out


def _outside(frames: int, gaps: Sequence[Gap]) -> np.typing.NDArray[np.int64]:
    wrong = np.zeros(frames, dtype=bool)
    for start, stop in gaps:
        wrong[start:stop] = True
    return np.flatnonzero(~wrong)


BASELINES: Mapping[str, Baseline] = {
    b.name: b
    for b in (
        Baseline(
            "butterworth-causal",
            "Butterworth, causal",
            "4th order, 6 Hz, one pass, as for a live stream; lags",
            _butterworth_causal,
        ),
        Baseline(
            "butterworth",
            "Butterworth, zero phase",
            "2nd order, 6 Hz, forwards and backwards (4th in all): the standard of gait analysis",
            _butterworth_zero_phase,
        ),
        Baseline(
            "savgol",
            "Savitzky-Golay",
            "cubic over 0.1 s: keeps peaks better than a low pass, removes noise, not level shifts",
            _savgol,
        ),
        Baseline(
            "kalman",
            "Kalman, causal",
            "constant velocity, 1° and 2000°/s², steady state: the dynamic model in [Choi26 §2.3]",
            _kalman,
        ),
        Baseline(
            "pca",
            "PCA projection",
            "components with 99 % of the clip's variance: the subspace idea in [Choi26 §2.2]",
            _pca,
            whole_body=True,
        ),
        Baseline(
            "pchip-oracle",
            "PCHIP (oracle)",
            "knows the true intervals and interpolates joints across them: motion there is lost",
            _pchip,
            oracle=True,
        ),
        Baseline(
            "slerp-oracle",
            "Slerp (oracle)",
            "knows the true intervals and turns evenly from the last good pose to the next",
            _slerp,
            oracle=True,
        ),
        Baseline(
            "unroll",
            "Unroll / Euler filter",
            "writes the same orientation with other angles, so a twist error stays unchanged",
            lambda q, *_: q,
        ),
    )
}
