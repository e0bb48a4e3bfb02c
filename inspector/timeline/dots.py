"""Dots and rings in a plot, all at the same frame."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from inspector.timeline.layers import Layer, Scenery
from inspector.timeline.pane import Pane

_DOT, _RING = 4.0, 6.5  # radii in pixels; a dot and a ring at the same place are both visible


class Dots(Layer):
    """The dots and rings of one plot, all at the same frame.

    Attributes
    ----------
    frame
        The frame of all dots.
    dots
        Pairs (value on the plot's axis, True for a ring or False for a dot).
    """

    def __init__(self, view: pg.ViewBox, scenery: Scenery, role: str = "after") -> None:
        super().__init__(view, scenery, 60.0)
        self._role = role
        self.frame = 0
        self.dots: list[tuple[float, bool]] = []

    def mark(self, pane: Pane) -> None:
        """Request a repaint of the part of a pane that contains the dots."""
        if self.dots:
            wide = 2.0 * _RING * self.scenery.scale
            strip = QRectF(self.place(self.frame) - wide, 0.0, 2.0 * wide, self._view.height())
            pane.viewport().update(strip.translated(self._view.scenePos()).toAlignedRect())

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw the visible dots, each with a rim in the background colour."""
        low, high = self._view.viewRange()[1]
        theme = self.scenery.theme
        ink, paper = QColor(getattr(theme, self._role)), QColor(theme.surface)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for height, ring in self.dots:
            at = QPointF(
                self.place(self.frame), (high - height) / (high - low) * self._view.height()
            )
            if not QRectF(self._view.rect()).contains(at):
                continue
            scale = self.scenery.scale
            for colour, extra in ((paper, 1.5), (ink, 0.0)):
                radius = ((_RING if ring else _DOT) + (0.0 if ring else extra)) * scale
                painter.setPen(
                    QPen(colour, (2.0 + 2.0 * extra) * scale) if ring else Qt.PenStyle.NoPen
                )
                painter.setBrush(Qt.BrushStyle.NoBrush if ring else colour)
                painter.drawEllipse(at, radius, radius)
        painter.restore()
