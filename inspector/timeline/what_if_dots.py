"""Dots in the plots at the playhead that show the values of an edited frame.

A full dot shows θp or m, and a ring shows θc; both have the colour of the pose after correction.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from inspector.language import tr
from inspector.timeline.curves import Curves, in_degrees
from inspector.timeline.layers import Layer, Scenery
from inspector.timeline.pane import Pane
from inspector.timeline.plot import Plot
from inspector.widgets.axes import root_scale

_DOT, _RING = 4.0, 6.5  # radii in pixels; a dot and a ring at the same point are both visible
_SPARE = 0.12  # margin around a dot outside the range, as a share of the range


class WhatIfDots:
    """The dots in all plots of a timeline."""

    def __init__(
        self, panes: Mapping[str, Pane], plots: Mapping[str, Plot], scenery: Scenery
    ) -> None:
        """Set up the dots.

        `plots` has the descriptions of the panes, with the same keys as `panes`.
        """
        self._plots = {key: plot for key, plot in plots.items() if plot.dots}
        self._panes = {key: panes[key] for key in self._plots}
        self.layers = {key: _Dots(pane.view, scenery) for key, pane in self._panes.items()}
        self._values: dict[str, float] = {}

    def show(self, curves: Curves | None, frame: int, values: Mapping[str, float]) -> None:
        """Show the angles of an edited frame, radians keyed by name, except undefined angles."""
        self._values = dict(curves.completed(frame, values)) if curves is not None else {}
        for key, pane in self._panes.items():
            dots = []
            plot = self._plots[key]
            for name, _, ring in plot.dots:
                if curves is not None and name in self._values:
                    degrees = plot.height(curves, name, self._values[name])
                    dots.append((float(root_scale(degrees)) if pane.root else degrees, ring))
            self._place(pane, self.layers[key], frame, dots)

    def title(self, key: str) -> list[tuple[str, str]]:
        """Return the part of a plot's title about its dots, as pairs (text, colour role)."""
        parts: list[tuple[str, str]] = []
        plot = self._plots.get(key)
        for name, symbol, ring in plot.dots if plot is not None else ():
            if name in self._values:
                angle = in_degrees(float(np.degrees(self._values[name]))).strip()
                first = "" if parts else f" {tr('what if')}"
                parts.append((f"  {first} {symbol} {'○' if ring else '●'} {angle}", "after"))
        return parts

    def _place(self, pane: Pane, layer: _Dots, frame: int, dots: list[tuple[float, bool]]) -> None:
        if (frame, dots) == (layer.frame, layer.dots):
            return
        layer.mark(pane)
        layer.frame, layer.dots = frame, dots
        layer.mark(pane)
        heights = [height for height, _ in dots]
        pane.time.include((min(heights), max(heights)) if heights else None, _SPARE)


class _Dots(Layer):
    """The dots of one plot, at heights in the plot's own values."""

    def __init__(self, view: pg.ViewBox, scenery: Scenery) -> None:
        super().__init__(view, scenery, 60.0)
        self.frame = 0
        self.dots: list[tuple[float, bool]] = []

    def mark(self, pane: Pane) -> None:
        """Show the dots in a pane, and repaint the strip that contains them."""
        if self.dots:
            wide = 2.0 * _RING * self.scenery.scale
            strip = QRectF(self.place(self.frame) - wide, 0.0, 2.0 * wide, self._view.height())
            pane.viewport().update(strip.translated(self._view.scenePos()).toAlignedRect())

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw the visible dots with a rim in the background colour."""
        low, high = self._view.viewRange()[1]
        ink, paper = QColor(self.scenery.theme.after), QColor(self.scenery.theme.surface)
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
