"""Two plots over τ, linked: how strong the frames of a chain are, and what every τ costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor

from inspector.widgets.axes import Axis, apart
from inspector.widgets.canvas import Canvas, TauLine
from inspector.widgets.theme import Theme, figures_font
from twistcore.rotation import Array
from twistcore.tuning import TauCurve

LOWEST, HIGHEST = 0.5, 180.0  # degrees in view
_BINS = np.linspace(np.log10(LOWEST), np.log10(HIGHEST), 65)
_DEGREES = (0.5, 1, 2, 5, 10, 20, 50, 100, 180)
_COUNTS = (0, 1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000)
_AXIS_WIDTH, _AXIS_HEIGHT = 44, 18
_LABEL_ROOM = 17.0  # pixels between two labels of a vertical axis
_LINE_WIDTH = 1.6


class _DegreesAxis(Axis):
    """Degrees on a logarithmic scale."""

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """Round degrees."""
        return [(1.0, [float(np.log10(d)) for d in _DEGREES])]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """The degrees that a place stands for."""
        return [f"{10**v:.3g}°" for v in values]


class _CountAxis(Axis):
    """Frames on the scale log(1 + n), on which a single one is still seen."""

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """Round counts, as many as find room."""
        room = _LABEL_ROOM * (high - low) / max(size, 1.0)
        chosen = apart((float(np.log1p(n)) for n in _COUNTS), room)
        return [(1.0, [at for at in chosen if at <= high - 0.5 * room])]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """The count that a place stands for."""
        return [f"{np.expm1(v):.0f}" for v in values]


class PercentAxis(Axis):
    """Per cent in quarters, or in halves where there is little room."""

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """0, 50, 100 and what lies between."""
        room = _LABEL_ROOM * (high - low) / max(size, 1.0)
        step = 25.0 if room <= 25.0 else 50.0
        return [(step, [float(v) for v in np.arange(0.0, 101.0, step)])]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """With the unit."""
        return [f"{v:.0f} %" for v in values]


class _WholeAxis(Axis):
    """Whole numbers only."""

    def tickSpacing(self, low: float, high: float, size: float) -> list[tuple[float, float]]:
        """Nothing is between two alarms."""
        step = max(1.0, np.ceil(_LABEL_ROOM * (high - low) / max(size, 1.0)))
        return [(float(step), 0.0)]


class TauPlot(Canvas):
    """A plot over τ in degrees with the τ line, which can be dragged; a double click sets it too.

    It shows what it is given; `asked` says what the person wants.
    """

    asked = Signal(float, bool)  # degrees; True while a drag goes on
    dropped = Signal()

    def __init__(self, left: pg.AxisItem) -> None:
        bottom, right = _DegreesAxis("bottom"), _WholeAxis("right")
        super().__init__({"left": left, "bottom": bottom, "right": right})
        self.grid.setContentsMargins(0, 2, 2, 0)
        self.set_type(figures_font(8.0))
        bottom.setHeight(_AXIS_HEIGHT)
        for axis in (left, right):
            axis.setWidth(_AXIS_WIDTH)
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

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self.colour_ground(theme)
        self.tau_line.setPen(pg.mkPen(theme.tau, width=_LINE_WIDTH))
        self.tau_line.setHoverPen(pg.mkPen(theme.tau, width=3.0))
        self.floor_line.setPen(pg.mkPen(theme.soft, width=1.2, style=Qt.PenStyle.DashLine))
        self.touch()

    def show_tau(self, degrees: float, *, held: bool) -> None:
        """Put the line at τ; not under a hand that holds it."""
        place = float(np.log10(np.clip(degrees, LOWEST, HIGHEST)))
        if not held and self.tau_line.value() != place:
            self.tau_line.setValue(place)

    def show_floor(self, degrees: float) -> None:
        """The noise floor."""
        self.floor_line.setValue(float(np.log10(max(degrees, LOWEST))))
        self.touch()


class Histogram(TauPlot):
    """Frames by strength: below τ faint, from τ on full; the paper's m(t) as a grey outline."""

    def __init__(self, theme: Theme) -> None:
        super().__init__(_CountAxis("left"))
        self._counts = np.zeros(len(_BINS) - 1)
        self._tau = LOWEST
        self.m, self.below, self.above = (
            pg.PlotCurveItem(_BINS, self._counts, stepMode="center", fillLevel=0.0)
            for _ in range(3)
        )
        for item in (self.m, self.below, self.above):
            self.addItem(item)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        super().set_theme(theme)
        for item, colour, alpha in (
            (self.m, theme.soft, 60),
            (self.below, theme.before, 70),
            (self.above, theme.before, 255),
        ):
            fill = QColor(colour)
            fill.setAlpha(alpha)
            item.setBrush(fill)
            item.setPen(pg.mkPen(colour, width=0.8))

    def show_strength(self, strength: Array, m: Array | None) -> None:
        """strength, m: degrees, (frames,); m None where the strength is m itself."""
        self._counts = _counted(strength)
        shown = np.log1p(_counted(m)) if m is not None else np.zeros(len(_BINS) - 1)
        self.m.setData(_BINS, shown)
        top = float(max(np.log1p(self._counts).max(), shown.max(), np.log1p(3)))
        self.view.setYRange(0.0, 1.08 * top, padding=0.0)
        self._split()

    def show_tau(self, degrees: float, *, held: bool) -> None:
        """The line, and which frames reach it."""
        super().show_tau(degrees, held=held)
        if degrees != self._tau:
            self._tau = degrees
            self._split()

    def _split(self) -> None:
        reaches = _BINS[1:] > np.log10(self._tau)
        shown = np.log1p(self._counts)
        self.below.setData(_BINS, np.where(reaches, 0.0, shown))
        self.above.setData(_BINS, np.where(reaches, shown, 0.0))
        self.touch()


class CostPlot(TauPlot):
    """FSR (left scale) and false alarms (right scale) against τ; a triangle at the suggestion."""

    def __init__(self, theme: Theme) -> None:
        super().__init__(PercentAxis("left"))
        self._alarms_view = pg.ViewBox(enableMenu=False, enableMouse=False)
        self.scene().addItem(self._alarms_view)
        self.axes["right"].linkToView(self._alarms_view)
        self.axes["right"].setStyle(showValues=True, tickLength=-4)
        self._alarms_view.setXLink(self.view)
        self.view.sigResized.connect(self._fit)
        self.alarms = pg.PlotCurveItem([0.0, 1.0], [0.0], stepMode="center", fillLevel=0.0)
        self._alarms_view.addItem(self.alarms)
        self.fsr = pg.PlotCurveItem()
        self.fsr.setZValue(10)
        self.addItem(self.fsr)
        self.mark = pg.ScatterPlotItem(symbol="t", size=11)
        self.mark.setZValue(25)
        self.addItem(self.mark)
        self.view.setYRange(0.0, 100.0, padding=0.08)
        self._fit()
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        super().set_theme(theme)
        self.fsr.setPen(pg.mkPen(theme.after, width=2.0))
        fill = QColor(theme.rejected)
        fill.setAlpha(90)
        self.alarms.setBrush(fill)
        self.alarms.setPen(pg.mkPen(theme.rejected, width=1.0))
        self.mark.setBrush(pg.mkBrush(theme.accepted))
        self.mark.setPen(pg.mkPen(theme.surface, width=1.0))
        self.axes["left"].setTextPen(QColor(theme.after))
        self.axes["right"].setTextPen(QColor(theme.rejected))

    def show_curve(self, curve: TauCurve | None) -> None:
        """The curve of a chain, or of several added up; None: not measured yet."""
        self.touch()
        if curve is None:
            self.fsr.setData([], [])
            self.alarms.setData([0.0, 1.0], [0.0])
            self.mark.setData([], [])
            return
        x = np.log10(np.degrees(curve.tau))
        self.fsr.setData(x, 100.0 * curve.fsr)
        middle = 0.5 * (x[1:] + x[:-1])
        self.alarms.setData(np.concatenate([x[:1], middle, x[-1:]]), curve.alarms)
        most = max(4.0, 1.15 * float(curve.alarms.max()))
        self._alarms_view.setYRange(0.0, most, padding=0.08)
        tau = curve.suggested()
        self.mark.setData([float(np.log10(np.degrees(tau)))], [100.0 * curve.at(tau)[0]])

    def _fit(self) -> None:
        self._alarms_view.setGeometry(self.view.sceneBoundingRect())
        self._alarms_view.linkedViewChanged(self.view, pg.ViewBox.XAxis)


def _counted(degrees: Array) -> Array:
    seen = degrees[degrees >= LOWEST]
    counts, _ = np.histogram(np.log10(np.minimum(seen, HIGHEST)), _BINS)
    return counts.astype(np.float64)
