"""Smooth a whole clip with a discrete smoothing spline, as an alternative to the tracker.

Each curve y(t) is replaced by the curve x(t) that minimises

    Σ |x(t) − y(t)|² + λ Σ |x(t−1) − 2x(t) + x(t+1)|²,   λ = (2 sin πfΔt)⁻⁴   [Whittaker 1923]

A sine with the cut-off frequency f keeps half of its amplitude, and a slower sine keeps more. The
result is not shifted in time. The gain at a frequency f' is 1/(1 + λ (2 sin πf'Δt)⁴), as with a
second-order Butterworth filter that is run in both directions, but the ends of the clip need no
padding. A straight line does not change by more than 1e-6 of its size, even at the lowest allowed
cut-off, a thousandth of the frame rate.

The four components of quaternions are smoothed separately, with each quaternion in the hemisphere
of the previous one, and then scaled to unit length. The result is independent of the coordinate
system, has no discontinuity at ±180°, and leaves a steady rotation about one axis unchanged except
near the ends.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded

from twistcore.errors import TwistError
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array, continuous_quaternion_signs, normalise

# The default cut-off in Hz in a clip with 25 frames per second, chosen on the training subjects by
# `python -m benchmarks.quamo_tune_rivals FOLDER`.
CUTOFF = 4.0
PLACE_SHARE = 0.75  # cut-off for the root's position as a share of the cut-off for rotations
_HIGHEST_USUAL = 0.4  # highest default cut-off, as a share of the frame rate
_LOWEST = 1e-3  # lowest allowed cut-off, as a share of the frame rate
_SECOND = np.array([1.0, -2.0, 1.0])  # the weights of a second difference


def default_spline_cutoff(dt: float) -> float:
    """Return the default cut-off in Hz for a frame time of `dt` seconds.

    It is 4 Hz at 25 frames per second, 5 Hz at 60, and 5.9 Hz at 120. The noise of a frame is
    assumed to be the same at any rate, so with more frames per second, the noise of each frame
    matters less, in proportion to `dt`. The weight of the roughness, about f⁻⁴, is therefore
    proportional to `dt` as well. Below 7.4 frames per second, the cut-off is 0.4 of the frame rate.
    """
    return float(min(CUTOFF * (NETWORK_DT / dt) ** 0.25, _HIGHEST_USUAL / dt))


def check_spline_cutoff(cutoff: float, dt: float) -> None:
    """Raise TwistError if a cut-off in Hz does not fit a frame time of `dt` seconds.

    The cut-off must be below half of the frame rate and, because of rounding, at least a thousandth
    of it.
    """
    if not (np.isfinite(cutoff) and _LOWEST <= cutoff * dt < 0.5):
        raise TwistError(
            "expected a cut-off of at least "
            f"{_LOWEST / dt:.4g} Hz (a thousandth of the frame rate) and below "
            f"{0.5 / dt:.4g} Hz (half of it), found {cutoff:g}"
        )


def smoothed_by_spline(
    values: Array, cutoff: float, dt: float, span: tuple[int, int] | None = None
) -> Array:
    """Smooth values over time with a spline.

    Parameters
    ----------
    values
        The values, shape (frames, …).
    cutoff
        The cut-off in Hz.
    dt
        The frame time in seconds.
    span
        The frames [start, stop) to smooth, by default all. The frames around it do not change, and
        the spline continues their values and speeds.

    Returns
    -------
    ndarray, shape (frames, …)
        The smoothed values. They do not change if there are fewer than three frames.

    Raises
    ------
    TwistError
        If the cut-off does not fit the frame time.
    """
    start, stop = span or (0, len(values))
    low, high = max(start - 2, 0), min(stop + 2, len(values))
    out = values.copy()
    if high - low < 3:
        return out
    check_spline_cutoff(cutoff, dt)
    weight = (2.0 * np.sin(np.pi * cutoff * dt)) ** -4
    frames, free = high - low, slice(start - low, stop - low)
    bands = np.zeros((3, frames))  # bands of the upper triangle, the diagonal last
    for i, here in enumerate(_SECOND):
        for ahead, there in enumerate(_SECOND[i:]):
            bands[2 - ahead, i + ahead : i + ahead + frames - 2] += weight * here * there
    bands[2] += 1.0
    given = values[low:high].reshape(frames, -1)
    fixed = given.copy()
    fixed[free] = 0.0
    bent = np.zeros_like(fixed)  # the gradient of the roughness of the fixed frames
    for i, here in enumerate(_SECOND):
        bent[i : i + frames - 2] += weight * here * np.diff(fixed, n=2, axis=0)
    found = solveh_banded(bands[:, free], given[free] - bent[free])
    out[start:stop] = found.reshape(values[start:stop].shape)
    return out


def rotations_smoothed_by_spline(
    q: Array, cutoff: float, dt: float, span: tuple[int, int] | None = None
) -> Array:
    """Smooth rotations over time with a spline, (frames, …, 4) → (frames, …, 4).

    The signs of the quaternions do not matter. The other parameters and the errors are the same as
    for :func:`smoothed_by_spline`.
    """
    if span is None:
        return normalise(smoothed_by_spline(continuous_quaternion_signs(q), cutoff, dt))
    out = q.copy()
    out[slice(*span)] = normalise(
        smoothed_by_spline(continuous_quaternion_signs(q), cutoff, dt, span)[slice(*span)]
    )
    return out
