"""Measure how far a running sum of twist increments departs from its natural course.

The running sum is called a level. Its natural course over a span of frames is called a bridge: the
cubic with the values and slopes of the level at both ends of the span. The departure of the level
from the bridge is measured at three *probes*: a quarter, a half and three quarters of the span. A
twist error δ that begins and ends within a span causes a departure of about δ, however gradually it
begins. Natural motion departs little, and less over shorter spans.
"""

from __future__ import annotations

from functools import cache, cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.prediction import Index
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

Single: TypeAlias = NDArray[np.float32]
Values: TypeAlias = NDArray[np.floating[Any]]  # of single or double precision

# Spans in seconds, each about 4/3 to 3/2 of the previous one: 8, 12, 16 … 384 frames at 120 Hz.
SPANS = tuple(n / 120.0 for n in (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384))
SHORTEST = 3  # length of the shortest span in frames
PROBES = (0.25, 0.5, 0.75)  # fractions of a span at which the departure is measured
SLOPE_SECONDS = 2.0 / 120.0  # time over which the slopes at the ends are measured
GRID = 4  # number of spans that begin within the length of a span


@dataclass(frozen=True)
class SpanGrid:
    """Overlapping spans of frames, all of the same length.

    The spans are numbered. The number of a span is called its position.

    Attributes
    ----------
    length
        The length of each span in frames.
    step
        The number of frames from one position to the next.
    reach
        The number of frames over which the slopes at both ends are measured.
    """

    length: int
    step: int
    reach: int

    @property
    def support(self) -> int:
        """The number of frames from which the departures over one span are computed."""
        return self.length + 2 * self.reach + 1

    def count(self, frames: int) -> int:
        """Return the number of spans in a clip with the given number of frames."""
        return max(0, (frames - self.support) // self.step + 1)

    def departures(self, level: Array) -> Array:
        """Return the departures of levels (running sums) from their natural courses, in radians.

        `level` has the shape (…, frames), and the result has the shape (probes, …, positions). The
        departures over the span at position j are computed from frames that begin with frame
        j·step.
        """
        many = self.count(level.shape[-1])
        last = self.step * (many - 1) + 1

        def at(frame: int) -> Array:
            return level[..., frame : frame + last : self.step]

        h, n = self.reach, self.length
        nodes = at(0), at(h), at(h + n), at(2 * h + n)
        out = np.empty((len(PROBES), *level.shape[:-1], many))
        for own, inside, weights in zip(out, *self._probes, strict=True):
            np.copyto(own, at(h + inside))
            for weight, node in zip(weights, nodes, strict=True):
                own -= weight * node
        return out

    @cached_property
    def _probes(self) -> tuple[list[int], list[tuple[float, float, float, float]]]:
        """The frame of each probe after the first frame of a span, and its bridge weights."""
        inside = [round(probe * self.length) for probe in PROBES]
        return inside, [
            hermite_bridge_frame_weights(i / self.length, self.length, self.reach) for i in inside
        ]

    def noise(self) -> Array:
        """Return the standard deviation at each probe of the departures of white noise with σ = 1.

        The shape is (probes,).
        """
        _, weights = self.nodes(0, 0)
        noise: Array = np.sqrt(1.0 + (weights**2).sum(axis=0))
        return noise

    def nodes(self, first: int, many: int) -> tuple[Index, Array]:
        """Return the frames and weights from which the departures over several spans are computed.

        These are `many` spans, beginning with position `first`. The frames, (5, probes, positions),
        are the frame of the probe and the four frames that define the bridge. The weights of these
        four frames have the shape (4, probes).
        """
        h, n = self.reach, self.length
        inside, weights = self._probes
        begin = self.step * (first + np.arange(many))
        frames = np.array([[h + i, 0, h, h + n, 2 * h + n] for i in inside]).T
        return frames[..., None] + begin, np.array(weights).T


def overlapping_frame_spans_by_length(fps: float, frames: int) -> tuple[SpanGrid, ...]:
    """Return the spans of each length that fits at least twice into a clip of `frames` frames."""
    reach = max(1, round(SLOPE_SECONDS * fps))
    lengths = sorted({max(SHORTEST, round(seconds * fps)) for seconds in SPANS})
    found = (SpanGrid(n, max(1, n // GRID), reach) for n in lengths)
    return tuple(s for s in found if 2 * s.support <= frames)


@cache
def hermite_bridge_frame_weights(
    at: float, length: int, reach: int
) -> tuple[float, float, float, float]:
    """Return the weights of four frames in the value of a bridge (a Hermite cubic over a span).

    The frames are `reach` frames before the first frame of the span, its first frame, its last
    frame, and `reach` frames after the last. They define the values and slopes of the cubic at both
    ends. The cubic is evaluated at the fraction `at` of the span, 0…1, and `length` is the length
    of the span in frames.
    """
    rise = at * at * (3.0 - 2.0 * at)
    slope_in = at * (1.0 - at) ** 2 * (length / reach)
    slope_out = at * at * (1.0 - at) * (length / reach)
    return -slope_in, 1.0 - rise + slope_in, rise + slope_out, -slope_out


def natural_accumulated_twist_curves(
    level: Array, ranges: Index, inner: slice, reach: int
) -> Array:
    """Return the natural courses of levels (running sums) over one frame range each.

    Each course is the Hermite cubic through the level one frame before and one frame after the
    range. The slope on each side is measured over `reach` frames, or fewer near the ends.

    Parameters
    ----------
    level
        The levels, shape (n, frames).
    ranges
        The frame ranges [start, stop), shape (n, 2), with at least one frame on either side.
    inner
        The frames of the result. Outside its range, a course is extrapolated.
    reach
        The number of frames over which slopes are measured.

    Returns
    -------
    ndarray, shape (n, frames of `inner`)
    """
    rows, first, last = np.arange(len(level)), ranges[:, 0] - 1, ranges[:, 1]
    before = np.minimum(reach, first)
    behind = np.minimum(reach, level.shape[1] - 1 - last)
    length = last - first
    ends = level[rows, first], level[rows, last]
    rise = ends[1] - ends[0]
    slope_in, slope_out = rise.copy(), rise.copy()  # per length; the mean slope if no frame is left
    at = before > 0
    slope_in[at] = ((ends[0] - level[rows, first - before]) * length)[at] / before[at]
    at = behind > 0
    slope_out[at] = ((level[rows, last + behind] - ends[1]) * length)[at] / behind[at]
    t = (np.arange(inner.start, inner.stop) - first[:, None]) / length[:, None]
    # The cubic with these ends and slopes, as a polynomial in t.
    third = (slope_in + slope_out - 2.0 * rise)[:, None]
    second = (3.0 * rise - 2.0 * slope_in - slope_out)[:, None]
    course: Array = ((third * t + second) * t + slope_in[:, None]) * t + ends[0][:, None]
    return course
