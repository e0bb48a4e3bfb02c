"""Edges: short runs of frames in which an error begins or ends [Method, step 5]."""

from __future__ import annotations

import numpy as np

from twistcore.detection.counter_twist.counter_rotation import SIGNIFICANT, CounterRotation, combine
from twistcore.detection.prediction import Index, Mask
from twistcore.detection.robust_cost import residual_cost
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

LONGEST = 6  # frames; slower onsets are drift, not edges
ALONE = float(np.radians(75.0))  # a jump this large in one frame is not part of a ramp
# Errors of prediction are correlated over a run, but not fully: σ of the sum of w frames over the
# sum of their σ, measured on blocks of w frames of CMU clips (w = 1…6).
SUM_SHARE = np.array([1.0, 1.0, 0.8, 0.77, 0.73, 0.7, 0.68])
DIFFERENT = 3.0  # σ by which x and −y must differ to be interpreted separately
FOLLOWED = 6.0  # gain from which the frames of a run count as steps of the error


@dataclass(frozen=True, eq=False)
class Edges:
    """The possible edges of a chain, sorted by start.

    The same frames can be interpreted as different edges, so edges may overlap.

    All arrays have the shape (n,).

    Attributes
    ----------
    start, stop
        The edge's frames [start, stop).
    peak
        The frame in which the error changes most.
    jump
        The angle by which the error changes over the edge, in radians.
    sigma
        The scale of the jump.
    gain
        The log-likelihood ratio of an error over natural motion, in nats.
    primary
        True for the best interpretation of these frames. Other interpretations of an edge inside an
        interval are not counted.
    """

    start: Index
    stop: Index
    peak: Index
    jump: Array
    sigma: Array
    gain: Array
    primary: Mask

    def __len__(self) -> int:
        return len(self.start)

    def __getitem__(self, at: Index | Mask) -> Edges:
        """Return the edges selected by an index array or a mask."""
        return Edges(*(column[at] for column in vars(self).values()))


def find_edges(counter: CounterRotation, chain: int) -> tuple[Edges, Mask]:
    """Return all possible edges of a chain, and a mask of the frames with a step, (frames,)."""
    d, event = counter.d[chain], counter.event[chain]
    size = np.abs(d)
    seen = np.flatnonzero(event | counter.lone[chain])
    large = size > SIGNIFICANT * counter.sigma[chain]
    # Runs of one sign, whether or not both signals agree: in a ramp, a natural jump may hide the
    # agreement in a frame. If frames without agreement split such a run, the pieces are further
    # interpretations.
    seen_or_large = np.flatnonzero(event | counter.lone[chain] | large)
    wide = _runs(seen_or_large, large, d)
    narrow = _runs(seen, event, d)
    key = LONGEST + 2
    known = np.append(wide @ (1, key), np.iinfo(np.int64).max)  # in ascending order
    asked = narrow @ (1, key)
    narrow = narrow[known[np.searchsorted(known, asked)] != asked]
    bounds = np.concatenate([wide, narrow])
    run, jump, sigma, gain, first = _readings(counter, chain, bounds)
    start, stop = bounds[run].T
    edges = Edges(
        start, stop, _peaks(size, bounds)[run], jump, sigma, gain, first & (run < len(wide))
    )
    step = event.copy()
    followed = edges[edges.primary & (gain > FOLLOWED)]
    for k in range(LONGEST):
        step[np.minimum(followed.start + k, followed.stop - 1)] = True
    return edges[np.lexsort((stop, start))], step


def _runs(at: Index, kind: Mask, d: Array) -> Index:
    """Return runs [start, stop) of consecutive frames with the same sign and kind, (n, 2).

    `at` contains the frames to examine. A run has at most LONGEST frames.
    """
    d, kind = d[at], kind[at]
    joins = np.zeros(len(at), dtype=bool)
    joins[1:] = (np.diff(at) == 1) & (d[1:] * d[:-1] > 0) & (kind[1:] == kind[:-1])
    joins[1:] &= (np.abs(d[1:]) < ALONE) & (np.abs(d[:-1]) < ALONE)
    place = np.arange(len(at))
    place -= np.maximum.accumulate(np.where(joins, 0, place))
    begins = np.flatnonzero(place % LONGEST == 0)
    ends = np.append(begins[1:], len(at)) - 1
    return np.stack([at[begins], at[ends[: len(begins)]] + 1], axis=1)


def _peaks(size: Array, bounds: Index) -> Index:
    """Return the frame with the largest size in each run, or the first if several are equal."""
    peak = bounds[:, 0].copy()
    for k in range(1, LONGEST):
        at = np.minimum(bounds[:, 0] + k, bounds[:, 1] - 1)
        peak = np.where(size[at] > size[peak], at, peak)
    return peak


def _readings(
    counter: CounterRotation, chain: int, bounds: Index
) -> tuple[Index, Array, Array, Array, Mask]:
    """Return the possible interpretations of runs of frames as edges.

    The result consists of five arrays: the index of the run, the jump, its σ, its gain, and True
    for the first interpretation of a run. A run is interpreted as the weighted mean of both
    signals. If the signals differ, it is interpreted as each of them instead, the quieter one
    first.
    """
    share = SUM_SHARE[bounds[:, 1] - bounds[:, 0]]
    x, y = (wrap(_sums(r[chain], bounds)) for r in (counter.rx, counter.ry))
    sigma = share * np.stack([_sums(s[chain], bounds) for s in (counter.sigma_x, counter.sigma_y)])
    mean, apart, sigma_mean, sigma_apart = combine(np.stack([x, y]), sigma)
    differ = np.abs(apart) > DIFFERENT * sigma_apart
    natural = residual_cost(x / sigma[0]) + residual_cost(y / sigma[1])
    jumps = np.stack([mean, x, -y])
    error = residual_cost(wrap(jumps - x) / sigma[0]) + residual_cost(wrap(jumps + y) / sigma[1])
    noisier = (sigma[0] > sigma[1]).astype(np.int64)
    run = np.repeat(np.arange(len(bounds)), 1 + differ)
    first = np.ones(len(run), dtype=bool)
    first[1:] = run[1:] != run[:-1]
    which = np.where(differ[run], 1 + np.where(first, noisier[run], 1 - noisier[run]), 0)
    sigmas = np.stack([sigma_mean, *sigma])
    return run, jumps[which, run], sigmas[which, run], (natural - error)[which, run], first


def _sums(values: Array, bounds: Index) -> Array:
    """Return the sum of the values over the frames of each run, (runs,).

    `bounds` contains the runs [start, stop), shape (runs, 2).
    """
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(total[bounds[:, 1]] - total[bounds[:, 0]])
