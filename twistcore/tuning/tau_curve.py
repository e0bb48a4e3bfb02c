"""Compute the cost of every τ for a chain, and suggest the τ with the lowest cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from math import nan
from operator import add

import numpy as np

from twistcore.skeleton.rotation import Array
from twistcore.tuning.drawn_errors import DrawnErrors, poisson_confidence_interval
from twistcore.tuning.listed_intervals import ListCounts
from twistcore.work.frozen import dataclass

# The smallest error of protocol H6. A larger τ could miss errors that should be found.
SMALLEST_ERROR = float(np.radians(2.0))
ALARM_PRICE = 0.05  # share of the error frames that one false alarm per clip or minute may cost
LOSS_ALLOWED = 0.001  # additional cost allowed for a larger τ, which is safer against noise
_SAME = 1e-6  # relative rounding error of a τ, which is stored in degrees


@dataclass(frozen=True, eq=False)
class TauCurve:
    """Counts for one chain, from which the cost of each τ in a grid is computed.

    The curves of several clips can be added.

    Parameters
    ----------
    tau
        The grid of τ in radians, shape (n,).
    repaired
        Number of error frames corrected by at least 80 %, shape (n,).
    errors
        Number of error frames.
    alarms
        Number of false alarms, shape (n,). These are listed intervals that a person rejected, and
        automatic corrections of the cleaned clips that nobody judged.
    minutes
        Total duration of the clips.
    noise
        The noise of each clip, in radians.
    drawn
        The results of the injected errors, from which the confidence limits of :attr:`fsr` are
        computed. None if there are no errors or the results are unknown.
    own
        The detector's automatic τ for each clip, in radians. By default, it equals the noise.
    counts
        Number of intervals that are listed, corrected automatically, or rejected at each τ in the
        original clips. None if they were not counted.
    """

    tau: Array
    repaired: Array
    errors: int
    alarms: Array
    minutes: float
    noise: tuple[float, ...]
    drawn: DrawnErrors | None = None
    own: tuple[float, ...] = ()
    counts: ListCounts | None = None

    @property
    def fsr(self) -> Array:
        """Return the fraction of repaired error frames, 0…1, shape (n,), or NaN without errors."""
        share: Array = (
            self.repaired / self.errors if self.errors else np.full(len(self.tau), np.nan)
        )
        return share

    @property
    def band(self) -> tuple[Array, Array]:
        """Return the lower and upper confidence limits of :attr:`fsr`, shape (n,), or NaN."""
        return self._drawn.band

    @property
    def floor(self) -> float:
        """Return the lowest τ that can be suggested: the median noise of the clips, in radians."""
        return float(np.median(self.noise)) if self.noise else 0.0

    @property
    def automatic(self) -> float:
        """Return the detector's automatic τ in radians, as the median over the clips."""
        return float(np.median(self.own)) if self.own else self.floor

    def __add__(self, other: TauCurve) -> TauCurve:
        both = self, other
        known = all(c.drawn is not None or not c.errors for c in both)
        return TauCurve(
            self.tau,
            self.repaired + other.repaired,
            self.errors + other.errors,
            self.alarms + other.alarms,
            self.minutes + other.minutes,
            self.noise + other.noise,
            self._drawn + other._drawn if known and any(c.drawn for c in both) else None,
            self.own + other.own,
            self.counts + other.counts if self.counts and other.counts else None,
        )

    def loss(self, price: float = ALARM_PRICE, smallest: float = SMALLEST_ERROR) -> Array:
        """Return the fraction of missed error frames plus the price of alarms at every τ, (n,).

        `price` is the fraction of error frames that may be missed to avoid one false alarm per
        clip, or per minute of a longer clip. Errors below `smallest` radians need not be found.
        """
        fsr = self.fsr
        if self.drawn is not None and (wanted := self.drawn.from_size(smallest)).frames.sum():
            fsr = wanted.fsr
        clips = max(self.minutes, len(self.noise), 1e-9)
        lost: Array = 1.0 - np.nan_to_num(fsr) + price * self.alarms / clips
        return lost

    def suggested(
        self,
        price: float = ALARM_PRICE,
        smallest: float = SMALLEST_ERROR,
        *,
        present: float | None = None,
    ) -> float:
        """Return the τ, in radians, with the lowest :meth:`loss`.

        A false alarm costs a person one key press, but nobody notices a missed error. By default,
        an alarm therefore costs as much as 5 % of the error frames, so that no τ misses half of the
        errors to avoid one alarm. If several τ cost the same, the largest one that is not above
        `smallest` is chosen, because a larger τ may miss errors of sizes that were not injected.
        The result is never below the clips' noise. `present`, the τ used so far, is returned if it
        is above the noise and no τ has a lower loss.
        """
        usable = np.flatnonzero(self.tau >= self.floor)
        if not len(usable):
            return self.floor
        if present is not None and self.is_best(present, price, smallest):
            return present
        loss = self.loss(price, smallest)[usable]
        good = usable[loss <= loss.min() + LOSS_ALLOWED]
        modest = good[self.tau[good] <= smallest]
        return float(self.tau[modest[-1] if len(modest) else good[0]])

    def losses(self, tau: Array, price: float, smallest: float) -> Array:
        """Return the :meth:`loss` at k values of τ (radians), shape (k,), interpolated."""
        at = np.log(np.maximum(tau, 1e-9))
        return np.interp(at, np.log(self.tau), self.loss(price, smallest))

    def is_best(self, tau: float, price: float, smallest: float) -> bool:
        """Return True if no τ above the clips' noise has a lower loss than `tau` (radians)."""
        usable = self.tau[self.tau >= self.floor]
        if tau < self.floor * (1.0 - _SAME) or not len(usable):
            return False
        here, *others = self.losses(np.array([tau, *usable]), price, smallest)
        return bool(here <= min(others) + LOSS_ALLOWED)

    def plateau(self, tau: float, price: float, smallest: float) -> tuple[float, float]:
        """Return the range around `tau`, in radians, in which the :meth:`loss` is the same."""
        usable = self.tau[self.tau >= self.floor]
        points = np.unique([*usable, min(self.floor, tau), tau])
        loss = self.losses(points, price, smallest)
        here = int(np.searchsorted(points, tau))
        other = np.flatnonzero(np.abs(loss - loss[here]) > LOSS_ALLOWED)
        low = other[other < here].max(initial=-1) + 1
        high = other[other > here].min(initial=len(points)) - 1
        return float(points[low]), float(points[high])

    def counts_at(self, tau: float) -> ListCounts | None:
        """Return the counts at the grid point nearest to `tau` (radians), or None."""
        if self.counts is None:
            return None
        k = self._nearest(tau)
        return ListCounts(*(float(np.asarray(c)[k]) for c in vars(self.counts).values()))

    def unjudged_at(self, tau: float) -> int:
        """Return the number of automatic corrections at `tau` (radians) that nobody has judged."""
        k = self._nearest(tau)
        rejected = np.asarray(self.counts.rejected)[k] if self.counts else 0.0
        return round(float(self.alarms[k] - rejected))

    def _nearest(self, tau: float) -> int:
        return int(np.abs(np.log(self.tau / max(tau, 1e-9))).argmin())

    def at(self, tau: float) -> tuple[float, float]:
        """Return :attr:`fsr` and the number of false alarms, interpolated at `tau` (radians)."""
        cost = self.cost(tau)
        return cost.fsr, cost.alarms

    def cost(self, tau: float) -> Cost:
        """Return the cost of `tau` (radians) with its confidence interval."""
        return total_tuning_cost([(self, tau)])

    @property
    def _drawn(self) -> DrawnErrors:
        none, nobody = np.zeros(0), np.zeros(0, dtype=int)
        nothing = DrawnErrors(none, none, nobody, nobody, np.zeros((0, len(self.tau))))
        return self.drawn or nothing

    def _place(self, tau: float) -> tuple[int, float]:
        """Return the index of the grid point below `tau`, and the distance of `tau` from it.

        The distance is a fraction of the step to the next grid point, measured in log τ.
        """
        at = float(np.interp(math.log(max(tau, 1e-9)), np.log(self.tau), range(len(self.tau))))
        below = min(int(at), max(len(self.tau) - 2, 0))
        return below, at - below


@dataclass(frozen=True)
class Cost:
    """The cost of a τ. A value that was not measured is NaN.

    Parameters
    ----------
    fsr
        The fraction of repaired error frames, 0…1.
    low, high
        95 % confidence interval of `fsr`.
    alarms
        Number of false alarms.
    minutes
        Duration of the clips in which alarms were counted.
    """

    fsr: float
    low: float
    high: float
    alarms: float
    minutes: float

    @property
    def rate(self) -> float:
        """Return the number of false alarms per minute, or NaN for 0 minutes."""
        return self.alarms / (self.minutes or nan)

    @property
    def rate_band(self) -> tuple[float, float]:
        """Return the 95 % confidence interval of the alarms per minute in similar clips."""
        low, high = poisson_confidence_interval(self.alarms)
        return (low / self.minutes, high / self.minutes) if self.minutes else (0.0, math.inf)


def total_tuning_cost(
    chosen: Sequence[tuple[TauCurve, float]], minutes: float | None = None
) -> Cost:
    """Return the total cost of several chains, given pairs of τ curve and τ (radians).

    The error frames and alarms of all chains are added. `minutes`, the duration of the clips, is
    the same for all chains. By default, the largest `minutes` of the curves is used.
    """
    alarms = errors = repaired = 0.0
    drawn: list[DrawnErrors] = []
    for curve, tau in chosen:
        below, share = curve._place(tau)
        pair = slice(below, below + 2)
        weights = np.array([1.0 - share, share])[: len(curve.tau[pair])]
        alarms += float(curve.alarms[pair] @ weights)
        repaired += float(curve.repaired[pair] @ weights)
        errors += curve.errors
        if curve.drawn is not None:
            drawn.append(curve.drawn.between(below, share))
    known = bool(drawn) and all(c.drawn is not None or not c.errors for c, _ in chosen)
    low, high = (float(end[0]) for end in reduce(add, drawn).band) if known else (nan, nan)
    if minutes is None:
        minutes = max((curve.minutes for curve, _ in chosen), default=0.0)
    return Cost(repaired / errors if errors else nan, low, high, alarms, minutes)


@dataclass(frozen=True)
class Tuned:
    """The τ of a chain and its cost. A value that was not measured is NaN.

    Parameters
    ----------
    tau, noise
        The threshold and the noise, in degrees.
    fsr
        The percentage of repaired error frames.
    alarms_per_minute
        The number of false alarms per minute.
    """

    tau: float
    noise: float
    fsr: float
    alarms_per_minute: float


def tau_with_cost(curve: TauCurve, tau: float | None = None) -> Tuned:
    """Return the suggested τ of a curve, or the given `tau` in radians, with its cost."""
    tau = curve.suggested() if tau is None else tau
    cost = curve.cost(tau)
    return Tuned(
        tau=math.degrees(tau),
        noise=math.degrees(curve.floor),
        fsr=100.0 * cost.fsr,
        alarms_per_minute=cost.rate,
    )
