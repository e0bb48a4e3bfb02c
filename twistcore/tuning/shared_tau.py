"""Decide from τ curves whether one τ suits all chains, and which chains need their own τ."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from twistcore.tuning.tau_curve import ALARM_PRICE, SMALLEST_ERROR, TauCurve
from twistcore.work.frozen import dataclass

SLIGHT = 0.01  # a chain whose loss rises by less than this does not need its own τ


@dataclass(frozen=True)
class SharedTau:
    """The threshold τ that suits most chains, and a comparison with each chain's own τ.

    Parameters
    ----------
    tau
        The shared τ in radians.
    best
        Names of the chains for which exactly the shared τ is suggested.
    served
        Names of the chains for which the shared τ is almost as good as their own τ.
    apart
        For each chain that needs its own τ, this τ in radians and a short reason, keyed by name.
    """

    tau: float
    best: tuple[str, ...]
    served: tuple[str, ...]
    apart: Mapping[str, tuple[float, str]]

    @property
    def chains(self) -> int:
        """Return the number of compared chains."""
        return len(self.best) + len(self.served) + len(self.apart)

    def words(self, labels: Mapping[str, str]) -> str:
        """Return a summary of the comparison in one or two sentences.

        `labels` maps chain names to displayed names.
        """
        degrees = np.degrees(self.tau)
        of, few = self.chains, len(self.served)
        said = (
            f"1 of {of} chains does best with {degrees:.2f}°"
            if len(self.best) == 1
            else f"{len(self.best)} of {of} chains do best with {degrees:.2f}°"
        )
        if few:
            lose = (
                "1 chain loses less than one percentage point with this τ"
                if few == 1
                else f"{few} chains lose less than one percentage point with this τ"
            )
            said = f"{said}; {lose}" if self.apart else f"{said} and {lose}"
        if not self.apart:
            return f"{said}: one τ is enough for all chains."
        own = (
            f"{labels.get(name, name)} {np.degrees(tau):.2f}° ({why})"
            for name, (tau, why) in self.apart.items()
        )
        return f"{said}. These chains need their own τ: {'; '.join(own)}."


def shared_tau(
    curves: Mapping[str, TauCurve],
    price: float = ALARM_PRICE,
    smallest: float = SMALLEST_ERROR,
) -> SharedTau | None:
    """Return the τ that suits most chains, or None if there are no curves.

    Parameters
    ----------
    curves
        The τ curve of each chain, keyed by chain name.
    price
        The share of error frames that may be missed to avoid one false alarm.
    smallest
        Size, in radians, of the smallest error that must be found.
    """
    if not curves:
        return None
    own = {name: curve.suggested(price, smallest) for name, curve in curves.items()}
    found: list[SharedTau] = []
    for tau in sorted(set(own.values())):
        others = {name: curve for name, curve in curves.items() if own[name] != tau}
        why = {name: _why(c, tau, own[name], price, smallest) for name, c in others.items()}
        found.append(
            SharedTau(
                tau,
                tuple(name for name in own if name not in others),
                tuple(name for name, reason in why.items() if not reason),
                {name: (own[name], reason) for name, reason in why.items() if reason},
            )
        )
    return min(found, key=lambda shared: (len(shared.apart), -len(shared.best)))


def _why(curve: TauCurve, tau: float, own: float, price: float, smallest: float) -> str:
    """Return the reason why a chain needs its own τ, or '' if the shared `tau` is good enough.

    `own` is the τ suggested for the chain. Both values are in radians.
    """
    if tau < curve.floor:
        return f"its noise does not allow a τ below {np.degrees(curve.floor):.2f}°"
    loss = curve.loss(price, smallest)
    there, here = np.interp(np.log([tau, own]), np.log(curve.tau), loss)
    if there - here < SLIGHT:
        return ""
    fsr, alarms = curve.at(tau)
    own_fsr, own_alarms = curve.at(own)
    if price * (alarms - own_alarms) > own_fsr - fsr:
        at = f"{np.degrees(tau):.2f}°"
        if round(alarms) == 1:
            return f"1 false alarm at {at}, but {own_alarms:.0f} at this τ"
        return f"{alarms:.0f} false alarms at {at}, but {own_alarms:.0f} at this τ"
    return (
        f"this τ repairs {100 * own_fsr:.0f} % of the errors, but only {100 * fsr:.0f} % are "
        f"repaired at {np.degrees(tau):.2f}°"
    )
