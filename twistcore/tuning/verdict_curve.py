"""Precision and recall at each τ according to people's verdicts, and the τ they suggest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from twistcore.detection.prediction import Index
from twistcore.skeleton.rotation import Array
from twistcore.tuning.injected_curve import GRID
from twistcore.tuning.tau_curve import ALARM_PRICE, LOSS_ALLOWED, SMALLEST_ERROR
from twistcore.tuning.verdicts_of import JudgedClip
from twistcore.work.frozen import dataclass

LEVEL = 0.9  # level of confidence intervals
_Z = 1.6449  # quantile of the normal distribution for LEVEL
ENOUGH_ERRORS = 10  # minimum of accepted intervals for a suggestion: recall in steps of 10 %
ENOUGH_OWN = 5  # minimum of verdicts on a chain; errors of other chains are used as well
BORROWED = 10.0  # weight of all other chains' errors, as a number of the chain's own errors
FEW_CLIPS = 5  # with fewer clips, verdicts are resampled instead
DRAWS = 400
_SAME = 1e-9  # share by which two τ may differ


def wilson(part: Array, whole: Array, z: float = _Z) -> tuple[Array, Array]:
    """Return the bounds of the confidence interval of part / whole, 0 and 1 if whole is 0."""
    part, n = np.asarray(part, float), np.asarray(whole, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = part / n
        middle = (share + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    low, high = np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
    return np.where(n > 0, low, 0.0), np.where(n > 0, high, 1.0)


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A suggested τ in radians.

    `low` and `high` limit the range in which τ costs the same or, if wider, the range of 90 % of
    the resampled suggestions. `least` is the size of the smallest accepted error, or NaN.
    """

    tau: float
    low: float
    high: float
    least: float = math.nan


@dataclass(frozen=True, eq=False)
class VerdictCurve:
    """Counts over a grid of τ, with a row for each clip or, if there are few, each verdict.

    Curves can be added.

    Attributes
    ----------
    tau
        The grid of τ in radians, shape (n,).
    errors, natural
        Numbers of decided intervals of each kind, shape (rows,).
    found, alarms
        Number of errors and natural intervals that are detected at each τ, shape (rows, n).
    clips
        Number of clips (or of minutes, if larger) multiplied by the number of reviewed chains.
    reviewed
        The τ in radians from which intervals were listed, as the median of chains and clips.
    others
        Recall of the errors of other chains, shape (n,), and their number, which is 0 for a curve
        of all chains.
    least
        The size of the smallest accepted error in radians, NaN if there is none.
    """

    tau: Array
    errors: Array
    natural: Array
    found: Array
    alarms: Array
    clips: float
    reviewed: float
    others: tuple[Array, int] = (np.zeros(0), 0)
    least: float = math.nan

    @property
    def counts(self) -> tuple[int, int]:
        """Return the numbers of decided errors and natural intervals."""
        return int(self.errors.sum()), int(self.natural.sum())

    @property
    def enough(self) -> bool:
        """Return True if there are enough verdicts to suggest a τ."""
        return self.needed == (0, 0)

    @property
    def needed(self) -> tuple[int, int]:
        """Return the numbers of accepted intervals (any chain) and own verdicts still needed."""
        own = self.counts
        errors = max(ENOUGH_ERRORS - own[0] - self.others[1], 0)
        return errors, 0 if own[0] >= ENOUGH_ERRORS else max(ENOUGH_OWN - sum(own), 0)

    @property
    def recall(self) -> Array:
        """Return the fraction of errors that are found, (n,), or NaN without errors."""
        return _share(self.found.sum(axis=0), self.errors.sum())

    @property
    def precision(self) -> Array:
        """Return the fraction of detections that are errors, (n,), or NaN without detections."""
        found = self.found.sum(axis=0)
        return _share(found, found + self.alarms.sum(axis=0))

    def recall_between(self) -> tuple[Array, Array]:
        """Return the limits, (n,), of the 90 % confidence interval of the recall."""
        found = self.found.sum(axis=0)
        return wilson(found, np.broadcast_to(self.errors.sum(), found.shape))

    def precision_between(self) -> tuple[Array, Array]:
        """Return the limits, (n,), of the 90 % confidence interval of the precision."""
        found = self.found.sum(axis=0)
        return wilson(found, found + self.alarms.sum(axis=0))

    def at(self, tau: float) -> int:
        """Return the grid index nearest to τ."""
        return int(np.abs(np.log(self.tau / max(tau, 1e-9))).argmin())

    def cost(self, price: float = ALARM_PRICE, weight: Array | None = None) -> Array:
        """Return the cost of every τ: the fraction of missed errors plus the price of alarms.

        `price` is the cost of one alarm per clip. If a chain has few errors, the errors of other
        chains show how large errors are in these clips. `weight` is the number of times that each
        row is counted, shape (draws, rows); the result then has the shape (draws, n).
        """
        weight = np.ones((1, len(self.errors))) if weight is None else weight
        errors, rows = weight @ self.errors, max(len(self.errors), 1)
        found = weight @ self.found
        if self.others[1]:
            errors, found = errors + BORROWED, found + BORROWED * self.others[0]
        missed = 1.0 - found / np.maximum(errors, 1e-9)[:, None]
        clips = max(self.clips, 1e-9) * weight.sum(axis=1) / rows
        cost = missed + price * (weight @ self.alarms) / np.maximum(clips, 1e-9)[:, None]
        return np.asarray(cost)

    def best(self, cost: Array, smallest: float = SMALLEST_ERROR) -> Index:
        """Return the grid indices of the lowest costs (draws, n), by the rule of :class:`TauCurve`.

        If several τ cost the same, the largest one up to the size of the smallest errors to find is
        chosen, but never one below the median τ of the review, below which the number of alarms is
        uncertain.
        """
        usable = self.tau >= self.reviewed * (1 - _SAME)
        if not usable.any():
            return np.full(len(cost), len(self.tau) - 1)
        cost = np.where(usable, cost, np.inf)
        good = cost <= cost.min(axis=1, keepdims=True) + LOSS_ALLOWED
        modest = good & (self.tau <= smallest * (1 + _SAME))
        last = len(self.tau) - 1 - modest[:, ::-1].argmax(axis=1)
        return np.asarray(np.where(modest.any(axis=1), last, good.argmax(axis=1)))

    def suggested(
        self,
        price: float = ALARM_PRICE,
        smallest: float = SMALLEST_ERROR,
        *,
        draws: int = DRAWS,
        seed: int = 0,
    ) -> Suggestion | None:
        """Return the τ that the verdicts suggest, with its uncertainty.

        Returns None if there are too few verdicts, or if they are one-sided (see
        :meth:`is_one_sided`).
        """
        if not self.enough or self.is_one_sided(price, smallest):
            return None
        cost = self.cost(price)
        place = int(self.best(cost, smallest)[0])
        drawn = self.best(self.cost(price, self.draw(draws, seed)), smallest)
        low, high = np.quantile(self.tau[drawn], [0.5 - LEVEL / 2, 0.5 + LEVEL / 2])
        first, last = self._plateau(cost[0], place)
        low, high = min(float(low), first), max(float(high), last)
        return Suggestion(float(self.tau[place]), low, high, self.least)

    def is_one_sided(self, price: float = ALARM_PRICE, smallest: float = SMALLEST_ERROR) -> bool:
        """Return True if only strong intervals were judged, and a τ above them gains nothing.

        Errors between the smallest size to find and the weakest judged interval are unknown then,
        so such verdicts do not justify a τ that would miss them.
        """
        if self.reviewed <= smallest * (1 + _SAME):
            return False
        usable = self.tau >= self.reviewed * (1 - _SAME)
        cost = self.cost(price)[0]
        return not usable.any() or bool(cost[usable][0] <= cost[usable].min() + LOSS_ALLOWED)

    @property
    def one_sided_sentence(self) -> str:
        """Return a sentence that explains why one-sided verdicts suggest no τ."""
        return (
            f"Nothing below {math.degrees(self.reviewed):.2f}° was judged, and the smallest "
            f"accepted error is {math.degrees(self.least):.1f}°. Judge weaker intervals, too, "
            "because these verdicts do not justify a larger τ."
        )

    def _plateau(self, cost: Array, place: int) -> tuple[float, float]:
        """Return the reviewed range of τ (radians) around `place` that costs the same.

        `place` is an index of the grid.
        """
        same = (np.abs(cost - cost[place]) <= LOSS_ALLOWED) & (
            self.tau >= self.reviewed * (1 - _SAME)
        )
        same[place] = True
        other = np.flatnonzero(~same)
        first = int(other[other < place].max(initial=-1)) + 1
        last = int(other[other > place].min(initial=len(cost))) - 1
        return float(self.tau[first]), float(self.tau[last])

    def draw(self, draws: int, seed: int) -> Array:
        """Return the count of each row in samples with replacement, shape (draws, rows)."""
        rows = len(self.errors)
        rng = np.random.default_rng(seed)
        drawn = rng.multinomial(rows, np.full(rows, 1.0 / rows), size=draws).astype(float)
        if not self.others[1]:
            drawn[drawn @ self.errors == 0] = (
                1.0  # a sample without errors cannot show the cost of τ
            )
        return np.asarray(drawn)


def _share(part: Array, whole: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.divide(part, whole, dtype=float))


def verdict_curve(clips: Sequence[JudgedClip], chain: str | None = None) -> VerdictCurve:
    """Return the curve over all clips with verdicts, for all their chains or for one chain.

    A reviewed clip in which no interval of the chain was listed is a clip without alarms.
    """
    clips = [clip for clip in clips if clip.verdicts]
    others = _errors_found(clips, chain) if chain is not None else (np.zeros(0), 0)
    if chain is not None:
        clips = [clip.of_chain(chain) for clip in clips if chain in clip.reviewed]
    groups = [clip.verdicts for clip in clips]
    if len(groups) < FEW_CLIPS:
        groups = [(v,) for group in groups for v in group]
    found, alarms = (np.zeros((len(groups), len(GRID))) for _ in range(2))
    errors, natural = (np.zeros(len(groups)) for _ in range(2))
    for row, group in enumerate(groups):
        for v in group:
            total, by_tau = (errors, found) if v.error else (natural, alarms)
            total[row] += 1
            by_tau[row] += v.found
    # The median, as for the noise in TauCurve: the maximum could come from one odd clip.
    seen = [t for clip in clips for t in clip.reviewed.values()]
    reviewed = float(np.median(seen)) if seen else math.inf
    reviewed_chains = sum(clip.reviewed_chains for clip in clips)
    length = max(sum(clip.minutes * clip.reviewed_chains for clip in clips), reviewed_chains)
    least = min((v.size for clip in clips for v in clip.verdicts if v.error), default=math.nan)
    counts = errors, natural, found, alarms
    return VerdictCurve(GRID, *counts, length, reviewed, others, least)


def _errors_found(clips: Sequence[JudgedClip], chain: str) -> tuple[Array, int]:
    """Return the recall of other chains' errors at each τ, and the number of these errors."""
    found = [v.found for clip in clips for v in clip.verdicts if v.error and v.chain != chain]
    return (np.mean(found, axis=0) if found else np.zeros(0)), len(found)


@dataclass(frozen=True)
class VerdictScore:
    """Numbers of decided intervals: errors, detected errors, natural intervals, and alarms."""

    errors: int
    found: int
    natural: int
    alarms: int

    @property
    def precision(self) -> tuple[float, float, float]:
        """Return the fraction of detections that are errors, with its lower and upper bound.

        Without detections, these are NaN, 0 and 1.
        """
        return _between(self.found, self.found + self.alarms)

    @property
    def recall(self) -> tuple[float, float, float]:
        """Return the fraction of errors that are found, with its lower and upper bound.

        Without errors, these are NaN, 0 and 1.
        """
        return _between(self.found, self.errors)


def verdict_score(
    clips: Sequence[JudgedClip], tau: Mapping[str, float], chain: str | None = None
) -> VerdictScore:
    """Return the score of one chain or of all chains in `tau`, at τ in radians for each chain."""
    place = {name: int(np.abs(np.log(GRID / t)).argmin()) for name, t in tau.items()}
    told = [
        (v.error, bool(v.found[place[v.chain]]))
        for clip in clips
        for v in clip.verdicts
        if v.chain in place and chain in (None, v.chain)
    ]
    errors, natural = ([found for error, found in told if error == kind] for kind in (True, False))
    return VerdictScore(len(errors), sum(errors), len(natural), sum(natural))


def _between(part: int, whole: int) -> tuple[float, float, float]:
    low, high = wilson(np.array(part), np.array(whole))
    return part / whole if whole else math.nan, float(low), float(high)
