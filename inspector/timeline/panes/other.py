"""The pane that shows a second detector for comparison."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.chain_curves import ChainCurves
from inspector.timeline.curves import Curves
from inspector.timeline.layers import Scenery
from inspector.timeline.other_detector import OtherDetector, ReadOnlyGestures
from inspector.timeline.pane import Pane
from inspector.timeline.plot import Plot


def _axis(curves: Curves) -> str:
    return tr("strength (°)") if isinstance(curves, ChainCurves) else ""


def _build(document: Document, scenery: Scenery, parent: QWidget) -> Pane:
    return OtherDetector(document, scenery.colours, parent)


plot = Plot(
    key="other",
    title=tr("Strength of the other detector"),
    place=50,
    weight=4,
    priority=20,
    axis=_axis,
    at_first=False,
    root=True,
    no_limb=tr("There is only one detector for limb flips. Select a chain to compare detectors."),
    gestures=ReadOnlyGestures,
    build=_build,
)
