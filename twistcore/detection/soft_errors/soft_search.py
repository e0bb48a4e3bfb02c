"""Search limbs for soft errors: explain the largest departures from natural motion first.

A *seed* is a span of frames with an unnaturally large departure from its natural course. The error
that explains a seed best is removed from the limb, and then the next seed is explained.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from twistcore.detection.prediction import Index, Mask
from twistcore.detection.soft_errors.explanations import FREE_AT, PRIOR, Explanations, Seed
from twistcore.detection.soft_errors.natural_scale import natural_twist_departure_cost
from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.surprise import SEED_CAP, SMALLEST, Surprise
from twistcore.skeleton.rotation import Array

SEED = 18.0  # nats: minimum gain of a seed, the sum over the three probes of its span
NEAR = 0.8  # minimum gain of other spans at the position of a seed, as a share of SEED
OF_LIMB = 0.7  # minimum gain of an error in its limb, as a share of its gain in its chain
OVER = 1.2  # multiple of the budget after which even a seed in progress is abandoned
IN_VAIN = 20  # a search ends after this number of successive seeds without an explanation


def twist_departure_costs_per_span(surprise: Surprise, k: int, rows: Index) -> Array:
    """Return the cost of natural motion over each span of one length, in nats, (rows, positions).

    The cost is the sum of the costs of u's departures from its natural course at the three probes
    of a span. `k` is the index of the span length in `Surprise.at`, and `rows` contains the rows of
    the chains.
    """
    a = surprise.at[k]
    u = a.u[:, rows]
    size = np.abs(u)
    gain = natural_twist_departure_cost(u / a.spread[:, rows], SEED_CAP).sum(axis=0)
    gain *= (size.max(axis=0) >= SMALLEST) & a.usable
    return np.asarray(gain)


def explain_seeds_within_budget(
    searches: Sequence[Search], surprise: Surprise, budget: float
) -> bool:
    """Explain the seeds of several limbs, strongest first. Return True if all seeds were examined.

    A seed is a span with an unnaturally large departure. When the work exceeds `budget`, in the
    units of `surprise.work`, no further seed is examined.
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
    """The search for the soft errors of one limb, which finds and removes one error at a time.

    `limb` contains the rows of the limb's chains to search.
    """

    def __init__(self, surprise: Surprise, limb: list[int]) -> None:
        self._surprise = surprise
        self._gain: dict[tuple[int, int], Array] = {}
        self._top: dict[tuple[int, int], Seed | None] = {}
        self._explained: dict[int, dict[Seed, Explanations]] = {}
        self._done: dict[int, Mask] = {r: np.zeros(surprise.frames, dtype=bool) for r in limb}
        self.found: list[SoftError] = []
        self._in_vain = 0  # seeds since the last explained one
        for row in limb:
            self._update(row)

    def _update(self, row: int) -> None:
        """Recompute the gains and the best seeds of a chain, and discard its cached explanations.

        `row` is the row of the chain.
        """
        self._explained[row] = {}
        for k in range(len(self._surprise.at)):
            self._gain[row, k] = twist_departure_costs_per_span(self._surprise, k, np.array([row]))[
                0
            ]
            self._top[row, k] = self._seed(row, k)

    def _seed(self, row: int, k: int, near: tuple[int, int] | None = None) -> Seed | None:
        """Return the best seed of a chain among the spans of the k-th length, or None.

        Frames that are marked as done are excluded. If `near` is given, the middle of the span must
        be between these two frames.
        """
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

    def next(self) -> Seed | None:
        """Return the strongest remaining seed, or None if the search is finished.

        A seed is a span of frames with an unnaturally large departure.
        """
        if self._in_vain >= IN_VAIN:
            return None
        seeds = (s for s in self._top.values() if s and s.gain > SEED)
        return max(seeds, key=lambda s: (round(s.gain), -s.length), default=None)

    def explain(self, top: Seed) -> None:
        """Find and remove the error that explains a seed, a span with a large departure.

        If there is no such error, the frames of the seed are marked as done.
        """
        best = self._best_of_limb(top)
        if best is None and self._is_spent():
            return  # the frames of the seed are reported as not searched
        if best is None:
            self._in_vain += 1
            reach = max(2, top.length // 2)
            self._done[top.row][max(top.middle - reach, 0) : top.middle + reach + 1] = True
            for k in range(len(self._surprise.at)):
                self._top[top.row, k] = self._seed(top.row, k)
            return
        self._in_vain = 0
        self.found.append(best)
        self._remove(best.row, best.start, best.offset)
        for row in self._surprise.neighbours(best.row):
            if row in self._done:
                self._update(row)

    def _is_spent(self) -> bool:
        return self._surprise.work > OVER * self._surprise.budget

    def left(self) -> Mask:
        """Return a mask of the frames in seeds that have not been examined, (frames,)."""
        out = np.zeros(self._surprise.frames, dtype=bool)
        for row, k in self._gain if self.next() is not None else ():
            span, gain = self._surprise.at[k].natural.span, self._gain[row, k]
            middles = span.step * np.arange(len(gain)) + span.reach + span.length // 2
            for middle in middles[(gain > SEED) & ~self._done[row][middles]].tolist():
                out[middle - span.length // 2 : middle + span.length // 2 + 1] = True
        return out

    def _remove(self, row: int, start: int, offset: Array) -> None:
        self._surprise.remove_error(row, start, offset)
        self._surprise.update_departures(row, start, start + len(offset))

    def _best_of_limb(self, top: Seed) -> SoftError | None:
        """Return the error in a seed's chain or a neighbouring one that explains the seed best.

        The result is None if no explanation is good enough.
        """
        rivals: list[SoftError] = []
        for row in self._surprise.neighbours(top.row):
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
        # If the departure is the effect of an error in a neighbouring chain, an explanation in this
        # chain makes the neighbour worse, so the gain in the limb is small.
        return best if value > max(PRIOR, OF_LIMB * best.gain) else None

    def _gain_of_limb(self, error: SoftError) -> float:
        """Return by how much removing an error reduces the surprise (cost) of the motion, in nats.

        The reductions in the error's chain and in its neighbours are added.
        """
        margin = len(error.offset) // 2 + 8
        window = max(error.start - margin, 0), min(error.stop + margin, self._surprise.frames)
        rows = self._surprise.neighbours(error.row)
        before = sum(self._surprise.of(r, *window) for r in rows)
        self._remove(error.row, error.start, error.offset)
        after = sum(self._surprise.of(r, *window) for r in rows)
        self._remove(error.row, error.start, -error.offset)
        return before - after

    def _shortest(self, row: int, places: list[Seed]) -> SoftError | None:
        """Return the error that explains the shortest seed and leaves no other seed nearby.

        If every explanation leaves a seed, for example because of another error nearby, the
        explanation with the highest gain relative to the square root of its length is returned. The
        result is None if none of the seeds in `places` has an explanation.
        """
        found: list[SoftError] = []
        for place in sorted(places, key=lambda s: s.length):
            # The seeds near an unexplained seed lead to the same spans again, so use the cache.
            known = self._explained[row]
            if self._is_spent():
                break
            if place not in known:
                known[place] = Explanations(self._surprise, place)
            one = known[place].best(FREE_AT)
            if one is None:
                continue
            if self._surprise.seed_left(row, one.start, one.offset) < SEED:
                return known[place].best(math.inf) or one
            found.append(one)
        return max(found, key=lambda f: f.gain / math.sqrt(len(f.offset)), default=None)
