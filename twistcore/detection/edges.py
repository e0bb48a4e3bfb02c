"""Edges: frames or short runs of frames in which an error sets in or ends [MATH.md §4.4]."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cost import residual_cost
from twistcore.detection.counter import SIGNIFICANT, CounterRotation, combine
from twistcore.detection.prediction import Mask
from twistcore.rotation import Array, wrap

LONGEST = 6  # frames; slower onsets are drift, not edges
ALONE = float(np.radians(75.0))  # a jump this large in one frame is no part of a ramp
# Errors of prediction hang together over a run, but not wholly: σ of the sum of w frames over the
# sum of their σ, measured on blocks of w frames of CMU clips (w = 1…6).
SUM_SHARE = (1.0, 1.0, 0.8, 0.77, 0.73, 0.7, 0.68)
DIFFERENT = 3.0  # σ by which x and −y differ before each becomes a reading of its own
WORTH = 1.0  # gain below which a reading explains nothing: a jump that the other signal denies
FOLLOWED = 6.0  # gain from which the frames of a run count as steps of the error


@dataclass(frozen=True, slots=True)
class Edge:
    """One reading of an edge: frames [start, stop), the jump in radians, and its standing.

    gain: how much cheaper 'an error jumps here' is than 'natural motion', in nats; primary: the
    best reading of its frames, the one that counts among the inner steps of an interval.
    """

    start: int
    stop: int
    peak: int
    jump: float
    sigma: float
    gain: float
    primary: bool


def find_edges(counter: CounterRotation, chain: int) -> tuple[tuple[Edge, ...], Mask]:
    """All readings of all edges of a chain, by start; and the frames that are steps, (frames,)."""
    d, event = counter.d[chain], counter.event[chain]
    large = np.abs(d) > SIGNIFICANT * counter.sigma[chain]
    seen = event | counter.lone[chain]
    # Runs of one sign, agreed or not: in a ramp a natural jump may hide the agreement of a frame.
    # Where agreement splits such a run, its pieces are readings too.
    wide = list(_runs(seen | large, large, d))
    narrow = [run for run in _runs(seen, event, d) if run not in set(wide)]
    step = event.copy()
    edges: list[Edge] = []
    for runs, primary in ((wide, True), (narrow, False)):
        for run, readings in zip(runs, _readings(counter, chain, runs), strict=True):
            peak = run[0]
            if run[1] - run[0] > 1:
                peak += int(np.abs(d[run[0] : run[1]]).argmax())
            edges += [
                Edge(*run, peak, *reading, primary and n == 0) for n, reading in enumerate(readings)
            ]
            if primary and readings[0][2] > FOLLOWED:
                step[run[0] : run[1]] = True
    return tuple(sorted(edges, key=lambda e: (e.start, e.stop))), step


def _runs(seen: Mask, kind: Mask, d: Array) -> Iterator[tuple[int, int]]:
    """Runs [start, stop) of seen frames of one sign and kind, at most LONGEST long."""
    at = np.flatnonzero(seen)
    if not len(at):
        return
    joins = (np.diff(at) == 1) & (d[at[1:]] * d[at[:-1]] > 0) & (kind[at[1:]] == kind[at[:-1]])
    joins &= (np.abs(d[at[1:]]) < ALONE) & (np.abs(d[at[:-1]]) < ALONE)
    start = 0
    for k in range(1, len(at) + 1):
        if k == len(at) or not joins[k - 1] or k - start >= LONGEST:
            yield int(at[start]), int(at[k - 1]) + 1
            start = k


def _readings(
    counter: CounterRotation, chain: int, runs: list[tuple[int, int]]
) -> list[list[tuple[float, float, float]]]:
    """(jump, σ, gain) of each run: the weighted mean of both signals, or both where they differ."""
    if not runs:
        return []
    bounds = np.array(runs)
    share = np.array(SUM_SHARE)[bounds[:, 1] - bounds[:, 0]]
    x, y = (wrap(_sums(r[chain], bounds)) for r in (counter.rx, counter.ry))
    sigma = share * np.stack([_sums(s[chain], bounds) for s in (counter.sigma_x, counter.sigma_y)])
    mean, apart, sigma_mean, sigma_apart = combine(np.stack([x, y]), sigma)
    differ = np.abs(apart) > DIFFERENT * sigma_apart
    natural = residual_cost(x / sigma[0]) + residual_cost(y / sigma[1])
    jumps = np.stack([mean, x, -y])
    error = residual_cost(wrap(jumps - x) / sigma[0]) + residual_cost(wrap(jumps + y) / sigma[1])
    triples = np.stack([jumps, np.stack([sigma_mean, *sigma]), natural - error], axis=-1).tolist()
    quiet_first = (sigma[0] <= sigma[1]).tolist()
    return [
        [tuple(triples[1 if q else 2][k]), tuple(triples[2 if q else 1][k])]
        if apart_
        else [tuple(triples[0][k])]
        for k, (apart_, q) in enumerate(zip(differ.tolist(), quiet_first, strict=True))
    ]


def _sums(values: Array, bounds: NDArray[np.int64]) -> Array:
    """Sums over frames [start, stop) of each row of bounds (runs, 2)."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(total[bounds[:, 1]] - total[bounds[:, 0]])
