"""The overview of the clip: intervals of all chains, the visible range and the playhead."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

from PySide6.QtCore import QLineF, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QPixmap, QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from inspector.language import tr
from inspector.timeline.visible_range import SMALLEST
from inspector.widgets.theme import Colours, blend_colour_over_paper
from twistcore.review import Decision, Judged

HEIGHT = 26
_SELECTED_SHARE = 0.46  # share of the strip's height for the row of the selected chain
_EDGE = 3.0
_NEAR = 4.0  # pixels within which the mouse grabs a part


class _Grip(Enum):
    """A part of the overview that the user can drag."""

    PLAYHEAD = "playhead"
    WINDOW = "window"  # the whole visible range of the plots
    FIRST = "first"  # an end of the visible range
    LAST = "last"


_CURSORS = {
    _Grip.PLAYHEAD: Qt.CursorShape.ArrowCursor,
    _Grip.WINDOW: Qt.CursorShape.OpenHandCursor,
    _Grip.FIRST: Qt.CursorShape.SizeHorCursor,
    _Grip.LAST: Qt.CursorShape.SizeHorCursor,
}


class OverviewStrip(QWidget):
    """An overview of the clip: a strip with a row for each chain and a mark for each interval.

    The mark of an accepted interval has the full height of its row. The mark of an undecided
    interval fills the lower part of the row, and the mark of a rejected interval is a thin line.
    """

    moved = Signal(int)  # with the frame to which the playhead was dragged
    clicked = Signal(int, object)  # with the clicked frame, and the interval there or None
    # With the first and the last frame to which the visible range was dragged
    ranged = Signal(float, float)
    dropped = Signal()  # a drag has ended

    def __init__(self, colours: Colours, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._colours = colours
        self._frames = 0
        self._chains: tuple[str, ...] = ()
        self._chain = ""
        self._intervals: Sequence[Judged] = ()
        self._selected: int | None = None
        self._frame = 0
        self._view = (0.0, 0.0)
        self._pressed: _Grip | None = None
        self._from = (0.0, 0.0, 0.0)  # pixel and visible range at the start of a drag
        self._dragged = False
        self.setMouseTracking(True)
        self._marks: QPixmap | None = None
        self._others: tuple[object, list[Judged], QPixmap] | None = None
        self.setFixedHeight(HEIGHT)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAccessibleName(tr("Overview of the clip"))
        self.setToolTip(
            tr(
                "The whole clip with the intervals of all chains; the selected chain is drawn "
                "larger.\n"
                "Click an interval to select it. Click anywhere else to move the playhead.\n"
                "Drag the box that marks the visible range to pan, or its edges to zoom. Drag the "
                "playhead to move it."
            )
        )
        colours.changed.connect(self._redraw)

    # -- content ------------------------------------------------------------------------------

    def show_review(
        self,
        frames: int,
        chains: tuple[str, ...],
        chain: str,
        intervals: Sequence[Judged],
        selected: int | None,
    ) -> None:
        """Show all intervals of a clip.

        Parameters
        ----------
        frames
            The number of frames.
        chains
            The names of all listed chains.
        chain
            The name of the selected chain.
        intervals
            The intervals of all chains.
        selected
            The id of the selected interval, or None.
        """
        self._frames, self._chains, self._chain = frames, chains, chain
        self._intervals, self._selected = intervals, selected
        self._redraw()

    def show_frame(self, frame: int) -> None:
        """Move the playhead to a frame. Only its previous and its new position are repainted."""
        for at in (self._frame, frame):
            self.update(round(self._x(at)) - 5, 0, 11, self.height())
        self._frame = frame

    def show_view(self, first: float, last: float) -> None:
        """Mark the range of frames that is visible in the plots."""
        if (first, last) != self._view:
            self._view = (first, last)
            self.update()

    def sizeHint(self) -> QSize:
        """Return the preferred size of the strip."""
        return QSize(400, HEIGHT)

    # -- positions ----------------------------------------------------------------------------

    def _x(self, frame: float) -> float:
        inner = max(1.0, self.width() - 2 * _EDGE)
        return _EDGE + (frame + 0.5) / max(1, self._frames) * inner

    def _frame_at(self, x: float) -> int:
        inner = max(1.0, self.width() - 2 * _EDGE)
        frame = int((x - _EDGE) / inner * self._frames)
        return max(0, min(self._frames - 1, frame))

    def _rows(self) -> dict[str, tuple[float, float]]:
        """Return the top and the height of each chain's row in pixels, keyed by chain.

        The row of the selected chain is the tallest.
        """
        space = self.height() - 4.0
        others = max(1, len(self._chains) - 1)
        large = space * _SELECTED_SHARE if len(self._chains) > 1 else space
        small = (space - large) / others
        rows, top = {}, 2.0
        for name in self._chains:
            height = large if name == self._chain else small
            rows[name] = (top, height)
            top += height
        return rows

    # -- painting -----------------------------------------------------------------------------

    def _redraw(self) -> None:
        self._marks = None
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Repaint the marks for the new size."""
        self._redraw()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the cached marks, the visible range and the playhead."""
        if self._marks is None:
            self._marks = self._painted_marks()
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._marks)
        if self._frames:
            self._paint_view(painter)
            x = round(self._x(self._frame)) + 0.5
            painter.setPen(QPen(QColor(self._colours.theme.accent), 2.0))
            painter.drawLine(QLineF(x, 0.0, x, self.height()))
        painter.end()

    def _painted_marks(self) -> QPixmap:
        """Return an image of all marks.

        The marks of all chains except the selected one are cached, because a change of τ affects
        only the selected chain.
        """
        rows = self._rows()
        others = [j for j in self._intervals if j.interval.chain != self._chain]
        state = (
            self._chain,
            self._chains,
            self._frames,
            self._selected,
            self._colours.theme,
            self.size(),
        )
        if self._others is None or self._others[:2] != (state, others):
            self._others = state, others, self._painted(self._blank(rows), others, rows)
        own = [j for j in self._intervals if j.interval.chain == self._chain]
        pixmap = self._painted(QPixmap(self._others[2]), own, rows)
        painter = QPainter(pixmap)
        painter.setPen(QColor(self._colours.theme.line))
        painter.drawRect(QRectF(0.5, 0.5, self.width() - 1.0, self.height() - 1.0))
        painter.end()
        return pixmap

    def _blank(self, rows: dict[str, tuple[float, float]]) -> QPixmap:
        ratio = self.devicePixelRatioF()
        pixmap = QPixmap(round(self.width() * ratio), round(self.height() * ratio))
        pixmap.setDevicePixelRatio(ratio)
        pixmap.fill(QColor(self._colours.theme.surface))
        if self._chain in rows:
            top, height = rows[self._chain]
            painter = QPainter(pixmap)
            painter.fillRect(
                QRectF(0, top, self.width(), height), QColor(self._colours.theme.window)
            )
            painter.end()
        return pixmap

    def _painted(
        self, pixmap: QPixmap, intervals: list[Judged], rows: dict[str, tuple[float, float]]
    ) -> QPixmap:
        painter = QPainter(pixmap)
        seen: set[tuple[str, int, int, Decision]] = set()
        for judged in intervals:
            if judged.interval.chain not in rows:
                continue
            left = self._x(judged.interval.start - 0.5)
            width = max(2.0, self._x(judged.interval.stop - 0.5) - left)
            key = (judged.interval.chain, round(left), round(width), judged.decision)
            if key in seen and judged.id != self._selected:
                continue  # another mark is already drawn at these pixels
            seen.add(key)
            top, height = rows[judged.interval.chain]
            self._paint_mark(painter, judged, QRectF(left, top, width, height))
        painter.end()
        return pixmap

    def _paint_mark(self, painter: QPainter, judged: Judged, box: QRectF) -> None:
        large = judged.interval.chain == self._chain
        name = getattr(self._colours.theme, str(judged.decision))
        colour = (
            QColor(name)
            if large
            else blend_colour_over_paper(name, self._colours.theme.surface, 170)
        )
        if large:
            box = QRectF(box.left(), box.top() + 1.0, box.width(), max(1.0, box.height() - 2.0))
        rect = QRectF(box)
        if judged.decision == Decision.UNDECIDED and large:
            rect.setTop(box.top() + 0.4 * box.height())
        elif judged.decision == Decision.REJECTED:
            rect = QRectF(box.left(), box.center().y() - 0.75, box.width(), 1.5)
        painter.fillRect(rect, colour)
        if judged.id == self._selected:
            painter.setPen(QPen(QColor(self._colours.theme.text), 1.0))
            painter.drawRect(box.adjusted(-1.5, -0.5, 1.5, 0.5))

    def _shows_all(self) -> bool:
        return self._view[0] <= 0.0 and self._view[1] >= self._frames - 1.0

    def _paint_view(self, painter: QPainter) -> None:
        left = max(0.0, self._x(max(self._view[0], -0.5)))
        right = min(float(self.width()), self._x(min(self._view[1], self._frames - 0.5)))
        if self._shows_all():
            return  # everything is visible, so no range is marked
        veil = QColor(self._colours.theme.window)
        veil.setAlpha(150)
        painter.fillRect(QRectF(0, 0, left, self.height()), veil)
        painter.fillRect(QRectF(right, 0, self.width() - right, self.height()), veil)
        painter.setPen(QPen(QColor(self._colours.theme.soft), 1.0))
        painter.drawRect(QRectF(left, 0.5, max(3.0, right - left), self.height() - 1.0))

    # -- the mouse ----------------------------------------------------------------------------

    def interval_at(self, at: QPointF) -> Judged | None:
        """Return the interval at a point in the strip, or None.

        If there are several, return the one in the nearest row.
        """
        rows = self._rows()
        found: list[tuple[float, float, Judged]] = []
        for judged in self._intervals:
            if (row := rows.get(judged.interval.chain)) is None:
                continue
            left, right = (self._x(f - 0.5) for f in (judged.interval.start, judged.interval.stop))
            aside = max(left - at.x(), at.x() - max(right, left + 2.0), 0.0)
            off = max(row[0] - at.y(), at.y() - row[0] - row[1], 0.0)
            if aside <= _NEAR and off <= _NEAR:
                found.append((off, aside, judged))
        return min(found, key=lambda f: f[:2])[2] if found else None

    def _grip_at(self, x: float) -> _Grip:
        """Return the part of the overview that a drag starting at pixel `x` would move."""
        if abs(x - self._x(self._frame)) <= _NEAR or self._shows_all():
            return _Grip.PLAYHEAD
        left, right = (self._x(f) for f in self._view)
        near, grip = min((abs(x - left), _Grip.FIRST), (abs(x - right), _Grip.LAST), key=_nearness)
        if near <= _NEAR:
            return grip
        return _Grip.WINDOW if left < x < right else _Grip.PLAYHEAD

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin to drag the part of the strip under the mouse."""
        if event.button() == Qt.MouseButton.LeftButton and self._frames:
            x = event.position().x()
            self._pressed, self._from, self._dragged = self._grip_at(x), (x, *self._view), False

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue a drag. Without a drag, set the cursor for the part under the mouse."""
        x = event.position().x()
        if not self._frames:
            return
        if self._pressed is None:
            self.setCursor(_CURSORS[self._grip_at(x)])
            return
        self._dragged = self._dragged or abs(x - self._from[0]) > _EDGE
        if not self._dragged:
            return
        if self._pressed is _Grip.PLAYHEAD:
            self.moved.emit(self._frame_at(x))
            return
        inner = max(1.0, self.width() - 2 * _EDGE)
        by = (x - self._from[0]) / inner * self._frames
        _, first, last = self._from
        if self._pressed is not _Grip.LAST:
            first = min(first + by, last - SMALLEST) if self._pressed is _Grip.FIRST else first + by
        if self._pressed is not _Grip.FIRST:
            last = max(last + by, first + SMALLEST) if self._pressed is _Grip.LAST else last + by
        self.ranged.emit(first, last)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End a drag or, if the mouse has not moved, handle a click."""
        if event.button() != Qt.MouseButton.LeftButton or self._pressed is None:
            return
        self._pressed = None
        if self._dragged:
            self.dropped.emit()
        else:
            at = event.position()
            self.clicked.emit(self._frame_at(at.x()), self.interval_at(at))


def _nearness(found: tuple[float, _Grip]) -> float:
    return found[0]
