"""The twist increments of limbs while errors are removed, and how unlikely they are (surprise).

Twist errors can be removed from the rotations tentatively, which also removes their exact effects
on neighbouring chains. The surprise of a frame range is the total cost of the departures from
natural courses over spans of all suitable lengths, in u (see `natural_scale`) and in x + y.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from twistcore.detection.limbs import Limbs
from twistcore.detection.prediction import Index, Mask
from twistcore.detection.soft_errors.departures import (
    PROBES,
    Single,
    SpanGrid,
    natural_accumulated_twist_curves,
    overlapping_frame_spans_by_length,
)
from twistcore.detection.soft_errors.local_departures import (
    LocalDepartures,
    SpanDepartures,
    local_departures,
)
from twistcore.detection.soft_errors.natural_scale import (
    NU,
    Natural,
    natural_twist_departure_cost,
    natural_twist_departure_scales,
)
from twistcore.skeleton.rotation import (
    Array,
    multiply,
    normalise,
    quaternion_from_axis_angle,
)
from twistcore.skeleton.twist_increments import twist_increments

# The weight of a departure. It is small because the departures at the three probes and at four
# neighbouring positions are nearly the same.
WEIGHT = 0.175
SMALLEST = float(np.radians(1.5))  # smaller departures are never examined
LEAST_AROUND = 6  # minimum number of frames on either side of an error in which no seed may remain
SEED_CAP = 20.0  # nats: maximum gain of one probe of a seed
LONGEST = 2.0  # spans of at most this multiple of a frame range's length are used for the range


@dataclass(eq=False)
class _AtSpan:
    """The departures over the spans of one length, in single precision to save memory.

    Attributes
    ----------
    natural
        The natural scales.
    u, total
        The departures of u and of x + y, radians, shape (probes, chains, positions).
    spread
        The scales of u, radians, shape (probes, chains, positions).
    usable
        Mask of the positions at which the span contains no cut, shape (positions,).
    """

    natural: Natural
    u: Single
    spread: Single
    total: Single
    usable: Mask


class _Grids(NamedTuple):
    """The scales of natural motion over spans of all lengths, concatenated into arrays.

    Attributes
    ----------
    length, support, step, positions
        Attributes of the :class:`SpanGrid` of each length, and its number of positions, shape
        (lengths,).
    first
        The index in `sigma` of the first position of each length, shape (lengths,).
    beta
        β, shape (lengths, rows).
    sigma
        σ of u in the middle of the spans, radians, shape (rows, positions of all lengths).
    """

    length: Index
    support: Index
    step: Index
    positions: Index
    first: Index
    beta: Array
    sigma: Array

    @staticmethod
    def of(natural: Sequence[Natural]) -> _Grids:
        """Combine the scales for all span lengths, the shortest first."""
        spans = [n.span for n in natural]
        count = np.array([n.sigma.shape[-1] for n in natural], dtype=np.intp)
        middles = [n.sigma[len(PROBES) // 2] for n in natural]
        return _Grids(
            np.array([s.length for s in spans], dtype=np.intp),
            np.array([s.support for s in spans], dtype=np.intp),
            np.array([s.step for s in spans], dtype=np.intp),
            count,
            np.cumsum(count) - count,
            np.array([n.beta for n in natural]),
            np.concatenate(middles, axis=-1) if middles else np.zeros((0, 0)),
        )


class Surprise:
    """Limbs from which errors are removed step by step, and their departures from natural motion.

    Each row is a chain. Chain k of limb i is in row k·limbs + i. `budget` is the maximum amount of
    work for the search, measured as the number of departures to which courses are fitted.
    """

    def __init__(self, limbs: Limbs, fps: float, cut: Mask, budget: float = math.inf) -> None:
        self.limbs, self.fps, self.cut = limbs, fps, cut
        self.joints = limbs.joints.copy()
        self.rows, self.frames = len(limbs) * limbs.count, limbs.frames
        self.x, self.y = limbs.increments()
        self.x[:, cut] = self.y[:, cut] = 0.0
        self.spans = overlapping_frame_spans_by_length(fps, self.frames)
        self.work = 0  # number of departures to which the search has fitted courses so far
        self.budget = budget
        self.at: list[_AtSpan] = []
        self._grids = _Grids.of([])

    def neighbours(self, row: int) -> list[int]:
        """Return the rows of a chain and of the chains directly above and below it in its limb."""
        rows = (row - self.limbs.count, row, row + self.limbs.count)
        return [r for r in rows if 0 <= r < self.rows]

    def limb(self, row: int) -> list[int]:
        """Return the rows of all chains in the same limb as `row`."""
        return list(range(row % self.limbs.count, self.rows, self.limbs.count))

    def remove_error(self, row: int, start: int, offset: Array) -> None:
        """Remove a twist error from the rotations of a chain, from frame `start` on.

        The twist increments and departures are not updated. Call :meth:`update_departures` for
        this.
        """
        k, i = divmod(row, self.limbs.count)
        at = slice(start, start + len(offset))
        axis = self._axis(row, at)
        parent, child = self.joints[k, i], self.joints[k + 1, i]
        parent[at] = normalise(multiply(parent[at], quaternion_from_axis_angle(axis, -offset)))
        child[at] = normalise(multiply(quaternion_from_axis_angle(axis, offset), child[at]))

    def update_departures(self, row: int, start: int, stop: int) -> None:
        """Update the twist increments and departures of a chain and its neighbours.

        Call this method after a change in frames [start, stop).
        """
        low, high = max(start - 1, 0), min(stop + 1, self.frames)
        for r in self.neighbours(row):
            k, i = divmod(r, self.limbs.count)
            part = slice(low, high)
            x, y = twist_increments(
                self.joints[k, i, part], self.joints[k + 1, i, part], self._axis(r, part)
            )
            live = ~self.cut[low + 1 : high]
            self.x[r, low + 1 : high] = x[1:] * live
            self.y[r, low + 1 : high] = y[1:] * live
            self._recompute(r, low, high)

    def _axis(self, row: int, at: slice) -> Array:
        k, i = divmod(row, self.limbs.count)
        axis: Array = self.limbs.axes[k, i]
        return axis if axis.ndim == 1 else axis[at]

    def measure(self, bad: Mask) -> None:
        """Compute all departures, and measure the scales of natural motion outside the bad frames.

        `bad` is the mask of the frames that may contain errors, shape (rows, frames).
        """
        natural = natural_twist_departure_scales(
            self.x, self.y, self.fps, self.spans, bad, self.limbs.step
        )
        level_x, level_y = np.cumsum(self.x, axis=1), np.cumsum(self.y, axis=1)
        across = np.concatenate([[0], np.cumsum(self.cut)])
        self.at = []
        for n in natural:
            u, total = n.rest(n.span.departures(level_x), n.span.departures(level_y))
            first = n.span.step * np.arange(u.shape[-1])
            usable = across[first + n.span.support] == across[first + 1]
            spread = n.spread(total).astype(np.float32)
            self.at.append(
                _AtSpan(n, u.astype(np.float32), spread, total.astype(np.float32), usable)
            )
        self._grids = _Grids.of(natural)

    def _recompute(self, row: int, low: int, high: int) -> None:
        """Recompute the departures of a chain that depend on any of the frames [low, high)."""
        for a in self.at:
            span = a.natural.span
            first, last = self._positions(span, low, high, a.u.shape[-1])
            if last <= first:
                continue
            part = slice(span.step * first, span.step * (last - 1) + span.support)
            turns = np.array([self.x[row, part], self.y[row, part]])
            x, y = span.departures(turns.cumsum(axis=1)).swapaxes(0, 1)
            total = x + y
            u = x - a.natural.beta[row] * total
            z = total / a.natural.sigma_sum[:, row, first:last]
            spread = a.natural.sigma[:, row, first:last] * np.sqrt((NU + z * z) / (NU + 1.0))
            a.u[:, row, first:last], a.total[:, row, first:last] = u, total
            a.spread[:, row, first:last] = spread

    @staticmethod
    def _positions(span: SpanGrid, low: int, high: int, count: int) -> tuple[int, int]:
        """Return the positions [first, last) at which spans overlap the frames [low, high)."""
        first = max(0, -(-(low - span.support + 1) // span.step))
        return first, min(count, (high - 1) // span.step + 1)

    def of(self, row: int, low: int, high: int) -> float:
        """Return the surprise of a chain over the spans that overlap frames [low, high), in nats.

        The surprise is the total cost of the departures from natural motion.
        """
        found = 0.0
        for a in self._similar_spans(high - low):
            first, last = self._positions(a.natural.span, low, high, a.u.shape[-1])
            here = a.usable[first:last]
            at = np.s_[:, row, first:last]
            z = a.u[at] / a.spread[at], a.total[at] / a.natural.sigma_sum[at]
            found += self._weight(a) * float(
                (
                    (natural_twist_departure_cost(z[0]) + natural_twist_departure_cost(z[1])) * here
                ).sum()
            )
        return found

    def local_departures(self, row: int, low: int, frames: int) -> LocalDepartures:
        """Return a chain's departures over spans that overlap `frames` frames from `low` on."""
        overlapping = []
        for a in self._similar_spans(frames):
            first, last = self._positions(a.natural.span, low, low + frames, a.u.shape[-1])
            if last > first:
                at = np.s_[:, row, first:last]
                weight = np.asarray(self._weight(a) * a.usable[first:last])
                overlapping.append(
                    SpanDepartures(a.natural.span, first, a.u[at], a.spread[at], weight)
                )
        return local_departures(low, frames, overlapping)

    def seed_left(self, row: int, start: int, offset: Array) -> float:
        """Return the highest remaining gain of any span near an error after its removal, in nats.

        The gain of a span is the cost of its departures as natural motion. Only spans that extend
        little beyond the error are considered, because there may be another error nearby.
        """
        most, stop = 0.0, start + len(offset)
        margin = max(LEAST_AROUND, len(offset) // 2)
        for a in self._similar_spans(len(offset)):
            span = a.natural.span
            first = max(0, -(-(start - margin) // span.step))
            last = min(a.u.shape[-1], (stop + margin - span.support) // span.step + 1)
            if last <= first:
                continue
            begin, end = span.step * first, span.step * (last - 1) + span.support
            level = np.zeros(end - begin)
            part = slice(max(start, begin), min(stop, end))
            level[part.start - begin : max(part.stop - begin, 0)] = offset[
                part.start - start : max(part.stop - start, 0)
            ]
            u = a.u[:, row, first:last] - span.departures(level)
            gain = natural_twist_departure_cost(u / a.spread[:, row, first:last], SEED_CAP).sum(
                axis=0
            )
            gain *= (np.abs(u).max(axis=0) >= SMALLEST) & a.usable[first:last]
            most = max(most, float(gain.max(initial=0.0)))
        return most

    def _similar_spans(self, length: int) -> list[_AtSpan]:
        found = [a for a in self.at if a.natural.span.length <= LONGEST * length]
        return found or self.at[:1]

    @staticmethod
    def _weight(a: _AtSpan) -> float:
        span = a.natural.span
        return WEIGHT * span.step / max(span.length / 4.0, 1.0)

    def weight_per_frame(self, length: int) -> float:
        """Return the total weight of the departures per frame in a range of `length` frames."""
        return sum(
            len(PROBES) * self._weight(a) / a.natural.span.step for a in self._similar_spans(length)
        )

    def free_offsets(self, row: int, ranges: Index, low: int, high: int) -> tuple[Array, Array]:
        """Return the offsets whose removal makes u follow its natural course, and their σ.

        Parameters
        ----------
        row
            The row of the chain.
        ranges
            The frame range [start, stop) of each offset, (n, 2), with at least one frame on either
            side.
        low, high
            The frames of the result, which contain all ranges.

        Returns
        -------
        offsets : ndarray, shape (n, high - low)
            Radians, 0 outside each range.
        sigma : ndarray, shape (n,)
            Radians. β and σ are interpolated from spans of similar length at that position.
        """
        reach = self.spans[0].reach
        first = max(low - 1 - reach, 0)
        last = min(high + 1 + reach, self.frames)
        levels = np.array([self.x[row, first:last], self.y[row, first:last]]).cumsum(axis=1)
        beta, sigma = self.scales(row, ranges)
        level = (1.0 - beta)[:, None] * levels[0] - beta[:, None] * levels[1]
        inner = slice(low - first, high - first)
        frames = np.arange(low, high)
        inside = (frames >= ranges[:, :1]) & (frames < ranges[:, 1:])
        course = natural_accumulated_twist_curves(level, ranges - first, inner, reach)
        return np.where(inside, level[:, inner] - course, 0.0), sigma

    def scales(self, row: int, ranges: Index) -> tuple[Array, Array]:
        """Return β and σ (see :class:`Natural`) for natural courses over n frame ranges.

        `ranges` has the shape (n, 2). The values, each (n,), are interpolated from spans of similar
        length.
        """
        starts, stops = ranges.T
        length = np.maximum(stops - starts, 1)
        grids, lengths = self._grids, self._grids.length
        k = np.searchsorted(lengths, length)
        near = np.stack([np.maximum(k - 1, 0), np.minimum(k, len(lengths) - 1)])
        middle = (starts + stops - grids.support[near]) // 2 // grids.step[near]
        position = grids.first[near] + np.minimum(np.maximum(middle, 0), grids.positions[near] - 1)
        beta, sigma = grids.beta[near, row], grids.sigma[row, position]
        a, b = lengths[near]
        share = np.log(length / a) / np.where(b > a, np.log(b / a), 1.0)
        share = np.where(b > a, np.minimum(np.maximum(share, 0.0), 1.0), 0.0)
        rest = 1.0 - share
        return rest * beta[0] + share * beta[1], sigma[0] ** rest * sigma[1] ** share
