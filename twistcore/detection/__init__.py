"""Finding the intervals in which a parent and its child twist against each other.

A detector analyses a motion once, without any threshold; its analysis then answers for every τ
quickly enough to follow a dragged line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from twistcore.detection.consistency.detector import ConsistencyDetector
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.paper import PaperDetector
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array
from twistcore.work.progress import Tell


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

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
    ) -> Analysis:
        """Everything that does not depend on τ; tell: how far it is."""
        ...


DETECTORS: Mapping[str, Detector] = {
    detector.name: detector for detector in (ConsistencyDetector(), PaperDetector())
}
DEFAULT_METHOD = "consistency"


__all__ = [
    "DEFAULT_METHOD",
    "DETECTORS",
    "Analysis",
    "Detector",
    "Interval",
    "Kind",
]
