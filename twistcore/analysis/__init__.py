"""Analyse one clip: detection, correction, quality, and decomposition of rotations."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from twistcore.analysis.clip_analysis import ClipAnalysis, Detection, analyse, detect

__all__ = ["ClipAnalysis", "Detection", "analyse", "detect"]

if not TYPE_CHECKING:
    # Loaded on first use, because quality and decomposition need no detector.
    def __getattr__(name: str) -> object:
        if name in __all__:
            module = import_module(f"{__name__}.clip_analysis")
            globals()[name] = value = getattr(module, name)
            return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
