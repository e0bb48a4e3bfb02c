"""Measure the departure of a level from its natural course, over spans of every length.

A level U is the running sum of increments. Its natural course over the span [a, a + L] is called a
bridge: the cubic with the same values and slopes at both ends. The departure of U from the bridge
is measured at a quarter, a half and three quarters of the span. A twist error δ that begins and
ends within a span causes a departure of about δ, however gradually it begins. Natural motion
departs little, and less over shorter spans.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np

from twistcore.detection.prediction import Index
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

# Spans in seconds, each about 4/3 to 3/2 of the previous one: 8, 12, 16 … 384 frames at 120 Hz.
SPANS = tuple(n / 120.0 for n in (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384))
SHORTEST = 3  # frames
PROBES = (0.25, 0.5, 0.75)  # fractions of a span
SLOPE_SECONDS = 2.0 / 120.0  # the time over which the slopes at the ends are measured
GRID = 4  # positions of a span's start within its length


@dataclass(frozen=True)
class Span:
    """Spans of `length` frames that start every `step` frames.

    `reach` is the number of frames over which the slopes at both ends are measured.
    """

    length: int
    step: int
    reach: int

    @property
    def support(self) -> int:
        """The number of frames that are needed to compute one departure."""
        return self.length + 2 * self.reach + 1

    def count(self, frames: int) -> int:
        """Return the number of positions of the span in a clip with the given number of frames."""
        return max(0, (frames - self.support) // self.step + 1)

    def departures(self, level: Array) -> Array:
        """Return the departures from the bridge, radians, (…, frames) → (probes, …, positions).

        The departure at position j is computed from the frames from j·step on.
        """
        many = self.count(level.shape[-1])
        last = self.step * (many - 1) + 1

        def at(frame: int) -> Array:
            return level[..., frame : frame + last : self.step]

        h, n = self.reach, self.length
        nodes = at(0), at(h), at(h + n), at(2 * h + n)
        out = np.empty((len(PROBES), *level.shape[:-1], many))
        for k, probe in enumerate(PROBES):
            inside = round(probe * n)
            weights = bridge_weights(inside / n, n, h)
            np.copyto(out[k], at(h + inside))
            for weight, node in zip(weights, nodes, strict=True):
                out[k] -= weight * node
        return out

    def noise(self) -> Array:
        """Return the standard deviation of the departures of white noise with σ = 1, (probes,)."""
        _, weights = self.nodes(0, 0)
        noise: Array = np.sqrt(1.0 + (weights**2).sum(axis=0))
        return noise

    def nodes(self, first: int, many: int) -> tuple[Index, Array]:
        """Return the frames from which `many` departures from position `first` on are computed.

        The second result contains the weights of these frames. The frames, (5, probes, positions),
        are the probe and the four nodes of its bridge. The weights, (4, probes), are the weights of
        the nodes in :meth:`departures`.
        """
        h, n = self.reach, self.length
        inside = [round(probe * n) for probe in PROBES]
        begin = self.step * (first + np.arange(many))
        frames = np.array([[h + i, 0, h, h + n, 2 * h + n] for i in inside]).T
        weights = np.array([bridge_weights(i / n, n, h) for i in inside]).T
        return frames[..., None] + begin, weights


def spans(fps: float, frames: int) -> tuple[Span, ...]:
    """Return all spans that fit into a clip at least twice. `frames` is the length of the clip."""
    reach = max(1, round(SLOPE_SECONDS * fps))
    lengths = sorted({max(SHORTEST, round(seconds * fps)) for seconds in SPANS})
    found = (Span(n, max(1, n // GRID), reach) for n in lengths)
    return tuple(s for s in found if 2 * s.support <= frames)


@cache
def bridge_weights(at: float, length: int, reach: int) -> tuple[float, float, float, float]:
    """Return the weights of four levels for the value of a bridge at the fraction `at` of a span.

    The levels are at four frames: `reach` frames before the span's first frame, the first frame,
    the last frame, and `reach` frames after the last. The cubic has the given values and slopes at
    both ends (Hermite).
    """
    rise = at * at * (3.0 - 2.0 * at)
    slope_in = at * (1.0 - at) ** 2 * (length / reach)
    slope_out = at * at * (1.0 - at) * (length / reach)
    return -slope_in, 1.0 - rise + slope_in, rise + slope_out, -slope_out


def bridge(level: Array, start: int, stop: int, reach: int) -> Array:
    """Return the natural course of levels (…, frames) over [start, stop), from nearby frames.

    At least one frame is needed on either side. If there are fewer than `reach` frames, the slope
    is measured over the frames that exist.
    """
    first, last = start - 1, stop
    before, behind = min(reach, first), min(reach, level.shape[-1] - 1 - last)
    length = last - first
    from_first, from_last, by_in, by_out = _cubic(length)
    ends = level[..., first, None], level[..., last, None]
    mean = (ends[1] - ends[0]) / length
    slope_in = (ends[0] - level[..., first - before, None]) / before if before else mean
    slope_out = (level[..., last + behind, None] - ends[1]) / behind if behind else mean
    return np.asarray(
        from_first * ends[0] + from_last * ends[1] + by_in * slope_in - by_out * slope_out
    )


@lru_cache(maxsize=1024)
def _cubic(length: int) -> tuple[Array, Array, Array, Array]:
    """Return the weights of a cubic's end values and end slopes for the inner frames of a span.

    The result consists of four arrays of shape (length − 1,).
    """
    t = np.arange(1, length) / length
    rise = t * t * (3.0 - 2.0 * t)
    found = 1.0 - rise, rise, t * (1.0 - t) ** 2 * length, t * t * (1.0 - t) * length
    for weights in found:
        weights.setflags(write=False)
    return found
