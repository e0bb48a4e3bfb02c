"""The time line: curves, strength with τ, interval regions, the overview of the clip."""

from inspector.plots.overview import OverviewStrip
from inspector.plots.proposal import proposed_interval
from inspector.plots.timeline import Timeline

__all__ = ["OverviewStrip", "Timeline", "proposed_interval"]
