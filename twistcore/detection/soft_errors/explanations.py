"""Explain a chain's unnaturally large departure from its natural course by a soft error.

The soft error is either a *free offset* or a *softened level* (see `softened_level`). A free offset
is chosen so that its removal makes u (see `natural_scale`) follow its bridge, the natural course,
exactly.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

from twistcore.detection.soft_errors.local_departures import LocalDepartures
from twistcore.detection.soft_errors.soft_error import SEEN, SoftError
from twistcore.detection.soft_errors.softened_level import (
    KERNELS,
    Level,
    fit_softened_levels,
    guess_softened_level,
    linear_unit_ramp,
    softened_level_curves,
)
from twistcore.detection.soft_errors.surprise import SMALLEST, Surprise
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

# Minimum gain of an error in nats, in its chain and in its limb. Clean motion gains up to 30.
PRIOR = 45.0
LEVEL_PRICE = 8.0  # cost of the four numbers of a softened level, in nats
COVERED = 4.0  # cost of each frame of an offset, in nats per unit of the departures' weight
CLOSE = 3.0  # residuals of more σ add little to the surprise
FREE_AT = 10.0  # a free offset of more σ is exact enough to be used unchanged
LEAST = float(np.radians(2.0))  # smallest error that is found without a silent joint
HOLE = 3  # maximum number of successive frames below the threshold within an error
# The windows that are searched around a seed: multiples of its length, and factors for the parts of
# a window before and after its middle.
WINDOWS = (1.0, 1.3, 1.7, 2.4, 3.5)
SHIFTS = ((1.0, 1.0), (1.6, 0.7), (0.7, 1.6))
MOVES = ((1, 3, 6, 10), (1, 2, 4), (1, 2, 4), (1, 2))  # frames by which ends are moved, by round
# The most likely levels near a seed are fitted. They are chosen from levels of these lengths,
# positions and onsets, relative to the length of the seed. To compare the levels, only spans that
# are longer than AS_LONG times the seed are used, because short spans are misleading if the ends of
# a level are off by a frame. One level is chosen for each factor WIDENED on the scales.
LENGTHS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
PLACES = (-0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45)
ONSETS = (0.2, 0.6)
AS_LONG, WIDENED = 0.6, (1.0, 3.0)
# Levels are searched for at most this multiple of the seed's length, and this number of frames,
# from its middle.
WIDEST, FARTHEST = 3, 96

# The work for an explanation, proportional to processor time: TO_BEGIN plus the number of its
# departures, and LEVELS times as much for softened levels.
TO_BEGIN, LEVELS = 1500, 2

Frames: TypeAlias = tuple[int, int]  # [start, stop)


class Tried(NamedTuple):
    """An offset over a frame range, with its evaluation.

    Attributes
    ----------
    left
        The remaining surprise (see `surprise`) plus the cost of the offset, in nats.
    offset
        The offset in each frame, radians, shape (frames,).
    sigma
        The standard deviation of the offset, radians.
    """

    left: float
    offset: Array
    sigma: float


NONE = Tried(np.inf, np.zeros(0), 0.0)


@dataclass(frozen=True)
class Seed:
    """A span of frames with an unnaturally large departure, at which a search begins.

    Attributes
    ----------
    gain
        The cost in nats of the span's departures as natural motion, which an error could save.
    row
        The row of the chain.
    at
        The index of the span length in `Surprise.at`.
    position
        The position (number) of the span in its :class:`SpanGrid`.
    middle
        The middle frame of the span.
    length
        The length of the span in frames.
    """

    gain: float
    row: int
    at: int
    position: int
    middle: int
    length: int


class Explanations:
    """The possible explanations of a seed (a span with an unnaturally large departure).

    Each explanation is evaluated only once. Free offsets over frames around the seed are evaluated
    immediately, and softened levels on request.
    """

    def __init__(self, surprise: Surprise, place: Seed) -> None:
        self._surprise, self._place = surprise, place
        self._known: dict[Frames, Tried] = {}
        self._free: Tried | None = None
        self._levelled: Tried | None = None
        spans = _proposed(surprise, place)
        if not spans:
            return
        margin = max(min(max(b - a for a, b in spans) // 2, 60), 8)
        reach = min(WIDEST * place.length, FARTHEST)
        low = max(min(min(a for a, _ in spans) - margin, place.middle - reach), 0)
        high = min(max(max(b for _, b in spans) + margin, place.middle + reach), surprise.frames)
        self._low, self._high = low, high
        self._departures = surprise.local_departures(place.row, low, high - low)
        surprise.work += TO_BEGIN + self._departures.u.size
        self._price = COVERED * surprise.weight_per_frame(high - low)
        nothing = np.zeros((1, *self._departures.u.shape), dtype=np.float32)
        self._nothing = float(self._departures.surprise(nothing)[0])
        if self._nothing >= PRIOR:  # nothing can gain more than this
            self._try_free(spans)

    def best(self, fit_below: float) -> SoftError | None:
        """Return the soft error with the lowest cost, or None if no explanation gains enough.

        If the largest value of the best free offset is less than `fit_below` σ, or if that offset
        gains too little, softened levels are fitted as well.
        """
        best = self._free
        if best is None:
            return None
        ratio = float(np.abs(best.offset).max()) / best.sigma
        if ratio < fit_below or self._nothing - best.left < PRIOR:
            if self._levelled is None:
                self._levelled = self._tried_as_level(best, ratio)
            best = self._levelled
        seen = np.flatnonzero(np.abs(best.offset) > SEEN)
        gain = self._nothing - best.left
        if gain < PRIOR or not len(seen):
            return None
        offset = best.offset[seen[0] : seen[-1] + 1]
        if np.abs(offset).max() < LEAST:
            return None
        return SoftError(self._place.row, self._low + int(seen[0]), offset, gain, best.sigma)

    def _within(self, a: int, b: int) -> Frames:
        return max(a, 1), min(b, self._surprise.frames - 1)

    def _try_free(self, spans: set[Frames]) -> None:
        """Evaluate free offsets (of any shape) over frame ranges, and store the best offset."""
        known = self._known
        inner = {self._within(*p) for p in spans}
        self._judge({p for p in inner if p[0] < p[1]})
        if not known:
            return
        for moves in MOVES:
            a, b = min(known, key=lambda p: known[p].left)
            tried = {(a + d * m, b) for m in moves for d in (-1, 1)}
            tried |= {(a, b + d * m) for m in moves for d in (-1, 1)}
            self._judge({self._within(p, q) for p, q in tried if p < q})
        self._free = min(known.values(), key=lambda t: t.left)

    def _judge(self, some: set[Frames]) -> None:
        """Evaluate free offsets (of any shape) over frame ranges that are not yet evaluated."""
        low, high, known = self._low, self._high, self._known
        new = [p for p in sorted(some) if p not in known and low <= p[0] < p[1] <= high]
        if not new:
            return
        ranges = np.array(new)
        offsets, sigmas = self._surprise.free_offsets(self._place.row, ranges, low, high)
        left = self._departures.surprise(self._departures.departures(offsets))
        left += self._price * (ranges[:, 1] - ranges[:, 0])
        for n, frames in enumerate(new):
            known[frames] = Tried(float(left[n]), offsets[n], float(sigmas[n]))

    def _tried_as_level(self, free: Tried, ratio: float) -> Tried:
        """Fit softened levels, and return the one with the lowest cost as a :class:`Tried`.

        A softened level is a constant offset that begins and ends gradually. If the free offset
        `free` is clear and has a lower cost, it is returned instead. `ratio` is the largest value
        of the free offset, in σ.
        """
        near, place, low = self._departures, self._place, self._low
        self._surprise.work += LEVELS * (TO_BEGIN + near.u.size)
        rivals = [free] if ratio >= FREE_AT else []
        starts = [(s, ratio / CLOSE) for s in (guess_softened_level(free.offset),) if s is not None]
        starts += _likely_levels(near, place.length, place.middle - low)
        every = [(start, kernel, coarsest) for start, coarsest in starts for kernel in KERNELS]
        for shape, left in fit_softened_levels(every, near.frames, near.departures, near.residuals):
            rivals.append(Tried(left + LEVEL_PRICE, shape, 0.5 * free.sigma))
            at = low + np.flatnonzero(np.abs(shape) > SEEN)
            if ratio >= FREE_AT and len(at):
                hull = self._within(int(at[0]), int(at[-1]) + 1)
                self._judge({hull})
                rivals.append(self._known.get(hull, rivals[-1]))
        return min(rivals, key=lambda r: r.left, default=NONE)


def _proposed(surprise: Surprise, place: Seed) -> set[Frames]:
    """Return the frame ranges [start, stop) of free offsets that may explain a seed.

    Free offsets have any shape. A seed is a span with an unnaturally large departure.
    """
    half = place.length / 2
    windows = []
    for factor in WINDOWS:
        for before, behind in SHIFTS:
            reach = half * factor + HOLE
            low = int(max(2, place.middle - reach * before))
            high = int(min(surprise.frames - 3, place.middle + reach * behind))
            if high - low >= HOLE:
                windows.append((low, high))
    found: set[Frames] = set()
    if not windows:
        return found
    first, last = min(low for low, _ in windows), max(high for _, high in windows)
    offsets, sigmas = surprise.free_offsets(place.row, np.array(windows), first, last)
    for (low, high), free, sigma in zip(windows, offsets, sigmas.tolist(), strict=True):
        size = np.abs(free[low - first : high - first])
        inner = size[max(0, int(place.middle - half) - low) : int(place.middle + half) - low]
        top = float(inner.max(initial=0.0))
        if top < 0.5 * SMALLEST:
            continue
        for least in (2.0 * sigma, 4.0 * sigma, 0.05 * top, 0.15 * top):
            at = np.flatnonzero(size > min(max(least, SEEN), 0.5 * top))
            gaps = np.flatnonzero(at[1:] - at[:-1] > HOLE).tolist()
            begins, ends = at[[0, *(g + 1 for g in gaps)]], at[[*gaps, -1]]
            for a, b in zip((begins + low).tolist(), (ends + low).tolist(), strict=True):
                meets = a <= place.middle + half and b >= place.middle - half
                if meets and b - a > place.length // 4:
                    found.add((a, b + 1))
    return found


def _likely_levels(near: LocalDepartures, length: int, middle: int) -> list[tuple[Level, float]]:
    """Return the most likely softened levels near a seed, each with a factor for the scales.

    A softened level is a constant offset that begins and ends gradually. For each factor by which
    the scales are widened, the level that explains the departures best is returned. `length` and
    `middle` are the length and the middle frame of the seed, counted from the start of the frame
    range.
    """
    n, shift, onset = (v.ravel() for v in np.meshgrid(length * np.array(LENGTHS), PLACES, ONSETS))
    start = middle + shift * np.maximum(n, length) - 0.5 * n
    levels = np.stack([np.ones_like(n), start, start + n, np.maximum(onset * n, 3.0)], axis=1)
    levels = levels[(start > 0.0) & (start + n < near.frames)]
    if not len(levels):
        return []
    courses = softened_level_curves(levels, linear_unit_ramp, near.frames)
    long = near.longer(AS_LONG * length)
    departures = long.departures(courses)
    found = []
    for wider in WIDENED:
        levels[:, 0] = long.sizes(departures, wider)
        left = long.surprise(levels[:, 0, None, None].astype(np.float32) * departures, wider)
        found.append((Level(*levels[left.argmin()].tolist()), wider))
    return found
