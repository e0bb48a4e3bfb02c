"""What lies behind and before the curves: interval regions, shading, playhead, title.

Each is one graphics item per plot that paints what is in view, in pixels. Thousands of intervals
cost no more than those on screen; one item per region would be slow.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QLine, QLineF, QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFont, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from inspector.theme import Theme, figures_font
from twistcore.review import Decision, Judged
from twistcore.rotation import Array

TITLE_HEIGHT = 17.0
_CROWDED = 4  # pixels for each region in view below which they are drawn as plain fills
_GLYPH_ROOM = 11  # pixels
_GLYPHS = {Decision.ACCEPTED: "✓", Decision.REJECTED: "✗", Decision.UNDECIDED: "?"}
_BORDERS = {
    Decision.ACCEPTED: Qt.PenStyle.SolidLine,
    Decision.REJECTED: Qt.PenStyle.DotLine,
    Decision.UNDECIDED: Qt.PenStyle.DashLine,
}


@dataclass
class Scenery:
    """What all plots show besides their curves; the time line fills it in, the layers read it."""

    theme: Theme
    frames: int = 0
    frame: int = 0
    intervals: tuple[Judged, ...] = ()  # of the selected chain, by start
    selected: int | None = None
    unreliable: Array = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    starts: Array = field(default_factory=lambda: np.zeros(0))
    stops: Array = field(default_factory=lambda: np.zeros(0))

    def set_intervals(self, intervals: tuple[Judged, ...]) -> None:
        """Other intervals."""
        self.intervals = intervals
        self.starts = np.array([j.interval.start for j in intervals], dtype=np.float64)
        self.stops = np.array([j.interval.stop for j in intervals], dtype=np.float64)

    def between(self, first: float, last: float) -> list[Judged]:
        """Intervals that reach into a range of frames, the selected one last."""
        seen = np.flatnonzero((self.stops - 0.5 > first) & (self.starts - 0.5 < last))
        chosen = [self.intervals[k] for k in seen]
        chosen.sort(key=lambda j: j.id == self.selected)
        return chosen


class Layer(QGraphicsItem):
    """An item over a view's whole rectangle, in its pixels."""

    def __init__(self, view: pg.ViewBox, scenery: Scenery, z: float) -> None:
        # Not a child of the view: that clips its children to a path, which makes fills slow.
        super().__init__(view.parentItem())
        self._view = view
        self.scenery = scenery
        self.setZValue(z)
        self.setAcceptedMouseButtons(Qt.MouseButton.NoButton)
        self.setFlag(QGraphicsItem.GraphicsItemFlag.ItemUsesExtendedStyleOption)
        view.sigResized.connect(self._resized)
        view.sigXRangeChanged.connect(self._moved)

    def _resized(self, *_: object) -> None:
        self.prepareGeometryChange()
        self.setPos(self._view.pos())

    def _moved(self, *_: object) -> None:
        self.update()

    def boundingRect(self) -> QRectF:
        """The view's rectangle."""
        return QRectF(self._view.rect())

    def place(self, frame: float) -> float:
        """Pixel of a place in frames."""
        first, last = self._view.viewRange()[0]
        return float((frame - first) / (last - first) * self._view.width())


class BackLayer(Layer):
    """Unreliable azimuth and interval regions, behind the curves."""

    def __init__(self, view: pg.ViewBox, scenery: Scenery, *, shade: bool, glyphs: bool) -> None:
        super().__init__(view, scenery, -200.0)  # behind the view itself
        self._shade, self._glyphs = shade, glyphs

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Everything that is in view."""
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        if self._shade:
            self._paint_unreliable(painter)
        seen = self.scenery.between(*self._view.viewRange()[0])
        chosen = [j for j in seen[-1:] if j.id == self.scenery.selected]
        if len(seen) * _CROWDED > self._view.width():
            self._paint_crowd(painter, seen)
        else:
            self._paint_regions(painter, seen[: len(seen) - len(chosen)], selected=False)
        self._paint_regions(painter, chosen, selected=True)
        painter.restore()

    def _paint_unreliable(self, painter: QPainter) -> None:
        theme, height = self.scenery.theme, self._view.height()
        first, last = self._view.viewRange()[0]
        tint = mixed(theme.soft, theme.surface, 26)
        spans = self.scenery.unreliable
        seen = spans[(spans[:, 1] - 0.5 > first) & (spans[:, 0] - 0.5 < last)]
        painter.setFont(_small_font())
        for start, stop in seen:
            left = max(0.0, self.place(start - 0.5))
            right = min(self._view.width(), self.place(stop - 0.5))
            width = max(1.0, right - left)
            painter.fillRect(QRectF(left, 0.0, width, height), tint)
            painter.fillRect(QRectF(left, height - 3.0, width, 3.0), _foot(theme))
            text = "azimuth unreliable"
            if width > QFontMetricsF(painter.font()).horizontalAdvance(text) + 12.0:
                painter.setPen(QColor(theme.soft))
                painter.drawText(QPointF(left + 5.0, height - 6.0), text)

    def _paint_crowd(self, painter: QPainter, seen: list[Judged]) -> None:
        """Regions a pixel or two apart: per decision, the columns that they cover."""
        width, height = int(self._view.width()), int(self._view.height())
        for decision in Decision:
            chosen = [j for j in seen if j.decision == decision]
            if not chosen:
                continue
            places = np.array(self._places(chosen))
            steps = np.zeros(width + 2, dtype=np.int64)
            np.add.at(steps, places[:, 0], 1)
            np.add.at(steps, places[:, 1], -1)
            covered = np.concatenate([[False], np.cumsum(steps)[:-1] > 0, [False]])
            theme = self.scenery.theme
            share = 26 if decision == Decision.REJECTED else 52
            colour = mixed(getattr(theme, str(decision)), theme.surface, share)
            for left, right in np.flatnonzero(np.diff(covered)).reshape(-1, 2).tolist():
                painter.fillRect(QRect(left, 0, right - left, height), colour)

    def _paint_regions(self, painter: QPainter, regions: list[Judged], *, selected: bool) -> None:
        """Fills, then borders, of each decision at a stroke."""
        theme, height = self.scenery.theme, int(self._view.height())
        for decision in Decision:
            chosen = [j for j in regions if j.decision == decision]
            if not chosen:
                continue
            name = getattr(theme, str(decision))
            colour = QColor(name)
            places = self._places(chosen)
            rects = [QRect(left, 0, right - left, height) for left, right in places]
            rejected = decision == Decision.REJECTED
            share = (46 if selected else 14) if rejected else (68 if selected else 34)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(mixed(name, theme.surface, share))
            painter.drawRects(rects)
            if rejected:
                stripes = mixed(name, theme.surface, 150 if selected else 90)
                painter.setBrush(QBrush(stripes, Qt.BrushStyle.BDiagPattern))
                painter.drawRects(rects)
            pen = QPen(colour, 2.0 if selected else 1.0, _BORDERS[decision])
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            inside = [x for pair in places for x in pair if 0 < x < self._view.width() - 1]
            painter.drawLines([QLine(x, 0, x, height) for x in inside])
            if selected:
                for x in inside:
                    painter.fillRect(QRect(x - 2, height // 2 - 9, 5, 18), colour)
            if self._glyphs:
                painter.setFont(_small_font(bold=True))
                for left, right in places:
                    if right - left >= _GLYPH_ROOM:
                        box = QRect(left, int(TITLE_HEIGHT), right - left, 14)
                        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, _GLYPHS[decision])

    def _places(self, regions: list[Judged]) -> list[list[int]]:
        """Left and right pixel of each region, kept inside the view.

        By hand: a clip in fractions of pixels makes every fill slow.
        """
        width = int(self._view.width())
        first, last = self._view.viewRange()[0]
        frames = np.array([(j.interval.start, j.interval.stop) for j in regions]) - 0.5
        places = np.rint((frames - first) / (last - first) * width).astype(np.int64)
        places[:, 1] = np.maximum(places[:, 1], places[:, 0] + 2)
        pairs: list[list[int]] = np.clip(places, 0, width).tolist()
        return pairs


class FrontLayer(Layer):
    """Playhead and title, before the curves."""

    def __init__(self, view: pg.ViewBox, scenery: Scenery) -> None:
        super().__init__(view, scenery, 50.0)
        self.title: list[tuple[str, str]] = []  # text and the theme's colour role

    def set_title(self, title: list[tuple[str, str]]) -> None:
        """Words and numbers at the left top."""
        if title != self.title:
            self.title = title
            self.update(QRectF(0.0, 0.0, self._view.width(), TITLE_HEIGHT + 1.0))

    def move_playhead(self, before: int, after: int) -> None:
        """Repaint where it was and where it is."""
        for frame in (before, after):
            self.update(QRectF(self.place(frame) - 3.0, 0.0, 6.0, self._view.height()))

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Playhead under the title."""
        painter.save()
        x = round(self.place(self.scenery.frame))
        if self.scenery.frames and 0 <= x <= self._view.width():
            painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
            pen = QPen(QColor(self.scenery.theme.accent), 2.0)
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            painter.drawLine(QLineF(x, 0.0, x, self._view.height()))
        self._paint_title(painter)
        painter.restore()

    def _paint_title(self, painter: QPainter) -> None:
        theme = self.scenery.theme
        font = _small_font()
        metrics = QFontMetricsF(font)
        painter.setFont(font)
        room = self._view.width() - 6.0
        width = sum(metrics.horizontalAdvance(text) for text, _ in self.title)
        back = QColor(theme.surface)
        back.setAlpha(215)
        painter.fillRect(QRectF(1.0, 1.0, min(width + 8.0, room), TITLE_HEIGHT - 1.0), back)
        x = 5.0
        for text, role in self.title:
            advance = metrics.horizontalAdvance(text)
            if x + advance > room:
                break
            painter.setPen(QColor(getattr(theme, role)))
            painter.drawText(QPointF(x, TITLE_HEIGHT - 4.5), text)
            x += advance


@cache
def mixed(colour: str, paper: str, alpha: int) -> QColor:
    """A colour as it looks on paper at alpha/255; opaque fills are 30 times as fast."""
    above, below, share = QColor(colour), QColor(paper), alpha / 255.0
    return QColor(
        *(
            round(share * a + (1.0 - share) * b)
            for a, b in zip(above.getRgb()[:3], below.getRgb()[:3], strict=True)
        )
    )


def _foot(theme: Theme) -> QColor:
    return mixed(theme.soft, theme.surface, 100)


def _small_font(*, bold: bool = False) -> QFont:
    font = figures_font(8.0)
    font.setBold(bold)
    return font
