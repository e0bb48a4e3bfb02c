"""A plot that is repainted together with its window."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import Signal
from PySide6.QtGui import QColor, QFont, QPen
from PySide6.QtWidgets import QGraphicsGridLayout, QGraphicsItem, QSizePolicy, QWidget

from inspector.widgets.theme import Theme

# Row and column of each axis; the view is at (0, 1)
_PLACES = {"left": (0, 0), "bottom": (1, 1), "right": (0, 2)}


class Canvas(pg.GraphicsView):
    """A plot with its axes. Call `touch` to repaint it.

    A normal graphics view repaints the window whenever its scene changes, so four plots would cause
    four repaints. The plot widget of pyqtgraph would also create forty widgets for a menu that is
    never used.
    """

    def __init__(
        self,
        axes: Mapping[str, pg.AxisItem],
        view: pg.ViewBox | None = None,
        parent: QWidget | None = None,
    ) -> None:
        """Build the plot.

        Parameters
        ----------
        axes
            The axes, keyed by side: 'left', 'bottom' or 'right'.
        view
            The view that shows the curves. None creates a view without mouse input.
        """
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
        """Add an item to the view without changing the range of the axes."""
        self.view.addItem(item, ignoreBounds=True)

    def colour_background(self, theme: Theme) -> None:
        """Apply the theme's colours to the background and the axes."""
        self.setBackground(theme.surface)
        for axis in self.axes.values():
            axis.setPen(QPen(QColor(theme.line), 1.0))
            axis.setTextPen(QColor(theme.soft))

    def count_from(self, first: int) -> None:
        """Set the number that the bottom axis shows for the first frame."""
        axis = self.axes["bottom"]
        axis.first, axis.picture = first, None
        self.touch()

    def set_type(self, font: QFont) -> None:
        """Set the font of the numbers on the axes."""
        for axis in self.axes.values():
            axis.setStyle(tickFont=font, tickLength=-4, autoExpandTextSpace=False)

    def touch(self) -> None:
        """Request a repaint of the plot. Qt paints it together with the rest of the window."""
        self.viewport().update()


class TauLine(pg.InfiniteLine):
    """A line at the threshold τ that the user can drag.

    The signal `changed` is emitted when the line moves and when the mouse enters or leaves it.
    """

    changed = Signal()

    def __init__(self, **options: Any) -> None:
        super().__init__(movable=True, **options)
        self.sigPositionChanged.connect(self.changed)

    def stop_dragging(self) -> None:
        """Stop a drag. The mouse then no longer moves the line."""
        self.moving = False

    def setMouseHover(self, hover: bool) -> None:
        """Emit `changed` when the mouse enters or leaves, because this changes the line's width."""
        if hover != self.mouseHovering:
            super().setMouseHover(hover)
            self.changed.emit()
