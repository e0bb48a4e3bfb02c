"""Measure the cost of a method on a clean clip: lag and loss of peak speed [Choi26 §4.2.3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.skeleton.rotation import Array, geodesic_angle
from twistcore.study.benchmark.clip_scene import CleanScene
from twistcore.study.evaluation import joints_with_possible_errors

LONGEST_LAG = 0.25  # longest lag that is searched for, seconds
# Seconds; a peak is a mean over this time, so that noise in single frames matters less.
LASTING = 0.05
_MICRO = 1e-6


@dataclass(frozen=True)
class Fidelity:
    """The lag and the loss of peak speed due to a method, as integers that are stored exactly.

    Attributes
    ----------
    peak
        Peak angular speed before filtering, m°/s.
    kept
        Fraction of the peak that remains after filtering, millionths.
    lag
        Lag, µs.
    lag_frames
        Lag, millionths of a frame.
    """

    peak: int
    kept: int
    lag: int
    lag_frames: int


def measure_fidelity(scene: CleanScene, refined: Array) -> Fidelity | None:
    """Compare the angular speeds of the chains' joints before and after filtering.

    The peak is the highest mean speed of the fastest joint over 50 ms. It is compared with the same
    joint's peak after filtering. The lag is the time shift with the highest cross-correlation of
    the speeds after subtracting their means, summed over all joints and interpolated by a parabola.
    Joints of chains with natural events are ignored, so that the peak is not an error.

    Parameters
    ----------
    scene
        The clean motion.
    refined
        The filtered rotations, shape (frames, joints, 4).

    Returns
    -------
    Fidelity or None
        Lag and loss of peak speed, or None if no joint remains, nothing moves or the clip is very
        short.
    """
    eventful = joints_with_possible_errors([c for c in scene.chains if c.name in scene.eventful])
    joints = np.setdiff1d(scene.joints, eventful)
    motion = scene.motion
    if not joints.size or motion.frames < 8:
        return None
    # Angular speeds, radians per frame, shape (frames − 1, joints).
    before, after = (
        geodesic_angle(q[:-1, joints], q[1:, joints]) for q in (motion.rotations, refined)
    )
    window = max(1, min(round(LASTING * motion.fps), len(before)))
    peaks = _lasting(before, window).max(axis=0)
    joint = int(peaks.argmax())
    peak = float(peaks[joint])
    if peak <= 0.0:
        return None
    lag = _lag(before, after, max(1, round(LONGEST_LAG * motion.fps)))
    return Fidelity(
        peak=round(float(np.degrees(peak)) * motion.fps * 1e3),
        kept=round(float(_lasting(after[:, [joint]], window).max()) / peak / _MICRO),
        lag=round(lag * motion.frame_time / _MICRO),
        lag_frames=round(lag / _MICRO),
    )


def _lasting(speed: Array, window: int) -> Array:
    """Return the mean speed in each window of frames, (frames − window + 1, joints)."""
    mean: Array = np.lib.stride_tricks.sliding_window_view(speed, window, axis=0).mean(axis=-1)
    return mean


def _lag(before: Array, after: Array, longest: int) -> float:
    """Return the lag of `after` behind `before` in frames, which is at most `longest`."""
    a, b = before - before.mean(axis=0), after - after.mean(axis=0)
    longest = min(longest, len(a) // 2)
    shifts = range(-longest, longest + 1)
    score = np.array(
        [
            np.einsum(
                "tj,tj->", a[max(0, -s) : len(a) - max(0, s)], b[max(0, s) : len(b) + min(0, s)]
            )
            for s in shifts
        ]
    )
    best = int(score.argmax())
    if (a == b).all() or not 0 < best < len(score) - 1:
        return float(shifts[best])
    left, top, right = score[best - 1 : best + 2]
    bend = left - 2.0 * top + right
    return float(shifts[best] + (0.5 * (left - right) / bend if bend < 0.0 else 0.0))
