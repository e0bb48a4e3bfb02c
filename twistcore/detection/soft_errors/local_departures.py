"""Evaluate many offsets over the same few frames of a chain, by the departures that they explain.

A search evaluates hundreds of offsets over the same frames. For all of them, each departure uses
the same frames and has the same scale. The frames and scales of all spans are therefore collected
once, and the departures are computed in one array operation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.prediction import FLOOR, Index
from twistcore.detection.soft_errors.departures import SpanGrid
from twistcore.detection.soft_errors.natural_scale import NU, cost
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SIZING = 6  # rounds of reweighting in the fit of a size


@dataclass(frozen=True)
class SpanDepartures:
    """The departures over spans of one length that overlap a frame range.

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
    u: Array
    spread: Array
    weight: Array


@dataclass(frozen=True, eq=False)
class LocalDepartures:
    """All n departures over spans that overlap a frame range, sorted by length, probe and position.

    Attributes
    ----------
    frames
        The number of frames in the range.
    nodes
        The frames from which each departure is computed, counted from the start of the range,
        beginning with the frame of the probe, shape (5, n). A frame outside the range has the index
        `frames`.
    weights
        The weights of the other four frames, shape (4, n).
    u, spread, weight
        Each departure, its scale in radians and its weight, shape (n,).
    lengths
        The length of the span of each departure in frames, shape (n,), ascending.
    """

    frames: int
    nodes: Index
    weights: Array
    u: Array
    spread: Array
    weight: Array
    lengths: Index

    def longer(self, shortest: float) -> LocalDepartures:
        """Return the departures over spans of at least `shortest` frames only."""
        told = slice(int(np.searchsorted(self.lengths, shortest)), None)
        return LocalDepartures(
            self.frames,
            self.nodes[:, told],
            self.weights[:, told],
            self.u[told],
            self.spread[told],
            self.weight[told],
            self.lengths[told],
        )

    def departures(self, courses: Array) -> Array:
        """Return the departures of m offsets from their bridges, in radians, (m, n).

        `courses` contains the offsets in each frame of the range, radians, shape (m, frames).
        Outside the range they are 0.
        """
        level = np.zeros((len(courses), self.frames + 1))
        level[:, :-1] = courses
        out: Array = level.take(self.nodes[0], axis=1)
        for node, weight in zip(self.nodes[1:], self.weights, strict=True):
            ends = level.take(node, axis=1)
            ends *= weight
            out -= ends
        return out

    def residuals(self, courses: Array, wider: float | Array = 1.0) -> Array:
        """Return the weighted residuals of u after the removal of m offsets, (m, n).

        The sum of their squares is the remaining surprise in nats. `courses` contains the offsets,
        shape (m, frames). `wider` is the factor by which all scales are multiplied, one number or
        one for each offset, (m, 1).
        """
        z = self.departures(courses)
        np.subtract(self.u, z, out=z)
        z /= wider * self.spread
        left = cost(z)
        left *= self.weight
        return np.copysign(np.sqrt(left, out=left), z, out=left)

    def sizes(self, departures: Array, wider: float = 1.0) -> Array:
        """Return the factors by which m offsets must be multiplied to explain u best, (m,).

        `departures` contains the departures of these offsets, shape (m, n). `wider` is the factor
        by which all scales are multiplied.
        """
        by, of = departures / (wider * self.spread), self.u / (wider * self.spread)
        trust = np.broadcast_to(self.weight, by.shape)
        found = np.zeros(len(by))
        for _ in range(SIZING):
            trusted = trust * by
            over = np.maximum((trusted * by).sum(axis=1), FLOOR)
            found = (trusted * of).sum(axis=1) / over
            left = of - found[:, None] * by
            trust = self.weight / (NU + 1.0 + left * left)
        return np.asarray(found)


def local_departures(
    low: int, frames: int, departures: Sequence[SpanDepartures]
) -> LocalDepartures:
    """Combine the departures over all spans that overlap `frames` frames from frame `low` on.

    `departures` has one item for each length of spans, the shortest first.
    """
    nodes, weights = [], []
    for t in departures:
        at, by = t.span.nodes(t.first, t.u.shape[1])
        nodes.append(at.reshape(len(at), -1))
        weights.append(np.repeat(by, t.u.shape[1], axis=1))
    at = np.concatenate([np.zeros((5, 0), dtype=np.intp), *nodes], axis=1) - low
    return LocalDepartures(
        frames,
        np.where((at >= 0) & (at < frames), at, frames),
        np.concatenate([np.zeros((4, 0)), *weights], axis=1),
        np.concatenate([np.zeros(0), *(t.u.ravel() for t in departures)]),
        np.concatenate([np.zeros(0), *(t.spread.ravel() for t in departures)]),
        np.concatenate(
            [np.zeros(0), *(np.broadcast_to(t.weight, t.u.shape).ravel() for t in departures)]
        ),
        np.repeat([t.span.length for t in departures], [t.u.size for t in departures]),
    )
