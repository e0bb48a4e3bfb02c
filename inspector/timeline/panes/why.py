"""The pane with the measured quantity that explains why the selected interval is listed."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.curves import Curves
from inspector.timeline.layers import Scenery
from inspector.timeline.pane import Pane
from inspector.timeline.plot import Plot
from inspector.timeline.why_listed import WhyListed, selected_plottable_interval


def _axis(curves: Curves) -> str:
    return tr("why listed") if selected_plottable_interval(curves.document) is not None else ""


def _draw(_: Curves, pane: Pane) -> None:
    pane.refresh()


def _build(document: Document, scenery: Scenery, parent: QWidget) -> Pane:
    return WhyListed(document, scenery, parent)


plot = Plot(
    key="why",
    title=tr("Why the interval is listed"),
    place=5,
    weight=4,
    priority=5,
    axis=_axis,
    draw=_draw,
    build=_build,
)
