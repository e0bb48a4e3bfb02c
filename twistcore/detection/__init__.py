"""Find errors: counter-twists, rolls, flips, jumps, spikes and noise, with notes about them.

A detector analyses a motion once, without a threshold. The resulting analysis returns the intervals
for any τ, fast enough for a person to drag the threshold line.
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
    # Loaded on first use because it needs numpy, which listing the names of detectors does not.
    def __getattr__(name: str) -> object:
        if name == "Interval":
            return import_module(f"{__name__}.interval").Interval
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
