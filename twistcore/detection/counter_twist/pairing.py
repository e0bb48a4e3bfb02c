"""Pair the edges of a chain to form intervals with the highest total gain [Method, steps 5-6].

Gains are log-likelihood ratios of an error over natural motion, in nats. The gain of an interval
consists of the gains of its two edges, of the steps inside that it explains, and of *closing*. An
interval closes if its jumps add up to 0 (modulo a full turn). The gain from closing compares how
likely this sum is for the jumps of an error and for two unrelated jumps. The prior cost of an
interval grows with its length.

The disjoint intervals with the highest total gain are found by dynamic programming over the edges,
in the order of their ends. The gain of an interval does not depend on τ, so it is computed once. A
new τ only selects the edges at which intervals may begin or end.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.counter_twist.counter_rotation import CounterRotation
from twistcore.detection.counter_twist.edges import Edges
from twistcore.detection.prediction import Index, Mask
from twistcore.detection.robust_cost import residual_cost
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

# Prior cost of an interval. In 2.9 minutes of clips with several injected errors, two natural jumps
# add up to 0 by chance with a higher gain.
PRIOR = 20.0
BORDER_PRIOR = 12.0  # prior cost of an interval with only one edge, up to a border of the segment
# An interval costs LENGTH·log(1 + frames / LENGTH_FRAMES), because more coincidences are possible
# in a longer one.
LENGTH, LENGTH_FRAMES = 4.0, 30.0
# A step inside an interval is jitter if it is smaller than this angle and this share of the last
# jump, or smaller than ALWAYS_SMALL: three σ of the difference of two values that jitter by 1°.
# Compared with 3.5°, this raised the success rate on Daz clips from 99.74 to 99.82 % (protocol H4)
# and from 99.50 to 99.73 % (H8+H4), and changed no other.
SMALL_STEP, SMALL_SHARE = float(np.radians(8.0)), 0.4
ALWAYS_SMALL = float(np.radians(4.25))
# Costs of jitter and of other steps inside an interval. The latter cost much, so that intervals do
# not merge.
SMALL_COST, STEP_COST = 8.0, 30.0
COUNTED = float(np.radians(1.5))  # smaller steps inside cost nothing: they cannot be edges
FOLLOW_COST, FOLLOW_ALL_COST = 2.0, 4.0  # costs of STEPS, and additional cost of ALL (see below)
# Tolerance of the sum of jumps in addition to their scales, as an angle and as a share of a jump.
TOLERANCE, TOLERANCE_SHARE = float(np.radians(0.05)), 0.005
CLOSING_CAP = 25.0  # maximum cost of jumps that do not add up to 0
# An unpaired jump is corrected on its shorter side if that side is at most this long, in seconds or
# in frames, whichever is longer, and at most this share of the other side. Only the length
# indicates which side is wrong. Longer intervals remain open.
SHORT_SECONDS, SHORT_FRAMES, SHORT_SHARE = 0.7, 24, 0.5
# An interval with one edge that lasts longer costs this much more.
USUAL_SECONDS, UNUSUAL_COST = 0.25, 4.5
# Minimum ratio of the rest of the segment to the length of an interval; if it is smaller, the two
# ends of the segment may be the errors instead.
SPANNING = 0.125
OPEN_GAIN = 20.0  # minimum gain of an unpaired jump that is reported as an open interval
BAND = 512  # maximum number of edges in an interval
BLOCK = 64  # number of rows of the table that are computed together
SMALLEST = float(np.radians(0.3))  # smaller edges are never used
# Values of `follows`: the offset of an interval changes only at its edges, also at the steps
# inside, or in every frame.
LEVEL, STEPS, ALL = 0, 1, 2


class Pair(NamedTuple):
    """An interval between two edges, or between one edge and a border of the segment.

    Attributes
    ----------
    opening, closing
        The indices of the first and the last edge in the table, −1 for a border.
    follows
        How the offset of the interval is computed (LEVEL, STEPS or ALL).
    gain
        The gain of the interval, in nats.
    """

    opening: int
    closing: int
    follows: int
    gain: float


@dataclass(frozen=True, eq=False)
class Block:
    """A block of the table of gains, with n stored pairs.

    Rows correspond to closing edges, and columns to opening edges. Only gains above 0 are
    stored, since there are few.

    Attributes
    ----------
    first_row, first_column
        The indices of the first closing edge and of the first opening edge.
    shape
        The number of rows and the number of columns.
    at
        The flat indices of the stored pairs, ascending, shape (n,).
    gains
        The gains of these pairs in nats, shape (n,).
    kinds
        The values of `follows` of these pairs, shape (n,).
    """

    first_row: int
    first_column: int
    shape: tuple[int, int]
    at: NDArray[np.int32]
    gains: Array
    kinds: NDArray[np.int8]

    @classmethod
    def of(cls, first_row: int, first_column: int, gain: Array, follows: NDArray[np.int8]) -> Block:
        """Create a block from gains and values of `follows`, both (rows, columns)."""
        at = np.flatnonzero(np.isfinite(gain))
        some = gain.ravel()[at], follows.ravel()[at]
        return cls(first_row, first_column, gain.shape, at.astype(np.int32), *some)

    @property
    def gain(self) -> Array:
        """The gains of all pairs, (rows, columns), with −inf for pairs without a gain."""
        out = np.full(self.shape, -np.inf)
        out.ravel()[self.at] = self.gains
        return out

    @property
    def follows(self) -> NDArray[np.int8]:
        """The value of `follows` for each pair, (rows, columns); LEVEL for pairs without a gain."""
        out = np.zeros(self.shape, dtype=np.int8)
        out.ravel()[self.at] = self.kinds
        return out


@dataclass(frozen=True, eq=False)
class PairTable:
    """The gains of all pairs of edges in a segment, frames [low, high), stored in blocks."""

    edges: Edges
    low: int
    high: int
    blocks: tuple[Block, ...]

    def partners(self, edge: int) -> dict[int, float]:
        """Return the gains of all pairs that include an edge, keyed by the other edge's index."""
        found: dict[int, float] = {}
        for block in self.blocks:
            row, column = edge - block.first_row, edge - block.first_column
            if 0 <= row < block.shape[0]:
                gains = block.gain[row]
                at = np.flatnonzero(np.isfinite(gains))
                found |= zip((at + block.first_column).tolist(), gains[at].tolist(), strict=True)
            if 0 <= column < block.shape[1]:
                gains = block.gain[:, column]
                at = np.flatnonzero(np.isfinite(gains))
                found |= zip((at + block.first_row).tolist(), gains[at].tolist(), strict=True)
        return found


def running_counter_rotation_sums(counter: CounterRotation, chain: int, step: Mask) -> Array:
    """Return the running sums of a chain's counter-rotation d and its variance σ².

    The rows of the result, (4, frames + 1), are the sums of d and σ² over steps and the sums of d
    and σ² over all frames, in radians and radians². The sum at index t excludes frame t. All
    segments of a chain share these sums, because a long clip has hundreds of segments. `step` is
    the mask of the steps, (frames,).
    """
    d, var = counter.d[chain], counter.sigma[chain] ** 2
    sums = np.stack([d * step, var * step, d, var]).cumsum(axis=1)
    return np.concatenate([np.zeros((4, 1)), sums], axis=1)


def edge_pair_table(edges: Edges, sums: Array, low: int, high: int) -> PairTable:
    """Return the gains of all pairs of edges in the segment [low, high).

    `sums` is the result of :func:`running_counter_rotation_sums` for the chain.
    """
    inside = (low < edges.start) & (edges.stop <= high) & (np.abs(edges.jump) >= SMALLEST)
    edges = edges[inside]
    between = sums[:, edges.start], sums[:, edges.stop]
    blocks = tuple(
        _block(edges, between, first, min(first + BLOCK, len(edges)))
        for first in range(0, len(edges), BLOCK)
    )
    return PairTable(edges, low, high, blocks)


def _block(edges: Edges, sums: tuple[Array, Array], first: int, last: int) -> Block:
    """Return the gains of all pairs whose closing edge has an index in [first, last).

    `sums` contains the values of :func:`running_counter_rotation_sums` at the start and at the stop
    of each edge.
    """
    row, begin = slice(first, last), max(0, first - BAND)
    col = slice(begin, last)
    size, variance = np.abs(edges.jump), edges.sigma**2
    # The opening edge must end before the closing edge begins.
    possible = edges.stop[col] <= edges.start[row, None]
    threshold = np.clip(SMALL_SHARE * size[row], ALWAYS_SMALL, SMALL_STEP)
    counts = edges.primary[col] & (size[col] >= COUNTED) & possible
    cost = np.where(size[col] < threshold[:, None], SMALL_COST, STEP_COST)
    inner = (edges.gain[col] - cost) * counts
    explained = inner[:, ::-1].cumsum(axis=1)[:, ::-1] - inner
    own = edges.gain[col] + edges.gain[row, None] - PRIOR
    # The gain from closing is limited by TOLERANCE. Pairs that gain nothing even then are left out.
    at = np.nonzero((own + np.maximum(explained, 0.0) > -_MOST_CLOSING) & possible)
    i, j = at[0] + first, at[1] + begin
    explained = explained[at]
    total, spread = edges.jump[i] + edges.jump[j], variance[i] + variance[j]
    spread += TOLERANCE**2 + (TOLERANCE_SHARE * np.maximum(size[i], size[j])) ** 2
    best = _closing(total, spread)
    follows = np.zeros(len(i), dtype=np.int8)
    at_start, at_stop = sums
    likeliest = np.log(_CIRCLE) - 0.5 * np.log(spread)
    for kind, extra in ((STEPS, FOLLOW_COST), (ALL, FOLLOW_COST + FOLLOW_ALL_COST)):
        # `likeliest` is the highest possible gain from closing for any variance.
        some = np.flatnonzero(likeliest + explained - extra > best)
        k = 2 * (kind - STEPS)
        moved = at_start[k, i[some]] - at_stop[k, j[some]]
        more = np.maximum(at_start[k + 1, i[some]] - at_stop[k + 1, j[some]], 0.0)
        value = _closing(total[some] + moved, spread[some] + more) + explained[some] - extra
        better = value > best[some]
        best[some[better]] = value[better]
        follows[some[better]] = kind
    length = (edges.start[i] - edges.start[j]).clip(0)
    value = best + own[at] - LENGTH * np.log1p(length / LENGTH_FRAMES)
    gain = np.full(possible.shape, -np.inf)
    gain[at] = np.where(value > 0.0, value, -np.inf)
    kinds = np.zeros(possible.shape, dtype=np.int8)
    kinds[at] = follows
    return Block.of(first, begin, gain, kinds)


_CIRCLE = 2.0 * np.pi / 2.5  # √(2π), rounded
_MOST_CLOSING = float(np.log(_CIRCLE / TOLERANCE))


def _closing(residual: Array, variance: Array) -> Array:
    """Return the log-likelihood ratios of jumps that belong to one error over unrelated jumps.

    `residual` contains the sums of the jumps in radians, which are near 0 for an error, and
    `variance` their variances.
    """
    sigma = np.sqrt(variance)
    return np.log(_CIRCLE / sigma) - residual_cost(wrap(residual) / sigma, CLOSING_CAP)


def best_edge_pairs(table: PairTable, tau: float, fps: float) -> list[Pair]:
    """Return the disjoint intervals of a segment with the highest total gain.

    Only edges with a jump of at least `tau` radians are used.
    """
    asked = np.abs(table.edges.jump) >= tau
    at = np.flatnonzero(asked)
    n = len(at)
    if not n:
        return []
    chosen = table.edges[at]
    order = np.argsort(chosen.stop, kind="stable")
    ready_ = np.searchsorted(chosen.stop[order], chosen.start, side="right")
    from_low, from_high = _alone(table, chosen, fps)
    ready, alone = ready_.tolist(), from_low.tolist()  # ready: edges that end before this one
    candidates = _candidates(table, asked, _longest_alone(fps))
    best = [0.0] * (n + 1)
    back: list[Pair | None] = [None] * (n + 1)
    rank = (np.cumsum(asked) - 1).tolist()
    for m, k in enumerate(order.tolist()):
        top, pair = best[m], None
        if alone[k] > top:
            top, pair = alone[k], Pair(-1, int(at[k]), LEVEL, alone[k])
        for found in candidates[k]:
            value = found.gain + best[min(ready[rank[found.opening]], m)]
            if value > top:
                top, pair = value, found
        best[m + 1], back[m + 1] = top, pair
    out: list[Pair] = []
    m = n
    tail = from_high + np.array(best)[ready_]
    if tail.max() > best[n]:
        k = int(tail.argmax())
        out.append(Pair(int(at[k]), -1, LEVEL, float(from_high[k])))
        m = ready[k]
    while m > 0:
        pair = back[m]
        if pair is None:
            m -= 1
            continue
        out.append(pair)
        m = ready[rank[pair.opening]] if pair.opening >= 0 else 0
    return out[::-1]


def _alone(table: PairTable, edges: Edges, fps: float) -> tuple[Array, Array]:
    """Return the gains of intervals between one edge and the start or the end of the segment.

    The first array contains the gains for the start, and the second for the end. Both have the
    shape (n,) for n edges. The gain is −inf for an interval that is long or not much shorter than
    the rest of the segment.
    """
    before, behind = edges.stop - 1 - table.low, table.high - edges.start
    longest = _longest_alone(fps)
    gains = []
    for side, other in ((before, behind), (behind, before)):
        short = (side <= longest) & (side <= SHORT_SHARE * other)
        gain = _gain_alone(edges, side) - UNUSUAL_COST * (side > round(USUAL_SECONDS * fps))
        gains.append(np.where(short, gain, -np.inf))
    return gains[0], gains[1]


def _gain_alone(edges: Edges, side: Index) -> Array:
    """Return the gains of intervals between n edges and a border, (n,).

    `side` contains the number of frames between each edge and the border.
    """
    gain: Array = edges.gain - BORDER_PRIOR - LENGTH * np.log1p(side / LENGTH_FRAMES)
    return gain


def _longest_alone(fps: float) -> int:
    """Return the maximum length of an interval with one edge that is corrected, in frames."""
    return max(SHORT_FRAMES, round(SHORT_SECONDS * fps))


def _candidates(table: PairTable, asked: Mask, longest: int) -> list[list[Pair]]:
    """Return, for each selected closing edge, the pairs that may be chosen.

    A pair is omitted if a shorter pair with the same closing edge has the same or a higher gain. A
    pair is also omitted if it covers nearly the whole segment, or if it covers most of the segment
    while two errors at the ends of the segment gain more.

    Parameters
    ----------
    table
        The table of the segment.
    asked
        Mask of the selected edges.
    longest
        The maximum length in frames of an error at an end of the segment.
    """
    out: list[list[Pair]] = []
    edges, whole = table.edges, table.high - table.low
    before, behind = edges.stop - 1 - table.low, table.high - edges.start
    early, late = before <= longest, behind <= longest
    from_low, from_high = _gain_alone(edges, before), _gain_alone(edges, behind)
    for block in table.blocks:
        rows = np.flatnonzero(asked[block.first_row : block.first_row + block.shape[0]])
        columns = np.flatnonzero(asked[block.first_column :][: block.shape[1]])
        gain = block.gain[np.ix_(rows, columns)]
        if late[rows + block.first_row].any() and early[columns + block.first_column].any():
            closing, opening = rows[:, None] + block.first_row, columns + block.first_column
            inside = edges.start[closing] - edges.start[opening]
            apart = from_low[opening] + from_high[closing]
            share = np.where(gain < apart, SHORT_SHARE, SPANNING)
            spans = late[closing] & early[opening] & (whole - inside <= share * inside)
            gain[spans] = -np.inf
        nearer = np.maximum.accumulate(gain[:, ::-1], axis=1)[:, ::-1]
        record = np.isfinite(gain)
        record[:, :-1] &= gain[:, :-1] > nearer[:, 1:]
        i, j = np.nonzero(record)
        values = gain[i, j].tolist()
        follows = block.follows[rows[i], columns[j]].tolist()
        openings = (columns[j] + block.first_column).tolist()
        closings = (rows + block.first_row).tolist()
        own: list[list[Pair]] = [[] for _ in closings]
        for row, opening, kind, value in zip(i.tolist(), openings, follows, values, strict=True):
            own[row].append(Pair(opening, closings[row], kind, value))
        out += own
    return out


def one_ended_jump_intervals(table: PairTable, pairs: Sequence[Pair], tau: float) -> list[Pair]:
    """Return the clear jumps of a segment outside all intervals, as intervals with one edge.

    Each interval is on the shorter side of its jump. `pairs` contains the chosen intervals, and
    `tau` is the threshold in radians.
    """
    edges = table.edges
    clear = (np.abs(edges.jump) >= tau) & (edges.gain >= OPEN_GAIN) & edges.primary
    out: list[Pair] = []
    if not clear.any():
        return out
    taken = np.zeros(table.high + 1, dtype=bool)
    for pair in pairs:
        first = edges.start[pair.opening] if pair.opening >= 0 else table.low
        last = edges.stop[pair.closing] if pair.closing >= 0 else table.high
        taken[first:last] = True
    known = np.concatenate([[0], np.cumsum(taken)])
    clear &= known[edges.stop] == known[edges.start]
    for k in np.flatnonzero(clear).tolist():
        before = edges.stop[k] - 1 - table.low <= table.high - edges.start[k]
        gain = float(edges.gain[k])
        out.append(Pair(-1, k, LEVEL, gain) if before else Pair(k, -1, LEVEL, gain))
    return out
