"""Methods to compare with the tracker: causal filters, smoothers of whole clips, and an offset.

Each rival has separate settings for rotations and for the root's position. They were chosen from a
grid on subjects that are not used for any table, among settings whose MPJPE (GRE for the root) is
no larger than our tracker's. `python -m benchmarks.quamo_tune_rivals FOLDER` repeats this choice
and documents the rule.

Linear filters are applied to the four components of the quaternions, each quaternion in the
hemisphere of the previous one. The results are scaled to unit length. Unlike angles, components do
not wrap around and have no preferred direction of rotation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, savgol_filter, sosfilt, sosfilt_zi, sosfiltfilt

from twistcore.quamo.spline import CUTOFF, PLACE_SHARE, smoothed_by_spline
from twistcore.quamo.state_space import align_hemisphere
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    continuous_quaternion_signs,
    exponential,
    logarithm,
    multiply,
    normalise,
)

Setting = tuple[float, ...]
# A function of values (frames, …), the frame time in seconds, and settings.
Smooth = Callable[[Array, float, Setting], Array]


@dataclass(frozen=True)
class Rival:
    """A filter to compare with the tracker.

    Attributes
    ----------
    name
        Name in tables.
    causal
        True if the filter uses only past and current frames.
    rotations, places
        The functions for rotations and for the root's position.
    turning, moving
        The settings of these functions.
    """

    name: str
    causal: bool
    rotations: Smooth
    places: Smooth
    turning: Setting
    moving: Setting

    def run(self, q_hat: Array, r_hat: Array, dt: float) -> tuple[Array, Array]:
        """Filter rotations (frames, …, joints, 4) and root positions (frames, …, 3)."""
        return self.rotations(q_hat, dt, self.turning), self.places(r_hat, dt, self.moving)


def one_euro_rotations(q_hat: Array, dt: float, setting: Setting) -> Array:
    """Filter rotations along the geodesic with the One-Euro filter [Casiez12].

    `setting` contains the lowest cut-off frequency in Hz, its increase in Hz per rad/s, and the
    cut-off frequency for the speed in Hz.
    """
    lowest, slope, cutoff = setting
    q = q_hat.copy()
    turning = np.zeros((*q_hat.shape[1:-1], 3))
    for t in range(1, len(q)):
        reference = align_hemisphere(q_hat[t], q_hat[t - 1])
        rate = logarithm(multiply(reference, conjugate(q_hat[t - 1]))) / dt
        turning = turning + _share(cutoff, dt) * (rate - turning)
        a = _share(lowest + slope * np.linalg.norm(turning, axis=-1), dt)
        step = logarithm(multiply(q_hat[t], conjugate(q[t - 1])))
        q[t] = multiply(exponential(a[..., None] * step), q[t - 1])
    return q


def one_euro_positions(r_hat: Array, dt: float, setting: Setting) -> Array:
    """Filter positions with the One-Euro filter [Casiez12].

    `setting` is the same as in :func:`one_euro_rotations`, but with the increase in Hz per m/s.
    """
    lowest, slope, cutoff = setting
    r = r_hat.copy()
    moving = np.zeros(r_hat.shape[1:])
    for t in range(1, len(r)):
        moving = moving + _share(cutoff, dt) * ((r_hat[t] - r_hat[t - 1]) / dt - moving)
        a = _share(lowest + slope * np.linalg.norm(moving, axis=-1), dt)
        r[t] = r[t - 1] + a[..., None] * (r_hat[t] - r[t - 1])
    return r


def butterworth(x: Array, dt: float, setting: Setting) -> Array:
    """Filter causally with a Butterworth low-pass filter that starts in its steady state.

    `setting` contains the order and the cut-off frequency in Hz.
    """
    order, cutoff = setting
    sos = butter(int(order), cutoff, fs=1.0 / dt, output="sos")
    state = np.multiply.outer(sosfilt_zi(sos), x[0])
    smooth: Array = sosfilt(sos, x, axis=0, zi=state)[0]
    return smooth


def zero_phase_butterworth_filter(x: Array, dt: float, setting: Setting) -> Array:
    """Filter forward and backward with a Butterworth low-pass filter, without delay.

    `setting` contains the order and the cut-off frequency in Hz.
    """
    order, cutoff = setting
    sos = butter(int(order), cutoff, fs=1.0 / dt, output="sos")
    ends = min(len(x) - 1, int(3.0 / (cutoff * dt)))
    smooth: Array = sosfiltfilt(sos, x, axis=0, padlen=ends)
    return smooth


def savitzky_golay(x: Array, dt: float, setting: Setting) -> Array:
    """Fit a polynomial around each frame and return its value in that frame.

    `setting` contains the window length in frames and the degree of the polynomial.
    """
    del dt
    frames, degree = (int(v) for v in setting)
    frames = min(frames, len(x) - (len(x) + 1) % 2)
    smooth: Array = savgol_filter(x, frames, min(degree, frames - 1), axis=0)
    return smooth


def spline_filter(x: Array, dt: float, setting: Setting) -> Array:
    """Smooth like `quamo refine --method spline`. `setting` is the cut-off frequency in Hz."""
    return smoothed_by_spline(x, setting[0], dt)


def quaternion_filter_from_array_filter(filtered: Smooth) -> Smooth:
    """Return a filter for rotations that applies `filtered` to the quaternion components."""

    def rotations(q_hat: Array, dt: float, setting: Setting) -> Array:
        return normalise(filtered(continuous_quaternion_signs(q_hat), dt, setting))

    return rotations


# These settings were printed by benchmarks.quamo_tune_rivals.
RIVALS = (
    Rival(
        "One-Euro", True, one_euro_rotations, one_euro_positions, (2.5, 3.0, 4.0), (5.0, 2.0, 1.0)
    ),
    Rival(
        "Butterworth",
        True,
        quaternion_filter_from_array_filter(butterworth),
        butterworth,
        (1.0, 7.0),
        (1.0, 6.0),
    ),
    Rival(
        "Butterworth, file",
        False,
        quaternion_filter_from_array_filter(zero_phase_butterworth_filter),
        zero_phase_butterworth_filter,
        (2.0, 4.5),
        (2.0, 3.0),
    ),
    Rival(
        "Savitzky-Golay, file",
        False,
        quaternion_filter_from_array_filter(savitzky_golay),
        savitzky_golay,
        (13.0, 5.0),
        (17.0, 4.0),
    ),
    Rival(
        "spline, file",
        False,
        quaternion_filter_from_array_filter(spline_filter),
        spline_filter,
        (CUTOFF,),
        (PLACE_SHARE * CUTOFF,),
    ),
)


def mean_rotation_offset(pairs: Iterable[tuple[Array, Array]]) -> Array:
    """Return the mean rotation vector from the input to the truth for each joint, (joints, 3).

    `pairs` contains the noisy and the true rotations (q̂, q) of each training clip. The result
    shows a systematic error that all clips share.
    """
    each = [logarithm(multiply(q, conjugate(q_hat))) for q_hat, q in pairs]
    mean: Array = np.concatenate(each).mean(axis=0)
    return mean


def rotate_joints_by_fitted_offsets(q_hat: Array, offset: Array) -> Array:
    """Rotate each joint of the input by a constant rotation that was fitted on training clips."""
    return multiply(exponential(offset), q_hat)


def _share(cutoff: Array | float, dt: float) -> Array:
    tau = 2.0 * np.pi * np.asarray(cutoff) * dt
    return tau / (1.0 + tau)
