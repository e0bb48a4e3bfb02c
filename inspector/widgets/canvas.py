"""A plot that is painted with its window, not by itself."""

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
    """A view with its axes, which repaints when it is told to `touch`.

    Left to itself every graphics scene repaints its window at once and alone: four plots, four
    repaints. pyqtgraph's own plot also makes forty widgets for a menu that nobody sees.
    """

    def __init__(
        self,
        axes: Mapping[str, pg.AxisItem],
        view: pg.ViewBox | None = None,
        parent: QWidget | None = None,
    ) -> None:
        """axes: by side, 'left', 'bottom', 'right'; without a view, one that no mouse moves."""
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
        """Put something into the view; the range does not follow it."""
        self.view.addItem(item, ignoreBounds=True)

    def colour_ground(self, theme: Theme) -> None:
        """A theme's colours for paper and axes."""
        self.setBackground(theme.surface)
        for axis in self.axes.values():
            axis.setPen(QPen(QColor(theme.line), 1.0))
            axis.setTextPen(QColor(theme.soft))

    def count_from(self, first: int) -> None:
        """Call the first frame `first`, on an axis of frames."""
        axis = self.axes["bottom"]
        axis.first, axis.picture = first, None
        self.touch()

    def set_type(self, font: QFont) -> None:
        """The type of the numbers at the axes."""
        for axis in self.axes.values():
            axis.setStyle(tickFont=font, tickLength=-4, autoExpandTextSpace=False)

    def touch(self) -> None:
        """Be painted with the window's next repaint."""
        self.viewport().update()


class TauLine(pg.InfiniteLine):
    """A line that is dragged; says when it moves, and when the mouse comes over it or leaves it."""

    changed = Signal()

    def __init__(self, **options: Any) -> None:
        super().__init__(movable=True, **options)
        self.sigPositionChanged.connect(self.changed)

    def let_go(self) -> None:
        """Out of the hand that drags it: what that hand does next is no longer about it."""
        self.moving = False

    def setMouseHover(self, hover: bool) -> None:
        """It is drawn thicker under the mouse."""
        if hover != self.mouseHovering:
            super().setMouseHover(hover)
            self.changed.emit()
