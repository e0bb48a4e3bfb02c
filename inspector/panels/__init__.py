"""Tables and forms around the document."""

from inspector.panels.chains import ChainsPanel
from inspector.panels.clips import ClipsPanel
from inspector.panels.detail import DetailCard
from inspector.panels.history import HistoryPanel
from inspector.panels.intervals import IntervalsPanel
from inspector.panels.transport import Transport

__all__ = ["ChainsPanel", "ClipsPanel", "DetailCard", "HistoryPanel", "IntervalsPanel", "Transport"]
