"""Interpolate rotations and positions between frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array, slerp


def interpolate_poses_at_times(q: Array, r: Array, times: Array) -> tuple[Array, Array]:
    """Interpolate rotations by slerp and positions linearly at the given times.

    Parameters
    ----------
    q
        Rotations, shape (frames, joints, 4).
    r
        Positions, shape (frames, …, 3).
    times
        Times of the samples, in frames. Each sample uses only the frames directly before and after
        its time.

    Returns
    -------
    tuple of ndarray
        Rotations and positions, with one entry per sample along the first axis.
    """
    before, after, share = frames_at_times(times, len(q))
    turned = slerp(q[before], q[after], np.broadcast_to(share[:, None], q[before].shape[:-1]))
    weight = share.reshape(-1, *[1] * (r.ndim - 1))
    return turned, r[before] + weight * (r[after] - r[before])


def frames_at_times(times: Array, frames: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Return the frames before and after each time, and the fraction between them, 0…1.

    `times` are in frames, and `frames` is the number of frames.
    """
    before = np.floor(times + 1e-9).astype(np.intp)
    share = np.clip(times - before, 0.0, 1.0)
    after = np.minimum(before + (share > 1e-9), frames - 1)
    return before, after, np.where(share > 1e-9, share, 0.0)
