"""A small plot of curves over the clip's frames, with the playhead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal

from inspector.widgets.axes import FrameAxis, RootAxis, UnitAxis
from inspector.widgets.canvas import Canvas
from inspector.widgets.theme import Colours, Theme, figures_font
from twistcore.skeleton.rotation import Array

_AXIS_WIDTH, _AXIS_HEIGHT = 46, 18


@dataclass(frozen=True, eq=False)
class Trace:
    """A curve in a plot.

    Attributes
    ----------
    x, y
        The frames and the values, (points,) each. NaN makes a gap.
    role
        The name of the curve's colour in the theme.
    dots
        True to also draw the points as dots, because a line does not show isolated points.
    """

    x: Array
    y: Array
    role: str
    dots: bool = False


class TracePlot(Canvas):
    """A plot of curves. The signal `asked` is emitted with the frame that the user clicks."""

    asked = Signal(int)

    def __init__(self, colours: Colours, unit: str = "", *, root: bool = False) -> None:
        """Build the plot.

        `unit` is written after the numbers on the left axis. `root` is True for degrees on a
        square-root scale.
        """
        left = RootAxis("left") if root else UnitAxis("left")
        if isinstance(left, UnitAxis):
            left.unit = unit
        super().__init__({"left": left, "bottom": FrameAxis("bottom")})
        self._lines: Sequence[Trace] = ()
        self.curves: list[pg.PlotCurveItem] = []
        self._dots = pg.ScatterPlotItem(symbol="o", size=3, pen=None)
        self.axes["left"].setWidth(_AXIS_WIDTH)
        self.axes["bottom"].setHeight(_AXIS_HEIGHT)
        self.set_type(figures_font(8.0))
        self.playhead = pg.InfiniteLine(angle=90)
        self.playhead.setZValue(20)
        self._level = pg.InfiniteLine(angle=0)
        self._level.hide()
        for item in (self.playhead, self._level, self._dots):
            self.addItem(item)
        self.scene().sigMouseClicked.connect(self._clicked)
        self.setMinimumHeight(56)
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        self.theme = theme
        self.colour_background(theme)
        self.playhead.setPen(pg.mkPen(theme.accent, width=1.5))
        self._level.setPen(pg.mkPen(theme.soft, width=1.0, style=Qt.PenStyle.DashLine))
        self.show_lines(self._lines)

    def show_lines(self, lines: Sequence[Trace]) -> None:
        """Replace the curves of the plot."""
        self._lines = tuple(lines)
        # Curves are reused and never removed, because Qt may still paint a removed item.
        while len(self.curves) < len(lines):
            self.curves.append(pg.PlotCurveItem())
            self.addItem(self.curves[-1])
        dots = [line for line in lines if line.dots]
        for curve, line in zip_longest(self.curves, lines):
            if line is None:
                curve.setData([], [])
                continue
            pen = pg.mkPen(getattr(self.theme, line.role), width=1.3)
            curve.setData(line.x, line.y, pen=pen, connect="finite", antialias=True)
        places = np.hstack([np.zeros((2, 0)), *(np.stack([k.x, k.y]) for k in dots)])
        self._dots.setData(
            *places[:, np.isfinite(places[1])],
            brush=pg.mkBrush(getattr(self.theme, dots[0].role)) if dots else None,
        )
        self.touch()

    def show_range(self, frames: int, low: float, high: float) -> None:
        """Show all frames and the values between `low` and `high`."""
        self.view.setXRange(-0.5, max(frames - 0.5, 0.5), padding=0.0)
        high = high if high > low else low + 1.0
        self.view.setYRange(low, high, padding=0.06)
        self.touch()

    def fit(self, frames: int) -> None:
        """Show all frames, and the values from 0 to the maximum."""
        tops = [float(np.nanmax(k.y)) for k in self._lines if np.isfinite(k.y).any()]
        self.show_range(frames, 0.0, max([*tops, 1e-3]))

    def show_level(self, value: float | None) -> None:
        """Draw a horizontal line at a value. None removes the line."""
        self._level.setVisible(value is not None)
        if value is not None:
            self._level.setValue(value)
        self.touch()

    def show_frame(self, frame: int) -> None:
        """Move the playhead to a frame."""
        self.playhead.setValue(frame)
        self.touch()

    def _clicked(self, event: Any) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            at = self.view.mapSceneToView(event.scenePos()).x()
            self.asked.emit(round(at))
