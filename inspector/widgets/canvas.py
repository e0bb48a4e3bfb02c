"""A plot that is repainted together with its window."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import Signal
from PySide6.QtGui import QColor, QFont, QPen
from PySide6.QtWidgets import QGraphicsGridLayout, QGraphicsItem, QSizePolicy, QWidget

from inspector.widgets.theme import Theme

_PLACES = {"left": (0, 0), "bottom": (1, 1), "right": (0, 2)}  # row and column; the view's is 0, 1


class Canvas(pg.GraphicsView):
    """A plot view with its axes, which repaints after `touch`.

    By default every graphics scene repaints the window by itself: four plots cause four repaints.
    pyqtgraph's own plot also creates forty widgets for a menu that is never used.
    """

    def __init__(
        self,
        axes: Mapping[str, pg.AxisItem],
        view: pg.ViewBox | None = None,
        parent: QWidget | None = None,
    ) -> None:
        """`axes`: by side, 'left', 'bottom' or 'right'; view: None for one without mouse input."""
        super().__init__(parent)
        self.setViewportUpdateMode(self.ViewportUpdateMode.NoViewportUpdate)
        self.enableMouse(False)
        self.view = view or pg.ViewBox(enableMenu=False, enableMouse=False)
        self.view.disableAutoRange()
        self.axes = dict(axes)
        plot = pg.GraphicsWidget()
        self.grid = QGraphicsGridLayout(plot)
        self.grid.setContentsMargins(0, 2, 8, 0)
        self.grid.setSpacing(0)
        self.grid.addItem(self.view, 0, 1)
        for side, axis in self.axes.items():
            axis.linkToView(self.view)
            axis.enableAutoSIPrefix(False)
            axis.setZValue(-1000)
            axis.setFlag(QGraphicsItem.GraphicsItemFlag.ItemNegativeZStacksBehindParent)
            self.grid.addItem(axis, *_PLACES[side])
        self.grid.setRowStretchFactor(0, 1)
        self.grid.setColumnStretchFactor(1, 1)
        self.setCentralItem(plot)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setFrameShape(self.Shape.NoFrame)

    def addItem(self, item: pg.GraphicsObject) -> None:
        """Add an item to the view without changing the range."""
        self.view.addItem(item, ignoreBounds=True)

    def colour_ground(self, theme: Theme) -> None:
        """Use a theme's colours for background and axes."""
        self.setBackground(theme.surface)
        for axis in self.axes.values():
            axis.setPen(QPen(QColor(theme.line), 1.0))
            axis.setTextPen(QColor(theme.soft))

    def count_from(self, first: int) -> None:
        """Count frames from `first` on the axis of frames."""
        axis = self.axes["bottom"]
        axis.first, axis.picture = first, None
        self.touch()

    def set_type(self, font: QFont) -> None:
        """Set the font of the axes' numbers."""
        for axis in self.axes.values():
            axis.setStyle(tickFont=font, tickLength=-4, autoExpandTextSpace=False)

    def touch(self) -> None:
        """Repaint the plot at the window's next repaint."""
        self.viewport().update()


class TauLine(pg.InfiniteLine):
    """A line that can be dragged; `changed` reports moves, and the mouse entering or leaving."""

    changed = Signal()

    def __init__(self, **options: Any) -> None:
        super().__init__(movable=True, **options)
        self.sigPositionChanged.connect(self.changed)

    def let_go(self) -> None:
        """End a drag, so that the mouse no longer moves the line."""
        self.moving = False

    def setMouseHover(self, hover: bool) -> None:
        """Report when the mouse enters or leaves, as the line gets thicker then."""
        if hover != self.mouseHovering:
            super().setMouseHover(hover)
            self.changed.emit()
