"""The computations for the detector of [Choi26] §3.3. `detectors/paper.py` declares it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import Array, wrap
from twistcore.skeleton.signals import TwistSignals

DEFAULT_TAU = float(np.radians(5.0))  # the paper gives no τ; this one reproduces its success rates


@dataclass(frozen=True, eq=False)
class PaperAnalysis:
    """The analysis of a motion by the paper's detector, before a threshold is chosen.

    `signals` contains the signals of each chain, keyed by chain name.
    """

    signals: Mapping[str, TwistSignals]

    def automatic_tau(self, chain: str) -> float:
        """Return the automatic τ in radians, which is the same for all chains."""
        del chain
        return DEFAULT_TAU

    def strength(self, chain: str) -> Array:
        """Return the strength m(t) of a chain, radians, (frames,)."""
        return self.signals[chain].strength

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of a chain at threshold τ in radians, sorted by start."""
        return intervals_of_offset(
            chain, paper_detector_running_offset(self.signals[chain], tau), tau
        )

    def removed(self, chain: str, tau: float) -> Array:
        """Return the running offset that the paper's correction removes, radians, (frames,)."""
        return paper_detector_running_offset(self.signals[chain], tau)


def paper_detector_running_offset(signals: TwistSignals, tau: float) -> Array:
    """Return offset(t) = offset(t−1) + err(t), with err = sign(Δθp)·m where m ≥ τ [Choi26 §3.3.1].

    The offset is in radians, (frames,), and is not wrapped. It may not return to 0, because the
    errors of the estimates add up.
    """
    return np.cumsum(paper_detector_error_increments(signals.dtheta_p, signals.strength, tau))


def paper_detector_error_increments(dtheta_p: ArrayLike, strength: ArrayLike, tau: float) -> Array:
    """Return err(t) = sign(Δθp)·m where m ≥ τ, and 0 elsewhere [Choi26 §3.3.1].

    `dtheta_p` contains Δθp and `strength` contains m, in radians. The result has their shape.
    """
    found: Array = np.where(np.asarray(strength) >= tau, np.sign(dtheta_p) * strength, 0.0)
    return found


def intervals_of_offset(chain: str, offset: Array, tau: float) -> tuple[Interval, ...]:
    """Divide a chain's running offset into intervals that a person can judge.

    `offset` is the result of :func:`paper_detector_running_offset`, and τ is in radians. An
    interval begins where the offset changes, and it ends where the wrapped offset is below τ. The
    remaining offset is the interval's residual and is not added to the next interval. An interval
    that does not close extends to the last frame, and its residual is the offset there.
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
