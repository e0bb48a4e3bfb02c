"""Plots of verdicts: precision and recall over τ, and the reliability of the confidence."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor

from inspector.tuning.cost_plot import PercentAxis
from inspector.tuning.tau_plots import TauPlot
from inspector.widgets.axes import Axis
from inspector.widgets.canvas import Canvas
from inspector.widgets.theme import Colours, Theme, figures_font
from twistcore.skeleton.rotation import Array
from twistcore.tuning import TauCurve
from twistcore.tuning.learned_confidence import Reliability
from twistcore.tuning.verdict_curve import Suggestion, VerdictCurve

_AXIS_WIDTH, _AXIS_HEIGHT = 44, 18
_NONE: tuple[list[float], list[float]] = ([], [])
_ALPHA = 45  # opacity of bands
_SMALLEST_DOT, _LARGEST_DOT = 5.0, 14.0  # pixels


class PrecisionPlot(TauPlot):
    """A plot of precision and recall over τ, with confidence bands.

    A triangle marks the suggested τ. For comparison with the recall, a dotted curve shows the share
    of injected errors that are repaired. Precision is drawn only to the right of the dashed line,
    because no interval with a lower strength was reviewed.
    """

    def __init__(self, colours: Colours) -> None:
        super().__init__(PercentAxis("left"))
        self.recall, self.precision = pg.PlotCurveItem(), pg.PlotCurveItem()
        self.injected = pg.PlotCurveItem()
        self._ends = [pg.PlotCurveItem() for _ in range(4)]
        self._bands = [pg.FillBetweenItem(*self._ends[k : k + 2]) for k in (0, 2)]
        self.mark = pg.ScatterPlotItem(symbol="t", size=11)
        self.between = pg.LinearRegionItem(movable=False)
        self.between.setZValue(-10)
        for item in (*self._ends, *self._bands, self.between, self.recall, self.precision):
            self.addItem(item)
        self.addItem(self.injected)
        self.mark.setZValue(25)
        self.addItem(self.mark)
        self.view.setYRange(0.0, 100.0, padding=0.08)
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        super()._colour(theme)
        for k, (curve, colour) in enumerate(
            ((self.recall, theme.after), (self.precision, theme.accepted))
        ):
            curve.setPen(pg.mkPen(colour, width=2.0))
            self._bands[k].setBrush(_faint(colour, _ALPHA))
            for end in self._ends[2 * k : 2 * k + 2]:
                end.setPen(pg.mkPen(_faint(colour, 2 * _ALPHA), width=0.8))
        self.injected.setPen(pg.mkPen(theme.before, width=1.6, style=Qt.PenStyle.DotLine))
        self.mark.setBrush(pg.mkBrush(theme.accepted))
        self.mark.setPen(pg.mkPen(theme.surface, width=1.0))
        self.between.setBrush(_faint(theme.undecided, _ALPHA))
        for line in self.between.lines:
            line.setPen(pg.mkPen(None))

    def show_injected(self, curve: TauCurve | None) -> None:
        """Plot the share of injected errors that are repaired at each τ. None clears the curve."""
        self.touch()
        known = curve is not None and curve.errors
        x, y = (np.log10(np.degrees(curve.tau)), curve.fsr) if curve and known else _NONE
        self.injected.setData(x, _percent(np.asarray(y)))

    def show_curve(self, curve: VerdictCurve | None, suggestion: Suggestion | None) -> None:
        """Plot the precision and recall for a group of verdicts, with the suggested τ.

        None clears the plot.
        """
        self.touch()
        self.between.setVisible(suggestion is not None)
        self.mark.setData([], [])
        if curve is None:
            for item in (self.recall, self.precision, *self._ends):
                item.setData(*_NONE)
            return
        x = np.log10(np.degrees(curve.tau))
        seen = curve.tau >= curve.reviewed * (1 - 1e-9)
        self.show_floor(float(np.degrees(min(curve.reviewed, np.pi))))
        for item, share in ((self.recall, curve.recall), (self.precision, curve.precision)):
            known = np.isfinite(share) & (seen | (item is self.recall))
            item.setData(x[known], _percent(share[known]))
        for end, share in zip(self._ends[:2], curve.recall_between(), strict=True):
            end.setData(x, _percent(share))
        for end, share in zip(self._ends[2:], curve.precision_between(), strict=True):
            end.setData(x[seen], _percent(share[seen]))
        if suggestion is not None:
            place = float(np.log10(np.degrees(suggestion.tau)))
            high = float(np.nan_to_num(curve.recall[curve.at(suggestion.tau)]))
            self.mark.setData([place], [100.0 * high])
            ends = np.log10(np.degrees([suggestion.low, suggestion.high]))
            self.between.setRegion((float(ends[0]), float(ends[1])))


class ReliabilityPlot(Canvas):
    """A plot of the share of accepted intervals over the confidence, before and after learning.

    Ideally, all dots are on the diagonal. A larger dot represents more intervals, and the bar
    through a dot is the confidence interval of the share.
    """

    def __init__(self, colours: Colours) -> None:
        super().__init__({side: Axis(side) for side in ("left", "bottom")})
        for axis in self.axes.values():
            axis.setTicks([[(k / 5, f"{k / 5:.1f}") for k in range(6)]])
        self.set_type(figures_font(8.0))
        self.axes["left"].setWidth(_AXIS_WIDTH)
        self.axes["bottom"].setHeight(_AXIS_HEIGHT)
        self.right = pg.PlotCurveItem([0.0, 1.0], [0.0, 1.0])
        self.before, self.after = (pg.ScatterPlotItem(symbol=s) for s in ("s", "o"))
        self.lines = [pg.PlotCurveItem(connect="pairs") for _ in range(2)]
        for item in (self.right, *self.lines, self.before, self.after):
            self.addItem(item)
        self.view.setXRange(0.0, 1.0, padding=0.05)
        self.view.setYRange(0.0, 1.0, padding=0.06)
        self.setMinimumHeight(80)
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        self.colour_background(theme)
        self.right.setPen(pg.mkPen(theme.soft, width=1.2, style=Qt.PenStyle.DashLine))
        for dots, line, colour in (
            (self.before, self.lines[0], theme.before),
            (self.after, self.lines[1], theme.after),
        ):
            dots.setBrush(_faint(colour, 190))
            dots.setPen(pg.mkPen(theme.surface, width=1.0))
            line.setPen(pg.mkPen(_faint(colour, 170), width=1.6))
        self.touch()

    def show_reliability(self, before: Reliability | None, after: Reliability | None) -> None:
        """Plot the reliability of the confidence before and after learning.

        None clears the plot.
        """
        for found, dots, lines in zip(
            (before, after), (self.before, self.after), self.lines, strict=True
        ):
            bins = found.bins if found else ()
            most = max((b.count for b in bins), default=1)
            sizes = [
                _SMALLEST_DOT + (_LARGEST_DOT - _SMALLEST_DOT) * (b.count / most) ** 0.5
                for b in bins
            ]
            dots.setData([b.said for b in bins], [b.was for b in bins], size=sizes)
            lines.setData(
                np.repeat([b.said for b in bins], 2),
                np.array([y for b in bins for y in (b.low, b.high)]),
            )
        self.touch()


def _percent(share: Array) -> Array:
    return np.asarray(100.0 * share)


def _faint(colour: str, alpha: int) -> QColor:
    ink = QColor(colour)
    ink.setAlpha(alpha)
    return ink
