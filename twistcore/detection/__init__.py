"""Finding the intervals in which a parent and its child twist against each other.

A detector analyses a motion once, without any threshold; its analysis then answers for every τ
quickly enough to follow a dragged line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from twistcore.chain import Chain
from twistcore.detection.consistency import ConsistencyDetector
from twistcore.detection.interval import Interval
from twistcore.detection.paper import PaperDetector
from twistcore.motion import Motion
from twistcore.progress import Tell, nobody
from twistcore.rotation import Array


class Analysis(Protocol):
    """What a detector knows of a motion before any τ."""

    def automatic_tau(self, chain: str) -> float:
        """τ in radians when nobody names one."""
        ...

    def strength(self, chain: str) -> Array:
        """The curve that the τ line lies on, radians ≥ 0, shape (frames,)."""
        ...

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Intervals of a chain at τ radians, by start."""
        ...


class Detector(Protocol):
    """A way of finding twist errors."""

    name: str

    def analyse(self, motion: Motion, chains: Sequence[Chain], tell: Tell = nobody) -> Analysis:
        """Everything that does not depend on τ; tell: how far it is."""
        ...


DETECTORS: Mapping[str, Detector] = {
    detector.name: detector for detector in (ConsistencyDetector(), PaperDetector())
}
DEFAULT_METHOD = "consistency"


def detect(
    motion: Motion,
    chains: Sequence[Chain],
    method: str = DEFAULT_METHOD,
    tau: float | Mapping[str, float] | None = None,
) -> tuple[Interval, ...]:
    """Intervals of all chains, by chain and start; τ in radians, for all or by chain name."""
    analysis = DETECTORS[method].analyse(motion, chains)
    taus = resolve_tau(analysis, chains, tau)
    return tuple(i for chain in chains for i in analysis.intervals(chain.name, taus[chain.name]))


def resolve_tau(
    analysis: Analysis, chains: Sequence[Chain], tau: float | Mapping[str, float] | None = None
) -> dict[str, float]:
    """τ in radians of every chain: as given, else the analysis' own."""
    if tau is None:
        return {chain.name: analysis.automatic_tau(chain.name) for chain in chains}
    if isinstance(tau, Mapping):
        own = resolve_tau(analysis, chains)
        return {name: tau.get(name, value) for name, value in own.items()}
    return {chain.name: float(tau) for chain in chains}


__all__ = [
    "DEFAULT_METHOD",
    "DETECTORS",
    "Analysis",
    "Detector",
    "Interval",
    "detect",
    "resolve_tau",
]
