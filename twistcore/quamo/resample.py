"""Resample a clip to 25 Hz, and apply the correction made at 25 Hz to the original clip."""

from __future__ import annotations

import numpy as np

from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.resampling import resampled
from twistcore.skeleton.rotation import Array, conjugate, multiply

__all__ = ["corrected", "resampled", "sample_times"]


def sample_times(frames: int, dt: float) -> Array:
    """Return the times of a clip's 25 Hz samples, usually in fractional frames, (samples,)."""
    count = int(np.floor((frames - 1) * dt / NETWORK_DT + 1e-9)) + 1
    times: Array = np.minimum(np.arange(count) * (NETWORK_DT / dt), float(frames - 1))
    return times


def corrected(
    q: Array, r: Array, times: Array, q_in: Array, r_in: Array, q_out: Array, r_out: Array
) -> tuple[Array, Array]:
    """Apply the samples' corrections q_out ⊗ q_in* and r_out − r_in to the clip.

    The correction is interpolated between samples, so a frame must wait for the next sample; after
    the last sample the correction stays constant. Motion faster than 12.5 Hz stays in the clip.
    """
    turn, shift = multiply(q_out, conjugate(q_in)), r_out - r_in
    step = times[1] - times[0] if len(times) > 1 else 1.0
    at = np.minimum(np.arange(len(q)) / step, float(len(times) - 1))
    turn, shift = resampled(turn, shift, at)
    return multiply(turn, q), r + shift
