"""The departures of all spans that meet a stretch of a chain, in one array.

A search tries hundreds of offsets over the same few frames. The frames that each departure uses,
and how surprising it is, are the same for all of them. So they are collected once, and the
departures of every span are one array operation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.prediction import FLOOR, Index
from twistcore.detection.soft_errors.departures import Span
from twistcore.detection.soft_errors.natural_scale import NU, cost
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SIZING = 6  # rounds in which a size is found


@dataclass(frozen=True)
class SpanDepartures:
    """The departures of one span over a stretch: positions from `first` on, which meet it.

    u, spread: (probes, positions), radians; weight: (positions,), 0 if there is a cut under it.
    """

    span: Span
    first: int
    u: Array
    spread: Array
    weight: Array


@dataclass(frozen=True, eq=False)
class Stretch:
    """The departures of so many frames, by span, probe and position; each n in all.

    nodes: the frames that a departure uses, its probe's first, (5, n), and the frame after the last
    one for frames outside; weights: of the four others, (4, n); u and its spread, radians, and its
    weight, (n,); lengths: of its span, frames, (n,), ascending.
    """

    frames: int
    nodes: Index
    weights: Array
    u: Array
    spread: Array
    weight: Array
    lengths: Index

    def longer(self, shortest: float) -> Stretch:
        """Return the departures of spans of at least so many frames."""
        told = slice(int(np.searchsorted(self.lengths, shortest)), None)
        return Stretch(
            self.frames,
            self.nodes[:, told],
            self.weights[:, told],
            self.u[told],
            self.spread[told],
            self.weight[told],
            self.lengths[told],
        )

    def departures(self, courses: Array) -> Array:
        """Return departures of courses (m, frames), 0 outside the stretch, (m, n), radians."""
        level = np.zeros((len(courses), self.frames + 1))
        level[:, :-1] = courses
        out: Array = level.take(self.nodes[0], axis=1)
        for node, weight in zip(self.nodes[1:], self.weights, strict=True):
            ends = level.take(node, axis=1)
            ends *= weight
            out -= ends
        return out

    def residuals(self, courses: Array, wider: float | Array = 1.0) -> Array:
        """Return what remains of u after removing courses (m, frames), (m, n).

        The sum of their squares is the surprise. wider: by how much all scales are widened, one
        number for all or one a course, (m, 1).
        """
        z = self.departures(courses)
        np.subtract(self.u, z, out=z)
        z /= wider * self.spread
        left = cost(z)
        left *= self.weight
        return np.copysign(np.sqrt(left, out=left), z, out=left)

    def sizes(self, departures: Array, wider: float = 1.0) -> Array:
        """Return the factors with which courses of such departures (m, n) explain u best, (m,)."""
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


def stretch(low: int, frames: int, told: Sequence[SpanDepartures]) -> Stretch:
    """Return the stretch of so many frames from `low` on, from spans sorted by length."""
    nodes, weights = [], []
    for t in told:
        at, by = t.span.nodes(t.first, t.u.shape[1])
        nodes.append(at.reshape(len(at), -1))
        weights.append(np.repeat(by, t.u.shape[1], axis=1))
    at = np.concatenate([np.zeros((5, 0), dtype=np.intp), *nodes], axis=1) - low
    return Stretch(
        frames,
        np.where((at >= 0) & (at < frames), at, frames),
        np.concatenate([np.zeros((4, 0)), *weights], axis=1),
        np.concatenate([np.zeros(0), *(t.u.ravel() for t in told)]),
        np.concatenate([np.zeros(0), *(t.spread.ravel() for t in told)]),
        np.concatenate(
            [np.zeros(0), *(np.broadcast_to(t.weight, t.u.shape).ravel() for t in told)]
        ),
        np.repeat([t.span.length for t in told], [t.u.size for t in told]),
    )
