"""Soft errors of limbs: sought where departures are too large, explained at least surprise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from twistcore.detection.prediction import Index, Mask
from twistcore.detection.soft_errors.natural_scale import cost
from twistcore.detection.soft_errors.soft_error import SEEN, SoftError
from twistcore.detection.soft_errors.softened_level import (
    KERNELS,
    Level,
    course,
    fitted,
    guess,
    ramp,
)
from twistcore.detection.soft_errors.stretch import Stretch
from twistcore.detection.soft_errors.surprise import SEED_CAP, SMALLEST, Surprise
from twistcore.rotation import Array

SEED = 18.0  # nats of the three probes of a span
NEAR = 0.8  # of SEED, at another span of the same place
PRIOR = 45.0  # nats that an interval must gain, own and in its limb: clean motion gains up to 30
OF_LIMB = 0.7  # of what an interval gains in its own chain it must gain in its limb
LEVEL_PRICE = 8.0  # of the four numbers of a softened level
COVERED = 4.0  # nats for what a departure costs on average and for leaving it free
CLOSE = 3.0  # σ from which a residual has little more to say
FREE_AT = 10.0  # σ that an offset needs before its course is taken as it is
LEAST = float(np.radians(2.0))  # of an error that is told by natural motion alone
HOLE = 3  # frames below the threshold inside of an interval
WINDOWS = (1.0, 1.3, 1.7, 2.4, 3.5)  # times a span, around it
SHIFTS = ((1.0, 1.0), (1.6, 0.7), (0.7, 1.6))
MOVES = ((1, 3, 6, 10), (1, 2, 4), (1, 2, 4), (1, 2))  # frames by which both ends are tried
# Levels around a seed of which the likeliest are fitted: by its span, their lengths and places; by
# their length, their onsets. They are told by spans nearly as long and longer: short ones tell
# nothing of a level that is not there to the frame.
LENGTHS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
PLACES = (-0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45)
ONSETS = (0.2, 0.6)
AS_LONG, WIDENED = 0.6, (1.0, 3.0)
WIDEST, FARTHEST = 3, 96  # times a seed's span, and frames, in which they are sought
IN_VAIN = 20  # seeds of a limb that nothing explains, one after the other, before it is left


@dataclass(frozen=True)
class Seed:
    """A span that departs too far: rank of the span, its position, its middle frame."""

    gain: float
    row: int
    at: int
    position: int
    middle: int
    length: int


def gains(surprise: Surprise, k: int, rows: Index) -> Array:
    """What the probes of the spans of rank k say against natural motion, (rows, positions)."""
    a = surprise.at[k]
    u = a.u[:, rows]
    size = np.abs(u)
    gain = cost(u / a.spread[:, rows], SEED_CAP).sum(axis=0)
    gain *= (size.max(axis=0) >= SMALLEST) & a.usable
    return np.asarray(gain)


class Search:
    """The soft errors of one limb, found one after the other in a :class:`Surprise`."""

    def __init__(self, surprise: Surprise, limb: list[int]) -> None:
        self._surprise, self._limb = surprise, limb
        self._gain: dict[tuple[int, int], Array] = {}
        self._top: dict[tuple[int, int], Seed | None] = {}
        self._done: dict[int, Mask] = {r: np.zeros(surprise.frames, dtype=bool) for r in limb}
        for row in limb:
            self._update(row)

    def _update(self, row: int) -> None:
        """Gains of a row's spans anew, and the best of each."""
        for k in range(len(self._surprise.at)):
            self._gain[row, k] = gains(self._surprise, k, np.array([row]))[0]
            self._top[row, k] = self._seed(row, k)

    def _seed(self, row: int, k: int, near: tuple[int, int] | None = None) -> Seed | None:
        """The best seed of a span in a row that is not done with, or that near a frame."""
        span = self._surprise.at[k].natural.span
        gain = self._gain[row, k]
        if not len(gain):
            return None
        shift = span.reach + span.length // 2
        middles = span.step * np.arange(len(gain)) + shift
        gain = np.where(self._done[row][middles], 0.0, gain)
        if near is not None:
            gain = np.where((middles >= near[0]) & (middles <= near[1]), gain, 0.0)
        position = int(gain.argmax())
        value = float(gain[position])
        return Seed(value, row, k, position, int(middles[position]), span.length) if value else None

    def run(self) -> list[SoftError]:
        """Soft errors, taken out of the surprise as they are found."""
        found: list[SoftError] = []
        in_vain = 0
        while in_vain < IN_VAIN:
            seeds = [s for s in self._top.values() if s and s.gain > SEED]
            if not seeds:
                break
            top = max(seeds, key=lambda s: (round(s.gain), -s.length))
            best = self._best_of_limb(top)
            if best is None:
                in_vain += 1
                reach = max(2, top.length // 2)
                self._done[top.row][max(top.middle - reach, 0) : top.middle + reach + 1] = True
                for k in range(len(self._surprise.at)):
                    self._top[top.row, k] = self._seed(top.row, k)
                continue
            in_vain = 0
            found.append(best)
            self._take_out(best.row, best.start, best.offset)
            for row in self._surprise.beside(best.row):
                if row in self._done:
                    self._update(row)
        return found

    def _take_out(self, row: int, start: int, offset: Array) -> None:
        self._surprise.take_out(row, start, offset)
        self._surprise.look_again(row, start, start + len(offset))

    def _best_of_limb(self, top: Seed) -> SoftError | None:
        """What explains a seed best, in its own chain or in one whose image it may be."""
        rivals: list[SoftError] = []
        for row in self._surprise.beside(top.row):
            if row not in self._done:
                continue
            places = []
            for k, a in enumerate(self._surprise.at):
                reach = a.natural.span.length // 2 + 2
                place = self._seed(row, k, (top.middle - reach, top.middle + reach))
                if place and place.gain > NEAR * SEED:
                    places.append(place)
            if (found := self._shortest(row, places)) is not None:
                rivals.append(found)
        judged = [(self._gain_of_limb(f), -k) for k, f in enumerate(rivals)]
        if not judged:
            return None
        value, k = max(judged)
        best = rivals[-k]
        # The image of another chain's error is explained at the cost of that chain.
        return best if value > max(PRIOR, OF_LIMB * best.gain) else None

    def _gain_of_limb(self, error: SoftError) -> float:
        """By how much an error, taken out, lowers the surprise of its chain and those beside it."""
        margin = len(error.offset) // 2 + 8
        window = max(error.start - margin, 0), min(error.stop + margin, self._surprise.frames)
        rows = self._surprise.beside(error.row)
        before = sum(self._surprise.of(r, *window) for r in rows)
        self._take_out(error.row, error.start, error.offset)
        after = sum(self._surprise.of(r, *window) for r in rows)
        self._take_out(error.row, error.start, -error.offset)
        return before - after

    def _shortest(self, row: int, places: list[Seed]) -> SoftError | None:
        """Of what explains seeds of shorter and longer spans the first that leaves no other.

        Where each leaves some, as beside another error, what gains most.
        """
        found: list[SoftError] = []
        for place in sorted(places, key=lambda s: s.length):
            one = self._explained(row, place, FREE_AT)
            if one is None:
                continue
            if self._surprise.seed_left(row, one.start, one.offset) < SEED:
                return self._explained(row, place, math.inf) or one
            found.append(one)
        return max(found, key=lambda f: f.gain / math.sqrt(len(f.offset)), default=None)

    def _explained(self, row: int, place: Seed, fit_below: float) -> SoftError | None:
        """The course of an offset in a row that leaves least to be surprised at.

        fit_below: of how many σ an offset is still tried to be a softened level.
        """
        surprise = self._surprise
        spans = self._proposed(row, place)
        if not spans:
            return None
        margin = max(min(max(b - a for a, b in spans) // 2, 60), 8)
        reach = min(WIDEST * place.length, FARTHEST)
        low = max(min(min(a for a, _ in spans) - margin, place.middle - reach), 0)
        high = min(max(max(b for _, b in spans) + margin, place.middle + reach), surprise.frames)
        price = COVERED * surprise.price_of_a_frame(high - low)

        known: dict[tuple[int, int], tuple[float, Array, float]] = {}
        stretch = surprise.stretch(row, low, high - low)
        nothing = float((stretch.residuals(np.zeros((1, high - low))) ** 2).sum())

        def judge(some: set[tuple[int, int]]) -> None:
            new = [p for p in sorted(some) if p not in known and low <= p[0] < p[1] <= high]
            if not new:
                return
            offsets = np.zeros((len(new), high - low))
            sigmas = []
            for n, (a, b) in enumerate(new):
                offsets[n, a - low : b - low], sigma = surprise.free_offset(row, a, b)
                sigmas.append(sigma)
            left = (stretch.residuals(offsets) ** 2).sum(axis=1)
            for n, (a, b) in enumerate(new):
                known[a, b] = float(left[n]) + price * (b - a), offsets[n], sigmas[n]

        inner = {(max(a, 1), min(b, surprise.frames - 1)) for a, b in spans}
        judge({p for p in inner if p[0] < p[1]})
        if not known:
            return None
        for moves in MOVES:
            best = min(known, key=lambda p: known[p][0])
            a, b = best
            tried = {(a + d * m, b) for m in moves for d in (-1, 1)}
            tried |= {(a, b + d * m) for m in moves for d in (-1, 1)}
            judge({(max(p, 1), min(q, surprise.frames - 1)) for p, q in tried if p < q})
        a, b = min(known, key=lambda p: known[p][0])
        value, offset, sigma = known[a, b]
        ratio = float(np.abs(offset).max()) / sigma
        if ratio < fit_below or nothing - value < PRIOR:
            rivals = [(value, offset, sigma)] if ratio >= FREE_AT else []
            starts = [(s, ratio / CLOSE) for s in (guess(offset),) if s is not None]
            starts += _likely_levels(stretch, place.length, place.middle - low)
            for start, coarsest in starts:
                for kernel in KERNELS:
                    shape, left = fitted(
                        start,
                        kernel,
                        high - low,
                        stretch.residuals,
                        coarsest,
                    )
                    rivals.append((left + LEVEL_PRICE, shape, 0.5 * sigma))
                    at = low + np.flatnonzero(np.abs(shape) > SEEN)
                    if ratio >= FREE_AT and len(at):
                        hull = max(int(at[0]), 1), min(int(at[-1]) + 1, surprise.frames - 1)
                        judge({hull})
                        rivals.append(known.get(hull, rivals[-1]))
            if not rivals:
                return None
            value, offset, sigma = min(rivals, key=lambda r: r[0])
        seen = np.flatnonzero(np.abs(offset) > SEEN)
        if nothing - value < PRIOR or not len(seen):
            return None
        offset = offset[seen[0] : seen[-1] + 1]
        if np.abs(offset).max() < LEAST:
            return None
        return SoftError(row, low + int(seen[0]), offset, nothing - value, sigma)

    def _proposed(self, row: int, place: Seed) -> set[tuple[int, int]]:
        """Frames [start, stop) that an error which shows in a span may have."""
        surprise, half = self._surprise, place.length / 2
        found: set[tuple[int, int]] = set()
        for factor in WINDOWS:
            for before, behind in SHIFTS:
                reach = half * factor + HOLE
                low = int(max(2, place.middle - reach * before))
                high = int(min(surprise.frames - 3, place.middle + reach * behind))
                if high - low < HOLE:
                    continue
                offset, sigma = surprise.free_offset(row, low, high)
                size = np.abs(offset)
                inner = size[
                    max(0, int(place.middle - half) - low) : int(place.middle + half) - low
                ]
                top = float(inner.max(initial=0.0))
                if top < 0.5 * SMALLEST:
                    continue
                for least in (2.0 * sigma, 4.0 * sigma, 0.05 * top, 0.15 * top):
                    at = np.flatnonzero(size > min(max(least, SEEN), 0.5 * top))
                    for run in np.split(at, np.flatnonzero(np.diff(at) > HOLE) + 1):
                        meets = run[0] + low <= place.middle + half
                        meets &= run[-1] + low >= place.middle - half
                        if meets and run[-1] - run[0] > place.length // 4:
                            found.add((low + int(run[0]), low + int(run[-1]) + 1))
        return found


def _likely_levels(stretch: Stretch, length: int, middle: int) -> list[tuple[Level, float]]:
    """The levels around a seed that explain u best, and how far scales were widened for it.

    length, middle: of the seed's span, in frames of the stretch.
    """
    n, shift, onset = (
        v.ravel() for v in np.meshgrid(length * np.array(LENGTHS), PLACES, ONSETS)
    )
    start = middle + shift * np.maximum(n, length) - 0.5 * n
    levels = np.stack([np.ones_like(n), start, start + n, np.maximum(onset * n, 3.0)], axis=1)
    levels = levels[(start > 0.0) & (start + n < stretch.frames)]
    if not len(levels):
        return []
    courses = course(levels, ramp, stretch.frames)
    told = stretch.longer(AS_LONG * length)
    departures = told.departures(courses)
    found = []
    for wider in WIDENED:
        levels[:, 0] = told.sizes(departures, wider)
        left = told.residuals(levels[:, :1] * courses, wider)
        best = levels[(left**2).sum(axis=1).argmin()]
        found.append((Level(*best.tolist()), wider))
    return found
