"""Compute the offset of each interval in every frame from its jumps [Method, steps 5-6]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.counter_twist.counter_rotation import CounterRotation
from twistcore.detection.counter_twist.edges import LONGEST, SUM_SHARE
from twistcore.detection.counter_twist.pairing import ALL, LEVEL, Pair, PairTable
from twistcore.detection.prediction import Mask
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

# The child is considered to rotate back by only a part of the error if both edges show this: the
# sum of both joints' rotations jumps by NOT_FOLLOWED_SIGMA σ and by the share NOT_FOLLOWED of the
# parent's jump, and the jumps at both edges add up to 0, for the parent and for the sum. The
# longest edges are not used, because they may be parts of softer onsets, which the predictions of
# parent and child follow to different degrees.
NOT_FOLLOWED_SIGMA, NOT_FOLLOWED = 5.0, 0.08
LEAST_FOLLOWED = 0.3  # if the child rotates back by a smaller share, the parent jumps alone
# Tolerance for jumps that add up to 0: in σ, as a share of the larger jump, and as an angle.
CLOSES_SIGMA, CLOSES_SHARE, CLOSES = 4.0, 0.05, float(np.radians(0.05))


@dataclass(frozen=True, eq=False)
class Course:
    """The twist error of an interval over time, from frame `start` on.

    Attributes
    ----------
    offset
        The twist error of the parent in each frame, radians, shape (frames,).
    residual
        The angle that remains after the last edge, radians.
    followed
        The fraction of the error by which the child rotates back. It is less than 1 only if both
        edges show this.
    """

    start: int
    offset: Array
    residual: float
    followed: float = 1.0


def interval_twist_errors_over_time(
    pairs: Sequence[Pair], table: PairTable, counter: CounterRotation, chain: int, step: Mask
) -> list[Course]:
    """Return the twist error of each interval over time.

    The error is the running sum of the interval's steps. The angle that remains at the end is
    distributed over the steps in proportion to their variance. If the child rotates back by only a
    part of the error, the size of the error is measured at the jumps of the parent alone.

    Parameters
    ----------
    pairs
        The intervals, as pairs of edges of `table`.
    table
        The table of a segment.
    counter
        The counter-rotation.
    chain
        The row of the chain in `counter`.
    step
        Mask of the frames in which the offset may change, shape (frames,).
    """
    d, variance = counter.d[chain], counter.sigma[chain] ** 2
    closed = [p for p in pairs if p.opening >= 0 and p.closing >= 0]
    courses = _closed(closed, table, d, variance, step)
    found = {
        p: _measured_at_parent(course, p, table, counter, chain)
        for p, course in zip(closed, courses, strict=True)
    }
    return [found[p] if p in found else _unclosed(p, table, d) for p in pairs]


def _measured_at_parent(
    course: Course, pair: Pair, table: PairTable, counter: CounterRotation, chain: int
) -> Course:
    """Return an error with its size measured at the jumps of the parent alone.

    The error is returned unchanged unless the child clearly rotates back by only a part of it.
    """
    edges = table.edges
    at = [slice(int(edges.start[k]), int(edges.stop[k])) for k in pair[:2]]
    x, y = (np.array([r[chain, a].sum() for a in at]) for r in (counter.rx, counter.ry))
    # Reverse the sign at the second edge: the values are equal if the jumps add up to 0.
    x[1], y[1] = -x[1], -y[1]
    apart = wrap(x + y)
    child = wrap(-y)
    parent = child + apart
    share = SUM_SHARE[[a.stop - a.start for a in at]]
    sigma_x, sigma_y = (
        share * [s[chain, a].sum() for a in at] for s in (counter.sigma_x, counter.sigma_y)
    )
    sigma = np.hypot(sigma_x, sigma_y)
    size = np.abs(parent)
    if (
        not size.all()  # if P does not move, C cannot rotate back
        or max(a.stop - a.start for a in at) >= LONGEST
        or (child * parent < LEAST_FOLLOWED * parent**2).any()
        or (apart * parent < NOT_FOLLOWED * parent**2).any()
        or (np.abs(apart) < NOT_FOLLOWED_SIGMA * sigma).any()
        or not _alike(parent, sigma_x, size)
        or not _alike(apart, sigma, size)
    ):
        return course
    weight = sigma_x**-2.0 / (sigma_x**-2.0).sum()
    level = float(weight @ parent)
    weight = sigma_y**-2.0 / (sigma_y**-2.0).sum()
    followed = float(weight @ child) / level
    steady = float(child[0] + wrap(edges.jump[pair.opening] - child[0]))
    offset = steady + wrap(course.offset - steady)
    return Course(course.start, wrap(offset * (level / steady)), course.residual, followed)


def _alike(values: Array, sigma: Array, size: Array) -> bool:
    """Return True if the values at both edges are equal within the tolerance.

    `sigma` contains the scales of both values, and `size` the sizes of the parent's jumps.
    """
    allowed = CLOSES_SIGMA * np.hypot(*sigma) + CLOSES_SHARE * size.max() + CLOSES
    return bool(abs(values[0] - values[1]) <= allowed)


def _closed(
    pairs: Sequence[Pair], table: PairTable, d: Array, variance: Array, step: Mask
) -> list[Course]:
    """Return the errors of intervals with two edges, computed together in one array.

    `d` is the counter-rotation of the chain and `variance` its variance, both (frames,).
    """
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
        Course(start, offset[a : a + n - 1], left)
        for start, a, n, left in zip(
            first.tolist(), begin.tolist(), length.tolist(), residual.tolist(), strict=True
        )
    ]


def _unclosed(pair: Pair, table: PairTable, d: Array) -> Course:
    """Return the error of an interval with one edge, between the edge and a border of the segment.

    The error is constant between the edge and the border.
    """
    edges, k = table.edges, max(pair.opening, pair.closing)
    start, stop = int(edges.start[k]), int(edges.stop[k])
    jumps = d[start:stop] + wrap(edges.jump[k] - d[start:stop].sum()) / (stop - start)
    if stop - start == 1:  # the same value in all frames, which may be most of a long clip
        first, length = (start, table.high - start) if pair.opening >= 0 else (table.low, 0)
        length = length or stop - 1 - table.low
        level = jumps if pair.opening >= 0 else -jumps
        return Course(first, np.broadcast_to(wrap(level), length), 0.0)
    if pair.opening < 0:
        offset = np.zeros(stop - 1 - table.low)
        rest = -jumps[::-1].cumsum()[::-1]  # the negative sum of the remaining jumps
        offset[:] = rest[0]
        offset[start - 1 - table.low :] = rest
        return Course(table.low, wrap(offset), 0.0)
    offset = np.zeros(table.high - start)
    offset[: stop - start] = jumps.cumsum()
    offset[stop - start :] = offset[stop - start - 1]
    return Course(start, wrap(offset), 0.0)
