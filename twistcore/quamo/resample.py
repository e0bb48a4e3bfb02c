"""Resample a clip to 25 Hz, and apply the correction made at 25 Hz to the original clip."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array, conjugate, multiply, slerp


def sample_times(frames: int, dt: float) -> Array:
    """Return the times of a clip's 25 Hz samples, usually in fractional frames, (samples,)."""
    count = int(np.floor((frames - 1) * dt / NETWORK_DT + 1e-9)) + 1
    times: Array = np.minimum(np.arange(count) * (NETWORK_DT / dt), float(frames - 1))
    return times


def resampled(q: Array, r: Array, times: Array) -> tuple[Array, Array]:
    """Interpolate rotations (frames, joints, 4) by slerp and positions (frames, 3) linearly.

    `times` are the times of the samples, in frames. A sample depends only on frames up to the first
    frame at or after it.
    """
    before, after, share = _neighbours(times, len(q))
    turned = slerp(q[before], q[after], np.broadcast_to(share[:, None], q[before].shape[:-1]))
    return turned, r[before] + share[:, None] * (r[after] - r[before])


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


def _neighbours(times: Array, frames: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    before = np.floor(times + 1e-9).astype(np.intp)
    share = np.clip(times - before, 0.0, 1.0)
    after = np.minimum(before + (share > 1e-9), frames - 1)
    return before, after, np.where(share > 1e-9, share, 0.0)
