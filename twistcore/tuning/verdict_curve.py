"""Compute precision and recall at each τ from reviewers' verdicts, and suggest a τ."""

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
ENOUGH_ERRORS = 10  # minimum number of accepted intervals: recall changes in steps of 10 %
ENOUGH_OWN = 5  # minimum number of verdicts on the chain itself
BORROWED = 10.0  # all errors of other chains together count as this many errors of the chain
FEW_CLIPS = 5  # with fewer clips, verdicts are resampled instead of clips
DRAWS = 400
_SAME = 1e-9  # relative rounding error of a τ


def wilson_bounds(part: Array, whole: Array) -> tuple[Array, Array]:
    """Return the lower and upper Wilson bounds of the fraction `part / whole`, at LEVEL.

    Where `whole` is 0, the bounds are 0 and 1.
    """
    z, part, n = _Z, np.asarray(part, float), np.asarray(whole, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = part / n
        middle = (share + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    low, high = np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
    return np.where(n > 0, low, 0.0), np.where(n > 0, high, 1.0)


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A suggested τ with its uncertainty, in radians.

    Parameters
    ----------
    tau
        The suggested τ.
    low, high
        The range in which τ costs the same or, if wider, the range that contains 90 % of the
        resampled suggestions.
    least
        The size of the smallest accepted error, or NaN.
    """

    tau: float
    low: float
    high: float
    least: float = math.nan


@dataclass(frozen=True, eq=False)
class VerdictCurve:
    """Counts of detected errors and false alarms at each τ of a grid, based on verdicts.

    Each row counts the verdicts on one clip or, if there are few clips, one verdict.

    Attributes
    ----------
    tau
        The grid of τ in radians, shape (n,).
    errors, natural
        Number of accepted and number of rejected intervals, shape (rows,).
    found, alarms
        Number of accepted and number of rejected intervals that are detected at each τ, shape
        (rows, n).
    clips
        Number of clips (or of minutes, if larger) multiplied by the number of reviewed chains.
    reviewed
        The lowest τ in radians at which intervals were listed, as the median of chains and clips.
    others
        Recall of the errors in other chains, shape (n,), and the number of these errors, which is 0
        for a curve of all chains.
    least
        The size of the smallest accepted error in radians, or NaN if there is none.
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
        """Return the number of accepted and the number of rejected intervals."""
        return int(self.errors.sum()), int(self.natural.sum())

    @property
    def enough(self) -> bool:
        """Return True if there are enough verdicts to suggest a τ."""
        return self.needed == (0, 0)

    @property
    def needed(self) -> tuple[int, int]:
        """Return how many more accepted intervals and verdicts are needed to suggest a τ.

        The first number counts accepted intervals of any chain. The second number counts verdicts
        on this chain.
        """
        own = self.counts
        errors = max(ENOUGH_ERRORS - own[0] - self.others[1], 0)
        return errors, 0 if own[0] >= ENOUGH_ERRORS else max(ENOUGH_OWN - sum(own), 0)

    @property
    def recall(self) -> Array:
        """Return the fraction of errors that are detected, shape (n,), or NaN without errors."""
        return _share(self.found.sum(axis=0), self.errors.sum())

    @property
    def precision(self) -> Array:
        """Return the fraction of detections that are errors, shape (n,), NaN without detections."""
        found = self.found.sum(axis=0)
        return _share(found, found + self.alarms.sum(axis=0))

    def recall_between(self) -> tuple[Array, Array]:
        """Return the lower and upper 90 % confidence limit of the recall, each of shape (n,)."""
        found = self.found.sum(axis=0)
        return wilson_bounds(found, np.broadcast_to(self.errors.sum(), found.shape))

    def precision_between(self) -> tuple[Array, Array]:
        """Return the lower and upper 90 % confidence limit of the precision, each of shape (n,)."""
        found = self.found.sum(axis=0)
        return wilson_bounds(found, found + self.alarms.sum(axis=0))

    def at(self, tau: float) -> int:
        """Return the index of the grid point nearest to `tau` (radians)."""
        return int(np.abs(np.log(self.tau / max(tau, 1e-9))).argmin())

    def cost(self, price: float = ALARM_PRICE, weight: Array | None = None) -> Array:
        """Return the fraction of missed errors plus the price of the alarms at every τ.

        The errors of other chains are included, so that the error sizes have a typical distribution
        even for a chain with few errors.

        Parameters
        ----------
        price
            The cost of one false alarm per clip, as a fraction of all errors.
        weight : array, shape (draws, rows), optional
            How often each row is counted. By default, every row is counted once.

        Returns
        -------
        array, shape (draws, n)
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
        """Return the grid index of the best τ for each row of `cost`, shape (draws, n).

        If several τ cost the same, the largest one that is not above `smallest` (radians) is
        chosen, as in :meth:`TauCurve.suggested`. The result is never below the lowest τ that was
        reviewed, since the number of alarms below it is unknown.
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

        The result is None if there are too few verdicts, or if they are one-sided (see
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
        """Return True if only strong detections were judged and no larger τ would lower the cost.

        Such verdicts do not justify a larger τ, since there may be errors below the weakest judged
        interval.
        """
        if self.reviewed <= smallest * (1 + _SAME):
            return False
        usable = self.tau >= self.reviewed * (1 - _SAME)
        cost = self.cost(price)[0]
        return not usable.any() or bool(cost[usable][0] <= cost[usable].min() + LOSS_ALLOWED)

    @property
    def one_sided_sentence(self) -> str:
        """Return a sentence that explains why one-sided verdicts do not suggest a τ."""
        return (
            f"Nothing below {math.degrees(self.reviewed):.2f}° was judged, and the smallest "
            f"accepted error is {math.degrees(self.least):.1f}°. Judge weaker intervals, too, "
            "because these verdicts do not justify a larger τ."
        )

    def _plateau(self, cost: Array, place: int) -> tuple[float, float]:
        """Return the range of τ (radians) around grid index `place` in which the cost is the same.

        Values of τ that were not reviewed are excluded.
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
        """Resample rows with replacement, and return how often each is drawn, (draws, rows)."""
        rows = len(self.errors)
        rng = np.random.default_rng(seed)
        drawn = rng.multinomial(rows, np.full(rows, 1.0 / rows), size=draws).astype(float)
        if not self.others[1]:
            drawn[drawn @ self.errors == 0] = (
                1.0  # a sample without errors says nothing about missed errors
            )
        return np.asarray(drawn)


def _share(part: Array, whole: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.divide(part, whole, dtype=float))


def tau_curve_from_verdicts(clips: Sequence[JudgedClip], chain: str | None = None) -> VerdictCurve:
    """Return the verdict curve of clips for one chain or, if `chain` is None, for all chains.

    A reviewed clip in which no interval of the chain was listed counts as a clip without alarms.
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
    # The median, as for the noise in TauCurve, since the maximum may come from one unusual clip.
    seen = [t for clip in clips for t in clip.reviewed.values()]
    reviewed = float(np.median(seen)) if seen else math.inf
    reviewed_chains = sum(clip.reviewed_chains for clip in clips)
    length = max(sum(clip.minutes * clip.reviewed_chains for clip in clips), reviewed_chains)
    least = min((v.size for clip in clips for v in clip.verdicts if v.error), default=math.nan)
    counts = errors, natural, found, alarms
    return VerdictCurve(GRID, *counts, length, reviewed, others, least)


def _errors_found(clips: Sequence[JudgedClip], chain: str) -> tuple[Array, int]:
    """Return the recall of errors in all other chains at each τ, (n,), and the error count."""
    found = [v.found for clip in clips for v in clip.verdicts if v.error and v.chain != chain]
    return (np.mean(found, axis=0) if found else np.zeros(0)), len(found)


@dataclass(frozen=True)
class VerdictScore:
    """Counts of accepted and rejected intervals, and how many of each are detected at one τ.

    Parameters
    ----------
    errors
        Number of accepted intervals.
    found
        Number of accepted intervals that are detected.
    natural
        Number of rejected intervals.
    alarms
        Number of rejected intervals that are detected.
    """

    errors: int
    found: int
    natural: int
    alarms: int

    @property
    def precision(self) -> tuple[float, float, float]:
        """Return the fraction of detections that are errors, with its 90 % confidence limits.

        Without detections, the result is (NaN, 0, 1).
        """
        return _between(self.found, self.found + self.alarms)

    @property
    def recall(self) -> tuple[float, float, float]:
        """Return the fraction of errors that are detected, with its 90 % confidence limits.

        Without errors, the result is (NaN, 0, 1).
        """
        return _between(self.found, self.errors)


def verdict_score(
    clips: Sequence[JudgedClip], tau: Mapping[str, float], chain: str | None = None
) -> VerdictScore:
    """Count the judged intervals, and those of them that are detected with the given τ.

    `tau` contains the τ of each chain in radians, keyed by chain name. Only verdicts on `chain` are
    counted or, if `chain` is None, verdicts on all chains in `tau`.
    """
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
    low, high = wilson_bounds(np.array(part), np.array(whole))
    return part / whole if whole else math.nan, float(low), float(high)
