"""Smooth a whole clip offline with a discrete smoothing spline instead of a tracker.

Each curve y(t) over n frames is replaced by the x(t) that minimises

    Σ |x(t) − y(t)|² + λ Σ |x(t−1) − 2x(t) + x(t+1)|²,   λ = (2 sin πfΔt)⁻⁴   [Whittaker 1923]

so that a sine of f Hz, the cut-off, keeps half of its amplitude and slower ones keep more, all
without a shift in time. The gain is 1/(1 + λ (2 sin πf'Δt)⁴), as with a second-order Butterworth
filter run in both directions, but the ends need no invented frames. A straight line is unchanged,
to 1e-6 of its size at the lowest allowed cut-off, a thousandth of the frame rate.

Rotations are smoothed in the four components of their quaternions, each in the hemisphere of the
previous one, and scaled to unit length again. This method commutes with any fixed rotation from the
left or the right, has no wrap, and leaves a steady turn about one axis unchanged except near the
ends.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded

from twistcore.errors import TwistError
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array, continuous_signs, normalise

# Hz at 25 Hz; chosen on the training subjects by `python -m benchmarks.quamo_tune_rivals FOLDER`.
CUTOFF = 4.0
PLACE_SHARE = 0.75  # cut-off for the root's position relative to the cut-off for rotations: 3 Hz
_HIGHEST_USUAL = 0.4  # usual cut-off times frame time
_LOWEST = 1e-3  # cut-off times frame time
_SECOND = np.array([1.0, -2.0, 1.0])  # the second difference


def usual_cutoff(dt: float) -> float:
    """Return the default cut-off for a frame time: 4 Hz at 25 fps, 5 at 60, and 5.9 at 120.

    The noise in a frame is assumed to be the same at any rate. With more frames per second, each
    frame's noise then matters less, in proportion to Δt. The best weight of the spline's roughness,
    f⁻⁴, should therefore be proportional to Δt as well. Below 7.4 fps the cut-off is 0.4 of the
    frame rate, which is always allowed.
    """
    return float(min(CUTOFF * (NETWORK_DT / dt) ** 0.25, _HIGHEST_USUAL / dt))


def check_cutoff(cutoff: float, dt: float) -> None:
    """Raise TwistError if the cut-off (Hz) does not fit the frame time.

    The cut-off must be less than half of the frame rate and, because of rounding, at least a
    thousandth of it.
    """
    if not (np.isfinite(cutoff) and _LOWEST <= cutoff * dt < 0.5):
        raise TwistError(
            "expected a cut-off of at least "
            f"{_LOWEST / dt:.4g} Hz (a thousandth of the frame rate) and below "
            f"{0.5 / dt:.4g} Hz (half of it), found {cutoff:g}"
        )


def smoothed(values: Array, cutoff: float, dt: float, span: tuple[int, int] | None = None) -> Array:
    """Return the smoothing spline of values over time, (frames, …), with frame time dt in seconds.

    `span` are the frames [start, stop) to smooth, by default all. The frames around it do not
    change, and the spline continues their values and speeds. A span in fewer than three frames is
    returned unchanged. Raises TwistError if the cut-off (Hz) does not fit the frame time.
    """
    start, stop = span or (0, len(values))
    low, high = max(start - 2, 0), min(stop + 2, len(values))
    out = values.copy()
    if high - low < 3:
        return out
    check_cutoff(cutoff, dt)
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


def smoothed_rotations(
    q: Array, cutoff: float, dt: float, span: tuple[int, int] | None = None
) -> Array:
    """Return smoothed rotations (frames, …, 4); the signs of the quaternions do not matter.

    Rotations outside the span [start, stop), if one is given, do not change.
    """
    if span is None:
        return normalise(smoothed(continuous_signs(q), cutoff, dt))
    out = q.copy()
    out[slice(*span)] = normalise(smoothed(continuous_signs(q), cutoff, dt, span)[slice(*span)])
    return out
