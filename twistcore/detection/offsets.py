"""Offsets of paired edges: the running sum of an interval's jumps, closed [MATH.md §4.5-4.7]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.counter_rotation import CounterRotation
from twistcore.detection.pairing import ALL, LEVEL, Pair, PairTable
from twistcore.detection.prediction import Mask
from twistcore.rotation import Array, wrap


def offsets_of(
    pairs: Sequence[Pair], table: PairTable, counter: CounterRotation, chain: int, step: Mask
) -> list[tuple[int, Array, float]]:
    """Start, twist error of P per frame (radians), and closing residual of each interval.

    The error is the running sum of its steps; what is left at the end is shared by variance.
    """
    d, variance = counter.d[chain], counter.sigma[chain] ** 2
    closed = [p for p in pairs if p.opening >= 0 and p.closing >= 0]
    found = dict(zip(closed, _closed(closed, table, d, variance, step), strict=True))
    return [found[p] if p in found else _unclosed(p, table, d) for p in pairs]


def _closed(
    pairs: Sequence[Pair], table: PairTable, d: Array, variance: Array, step: Mask
) -> list[tuple[int, Array, float]]:
    """All intervals with two edges, their frames strung together in one array."""
    if not pairs:
        return []
    edges = table.edges
    opening, closing, kind = np.array([p[:3] for p in pairs]).T
    first, last = edges.start[opening], edges.stop[closing]
    length = last - first
    begin = np.cumsum(length) - length
    of = np.repeat(np.arange(len(pairs)), length)
    place = np.arange(len(of)) - begin[of]
    frame = first[of] + place
    total = np.concatenate([[0.0], np.cumsum(d)])
    used = (kind[of] == ALL) | ((kind[of] != LEVEL) & step[frame])
    jumps, spread = d[frame] * used, variance[frame] * used
    for edge, inside in (
        (opening, frame < edges.stop[opening][of]),
        (closing, frame >= edges.start[closing][of]),
    ):
        width = edges.stop[edge] - edges.start[edge]
        missing = edges.jump[edge] - (total[edges.stop[edge]] - total[edges.start[edge]])
        here = of[inside]
        jumps[inside] = d[frame[inside]] + (wrap(missing) / width)[here]
        spread[inside] = (edges.sigma[edge] ** 2 / width)[here]
    residual = wrap(np.add.reduceat(jumps, begin))
    jumps -= (residual / np.add.reduceat(spread, begin))[of] * spread
    offset = jumps.cumsum()
    offset = wrap(offset - (offset[begin] - jumps[begin])[of])
    return [
        (start, offset[a : a + n - 1], left)
        for start, a, n, left in zip(
            first.tolist(), begin.tolist(), length.tolist(), residual.tolist(), strict=True
        )
    ]


def _unclosed(pair: Pair, table: PairTable, d: Array) -> tuple[int, Array, float]:
    """An interval from or to a border: the level before or after its one edge."""
    edges, k = table.edges, max(pair.opening, pair.closing)
    start, stop = int(edges.start[k]), int(edges.stop[k])
    jumps = d[start:stop] + wrap(edges.jump[k] - d[start:stop].sum()) / (stop - start)
    if pair.opening < 0:
        offset = np.zeros(stop - 1 - table.low)
        rest = -jumps[::-1].cumsum()[::-1]  # δ(t) = −(jumps still to come)
        offset[:] = rest[0]
        offset[start - 1 - table.low :] = rest
        return table.low, wrap(offset), 0.0
    offset = np.zeros(table.high - start)
    offset[: stop - start] = jumps.cumsum()
    offset[stop - start :] = offset[stop - start - 1]
    return start, wrap(offset), 0.0
