"""The offset of each pair of edges: the running sum of its jumps, which returns to 0.

These are steps 5 and 6 of [Method].
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.counter_twist.counter_rotation import CounterRotation
from twistcore.detection.counter_twist.edges import LONGEST, SUM_SHARE
from twistcore.detection.counter_twist.pairing import ALL, LEVEL, Pair, PairTable
from twistcore.detection.prediction import Mask
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

# C is considered to turn back only a part if both edges show it: x + y jumps there by this many σ
# and by this share of P's jump, and both P's jumps and the jumps of x + y add up to 0. The longest
# edges may be parts of softer onsets, which the predictions of x and y follow to different degrees.
NOT_FOLLOWED_SIGMA, NOT_FOLLOWED = 5.0, 0.08
LEAST_FOLLOWED = 0.3  # with less, one joint jumps alone, which is not a twist error
CLOSES_SIGMA, CLOSES_SHARE, CLOSES = 4.0, 0.05, float(np.radians(0.05))


@dataclass(frozen=True, eq=False)
class Course:
    """The error of an interval in each frame from `start` on.

    Attributes
    ----------
    offset
        The twist error of the parent P in each frame, radians, shape (frames,).
    residual
        The angle that remains after the closing edge, radians.
    followed
        The fraction of the error that the child C turns back; less than 1 only if both edges show
        this.
    """

    start: int
    offset: Array
    residual: float
    followed: float = 1.0


def offsets_of(
    pairs: Sequence[Pair], table: PairTable, counter: CounterRotation, chain: int, step: Mask
) -> list[Course]:
    """Return the error of each interval in every frame.

    The error is the running sum of the interval's steps. The angle that remains at the end is
    distributed over the steps in proportion to their variance. If C turns back only part of the
    error, the size of the error is measured at the jumps of P alone.
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
    """Return the error measured at the jumps of P alone, if C clearly turns back only part of it.

    In all other cases, the error is returned unchanged.
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
        not size.all()  # if P does not move there is nothing for C to follow
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
    """Return True if the values at both edges differ no more than their scales allow.

    `sigma` contains the scales of both values, and `size` contains the sizes of P's jumps.
    """
    allowed = CLOSES_SIGMA * np.hypot(*sigma) + CLOSES_SHARE * size.max() + CLOSES
    return bool(abs(values[0] - values[1]) <= allowed)


def _closed(
    pairs: Sequence[Pair], table: PairTable, d: Array, variance: Array, step: Mask
) -> list[Course]:
    """Return the errors of all intervals with two edges. All are computed in one array."""
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
    """Return the error of an interval that begins or ends at a border and so has only one edge.

    The level of the error is constant between the edge and the border.
    """
    edges, k = table.edges, max(pair.opening, pair.closing)
    start, stop = int(edges.start[k]), int(edges.stop[k])
    jumps = d[start:stop] + wrap(edges.jump[k] - d[start:stop].sum()) / (stop - start)
    if stop - start == 1:  # the same level in all frames, possibly most of a long clip
        first, length = (start, table.high - start) if pair.opening >= 0 else (table.low, 0)
        length = length or stop - 1 - table.low
        level = jumps if pair.opening >= 0 else -jumps
        return Course(first, np.broadcast_to(wrap(level), length), 0.0)
    if pair.opening < 0:
        offset = np.zeros(stop - 1 - table.low)
        rest = -jumps[::-1].cumsum()[::-1]  # δ(t) = −(sum of the remaining jumps)
        offset[:] = rest[0]
        offset[start - 1 - table.low :] = rest
        return Course(table.low, wrap(offset), 0.0)
    offset = np.zeros(table.high - start)
    offset[: stop - start] = jumps.cumsum()
    offset[stop - start :] = offset[stop - start - 1]
    return Course(start, wrap(offset), 0.0)
