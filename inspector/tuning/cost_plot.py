"""A plot of the cost of τ: the share of repaired errors (FSR) and the false alarms."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor

from inspector.tuning.tau_plots import LABEL_ROOM, TauPlot
from inspector.widgets.axes import Axis
from inspector.widgets.theme import Colours, Theme
from twistcore.tuning import TauCurve

_FEW_ALARMS = 4.0  # the right axis shows at least this many
_BAND_ALPHA = 60


class PercentAxis(Axis):
    """An axis in per cent, with a tick at every 25 % or 50 %."""

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """Return the tick positions between `low` and `high`, for an axis `size` pixels long."""
        room = LABEL_ROOM * (high - low) / max(size, 1.0)
        step = 25.0 if room <= 25.0 else 50.0
        return [(step, [float(v) for v in np.arange(0.0, 101.0, step)])]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Return the tick labels in per cent."""
        return [f"{v:.0f} %" for v in values]


class CostPlot(TauPlot):
    """A plot of the share of repaired errors (FSR, left axis) and false alarms (right axis) over τ.

    The FSR has a confidence band. A triangle ▼ marks the suggested τ.
    """

    def __init__(self, colours: Colours) -> None:
        super().__init__(PercentAxis("left"))
        self._alarms_view = pg.ViewBox(enableMenu=False, enableMouse=False)
        self.scene().addItem(self._alarms_view)
        self.axes["right"].linkToView(self._alarms_view)
        self.axes["right"].setStyle(showValues=True, tickLength=-4)
        self._alarms_view.setXLink(self.view)
        self.view.sigResized.connect(self._fit)
        self.alarms = pg.PlotCurveItem([0.0, 1.0], [0.0], stepMode="center", fillLevel=0.0)
        self._alarms_view.addItem(self.alarms)
        self._edges = pg.PlotCurveItem(), pg.PlotCurveItem()
        self.band = pg.FillBetweenItem(*self._edges)
        self.band.setZValue(5)
        self.addItem(self.band)
        self.fsr = pg.PlotCurveItem()
        self.fsr.setZValue(10)
        self.addItem(self.fsr)
        self.mark = pg.ScatterPlotItem(symbol="t", size=11)
        self.mark.setZValue(25)
        self.addItem(self.mark)
        self.view.setYRange(0.0, 100.0, padding=0.08)
        self._alarms_view.setYRange(0.0, _FEW_ALARMS, padding=0.08)
        self.alarms.setVisible(False)
        self._fit()
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        super()._colour(theme)
        self.fsr.setPen(pg.mkPen(theme.after, width=2.0))
        shade = QColor(theme.after)
        shade.setAlpha(_BAND_ALPHA)
        self.band.setBrush(shade)
        fill = QColor(theme.rejected)
        fill.setAlpha(90)
        self.alarms.setBrush(fill)
        self.alarms.setPen(pg.mkPen(theme.rejected, width=1.0))
        self.mark.setBrush(pg.mkBrush(theme.accepted))
        self.mark.setPen(pg.mkPen(theme.surface, width=1.0))
        self.axes["left"].setTextPen(QColor(theme.after))
        self.axes["right"].setTextPen(QColor(theme.rejected))

    def show_curve(self, curve: TauCurve | None) -> None:
        """Show the cost curve of one chain or the common curve of several chains.

        None clears the plot.
        """
        self.touch()
        known = curve is not None and curve.drawn is not None
        self.band.setVisible(known)
        self.alarms.setVisible(curve is not None and curve.errors > 0)
        if curve is None or not curve.errors:
            self.fsr.setData([], [])
            self.mark.setData([], [])
            return
        x = np.log10(np.degrees(curve.tau))
        self.fsr.setData(x, 100.0 * curve.fsr)
        if known:
            for edge, share in zip(self._edges, curve.band, strict=True):
                edge.setData(x, 100.0 * share)
        middle = 0.5 * (x[1:] + x[:-1])
        self.alarms.setData(np.concatenate([x[:1], middle, x[-1:]]), curve.alarms)
        most = max(_FEW_ALARMS, 1.15 * float(curve.alarms.max()))
        self._alarms_view.setYRange(0.0, most, padding=0.08)

    def show_suggestion(self, curve: TauCurve, suggested: float) -> None:
        """Mark the suggested τ, in radians, on the visible curve."""
        self.touch()
        if curve.errors:
            place = float(np.log10(np.degrees(suggested)))
            self.mark.setData([place], [100.0 * curve.at(suggested)[0]])

    def _fit(self) -> None:
        self._alarms_view.setGeometry(self.view.sceneBoundingRect())
        self._alarms_view.linkedViewChanged(self.view, pg.ViewBox.XAxis)
