"""What every τ costs a chain, and the τ that this speaks for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from math import nan
from operator import add

import numpy as np

from twistcore.skeleton.rotation import Array
from twistcore.tuning.drawn_errors import DrawnErrors, rate_band
from twistcore.work.frozen import dataclass

SMALLEST_ERROR = float(np.radians(2.0))  # of H6: a larger τ passes errors over that are looked for
ALARM_PRICE = 0.05  # share of the error frames that one false alarm a clip or minute may cost
LOSS_ALLOWED = 0.001  # what a larger τ, safer against noise, may cost besides


@dataclass(frozen=True, eq=False)
class TauCurve:
    """What every τ of a grid costs a chain; counts, so that curves of many clips add.

    tau: radians, (n,); repaired: error frames repaired by 80 % or more, (n,); errors: error frames
    in all; alarms: intervals applied in the cleaned clips, (n,); minutes: their length; noise: that
    of the clips, radians, one for every clip; drawn: the errors one by one, where known; where
    there are none nothing is unknown; own: the detector's automatic τ, radians, one for every clip,
    where that is another than the noise.
    """

    tau: Array
    repaired: Array
    errors: int
    alarms: Array
    minutes: float
    noise: tuple[float, ...]
    drawn: DrawnErrors | None = None
    own: tuple[float, ...] = ()

    @property
    def fsr(self) -> Array:
        """Share of the error frames that were repaired, 0…1, (n,); NaN where nothing was drawn."""
        share: Array = (
            self.repaired / self.errors if self.errors else np.full(len(self.tau), np.nan)
        )
        return share

    @property
    def band(self) -> tuple[Array, Array]:
        """Where the FSR lies by what was drawn, 0…1, (n,) each; NaN where nothing tells."""
        return self._drawn.band

    @property
    def alarms_per_minute(self) -> Array:
        """False alarms per minute of clip, (n,); NaN in no minute."""
        rate: Array = self.alarms / (self.minutes or nan)
        return rate

    @property
    def floor(self) -> float:
        """The clips' own noise, radians: the median."""
        return float(np.median(self.noise)) if self.noise else 0.0

    @property
    def automatic(self) -> float:
        """The detector's automatic τ, radians: the median."""
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
        )

    def loss(self, price: float = ALARM_PRICE, smallest: float = SMALLEST_ERROR) -> Array:
        """What every τ loses, (n,): the share of error frames missed, and its alarms at `price`.

        price: the share of the error frames that one false alarm a clip, or a minute of a longer
        one, may cost; smallest: radians, errors below are not looked for.
        """
        fsr = self.fsr
        if self.drawn is not None and (wanted := self.drawn.from_size(smallest)).frames.sum():
            fsr = wanted.fsr
        clips = max(self.minutes, len(self.noise), 1e-9)
        lost: Array = 1.0 - np.nan_to_num(fsr) + price * self.alarms / clips
        return lost

    def suggested(self, price: float = ALARM_PRICE, smallest: float = SMALLEST_ERROR) -> float:
        """τ in radians whose :meth:`loss` is least.

        An alarm costs a person a key, a missed error is never seen: so an alarm is worth 5 points
        of FSR unless somebody has another price, and no τ passes half of the errors over for the
        sake of one alarm. Among equals the largest up to the size of the smallest errors looked
        for: what was drawn here says little about those between. Never below the clips' own noise.
        """
        usable = np.flatnonzero(self.tau >= self.floor)
        if not len(usable):
            return self.floor
        loss = self.loss(price, smallest)[usable]
        good = usable[loss <= loss.min() + LOSS_ALLOWED]
        modest = good[self.tau[good] <= smallest]
        return float(self.tau[modest[-1] if len(modest) else good[0]])

    def at(self, tau: float) -> tuple[float, float]:
        """FSR, 0…1, and false alarms at τ radians, from the neighbours on the grid."""
        cost = self.cost(tau)
        return cost.fsr, cost.alarms

    def cost(self, tau: float) -> Cost:
        """The same with the band, and how long was looked for alarms."""
        return cost_of_all([(self, tau)])

    @property
    def _drawn(self) -> DrawnErrors:
        none, nobody = np.zeros(0), np.zeros(0, dtype=int)
        nothing = DrawnErrors(none, none, nobody, nobody, np.zeros((0, len(self.tau))))
        return self.drawn or nothing

    def _place(self, tau: float) -> tuple[int, float]:
        """The place on the grid below τ, and the share of the way to the next, in log τ."""
        at = float(np.interp(math.log(max(tau, 1e-9)), np.log(self.tau), range(len(self.tau))))
        below = min(int(at), max(len(self.tau) - 2, 0))
        return below, at - below


@dataclass(frozen=True)
class Cost:
    """What a τ costs; NaN where it was not measured.

    fsr: 0…1; low, high: where it lies by what was drawn, at 95 % confidence; alarms: counted in
    `minutes` of clip.
    """

    fsr: float
    low: float
    high: float
    alarms: float
    minutes: float

    @property
    def rate(self) -> float:
        """Alarms a minute; NaN in no minute."""
        return self.alarms / (self.minutes or nan)

    @property
    def rate_band(self) -> tuple[float, float]:
        """Alarms a minute that clips like these may have, by those counted, at 95 % confidence."""
        low, high = rate_band(self.alarms)
        return (low / self.minutes, high / self.minutes) if self.minutes else (0.0, math.inf)


def cost_of_all(chosen: Sequence[tuple[TauCurve, float]], minutes: float | None = None) -> Cost:
    """What several chains, each at its own τ in radians, cost together.

    All their frames and all their alarms, in `minutes` of clip: more chains make it no longer.
    Where it is not given they are all of the same clips.
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
    """A chain's τ with the reasons for it; degrees, per cent; NaN where not measured."""

    tau: float
    noise: float
    fsr: float
    alarms_per_minute: float


def tuned(curve: TauCurve, tau: float | None = None) -> Tuned:
    """The suggestion of a curve, or a τ in radians, with what it costs."""
    tau = curve.suggested() if tau is None else tau
    cost = curve.cost(tau)
    return Tuned(
        tau=math.degrees(tau),
        noise=math.degrees(curve.floor),
        fsr=100.0 * cost.fsr,
        alarms_per_minute=cost.rate,
    )
