"""Evaluate many offsets over the same few frames of a chain, by the departures that they explain.

A *departure* is the distance of a running sum of twist increments from its natural course over a
span of frames. A search evaluates hundreds of offsets over the same frames. For all of them, each
departure uses the same frames and has the same scale. The frames and scales of all spans are
therefore collected once, and the departures are computed in one array operation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from twistcore.detection.prediction import FLOOR, Index
from twistcore.detection.soft_errors.departures import PROBES, Single, SpanGrid
from twistcore.detection.soft_errors.natural_scale import CAP, NU
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SIZING = 6  # rounds of reweighting in the fit of a size
HALF = 0.5 * (NU + 2.0)  # factor of the logarithm in the cost of a departure
LEAST = np.float32(1e-6)  # smallest departure in scales, so that its derivative can be computed


@dataclass(frozen=True)
class SpanDepartures:
    """The departures from natural courses over spans of one length that overlap a frame range.

    Attributes
    ----------
    span
        The spans.
    first
        The position of the first span.
    u, spread
        The departures and their scales, radians, shape (probes, positions).
    weight
        The weights of the departures, shape (positions,), 0 where the span crosses a cut.
    """

    span: SpanGrid
    first: int
    u: Single
    spread: Single
    weight: Array


@dataclass(frozen=True, eq=False)
class LocalDepartures:
    """The departures from natural courses over n spans that overlap a frame range.

    The spans are sorted by length and position. There are three departures per span, one for each
    probe. The numbers have single precision,
    which is twice as fast and still finer than any scale.

    Attributes
    ----------
    frames
        The number of frames in the range.
    inside, ends
        The frames from which the departures of each span are computed, counted from the start of
        the range: the frames of the probes, shape (3, n), and the four frames that define the
        bridge, shape (4, n). A frame outside the range has the index `frames`.
    weights
        The weights of the four frames for each probe, shape (4, 3, n).
    u
        Each departure, radians, shape (3, n).
    per_scale
        1 / (√(ν + 1) σ) for the scale σ of each departure, 1/radians, shape (3, n).
    root
        The square root of the weight of each departure, shape (3, n).
    lengths
        The length of each span in frames, shape (n,), ascending.
    """

    frames: int
    inside: Index
    ends: Index
    weights: Single
    u: Single
    per_scale: Single
    root: Single
    lengths: Index

    def longer(self, shortest: float) -> LocalDepartures:
        """Return a copy with only the departures over spans of at least `shortest` frames."""
        first = int(np.searchsorted(self.lengths, shortest))
        return LocalDepartures(
            self.frames,
            self.inside[:, first:].copy(),
            self.ends[:, first:].copy(),
            self.weights[..., first:].copy(),
            self.u[:, first:].copy(),
            self.per_scale[:, first:].copy(),
            self.root[:, first:].copy(),
            self.lengths[first:],
        )

    def departures(self, courses: Array) -> Single:
        """Return the departures of m offsets from their natural courses, in radians, (m, 3, n).

        `courses` contains the value of each offset in each frame of the range, radians, shape (m,
        frames). Outside the range, offsets are 0.
        """
        level = np.zeros((len(courses), self.frames + 1), dtype=np.float32)
        level[:, :-1] = courses
        out: Single = level.take(self.inside, axis=1)
        ends = level.take(self.ends, axis=1)
        for k, weights in enumerate(self.weights):
            out -= weights * ends[:, k, None]
        return out

    def surprise(self, departures: Single, wider: float = 1.0) -> Array:
        """Return the cost of the departures that remain after removing each offset, in nats, (m,).

        `departures` contains the departures of the m offsets, shape (m, 3, n). `wider` is the
        factor by which all scales are multiplied.
        """
        q = (self.u - departures) * (self.per_scale / np.float32(wider))
        q *= q
        costs = _costs(q).reshape(len(q), self.root.size)
        return np.asarray(costs @ (self.root * self.root).ravel(), dtype=np.float64)

    def residuals(self, departures: Single, wider: Array) -> tuple[Single, Single]:
        """Return the weighted residuals after removing each offset, and their derivatives.

        The residuals are the departures that remain. The sum of their squares is the surprise
        (cost) in nats. The derivatives are with respect to the departures. Both results have the
        shape (m, 3 n). `departures` contains the departures of the m offsets, shape (m, 3, n), and
        `wider` the factor by which the scales are multiplied for each offset, (m, 1).
        """
        scaled = self.per_scale / wider[..., None].astype(np.float32)
        q = (self.u - departures) * scaled
        size = np.maximum(np.abs(q), LEAST)
        square = size * size
        costs = _costs(square)
        capped = costs >= CAP
        rooted = np.sqrt(costs)
        square += 1.0
        square *= rooted
        size *= scaled
        size /= square
        size *= np.float32(-HALF) * self.root
        size[capped] = 0.0
        rooted *= self.root
        left = np.copysign(rooted, q, out=rooted)
        return left.reshape(len(q), -1), size.reshape(len(q), -1)

    def sizes(self, departures: Single, wider: float = 1.0) -> Array:
        """Return the factors by which offsets must be multiplied to explain the departures best.

        `departures` contains the departures of the m offsets, shape (m, 3, n). `wider` is the
        factor by which all scales are multiplied. The result has the shape (m,).
        """
        scaled = self.per_scale / np.float32(wider)
        by, of = (
            (departures * scaled).reshape(len(departures), scaled.size),
            (self.u * scaled).ravel(),
        )
        weight = (self.root * self.root).ravel()
        trust = np.broadcast_to(weight, by.shape)
        found: Single = np.zeros(len(by), dtype=np.float32)
        for _ in range(SIZING):
            trusted = trust * by
            over = np.maximum(np.einsum("mn,mn->m", trusted, by), np.float32(FLOOR))
            found = (trusted @ of) / over
            left = of - found[:, None] * by
            left *= left
            left += 1.0
            trust = weight / left
        return np.asarray(found, dtype=np.float64)


def _costs(square: Single) -> Single:
    """Return the costs of departures as natural motion, in nats, from squared, scaled departures.

    `square` contains the squares of q = z / √(ν + 1). See
    :func:`natural_twist_departure_cost`.
    """
    costs: Single = np.log1p(square)
    costs *= HALF
    return np.minimum(costs, np.float32(CAP), out=costs)


def local_departures(
    low: int, frames: int, departures: Sequence[SpanDepartures]
) -> LocalDepartures:
    """Combine the departures over all spans that overlap `frames` frames from frame `low` on.

    `departures` contains one item for each span length, the shortest first.
    """
    nodes, weights = [np.zeros((5, len(PROBES), 0), dtype=np.intp)], [np.zeros((4, len(PROBES), 0))]
    for t in departures:
        at, by = t.span.nodes(t.first, t.u.shape[1])
        nodes.append(at)
        weights.append(np.repeat(by[..., None], t.u.shape[1], axis=2))
    at = np.concatenate(nodes, axis=2) - low
    at = np.where((at >= 0) & (at < frames), at, frames)
    none = np.zeros((len(PROBES), 0))
    spread = np.concatenate([none, *(t.spread for t in departures)], axis=1)
    weight = np.concatenate(
        [none, *(np.broadcast_to(t.weight, t.u.shape) for t in departures)], axis=1
    )
    return LocalDepartures(
        frames,
        at[0],
        at[1:, 0],
        np.concatenate(weights, axis=2).astype(np.float32),
        np.concatenate([none, *(t.u for t in departures)], axis=1).astype(np.float32),
        (1.0 / (math.sqrt(NU + 1.0) * spread)).astype(np.float32),
        np.sqrt(weight).astype(np.float32),
        np.repeat([t.span.length for t in departures], [t.u.shape[1] for t in departures]),
    )
