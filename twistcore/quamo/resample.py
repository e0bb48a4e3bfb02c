"""Apply a correction that was computed at 25 Hz to a clip with a different frame rate."""

from __future__ import annotations

import numpy as np

from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.resampling import interpolate_poses_at_times
from twistcore.skeleton.rotation import Array, conjugate, multiply

__all__ = ["apply_sample_corrections", "interpolate_poses_at_times", "network_sample_times"]


def network_sample_times(frames: int, dt: float) -> Array:
    """Return the times of the 25 Hz samples of a clip, in fractional frames, shape (samples,).

    `frames` is the number of frames of the clip, and `dt` is its frame time in seconds.
    """
    count = int(np.floor((frames - 1) * dt / NETWORK_DT + 1e-9)) + 1
    times: Array = np.minimum(np.arange(count) * (NETWORK_DT / dt), float(frames - 1))
    return times


def apply_sample_corrections(
    q: Array, r: Array, times: Array, q_in: Array, r_in: Array, q_out: Array, r_out: Array
) -> tuple[Array, Array]:
    """Apply the corrections of 25 Hz samples, q_out ⊗ q_in* and r_out − r_in, to a clip.

    The corrections are interpolated between samples, so a frame must wait for the next sample. They
    are constant after the last sample. Motion faster than 12.5 Hz does not change.

    Parameters
    ----------
    q, r
        The rotations and positions of the clip, shape (frames, …, 4) and (frames, 3).
    times
        The times of the samples, from :func:`network_sample_times`.
    q_in, r_in
        The samples before the correction.
    q_out, r_out
        The samples after the correction.

    Returns
    -------
    q, r : ndarray
        The corrected rotations and positions of the clip.
    """
    turn, shift = multiply(q_out, conjugate(q_in)), r_out - r_in
    step = times[1] - times[0] if len(times) > 1 else 1.0
    at = np.minimum(np.arange(len(q)) / step, float(len(times) - 1))
    turn, shift = interpolate_poses_at_times(turn, shift, at)
    return multiply(turn, q), r + shift
