"""A curve of a plot: nothing but a line, broken where there are no values."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter, QPainterPath, QPen
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from twistcore.skeleton.rotation import Array

_NOTHING = np.zeros(0)


class Line(pg.GraphicsObject):
    """Points joined by a line; who changes it says when the plot is painted anew.

    pyqtgraph's own curve can fill, step and export values as well, and looks through all its points
    whenever it is asked how large it is. This one is as large as what is in view.
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
        """Frames and heights, both (points,); NaN breaks the line."""
        self._points = x, y
        self._path = None

    def points(self) -> tuple[Array, Array]:
        """Frames and heights as they were given."""
        return self._points

    def boundingRect(self) -> QRectF:
        """What is in view."""
        return QRectF(self._view.viewRect())

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """The line."""
        if self._path is None:
            x, y = self._points
            self._path = pg.arrayToQPath(x, y, connect="finite", finiteCheck=True)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, self.smooth)
        painter.setPen(self.pen)
        painter.drawPath(self._path)
