"""A curve that is fast to draw: a line with gaps at missing values."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter, QPainterPath, QPen
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from twistcore.skeleton.rotation import Array

_NOTHING = np.zeros(0)


class Line(pg.GraphicsObject):
    """A line through points. The caller must repaint the plot after a change.

    The curve class of pyqtgraph has more features, but it scans all points to compute its bounding
    box. This line uses the visible range as its bounding box.
    """

    def __init__(self, view: pg.ViewBox) -> None:
        super().__init__()
        self._view = view
        self._points = (_NOTHING, _NOTHING)
        self._path: QPainterPath | None = None
        self.pen = QPen()
        self.smooth = False
        view.sigRangeChanged.connect(lambda *_: self.prepareGeometryChange())

    def show_points(self, x: Array, y: Array) -> None:
        """Set the points from frames `x` and values `y`, (points,) each. NaN breaks the line."""
        self._points = x, y
        self._path = None

    def points(self) -> tuple[Array, Array]:
        """Return the frames and values of the points, (points,) each."""
        return self._points

    def boundingRect(self) -> QRectF:
        """Return the visible range as the bounding box."""
        return QRectF(self._view.viewRect())

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw a line through the points, broken at NaN."""
        if self._path is None:
            x, y = self._points
            self._path = pg.arrayToQPath(x, y, connect="finite", finiteCheck=True)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, self.smooth)
        painter.setPen(self.pen)
        painter.drawPath(self._path)
