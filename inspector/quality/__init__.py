"""The quality tab: evidence of every joint over time, and tracking with QuaMo."""

from inspector.quality.actions import QualityActions
from inspector.quality.panel import QualityPanel

__all__ = ["QualityActions", "QualityPanel"]
