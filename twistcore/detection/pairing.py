"""Edges paired into intervals: the cheapest explanation of a chain's edges [MATH.md §4.5-4.6].

All values are gains in nats (log likelihood ratios against 'natural motion'). An interval gains by
its two edges, by the steps inside that it explains, and by closing: how much likelier its sum is 0
modulo a turn under the scales of its steps than if the two jumps had nothing to do with each other.
It pays a prior, and for length. The set of disjoint intervals with the highest total gain is found
by dynamic programming over edges in the order of their ends. What an interval gains does not
depend on τ, so it is computed once; a new τ only chooses the edges that may begin or end one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cost import residual_cost
from twistcore.detection.counter import CounterRotation
from twistcore.detection.edges import Edge
from twistcore.detection.prediction import Mask
from twistcore.rotation import Array, wrap

PRIOR = 20.0  # of an interval: two natural jumps that close by chance gain less in 2.9 rich minutes
BORDER_PRIOR = 12.0  # of an interval cut by a border: one edge, nothing closes
LENGTH, LENGTH_FRAMES = (
    4.0,
    30.0,
)  # cost LENGTH·log(1 + frames / LENGTH_FRAMES): more may happen by chance
SMALL_STEP, SMALL_SHARE = float(np.radians(8.0)), 0.4  # jitter inside, beside the closing jump
ALWAYS_SMALL = float(np.radians(3.5))  # jitter beside any jump
SMALL_COST, STEP_COST = 8.0, 30.0  # a real step inside is dear, or neighbours would merge
COUNTED = float(np.radians(1.5))  # smaller steps inside are free: they cannot begin an interval
FOLLOW_COST, FOLLOW_ALL_COST = 2.0, 4.0
TOLERANCE, TOLERANCE_SHARE = float(np.radians(0.05)), 0.005  # of closing, beside the scales
CLOSING_CAP = 25.0
SHORT_SECONDS = 0.25  # an unpaired jump's shorter side up to this is applied, longer is open
OPEN_GAIN = 20.0  # both signals must show an unpaired jump clearly
BAND = 512  # edges an interval may span
SMALLEST = float(np.radians(0.3))  # edges below are never asked for
LEVEL, STEPS, ALL = 0, 1, 2  # what an interval's offset follows: its edges, its events, every frame


@dataclass(frozen=True, slots=True)
class Pair:
    """An interval by its edges; None for a border. gain in nats."""

    opening: Edge | None
    closing: Edge | None
    follows: int
    gain: float


@dataclass(frozen=True, eq=False)
class PairTable:
    """Gains of all pairs of a segment's edges; row: closing edge, column: opening one, banded.

    Edges by start; gain (n, band) with column c for edge row − band + c, −inf where impossible.
    """

    edges: tuple[Edge, ...]
    low: int
    high: int
    start: NDArray[np.int64]
    stop: NDArray[np.int64]
    size: Array
    own: Array
    gain: Array
    follows: NDArray[np.int8]


def pair_table(
    counter: CounterRotation, chain: int, edges: Sequence[Edge], step: Mask, low: int, high: int
) -> PairTable:
    """Gains of all pairs of edges within frames [low, high)."""
    chosen = tuple(e for e in edges if low < e.start and e.stop <= high and abs(e.jump) >= SMALLEST)
    n = len(chosen)
    band = min(n, BAND)
    start = np.array([e.start for e in chosen], dtype=np.int64)
    stop = np.array([e.stop for e in chosen], dtype=np.int64)
    jump = np.array([e.jump for e in chosen])
    variance = np.array([e.sigma for e in chosen]) ** 2
    own = np.array([e.gain for e in chosen])
    primary = np.array([e.primary for e in chosen], dtype=bool)
    gain = np.full((n, band), -np.inf)
    follows = np.zeros((n, band), dtype=np.int8)
    if n < 2:
        return PairTable(chosen, low, high, start, stop, np.abs(jump), own, gain, follows)
    d, var = counter.d[chain], counter.sigma[chain] ** 2
    before = [
        (np.concatenate([[0.0], np.cumsum(d * w)]), np.concatenate([[0.0], np.cumsum(var * w)]))
        for w in (step.astype(np.float64), np.ones(len(d)))
    ]
    row = np.arange(n)[:, None]
    col = row - band + np.arange(band)[None, :]
    a = np.maximum(col, 0)
    possible = (col >= 0) & (stop[a] <= start[:, None])
    size = np.abs(jump)
    small = size[a] < np.clip(SMALL_SHARE * size, ALWAYS_SMALL, SMALL_STEP)[:, None]
    counts = primary & (size >= COUNTED)
    inner = np.where(counts[a] & possible, own[a] - np.where(small, SMALL_COST, STEP_COST), 0.0)
    explained = inner[:, ::-1].cumsum(axis=1)[:, ::-1] - inner
    total, spread = jump[a] + jump[:, None], variance[a] + variance[:, None]
    floor = TOLERANCE**2 + (TOLERANCE_SHARE * np.maximum(size[a], size[:, None])) ** 2
    options = [_closing(total, spread + floor)]
    for (sum_d, sum_v), extra in zip(
        before, (FOLLOW_COST, FOLLOW_COST + FOLLOW_ALL_COST), strict=True
    ):
        between = sum_d[start][:, None] - sum_d[stop[a]]
        more = np.maximum(sum_v[start][:, None] - sum_v[stop[a]], 0.0)
        options.append(_closing(total + between, spread + more + floor) + explained - extra)
    values = np.stack(options)
    length = (start[:, None] - start[a]).clip(0)
    value = values.max(axis=0) + own[a] + own[:, None] - PRIOR
    value = value - LENGTH * np.log1p(length / LENGTH_FRAMES)
    gain = np.where(possible, value, -np.inf)
    follows = values.argmax(axis=0).astype(np.int8)
    return PairTable(chosen, low, high, start, stop, size, own, gain, follows)


def _closing(residual: Array, variance: Array) -> Array:
    """Log of how much likelier a sum is ≡ 0 than just anything on the circle."""
    sigma = np.sqrt(variance)
    return np.log(2.0 * np.pi / (2.5 * sigma)) - residual_cost(wrap(residual) / sigma, CLOSING_CAP)


def best_pairs(table: PairTable, tau: float, fps: float) -> list[Pair]:
    """The set of disjoint intervals of highest total gain among edges of at least τ radians."""
    at = np.flatnonzero(table.size >= tau)
    n, band = len(at), table.gain.shape[1]
    if not n:
        return []
    start, stop, own = table.start[at], table.stop[at], table.own[at]
    order = np.argsort(stop, kind="stable")
    ends = stop[order]
    ready = np.searchsorted(ends, start, side="right")  # edges that end before this one starts
    short = round(SHORT_SECONDS * fps)
    best = np.zeros(n + 1)
    back: list[tuple[int, int] | None] = [None] * (n + 1)  # (closing, opening or −1)
    for m, j in enumerate(order):
        best[m + 1] = best[m]
        if stop[j] - 1 - table.low <= short and own[j] - BORDER_PRIOR > best[m + 1]:
            best[m + 1], back[m + 1] = own[j] - BORDER_PRIOR, (int(j), -1)
        first = int(np.searchsorted(at, at[j] - band))
        if first == j:
            continue
        value = table.gain[at[j], at[first:j] - at[j] + band] + best[np.minimum(ready[first:j], m)]
        k = int(value.argmax())
        if value[k] > best[m + 1]:
            best[m + 1], back[m + 1] = value[k], (int(j), first + k)
    out: list[Pair] = []
    m = n
    tail = own - BORDER_PRIOR + best[ready]
    tail[table.high - start > short] = -np.inf
    if tail.max() > best[n]:
        j = int(tail.argmax())
        out.append(Pair(table.edges[at[j]], None, LEVEL, float(own[j] - BORDER_PRIOR)))
        m = int(ready[j])
    while m > 0:
        entry = back[m]
        if entry is None:
            m -= 1
            continue
        j, a = entry
        closing = table.edges[at[j]]
        if a < 0:
            out.append(Pair(None, closing, LEVEL, float(own[j] - BORDER_PRIOR)))
            break
        cell = int(at[j]), int(at[a] - at[j] + band)
        out.append(
            Pair(table.edges[at[a]], closing, int(table.follows[cell]), float(table.gain[cell]))
        )
        m = int(ready[a])
    return out[::-1]


def unpaired(table: PairTable, pairs: Sequence[Pair], tau: float) -> list[Pair]:
    """Clear jumps that no interval explains, each as its shorter side of the segment."""
    taken = np.zeros(table.high + 1, dtype=bool)
    for pair in pairs:
        first = pair.opening.start if pair.opening else table.low
        last = pair.closing.stop if pair.closing else table.high
        taken[first:last] = True
    out = []
    for k in np.flatnonzero((table.size >= tau) & (table.own >= OPEN_GAIN)):
        edge = table.edges[k]
        if taken[edge.start : edge.stop].any() or not edge.primary:
            continue
        before = edge.stop - 1 - table.low <= table.high - edge.start
        out.append(Pair(None if before else edge, edge if before else None, LEVEL, edge.gain))
    return out


def offset_of(
    pair: Pair, counter: CounterRotation, chain: int, step: Mask, low: int, high: int
) -> tuple[int, Array, float]:
    """Start, twist error of P per frame (radians), and closing residual of an interval.

    The error is the running sum of its steps; what is left at the end is shared by variance.
    """
    opening, closing = pair.opening, pair.closing
    first = opening.start if opening else low + 1
    last = closing.stop if closing else high
    d, variance = counter.d[chain, first:last], counter.sigma[chain, first:last] ** 2
    used = np.zeros(last - first, dtype=bool)
    if opening and closing and pair.follows != LEVEL:
        used = step[first:last].copy() if pair.follows == STEPS else ~used
    jumps, spread = np.where(used, d, 0.0), np.where(used, variance, 0.0)
    for edge in (opening, closing):
        if edge is None:
            continue
        at = slice(edge.start - first, edge.stop - first)
        width = edge.stop - edge.start
        jumps[at] = d[at] + wrap(edge.jump - d[at].sum()) / width
        spread[at] = edge.sigma**2 / width
    if opening is None:
        # δ(t) = −(jumps still to come)
        offset = -jumps[::-1].cumsum()[::-1]
        return low, wrap(offset), 0.0
    residual = 0.0
    if closing is not None:
        residual = float(wrap(jumps.sum()))
        jumps = jumps - residual * spread / spread.sum()
    offset = wrap(jumps.cumsum())
    return first, offset if closing is None else offset[:-1], residual
