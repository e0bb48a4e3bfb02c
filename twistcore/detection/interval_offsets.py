"""Constant offsets, and copies of an interval with other frames or another offset."""

from __future__ import annotations

import numpy as np

from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import Array, wrap


def resized_interval(interval: Interval, start: int, stop: int) -> Interval:
    """Return a copy of the interval with frames [start, stop).

    An added frame has the same offset as the nearest frame of the interval.
    """
    at = np.clip(np.arange(start, stop), interval.start, interval.stop - 1) - interval.start
    return interval.with_offset(start, interval.offset[at])


def same_offsets(one: Interval, other: Interval) -> bool:
    """Return True if two intervals have the same frames and, except for rounding, equal offsets."""
    frames = (one.start, one.stop, one.carried) == (other.start, other.stop, other.carried)
    return frames and np.allclose(one.offset, other.offset, atol=1e-12)


def with_offset_of_size(interval: Interval, delta: float) -> Interval:
    """Return the interval with its offset shifted so that the median is `delta`, in radians.

    If the error begins and ends gradually, its offset is scaled instead, so that the largest offset
    becomes `delta` and the ends remain gradual.
    """
    if interval.soft_ended:
        return interval.with_offset(interval.start, interval.offset * (delta / interval.largest))
    return interval.with_offset(interval.start, wrap(interval.offset + (delta - interval.delta)))


def with_offset_replaced_by_median(interval: Interval) -> Interval:
    """Return the interval with its offset replaced by the median offset in all frames."""
    return interval.with_offset(interval.start, np.full(interval.frames, interval.delta))


def with_offset_making_twist_linear(interval: Interval, theta_p: Array) -> Interval:
    """Return the interval with offsets whose removal makes the parent's twist linear in time.

    The correction then removes all variation of the twist, such as drift or jitter.

    Parameters
    ----------
    interval
        The interval.
    theta_p : array, shape (frames of the clip,)
        The parent's twist θp in radians.
    """
    if interval.frames >= len(theta_p):
        return interval
    return interval.with_offset(
        interval.start, angles_relative_to_adjacent_frames(theta_p, interval.start, interval.stop)
    )


def angles_relative_to_adjacent_frames(theta: Array, start: int, stop: int) -> Array:
    """Return the angles in [start, stop) relative to a line between the frames on either side.

    The line connects the angle in the frame before the span with the angle in the frame after it.
    At the start or end of the clip, where one of these frames is missing, the line is horizontal.
    If the span is the whole clip, the line is horizontal at the angle of the last frame.

    Parameters
    ----------
    theta : array, shape (frames of the clip,)
        Angles in radians.
    start, stop
        The first frame of the span, and the frame after its last one.

    Returns
    -------
    array, shape (stop − start,)
        The relative angles in radians, in (−π, π].
    """
    outside = [t for t in (start - 1, stop) if 0 <= t < len(theta)] or [len(theta) - 1]
    before, behind = float(theta[outside[0]]), float(theta[outside[-1]])
    share = (np.arange(stop - start) + 1) / (stop - start + 1)
    return wrap(theta[start:stop] - (before + wrap(behind - before) * share))


def new_constant_offset_interval(chain: str, start: int, stop: int, delta: float) -> Interval:
    """Return an interval with the offset `delta`, in radians, in all frames."""
    offset: Array = np.full(stop - start, delta)
    return Interval(chain, start, stop, offset)
