"""The base class of plots with τ on the horizontal axis."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal

from inspector.widgets.axes import Axis
from inspector.widgets.canvas import Canvas, TauLine
from inspector.widgets.theme import Theme, figures_font

LOWEST, HIGHEST = 0.5, 180.0  # the visible range in degrees
_DEGREES = (0.5, 1, 2, 5, 10, 20, 50, 100, 180)
AXIS_WIDTH, _AXIS_HEIGHT = 44, 18
LABEL_ROOM = 17.0  # pixels between two labels of a vertical axis
_LINE_WIDTH = 1.6


class _WholeAxis(Axis):
    """An axis with ticks at whole numbers only."""

    def tickSpacing(self, low: float, high: float, size: float) -> list[tuple[float, float]]:
        """Return a tick spacing that is a whole number."""
        step = max(1.0, np.ceil(LABEL_ROOM * (high - low) / max(size, 1.0)))
        return [(float(step), 0.0)]


class TauPlot(Canvas):
    """A plot with τ, in degrees, on the horizontal axis.

    When the user drags the τ line or double-clicks, `asked` is emitted with the new τ in degrees,
    and a flag that is True during a drag.
    """

    asked = Signal(float, bool)  # τ in degrees; True during a drag
    dropped = Signal()

    def __init__(self, left: pg.AxisItem) -> None:
        bottom, right = Axis("bottom"), _WholeAxis("right")
        bottom.setTicks([[(float(np.log10(d)), f"{d:g}°") for d in _DEGREES]])
        super().__init__({"left": left, "bottom": bottom, "right": right})
        self.grid.setContentsMargins(0, 2, 2, 0)
        self.set_type(figures_font(8.0))
        bottom.setHeight(_AXIS_HEIGHT)
        for axis in (left, right):
            axis.setWidth(AXIS_WIDTH)
        right.setStyle(showValues=False, tickLength=0)
        self.view.setXRange(np.log10(LOWEST), np.log10(HIGHEST), padding=0.03)
        self.floor_line = pg.InfiniteLine(angle=90)
        self.tau_line = TauLine(angle=90)
        self.tau_line.changed.connect(self.touch)
        self.tau_line.setBounds([float(np.log10(LOWEST)), float(np.log10(HIGHEST))])
        self.tau_line.setCursor(Qt.CursorShape.SizeHorCursor)
        self.tau_line.setZValue(30)
        self.floor_line.setZValue(20)
        self.addItem(self.floor_line)
        self.addItem(self.tau_line)
        self.tau_line.sigDragged.connect(lambda line: self.asked.emit(10 ** line.value(), True))
        self.tau_line.sigPositionChangeFinished.connect(self.dropped)
        self.scene().sigMouseClicked.connect(self._clicked)
        self.setMinimumHeight(56)

    def _clicked(self, event: Any) -> None:
        if event.double() and event.button() == Qt.MouseButton.LeftButton:
            at = self.view.mapSceneToView(event.scenePos()).x()
            self.asked.emit(float(np.clip(10**at, LOWEST, HIGHEST)), False)

    def _colour(self, theme: Theme) -> None:
        self.colour_background(theme)
        self.tau_line.setPen(pg.mkPen(theme.tau, width=_LINE_WIDTH))
        self.tau_line.setHoverPen(pg.mkPen(theme.tau, width=3.0))
        self.floor_line.setPen(pg.mkPen(theme.soft, width=1.2, style=Qt.PenStyle.DashLine))
        self.touch()

    def show_tau(self, degrees: float, *, held: bool) -> None:
        """Move the τ line, unless the user is dragging it."""
        place = float(np.log10(np.clip(degrees, LOWEST, HIGHEST)))
        if not held and self.tau_line.value() != place:
            self.tau_line.setValue(place)

    def show_floor(self, degrees: float) -> None:
        """Move the dashed line, for example to the detector's automatic τ."""
        self.floor_line.setValue(float(np.log10(max(degrees, LOWEST))))
        self.touch()
