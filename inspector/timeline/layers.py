"""Layers behind and in front of the curves: intervals, shading, playhead and titles.

Each layer is a single graphics item per plot and paints only the visible range, in pixels. The
painting time therefore depends only on the number of visible intervals. One graphics item for each
interval would be slow in clips with thousands of intervals.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from inspector.timeline.regions import Regions, widen_narrow_spans
from inspector.timeline.time_view import TimeView
from inspector.timeline.title_lines import title_lines
from inspector.widgets.axes import TEXT_HEIGHT
from inspector.widgets.theme import Colours, Theme, blend_colour_over_paper, figures_font
from twistcore.review import Judged
from twistcore.skeleton.rotation import Array

_TITLE_HEIGHT = 17.0
_WHOLE = 0.95  # visible share of the values above which there is no bar at the right edge
_REMEMBERED = 8  # number of cached regions; all plots use the same one or two


@dataclass(frozen=True)
class DragLabel:
    """The label next to the mouse pointer during a drag.

    Attributes
    ----------
    key
        The key of the plot that shows the label.
    frame
        The horizontal position of the label, as a frame.
    pixel
        The distance of the label from the top of the plot, in pixels.
    words
        The text.
    band
        The frames [start, stop) of an interval that is being drawn, or None. All plots show it.
    """

    key: str
    frame: float
    pixel: float
    words: str
    band: tuple[int, int] | None = None


@dataclass
class Scenery:
    """The data that the plots show, except the curves.

    The timeline sets the data, and the layers read them.
    """

    colours: Colours
    scale: float = 1.0  # scale of text and lines, larger in a presentation
    still: bool = False  # True in a figure; its numbers do not change and need no fixed width
    title_lines: int = 1  # lines of text above each plot
    frames: int = 0
    frame: int = 0
    intervals: tuple[Judged, ...] = ()  # intervals of the selected chain, sorted by start
    selected: int | None = None
    drag_label: DragLabel | None = None
    unreliable: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    unreliable_words: str = ""  # the text drawn in unreliable spans
    unreliable_hint: str = ""  # the tool tip of unreliable spans
    starts: Array = field(default_factory=lambda: np.zeros(0))
    stops: Array = field(default_factory=lambda: np.zeros(0))
    _regions: dict[object, Regions] = field(default_factory=dict)

    @property
    def theme(self) -> Theme:
        """The theme that defines all colours."""
        return self.colours.theme

    @property
    def title_height(self) -> float:
        """The height, in pixels, of the title of a plot."""
        return self.line_height * self.title_lines

    @property
    def line_height(self) -> float:
        """The height, in pixels, of one line of the title."""
        return _TITLE_HEIGHT * self.scale + self.higher

    @property
    def higher(self) -> float:
        """The additional height of a line of text, in pixels, compared with the default font."""
        high = QFontMetricsF(self.font()).height()
        return max(0.0, high - TEXT_HEIGHT * self.scale)

    def font(self, *, bold: bool = False) -> QFont:
        """Return the font for text in plots."""
        font = figures_font(8.0 * self.scale)
        font.setBold(bold)
        return font

    def set_intervals(self, intervals: tuple[Judged, ...]) -> None:
        """Set the intervals that the plots show, sorted by start."""
        self.intervals = intervals
        self._regions.clear()
        self.starts = np.array([j.interval.start for j in intervals], dtype=np.float64)
        self.stops = np.array([j.interval.stop for j in intervals], dtype=np.float64)

    def between(self, first: float, last: float) -> list[Judged]:
        """Return the intervals that overlap a range of frames, with the selected interval last."""
        seen = np.flatnonzero((self.stops - 0.5 > first) & (self.starts - 0.5 < last))
        chosen = [self.intervals[k] for k in seen]
        chosen.sort(key=lambda j: j.id == self.selected)
        return chosen

    def drawn_ends(self, judged: Judged, pixel: float) -> tuple[float, float]:
        """Return the start and the end of an interval as it is drawn, in frames.

        Short intervals are drawn wider than they are. `pixel` is the number of frames per pixel.
        """
        ends = np.array([[judged.interval.start, judged.interval.stop]]) - 0.5
        start, stop = widen_narrow_spans(ends, pixel)[0].tolist()
        return start, stop

    def regions(self, first: float, last: float, width: int) -> Regions:
        """Return the pixel regions that show the intervals in a range of frames.

        `width` is the width of the plot in pixels. The regions are cached, because all plots show
        the same regions.
        """
        key = (first, last, width, self.selected)
        if key not in self._regions:
            if len(self._regions) >= _REMEMBERED:
                self._regions.clear()
            seen = self.between(first, last)
            self._regions[key] = Regions(seen, self.selected, first, last, width)
        return self._regions[key]


class Layer(QGraphicsItem):
    """The base class of layers: a graphics item that covers a view and paints in pixels."""

    def __init__(self, view: pg.ViewBox, scenery: Scenery, z: float) -> None:
        # The parent is not the view, which clips its children to a path and makes fills slow.
        super().__init__(view.parentItem())
        self._view = view
        self.scenery = scenery
        self.setZValue(z)
        self.setAcceptedMouseButtons(Qt.MouseButton.NoButton)
        self.setFlag(QGraphicsItem.GraphicsItemFlag.ItemUsesExtendedStyleOption)
        view.sigResized.connect(self._resized)

    def _resized(self, *_: object) -> None:
        self.prepareGeometryChange()
        self.setPos(self._view.pos())

    def boundingRect(self) -> QRectF:
        """Return the rectangle of the view, which this item covers."""
        return QRectF(self._view.rect())

    def place(self, frame: float) -> float:
        """Return the horizontal position, in pixels, of a frame. Both may be fractional."""
        first, last = self._view.viewRange()[0]
        return float((frame - first) / (last - first) * self._view.width())


class BackLayer(Layer):
    """The layer behind the curves. It shows intervals and shades unreliable frames."""

    def __init__(self, view: pg.ViewBox, scenery: Scenery, *, shade: bool, glyphs: bool) -> None:
        super().__init__(view, scenery, -200.0)  # behind the view itself
        self._shade, self._glyphs = shade, glyphs

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Paint the intervals and shade the unreliable frames in the visible range."""
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        if self._shade:
            self._paint_unreliable(painter)
        first, last = self._view.viewRange()[0]
        regions = self.scenery.regions(first, last, int(self._view.width()))
        font = self.scenery.font(bold=True) if self._glyphs else None
        regions.paint(painter, self.scenery.theme, int(self._view.height()), font)
        painter.restore()

    def _paint_unreliable(self, painter: QPainter) -> None:
        theme, height = self.scenery.theme, self._view.height()
        first, last = self._view.viewRange()[0]
        tint, foot = (
            blend_colour_over_paper(theme.soft, theme.surface, share) for share in (26, 100)
        )
        spans = self.scenery.unreliable
        seen = spans[(spans[:, 1] - 0.5 > first) & (spans[:, 0] - 0.5 < last)]
        painter.setFont(self.scenery.font())
        for start, stop in seen:
            left = max(0.0, self.place(start - 0.5))
            right = min(self._view.width(), self.place(stop - 0.5))
            width = max(1.0, right - left)
            painter.fillRect(QRectF(left, 0.0, width, height), tint)
            painter.fillRect(QRectF(left, height - 3.0, width, 3.0), foot)
            text = self.scenery.unreliable_words
            if width > QFontMetricsF(painter.font()).horizontalAdvance(text) + 12.0:
                painter.setPen(QColor(theme.soft))
                painter.drawText(QPointF(left + 5.0, height - 6.0), text)


class FrontLayer(Layer):
    """The layer in front of the curves: playhead, drag label, title and axis labels.

    Attributes
    ----------
    title
        The title as pairs (text, name of a colour in the theme).
    values, time
        The labels of the left and bottom axes.
    tau
        The position of the τ line on the value axis and the label of the line, or None.
    """

    def __init__(self, view: TimeView, scenery: Scenery) -> None:
        super().__init__(view, scenery, 50.0)
        self._key, self._values = view.key, view
        self.title: list[tuple[str, str]] = []
        self.values = self.time = ""
        self.tau: tuple[float, str] | None = None

    def boundingRect(self) -> QRectF:
        """Return the rectangle of the whole plot with its axes."""
        parent = self.parentItem()
        return QRectF(parent.boundingRect()).translated(-self.pos()) if parent else QRectF()

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Paint the playhead, the drag label, the title and the axis labels.

        The title and the axis labels are painted only if their area must be repainted.
        """
        painter.save()
        painter.setFont(self.scenery.font())
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        self._paint_playhead(painter)
        self._paint_part(painter)
        if self.scenery.drag_label is not None:
            self._paint_drag_label(painter, self.scenery.drag_label)
        if option.exposedRect.left() < 0.0:
            self._paint_axis_words(painter)
            self._paint_tau(painter)
        if option.exposedRect.top() < 0.0:
            self._paint_title(painter)
        painter.restore()

    def _paint_playhead(self, painter: QPainter) -> None:
        x = round(self.place(self.scenery.frame))
        if self.scenery.frames and 0 <= x <= self._view.width():
            pen = QPen(QColor(self.scenery.theme.accent), 2.0)
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            painter.drawLine(QLineF(x, 0.0, x, self._view.height()))

    def _paint_part(self, painter: QPainter) -> None:
        """Draw a bar at the right edge that shows which part of the value range is visible."""
        if self._values.part is None:
            return
        (low, high), (bottom, top) = self._values.viewRange()[1], self._values.all_values
        bottom, top = min(bottom, low), max(top, high)
        if high - low > _WHOLE * (top - bottom):
            return
        tall, left = self._view.height(), self._view.width() - 5.0
        theme, scale = self.scenery.theme, tall / (top - bottom)
        painter.fillRect(QRectF(left, 0.0, 5.0, tall), QColor(theme.line))
        thumb = QRectF(left, (top - high) * scale, 5.0, max((high - low) * scale, 4.0))
        painter.fillRect(thumb, QColor(theme.soft))

    def _paint_drag_label(self, painter: QPainter, label: DragLabel) -> None:
        theme, view = self.scenery.theme, QRectF(self._view.rect())
        if label.band is not None:
            left, right = (self.place(frame - 0.5) for frame in label.band)
            band = QRectF(left, 0.0, max(2.0, right - left), view.height()).intersected(view)
            ink = QColor(theme.accent)
            ink.setAlpha(70)
            painter.fillRect(band, ink)
        if label.key == self._key:
            size = QFontMetricsF(painter.font()).size(0, label.words)
            box = QRectF(self.place(label.frame) + 8.0, label.pixel - 1.4 * size.height(),
                         size.width() + 8.0, size.height() + 2.0)  # fmt: skip
            if box.right() > view.right():
                box.moveRight(self.place(label.frame) - 8.0)
            box.moveTop(min(max(box.top(), 0.0), view.height() - box.height()))
            painter.fillRect(box, QColor(theme.accent))
            painter.setPen(QColor(theme.surface))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, label.words)

    def _paint_axis_words(self, painter: QPainter) -> None:
        """Paint the labels of the left and bottom axes."""
        theme, metrics = self.scenery.theme, QFontMetricsF(painter.font())
        painter.setPen(QColor(theme.soft))
        edge, high = self.boundingRect().left(), metrics.height()
        top, bottom = self._label_space(metrics, edge + high)
        if self.values and metrics.horizontalAdvance(self.values) <= bottom - top:
            painter.save()
            painter.translate(edge, bottom)
            painter.rotate(-90.0)
            box = QRectF(0.0, 0.0, bottom - top, high)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self.values)
            painter.restore()
        if self.time:
            # at the same height as the numbers
            box = QRectF(edge, self._view.height() + 3.0 * self.scenery.scale, -edge - 6.0, high)
            painter.drawText(box, Qt.AlignmentFlag.AlignRight, self.time)

    def _label_space(self, metrics: QFontMetricsF, edge: float) -> tuple[float, float]:
        """Return the top and the bottom, in pixels, of the space for the label of the left axis.

        `edge` is the right edge of the label. If the label would overlap the τ label, the result is
        the larger of the spaces above and below the τ label.
        """
        tall, box = self._view.height(), self._tau_box(metrics)
        if box is None or box.left() >= edge:
            return 0.0, tall
        wanted = metrics.horizontalAdvance(self.values)
        top, bottom = 0.5 * (tall - wanted), 0.5 * (tall + wanted)
        if box.bottom() <= top or box.top() >= bottom:
            return 0.0, tall
        return (0.0, box.top()) if box.center().y() > 0.5 * tall else (box.bottom(), tall)

    def _tau_box(self, metrics: QFontMetricsF) -> QRectF | None:
        """Return the rectangle of the τ label at the axis, or None if it is not visible."""
        low, high = self._view.viewRange()[1]
        if self.tau is None or not low <= self.tau[0] <= high:
            return None
        y = (high - self.tau[0]) / (high - low) * self._view.height()
        wide, tall = metrics.horizontalAdvance(self.tau[1]) + 6.0, metrics.height()
        top = min(max(y - 0.5 * tall, 0.0), self._view.height() - tall)
        return QRectF(-wide, top, wide, tall)

    def _paint_tau(self, painter: QPainter) -> None:
        """Paint the τ label at the axis."""
        theme, box = self.scenery.theme, self._tau_box(QFontMetricsF(painter.font()))
        if box is None or self.tau is None:
            return
        words = self.tau[1]
        painter.fillRect(box, QColor(theme.tau))
        painter.setPen(QColor(theme.surface))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)

    def title_lines(self) -> list[list[tuple[str, str]]]:
        """Return the lines of the title: one in the window, as many as necessary in a figure."""
        if not self.scenery.still:
            return [self.title]
        advance = QFontMetricsF(self.scenery.font()).horizontalAdvance
        return title_lines(self.title, self.boundingRect().width() - 6.0, advance)

    def _paint_title(self, painter: QPainter) -> None:
        theme, edges = self.scenery.theme, self.boundingRect()
        metrics = QFontMetricsF(painter.font())
        lines = self.title_lines()
        for k, line in enumerate(lines):
            above = (len(lines) - 1 - k) * self.scenery.line_height
            x, y = edges.left() + 4.0, -4.5 * self.scenery.scale - above
            for text, role in line:
                advance = metrics.horizontalAdvance(text)
                if x + advance > edges.right() - 2.0:
                    break
                painter.setPen(QColor(getattr(theme, role)))
                painter.drawText(QPointF(x, y), text)
                x += advance
