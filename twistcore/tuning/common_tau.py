"""Decide whether one threshold τ is enough for all chains, or which chains need their own τ.

The decision is tested on verdicts that were not used to choose τ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from twistcore.tuning.tau_curve import ALARM_PRICE, SMALLEST_ERROR
from twistcore.tuning.verdict_curve import Suggestion, VerdictCurve, tau_curve_from_verdicts
from twistcore.tuning.verdicts_of import JudgedClip

_DRAWS = 1000
_DOUBT = 0.05  # accepted probability that any chain gets its own τ by chance


@dataclass(frozen=True, eq=False)
class ChainTau:
    """A comparison of one chain's own τ with the common τ.

    Attributes
    ----------
    chain
        Name of the chain.
    curve
        Precision and recall of the chain at every τ.
    own
        The τ suggested for this chain alone, or None if the chain has too few verdicts.
    apart
        True if `own` costs less than the common τ, even on verdicts that were not used to choose
        `own`.
    """

    chain: str
    curve: VerdictCurve
    own: Suggestion | None
    apart: bool


@dataclass(frozen=True, eq=False)
class CommonTau:
    """The τ suggested by the verdicts on all chains, with a comparison for each chain."""

    common: Suggestion | None
    chains: tuple[ChainTau, ...]

    def tau(self, chain: str) -> float | None:
        """Return the τ of a chain in radians: its own τ if the chain needs one, or the common τ.

        The result is None if there are too few verdicts for a common τ.
        """
        for c in self.chains:
            if c.chain == chain and c.apart and c.own is not None:
                return c.own.tau
        return self.common.tau if self.common else None

    def limits_sentence(self) -> str:
        """Return a sentence about the smallest accepted error and the range of τ, or ''."""
        if self.common is None or math.isnan(self.common.least):
            return ""
        low, high, least = map(math.degrees, (self.common.low, self.common.high, self.common.least))
        return (
            f"The smallest accepted error is {least:.1f}°; any τ from {low:.2f} to {high:.2f}° "
            "may be equally good."
        )

    def words(self, label: Callable[[str], str] = str) -> Iterator[str]:
        """Yield sentences that say whether one τ is enough, and why some chains need their own.

        `label` is a function that returns the displayed name of a chain.
        """
        if self.common is None:
            return
        tau = math.degrees(self.common.tau)
        own = [c for c in self.chains if c.apart]
        known = [c for c in self.chains if c.own is not None]
        few = len(self.chains) - len(known)
        rest = (
            "1 chain has too few verdicts for its own τ."
            if few == 1
            else f"{few} chains have too few verdicts for their own τ."
        )
        if not known:
            yield (
                f"Use one τ of {tau:.2f}° for all chains: no chain has enough verdicts of its own."
            )
        elif not own:
            said = (
                f"One τ of {tau:.2f}° is enough for all chains. On verdicts that were not "
                "used to choose it, no chain does better with a τ of its own."
            )
            yield f"{said} {rest}" if few else said
        else:
            said = f"One τ of {tau:.2f}° is enough for all chains except {len(own)}."
            yield f"{said} {rest}" if few else said
        for c in own:
            yield self._why(c, label(c.chain))
        if limits := self.limits_sentence():
            yield limits

    def _why(self, chain: ChainTau, name: str) -> str:
        assert self.common is not None
        assert chain.own is not None
        curve = chain.curve
        more, less = _differences(curve, chain.own, self.common)
        tells = []
        if less > 0:
            natural = int(curve.natural.sum())
            tells.append(
                "no longer lists the rejected interval"
                if natural == 1
                else f"lists {less} fewer of the {natural} rejected intervals"
            )
        if more > 0:
            tells.append(f"finds {more} more of the {int(curve.errors.sum())} errors")
        if less < 0:
            tells.append(f"lists {-less} more of the rejected intervals")
        if more < 0:
            tells.append(f"misses {-more} more of the {int(curve.errors.sum())} errors")
        return (
            f"{name} needs its own τ of {math.degrees(chain.own.tau):.2f}°, because this τ "
            f"{', '.join(tells)}."
        )


def _differences(curve: VerdictCurve, own: Suggestion, common: Suggestion) -> tuple[int, int]:
    """Compare a chain's own τ with the common τ, and return the differences in errors and alarms.

    The result is the number of additional errors that `own` finds and the number of false alarms
    that it avoids. Both numbers can be negative.
    """
    here, there = curve.at(own.tau), curve.at(common.tau)
    found, alarms = curve.found.sum(axis=0), curve.alarms.sum(axis=0)
    return int(found[here] - found[there]), int(alarms[there] - alarms[here])


def common_tau(
    clips: Sequence[JudgedClip],
    price: float = ALARM_PRICE,
    smallest: float = SMALLEST_ERROR,
    *,
    seed: int = 0,
) -> CommonTau:
    """Return the common τ and the chains that need their own τ.

    The verdicts on chains with their own τ do not affect the common τ. `price` is the cost of one
    false alarm per clip. `smallest` is the size, in radians, of the smallest error that must be
    found. `seed` seeds the resampling of the verdicts.
    """
    names = sorted({v.chain for clip in clips for v in clip.verdicts})
    curves = {name: tau_curve_from_verdicts(clips, name) for name in names}
    own = {name: c.suggested(price, smallest, seed=seed) for name, c in curves.items()}
    tested = sum(o is not None for o in own.values())
    apart: set[str] = set()
    while True:
        rest = [clip.without(apart) for clip in clips]
        common = tau_curve_from_verdicts(rest).suggested(price, smallest, seed=seed)
        if common is None:
            break
        gains = {
            name: _gain(curves[name], common.tau, price, smallest, seed)
            for name in names
            if own[name] is not None and name not in apart
        }
        new = {k: g for k, (g, sure) in gains.items() if g > 0 and sure >= 1 - _DOUBT / tested}
        if not new:
            break
        # Only one chain at a time, since the common τ then changes.
        apart.add(max(new, key=lambda name: new[name]))
    common = common or tau_curve_from_verdicts(clips).suggested(price, smallest)
    chains = []
    for name in names:
        mine = own[name]
        # The common τ has changed as chains were excluded, and may now suit an excluded chain.
        better = mine and common and max(_differences(curves[name], mine, common)) > 0
        needs = name in apart and bool(better)
        chains.append(ChainTau(name, curves[name], mine, needs))
    return CommonTau(common, tuple(chains))


def _gain(
    curve: VerdictCurve, common: float, price: float, smallest: float, seed: int
) -> tuple[float, float]:
    """Return how much a chain's own τ saves on average, and the share of draws in which it saves.

    The saving is the reduction of the cost relative to the τ `common` (radians). In every random
    draw, a τ is chosen on the drawn rows of the curve and tested on the other rows, because a τ
    always looks best on the rows on which it was chosen. Errors of other chains help to choose τ,
    but only rows of this chain count as savings.
    """
    drawn = curve.draw(_DRAWS, seed)
    left = (drawn == 0).astype(float)
    fair = left.sum(axis=1) > 0
    drawn, left = drawn[fair], left[fair]
    if len(drawn) < _DRAWS // 10:
        return 0.0, 0.0
    own = curve.best(curve.cost(price, drawn), smallest)
    cost = replace(curve, others=(np.zeros(0), 0)).cost(price, left)
    saved = cost[:, curve.at(common)] - cost[np.arange(len(own)), own]
    # A tie, with no remaining row between the two τ, is no evidence for either.
    sure = (saved > 0).mean() + 0.5 * (saved == 0).mean()
    return float(saved.mean()), float(sure)
