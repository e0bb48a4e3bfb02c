"""The histogram of a chain's strength. A click on a bar moves the playhead to one of its frames."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QResizeEvent
from PySide6.QtWidgets import QLabel

from inspector.language import plural
from inspector.tuning.tau_plots import AXIS_WIDTH, HIGHEST, LABEL_ROOM, LOWEST, TauPlot
from inspector.widgets.axes import Axis, spaced_ticks
from inspector.widgets.theme import Colours, Theme, figures_font
from twistcore.skeleton.rotation import Array

_BINS = np.linspace(np.log10(LOWEST), np.log10(HIGHEST), 65)
_COUNTS = (0, 1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000)


class _CountAxis(Axis):
    """An axis for counts n with the scale log(1 + n), so that even a count of one is visible."""

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """Return as many tick positions as fit, at round numbers."""
        room = LABEL_ROOM * (high - low) / max(size, 1.0)
        chosen = spaced_ticks((float(np.log1p(n)) for n in _COUNTS), room)
        return [(1.0, [at for at in chosen if at <= high - 0.5 * room])]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Return the tick labels."""
        return [f"{np.expm1(v):.0f}" for v in values]


class Histogram(TauPlot):
    """A histogram of the strength over all frames, with the paper's m(t) as a grey outline.

    Bars below τ are faint. A click on a bar emits `picked` with the index of the bar.

    Attributes
    ----------
    words
        A label that describes the bar under the mouse or, if there is none, the chosen bar.
    """

    picked = Signal(int)

    def __init__(self, colours: Colours) -> None:
        super().__init__(_CountAxis("left"))
        self.words = QLabel(self)
        self.words.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.words.setFont(figures_font(8.0))
        self._choice_words, self._chosen, self._pointed = "", -1, -1
        self.mark = pg.PlotCurveItem(_BINS[:2], np.zeros(1), stepMode="center", fillLevel=0.0)
        self.mark.setZValue(15)
        self.addItem(self.mark)
        self.setMouseTracking(True)
        self._counts = np.zeros(len(_BINS) - 1)
        self._tau = LOWEST
        self.m, self.below, self.above = (
            pg.PlotCurveItem(_BINS, self._counts, stepMode="center", fillLevel=0.0)
            for _ in range(3)
        )
        for item in (self.m, self.below, self.above):
            self.addItem(item)
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        super()._colour(theme)
        self.words.setStyleSheet(
            f"color: {theme.text}; background: {theme.surface}; padding: 0 3px;"
        )
        self.mark.setPen(pg.mkPen(theme.accent, width=2.5))
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
        """Show the histograms of the strength and of the paper's m, both in degrees, (frames,).

        `m` is None if the strength is the same as m.
        """
        self._counts = _counted(strength)
        shown = np.log1p(_counted(m)) if m is not None else np.zeros(len(_BINS) - 1)
        self.m.setData(_BINS, shown)
        top = float(max(np.log1p(self._counts).max(), shown.max(), np.log1p(3)))
        self.view.setYRange(0.0, 1.08 * top, padding=0.0)
        self._split()

    def show_choice(self, bar: int | None, words: str) -> None:
        """Mark a bar, and describe it with `words`. If `bar` is None, mark no bar."""
        self._chosen, self._choice_words = -1 if bar is None else bar, words
        if bar is not None:
            self.mark.setData(_BINS[bar : bar + 2], np.log1p(self._counts[bar : bar + 1]))
        self.mark.setVisible(bar is not None)
        self._show_words()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Describe the bar under the mouse."""
        super().mouseMoveEvent(event)
        bar = self._bar_at(self.mapToScene(event.position().toPoint()))
        if bar != self._pointed:
            self._pointed = bar
            self._show_words()

    def leaveEvent(self, event: QEvent) -> None:
        """When the mouse leaves the plot, describe the chosen bar again."""
        super().leaveEvent(event)
        self._pointed = -1
        self._show_words()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Move the label to the new right edge of the plot."""
        super().resizeEvent(event)
        if hasattr(self, "words"):
            self._place_words()

    def _clicked(self, event: Any) -> None:
        super()._clicked(event)
        if not event.double() and event.button() == Qt.MouseButton.LeftButton:
            bar = self._bar_at(event.scenePos())
            if bar >= 0:
                self.picked.emit(bar)

    def _bar_at(self, place: QPointF) -> int:
        """Return the index of the bar at a point of the scene, or −1 if there is no bar."""
        if not self.view.sceneBoundingRect().contains(place):
            return -1
        bar = int(np.searchsorted(_BINS, self.view.mapSceneToView(place).x())) - 1
        return bar if 0 <= bar < len(self._counts) and self._counts[bar] else -1

    def _show_words(self) -> None:
        """Describe the bar under the mouse or, if there is none, the chosen bar."""
        words = self._choice_words
        if self._pointed >= 0 and (self._pointed != self._chosen or not words):
            frames = int(self._counts[self._pointed])
            bar = histogram_bar_label(self._pointed)
            words = plural("{bar}: {n} frame", "{bar}: {n} frames", frames, bar=bar)
        self.words.setText(words)
        self.words.setVisible(bool(words))
        self._place_words()
        self.touch()

    def _place_words(self) -> None:
        self.words.adjustSize()
        self.words.move(self.width() - AXIS_WIDTH - self.words.width() - 4, 2)

    def show_tau(self, degrees: float, *, held: bool) -> None:
        """Move the τ line, and emphasise the bars at and above τ.

        `held` is True while the user drags the line.
        """
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


def histogram_bar_index(degrees: Array) -> NDArray[np.int_]:
    """Return the index of the bar that contains each strength, (frames,).

    The index is −1 for a strength below the first bar.
    """
    place = np.log10(np.clip(degrees, LOWEST, HIGHEST))
    bars = np.minimum(np.searchsorted(_BINS, place, side="right") - 1, len(_BINS) - 2)
    return np.where(degrees < LOWEST, -1, bars)


def histogram_bar_label(bar: int) -> str:
    """Return the range of strengths in a bar as text."""
    low, high = 10 ** _BINS[bar], 10 ** _BINS[bar + 1]
    return f"{low:.3g}–{high:.3g}°"


def _counted(degrees: Array) -> Array:
    bars = histogram_bar_index(degrees)
    return np.bincount(bars[bars >= 0], minlength=len(_BINS) - 1).astype(np.float64)
