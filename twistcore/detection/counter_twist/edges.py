"""Find edges: short runs of frames in which an error may begin or end [Method, step 5]."""

from __future__ import annotations

import numpy as np

from twistcore.detection.counter_twist.counter_rotation import (
    SIGNIFICANT,
    CounterRotation,
    combine_counter_rotation_residuals,
)
from twistcore.detection.prediction import Index, Mask
from twistcore.detection.robust_cost import residual_cost
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

LONGEST = 6  # maximum length of an edge in frames; a slower onset is drift
ALONE = float(np.radians(75.0))  # a jump of at least this angle in one frame is not part of a ramp
# The ratio of σ of a sum over w frames to the sum of their σ, for w = 0…6. The errors of prediction
# are only partly correlated. Measured on blocks of w frames of CMU clips.
SUM_SHARE = np.array([1.0, 1.0, 0.8, 0.77, 0.73, 0.7, 0.68])
DIFFERENT = 3.0  # in σ; if parent and child differ more, their rotations are used separately
FOLLOWED = 6.0  # nats: minimum gain of an edge whose frames are all steps of the error


@dataclass(frozen=True, eq=False)
class Edges:
    """The n possible edges of a chain, sorted by start.

    The same frames can be interpreted as different edges, so edges may overlap. All arrays have the
    shape (n,).

    Attributes
    ----------
    start, stop
        The edge's frames [start, stop).
    peak
        The frame in which the error changes most.
    jump
        The angle by which the error changes over the edge, in radians.
    sigma
        The scale of the jump, radians.
    gain
        The log-likelihood ratio of an error over natural motion, in nats.
    primary
        True for the best interpretation of the frames. Only these edges count inside an interval.
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


def find_interval_edges_and_steps(counter: CounterRotation, chain: int) -> tuple[Edges, Mask]:
    """Return all possible edges of a chain, and a mask of its steps, (frames,).

    Edges are short runs of frames in which an error may begin or end. Steps are the frames in which
    the offset of an interval may change. `chain` is the row of the chain in the counter-rotation.
    """
    d, event = counter.d[chain], counter.event[chain]
    size = np.abs(d)
    seen = np.flatnonzero(event | counter.lone[chain])
    large = size > SIGNIFICANT * counter.sigma[chain]
    # `wide` contains runs of frames with rotations of one sign, whether or not both joints agree,
    # because a natural jump may hide the agreement in a frame of a ramp. If such a run contains
    # frames without agreement, the pieces between them are further interpretations (`narrow`).
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
    """Return runs [start, stop) of frames in which the sign of d and `kind` are constant, (n, 2).

    `at` contains the frames to examine, `kind` is a mask and `d` is the counter-rotation, both
    (frames,). A run has at most LONGEST frames.
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
    """Return the frame with the largest size in each run, or the first of several equal ones.

    `size` has the shape (frames,), and `bounds` contains the runs [start, stop), shape (runs, 2).
    """
    peak = bounds[:, 0].copy()
    for k in range(1, LONGEST):
        at = np.minimum(bounds[:, 0] + k, bounds[:, 1] - 1)
        peak = np.where(size[at] > size[peak], at, peak)
    return peak


def _readings(
    counter: CounterRotation, chain: int, bounds: Index
) -> tuple[Index, Array, Array, Array, Mask]:
    """Return the possible interpretations of runs of frames as edges.

    The jump of an edge is the weighted mean of the rotations of parent and child. If these differ,
    the run is interpreted twice, once with the rotation of each joint. The joint with the smaller
    scale comes first.

    Returns
    -------
    run : ndarray, shape (n,)
        The index of the run of each interpretation.
    jump, sigma : ndarray, shape (n,)
        The jump and its scale, radians.
    gain : ndarray, shape (n,)
        The log-likelihood ratio of an error over natural motion, in nats.
    first : ndarray, shape (n,)
        True for the first interpretation of a run.
    """
    share = SUM_SHARE[bounds[:, 1] - bounds[:, 0]]
    x, y = (wrap(_sums(r[chain], bounds)) for r in (counter.rx, counter.ry))
    sigma = share * np.stack([_sums(s[chain], bounds) for s in (counter.sigma_x, counter.sigma_y)])
    mean, apart, sigma_mean, sigma_apart = combine_counter_rotation_residuals(
        np.stack([x, y]), sigma
    )
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
