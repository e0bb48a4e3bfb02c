"""A plot that is painted with its window, not by itself."""

from __future__ import annotations

from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import Signal


class Canvas(pg.PlotWidget):
    """A plot widget that repaints when it is told to `touch`.

    Left to itself every graphics scene repaints its window at once and alone: four plots, four
    repaints, each of which puts the whole window together with the 3D view.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.setViewportUpdateMode(self.ViewportUpdateMode.NoViewportUpdate)

    def touch(self) -> None:
        """Be painted with the window's next repaint."""
        self.viewport().update()


class TauLine(pg.InfiniteLine):
    """A line that is dragged; says when it moves, and when the mouse comes over it or leaves it."""

    changed = Signal()

    def __init__(self, **options: Any) -> None:
        super().__init__(movable=True, **options)
        self.sigPositionChanged.connect(self.changed)

    def setMouseHover(self, hover: bool) -> None:
        """It is drawn thicker under the mouse."""
        if hover != self.mouseHovering:
            super().setMouseHover(hover)
            self.changed.emit()
