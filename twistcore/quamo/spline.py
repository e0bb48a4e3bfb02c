"""A whole clip smoothed by a discrete smoothing spline: what needs no tracker where all is known.

Each number x(t) of n frames, given as y(t), becomes what is least in

    Σ |x(t) − y(t)|² + λ Σ |x(t−1) − 2x(t) + x(t+1)|²,   λ = (2 sin πfΔt)⁻⁴   [Whittaker 1923]

so that a sine of f Hz, the cut-off, keeps half of its size, slower ones more, each without a shift
in time: the gain is 1/(1 + λ (2 sin πf'Δt)⁴), that of a Butterworth filter of second order run in
both directions, but the ends need no made-up frames. A straight line is left as it is, to 1e-6 of
its size at the lowest cut-off that is taken, a thousandth of the frame rate.

Rotations are smoothed in the four components of their quaternions, each on the side of the one
before, and scaled to unit length again. That commutes with any fixed rotation from the left or the
right, has no wrap, and leaves a steady turn about one axis as it is but near the ends.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded

from twistcore.errors import TwistError
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array, continuous, normalise

# Hz at 25 Hz; chosen on the training subjects by `python -m benchmarks.quamo_tune_rivals FOLDER`.
CUTOFF = 4.0
PLACE_SHARE = 0.75  # cut-off of the root's place, of that of rotations: 3 Hz
_HIGHEST_USUAL = 0.4  # usual cut-off times frame time
_LOWEST = 1e-3  # cut-off times frame time
_SECOND = np.array([1.0, -2.0, 1.0])  # the second difference


def usual_cutoff(dt: float) -> float:
    """Cut-off in Hz for a frame time: 4 Hz at 25 Hz, 5 at 60, 5.9 at 120.

    The noise of a frame is taken to be as large at any rate. In a second of more frames it then
    weighs less, in proportion to Δt, and so may f⁻⁴, what the best spline weighs roughness with.
    Below 7.4 Hz it is 0.4 of the frame rate, which a rate can always have.
    """
    return float(min(CUTOFF * (NETWORK_DT / dt) ** 0.25, _HIGHEST_USUAL / dt))


def smoothed(values: Array, cutoff: float, dt: float) -> Array:
    """The smoothing spline of numbers over time, (frames, …), frame time dt in seconds.

    Fewer than three frames stay as they are, whatever the cut-off. TwistError where the cut-off
    (Hz) is below a thousandth of the frame rate, where rounding would bend the result, or not below
    its half.
    """
    frames = len(values)
    if frames < 3:
        return values.copy()
    if not (np.isfinite(cutoff) and _LOWEST <= cutoff * dt < 0.5):
        raise TwistError(
            f"expected a cut-off from {_LOWEST / dt:.4g} Hz, a thousandth of the frame rate, to "
            f"below {0.5 / dt:.4g} Hz, its half, found {cutoff:g}"
        )
    weight = (2.0 * np.sin(np.pi * cutoff * dt)) ** -4
    bands = np.zeros((3, frames))  # of the upper half, the diagonal last
    for i, here in enumerate(_SECOND):
        for ahead, there in enumerate(_SECOND[i:]):
            bands[2 - ahead, i + ahead : i + ahead + frames - 2] += weight * here * there
    bands[2] += 1.0
    found: Array = solveh_banded(bands, values.reshape(frames, -1)).reshape(values.shape)
    return found


def smoothed_rotations(q: Array, cutoff: float, dt: float) -> Array:
    """Rotations (frames, …, 4) smoothed; the sign of a quaternion does not matter."""
    return normalise(smoothed(continuous(q), cutoff, dt))
