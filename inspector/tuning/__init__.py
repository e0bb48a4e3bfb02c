"""The tuning tab: what every τ costs this clip, suggestions, profiles."""

from inspector.tuning.actions import TuningActions
from inspector.tuning.panel import TuningPanel

__all__ = ["TuningActions", "TuningPanel"]
