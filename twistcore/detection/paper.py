"""What the detector of [Choi26] §3.3 computes; the detector is `detectors/paper.py`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import Array, wrap
from twistcore.skeleton.signals import TwistSignals

DEFAULT_TAU = float(np.radians(5.0))  # the paper names none; 5° gives its success rates again


@dataclass(frozen=True, eq=False)
class PaperAnalysis:
    """The signals of every chain; a new τ only thresholds them."""

    signals: Mapping[str, TwistSignals]

    def automatic_tau(self, chain: str) -> float:
        """τ in radians for a chain when nobody names one."""
        del chain
        return DEFAULT_TAU

    def strength(self, chain: str) -> Array:
        """m(t), radians, shape (frames,)."""
        return self.signals[chain].strength

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Intervals of a chain at τ radians."""
        return intervals_of_offset(chain, running_offset(self.signals[chain], tau), tau)

    def removed(self, chain: str, tau: float) -> Array:
        """What the paper's correction takes out at τ radians: its running sum, (frames,)."""
        return running_offset(self.signals[chain], tau)


def running_offset(signals: TwistSignals, tau: float) -> Array:
    """offset(t) = offset(t−1) + err(t), err = sign(Δθp)·m where m ≥ τ; (frames,) [Choi26 §3.3.1].

    Raw: it is not wrapped and, as errors of estimation add up, never returns to zero for sure.
    """
    return np.cumsum(error_of(signals.dtheta_p, signals.strength, tau))


def error_of(dtheta_p: ArrayLike, strength: ArrayLike, tau: float) -> Array:
    """err(t) = sign(Δθp)·m where m ≥ τ, else 0; radians, the inputs' shape [Choi26 §3.3.1]."""
    found: Array = np.where(np.asarray(strength) >= tau, np.sign(dtheta_p) * strength, 0.0)
    return found


def intervals_of_offset(chain: str, offset: Array, tau: float) -> tuple[Interval, ...]:
    """The running sum cut into intervals for a person to judge.

    An event opens one; it closes where |wrap(offset)| < τ. What is left then is its residual and
    is not carried into the next. Without an end it runs to the last frame, residual and all.
    """
    found = []
    events = np.flatnonzero(np.diff(offset, prepend=0.0) != 0.0)
    start, base = -1, 0.0
    for t in events:
        left = float(wrap(offset[t] - base))
        if start < 0:
            start, base = int(t), float(offset[t - 1]) if t > 0 else 0.0
        elif abs(left) < tau:
            found.append(
                Interval(chain, start, int(t), wrap(offset[start:t] - base), residual=left)
            )
            start, base = -1, float(offset[t])
    if start >= 0:
        rest = wrap(offset[start:] - base)
        found.append(Interval(chain, start, len(offset), rest, residual=float(rest[-1])))
    return tuple(found)
