"""Soft errors of limbs: sought where departures are too large, explained at least surprise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from twistcore.detection.prediction import Index, Mask
from twistcore.detection.soft_errors.explanations import FREE_AT, PRIOR, Explanations, Seed
from twistcore.detection.soft_errors.natural_scale import cost
from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.surprise import SEED_CAP, SMALLEST, Surprise
from twistcore.skeleton.rotation import Array

SEED = 18.0  # nats of the three probes of a span
NEAR = 0.8  # of SEED, at another span of the same place
OF_LIMB = 0.7  # of what an interval gains in its own chain it must gain in its limb
IN_VAIN = 20  # seeds of a limb that nothing explains, one after the other, before it is left


def gains(surprise: Surprise, k: int, rows: Index) -> Array:
    """What the probes of the spans of rank k say against natural motion, (rows, positions)."""
    a = surprise.at[k]
    u = a.u[:, rows]
    size = np.abs(u)
    gain = cost(u / a.spread[:, rows], SEED_CAP).sum(axis=0)
    gain *= (size.max(axis=0) >= SMALLEST) & a.usable
    return np.asarray(gain)


def search_all(searches: Sequence[Search], surprise: Surprise, budget: float) -> bool:
    """Explain the seeds of several limbs, those that say most first; whether all were looked at.

    budget: the work after which no other seed is begun, as `surprise.work` counts it.
    """
    end = surprise.work + budget
    while True:
        tops = [(top, s) for s in searches if (top := s.next()) is not None]
        if not tops:
            return True
        if surprise.work >= end:
            return False
        top, search = max(tops, key=lambda t: t[0].gain)
        search.explain(top)


class Search:
    """The soft errors of one limb, found one after the other in a :class:`Surprise`."""

    def __init__(self, surprise: Surprise, limb: list[int]) -> None:
        self._surprise, self._limb = surprise, limb
        self._gain: dict[tuple[int, int], Array] = {}
        self._top: dict[tuple[int, int], Seed | None] = {}
        self._explained: dict[int, dict[Seed, Explanations]] = {}
        self._done: dict[int, Mask] = {r: np.zeros(surprise.frames, dtype=bool) for r in limb}
        self.found: list[SoftError] = []
        self._in_vain = 0  # seeds since the last that was explained
        for row in limb:
            self._update(row)

    def _update(self, row: int) -> None:
        """Gains of a row's spans anew, and the best of each; what explained its seeds is gone."""
        self._explained[row] = {}
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
        """All soft errors, taken out of the surprise as they are found."""
        while (top := self.next()) is not None:
            self.explain(top)
        return self.found

    def next(self) -> Seed | None:
        """The seed that says most, or None where the search has come to its end."""
        if self._in_vain >= IN_VAIN:
            return None
        seeds = (s for s in self._top.values() if s and s.gain > SEED)
        return max(seeds, key=lambda s: (round(s.gain), -s.length), default=None)

    def explain(self, top: Seed) -> None:
        """Take out what explains the next seed, or be done with it."""
        best = self._best_of_limb(top)
        if best is None:
            self._in_vain += 1
            reach = max(2, top.length // 2)
            self._done[top.row][max(top.middle - reach, 0) : top.middle + reach + 1] = True
            for k in range(len(self._surprise.at)):
                self._top[top.row, k] = self._seed(top.row, k)
            return
        self._in_vain = 0
        self.found.append(best)
        self._take_out(best.row, best.start, best.offset)
        for row in self._surprise.beside(best.row):
            if row in self._done:
                self._update(row)

    def left(self) -> Mask:
        """Frames under seeds that were not looked at, (frames,)."""
        out = np.zeros(self._surprise.frames, dtype=bool)
        for row, k in self._gain if self.next() is not None else ():
            span, gain = self._surprise.at[k].natural.span, self._gain[row, k]
            middles = span.step * np.arange(len(gain)) + span.reach + span.length // 2
            for middle in middles[(gain > SEED) & ~self._done[row][middles]].tolist():
                out[middle - span.length // 2 : middle + span.length // 2 + 1] = True
        return out

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
            # Seeds near one that nothing explained lead to the same spans again.
            known = self._explained[row]
            if place not in known:
                known[place] = Explanations(self._surprise, place)
            one = known[place].best(FREE_AT)
            if one is None:
                continue
            if self._surprise.seed_left(row, one.start, one.offset) < SEED:
                return known[place].best(math.inf) or one
            found.append(one)
        return max(found, key=lambda f: f.gain / math.sqrt(len(f.offset)), default=None)
