"""Detection of errors in a motion: counter-twists, rolls, flips, jumps, spikes and noise.

A detector analyses a motion once, without a threshold. The resulting analysis computes the
intervals at any threshold τ, fast enough to update them while a user drags the threshold line.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from twistcore.detection.kind import Kind, KindInfo
from twistcore.detection.protocol import Analysis, Detector, DetectorInfo
from twistcore.detection.registry import DEFAULT_METHOD, DETECTORS, register

if TYPE_CHECKING:
    from twistcore.detection.interval import Interval

__all__ = [
    "DEFAULT_METHOD",
    "DETECTORS",
    "Analysis",
    "Detector",
    "DetectorInfo",
    "Interval",
    "Kind",
    "KindInfo",
    "register",
]

if not TYPE_CHECKING:
    # `Interval` needs numpy, which takes long to load, so it is imported on first use.
    def __getattr__(name: str) -> object:
        if name == "Interval":
            return import_module(f"{__name__}.interval").Interval
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
