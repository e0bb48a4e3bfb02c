"""The widgets over the 3D view: legend, notice, labels, colour scale, drawings and divider."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from PySide6.QtCore import QPoint, QPointF, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QLabel, QWidget

from inspector.language import tr, tr_as
from inspector.viewport.bone_colours import offset_scale_colours
from inspector.viewport.clock import Clock, Hands
from inspector.viewport.crowding import Crowding
from inspector.viewport.whole_figure import Miniature, WholeFigure
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array

_Shown = TypeVar("_Shown", bound=QWidget)
_MARGIN = 8  # pixels between overlays and the border
# Positions that are tried for a label: in 16 directions from its place, given as angles and as unit
# vectors (16, 2), and at these distances in pixels
_WAYS = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
_COMPASS = np.stack([np.cos(_WAYS), np.sin(_WAYS)], axis=1)
_REACHES = 14.0, 32.0, 54.0, 80.0
_FAR = 0.05  # cost of a pixel of distance, in units of the weight that a label covers
_SOLID = 8.0  # weight of each cell of Crowding that a label covers
_READ = 1000.0  # weight of each cell that must stay free, even if labels cover the figure
SIDES = {"Left": tr_as("side", "L"), "Right": tr_as("side", "R")}  # letters in the image
EMPTY = tr("Open a clip (Ctrl+O), drop one here, or try the sample")


class Overlays:
    """The widgets over a 3D view. All of them except the clock ignore the mouse."""

    def __init__(self, view: QWidget) -> None:
        # The line between two images; created first, so that it is below the other widgets.
        self.divider = _ignore_mouse(QWidget(view))
        self.divider.hide()
        self.notice = _ignore_mouse(QLabel(view))  # a sentence in the middle of the view
        self.notice.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.notice.setWordWrap(True)
        self.legend = _ignore_mouse(QLabel(view))  # the meaning of the colours
        self.legend.setTextFormat(Qt.TextFormat.RichText)
        self.legend.hide()
        self.angle = _ignore_mouse(QLabel(view))  # next to the wrong bone
        self.angle.hide()
        self.scale = OffsetScale(view)
        self.sides = {side: _ignore_mouse(QLabel(letter, view)) for side, letter in SIDES.items()}
        for label in self.sides.values():
            label.hide()
        self.whole = WholeFigure(view)
        self.clock = Clock(view)
        self._split = False
        self._wrong = False  # True if the letters of the sides are next to an error

    def colour(self, theme: Theme, points: float) -> None:
        """Apply the theme's colours. `points` is the font size of the legend in points."""
        self.notice.setStyleSheet(f"color: {theme.soft}; background: transparent; font-size: 15px")
        self.legend.setStyleSheet(
            f"background: {theme.raised}; color: {theme.text}; padding: 4px 8px;"
            f"border-bottom: 1px solid {theme.line}; font-size: {points:.1f}pt;"
        )
        self.fit()
        self.angle.setStyleSheet(
            f"background: {theme.raised}; color: {theme.before}; border-radius: 4px;"
            f"padding: 1px 5px; font-weight: bold; font-size: {1.3 * points:.1f}pt;"
        )
        self.divider.setStyleSheet(f"background: {theme.line}")
        self._theme, self._points = theme, points
        self._colour_sides()
        self.whole.colour(theme)
        self.clock.colour(theme)
        self.scale.colour(theme)

    def _colour_sides(self) -> None:
        theme = self._theme
        paper = theme.before if self._wrong else theme.text
        for label in self.sides.values():
            label.setStyleSheet(
                f"background: {paper}; color: {theme.raised}; border-radius: 3px;"
                f"padding: 0px 4px; font-weight: bold; font-size: {1.2 * self._points:.1f}pt;"
            )

    def place(self, *, drawing: bool, by_offset: bool, split: bool) -> None:
        """Place all overlays, and show or hide them.

        Parameters
        ----------
        drawing
            True if a figure is drawn. If it is False, only the notice is visible.
        by_offset
            True to show the colour scale of |offset|.
        split
            True if there are two images.
        """
        view = self.notice.parentWidget()  # a stored reference would keep OpenGL alive
        assert view is not None
        high = view.height()
        self._split = split
        self.legend.setVisible(drawing)
        self.notice.setGeometry(view.rect())
        self.scale.setVisible(drawing and by_offset)
        self.scale.move(_MARGIN, high - self.scale.height() - _MARGIN)
        self.divider.setVisible(drawing and split)
        if not drawing:
            for label in (*self.sides.values(), self.angle, self.whole, self.clock):
                label.hide()
        self.fit()

    def reserve_scale(self, crowding: Crowding) -> None:
        """Keep other overlays away from the colour scale if it is visible."""
        if not self.scale.isHidden():
            crowding.add_box(self.scale.geometry(), _READ)

    def show_legend(self, text: str) -> None:
        """Show a legend, given as rich text."""
        if text != self.legend.text():
            self.legend.setText(text)
            self.fit()

    def show_angle(self, text: str, bone: Array, thick: float, crowding: Crowding) -> None:
        """Show an angle next to a bone in the left image.

        Parameters
        ----------
        text
            The angle with its unit; an empty string hides the label.
        bone
            The ends of the bone in pixels, (2, 2).
        thick
            The radius of the bone in pixels.
        crowding
            The crowded parts of the image. The label is added to them.
        """
        if not text:
            self.angle.hide()
            return
        if text != self.angle.text():
            self.angle.setText(text)
        size = self.angle.sizeHint()
        middle, turn = bone.mean(axis=0), bone[1] - bone[0]
        away = turn / max(float(np.linalg.norm(turn)), 1.0)
        away = np.array([-away[1], away[0]])
        first = middle + (thick + _half_extent(size, away)) * away
        self.angle.setGeometry(self._clear_place(first, size, crowding, around=middle))
        self.angle.show()
        crowding.add_box(self.angle.geometry(), _SOLID)

    def show_sides(
        self, places: Mapping[str, Array], crowding: Crowding, *, wrong: bool = False
    ) -> None:
        """Show letters that mark the sides of the body, such as L and R, in the left image.

        Parameters
        ----------
        places
            The pixel at or near which to show each letter, (2,), keyed by side. A letter is hidden
            if it has no pixel or if the pixel is outside the image.
        crowding
            The crowded parts of the image. The letters are added to them.
        wrong
            True to show the letters in the colour of an error.
        """
        if wrong != self._wrong:
            self._wrong = wrong
            self._colour_sides()
        room = self._room()
        for side, label in self.sides.items():
            at = places.get(side)
            if at is not None and room.contains(QPoint(*np.round(at).astype(int).tolist())):
                label.setGeometry(self._clear_place(at, label.sizeHint(), crowding, around=at))
                crowding.add_box(label.geometry(), _SOLID)
                label.show()
            else:
                label.hide()

    def _clear_place(
        self, first: Array, size: QSize, crowding: Crowding, *, around: Array
    ) -> QRect:
        """Return a rectangle for a label, near its preferred position, where it covers little.

        Parameters
        ----------
        first
            The preferred centre of the label in pixels, (2,).
        size
            The size of the label.
        crowding
            The crowded parts of the image.
        around
            The pixel around which alternative centres are tried, (2,).
        """
        room, extent = self._room(), np.array(size.toTuple())
        least = np.array(room.topLeft().toTuple()) + extent / 2.0
        most = np.array(room.bottomRight().toTuple()) + 1.0 - extent / 2.0
        reaches = np.array(_REACHES)[:, None] + np.abs(_COMPASS) @ extent / 2.0
        near = around + (reaches[..., None] * _COMPASS).reshape(-1, 2)
        centres = np.clip(np.vstack([first, near]), least, np.maximum(least, most))
        covered = crowding.within(centres - extent / 2.0, centres + extent / 2.0)
        far = np.linalg.norm(centres - first, axis=1)
        at = centres[int(np.argmin(covered + _FAR * far))]
        box = QRect(QPoint(0, 0), size)
        box.moveTopLeft(QPoint(*np.round(at - extent / 2.0).astype(int).tolist()))
        return box

    def show_whole(self, drawn: Miniature | None, size: QSize, crowding: Crowding) -> None:
        """Show a drawing of the whole figure in the emptiest corner of the left image.

        Parameters
        ----------
        drawn
            The drawing; None hides the widget.
        size
            The size of the drawing.
        crowding
            The crowded parts of the image. The widget is added to them.
        """
        corner = None if drawn is None else self._emptiest_corner(size, crowding)
        if drawn is None or corner is None:
            self.whole.hide()
        else:
            self.whole.show_miniature(drawn, corner, SIDES)
            crowding.add_box(corner, _SOLID)

    def show_clock(self, hands: Hands | None, size: QSize, crowding: Crowding) -> bool:
        """Show the clock in the emptiest corner of the left image, and return True if it is shown.

        While the user drags the hand, the clock does not move.

        Parameters
        ----------
        hands
            The hands of the clock; None hides the clock.
        size
            The size of the clock.
        crowding
            The crowded parts of the image. The clock is added to them.
        """
        corner = None if hands is None else self._emptiest_corner(size, crowding)
        if self.clock.held:
            corner = self.clock.geometry()
        elif hands is None or corner is None:
            self.clock.hide()
            return False
        if hands is not None and corner is not None:
            self.clock.show_hands(hands, corner)
            crowding.add_box(corner, _SOLID)
        return True

    def _emptiest_corner(self, size: QSize, crowding: Crowding) -> QRect | None:
        """Return the rectangle for a widget in the emptiest corner, or None if it does not fit."""
        room = self._room().adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN)
        if room.width() < size.width() or room.height() < size.height():
            return None
        low, right = room.bottom() - size.height() + 1, room.right() - size.width() + 1
        places = [(x, y) for y in (low, room.top()) for x in (room.left(), right)]
        first = np.array(places, dtype=float)
        covered = crowding.within(first - _MARGIN, first + size.toTuple() + _MARGIN)
        return QRect(QPoint(*places[int(np.argmin(covered))]), size)

    def _room(self) -> QRect:
        """Return the part of the left image below the legend."""
        view = self.notice.parentWidget()
        assert view is not None
        wide = view.width() // (2 if self._split else 1)
        return QRect(0, self.top, wide, view.height() - self.top)

    @property
    def top(self) -> int:
        """The height of the legend in pixels, but at least the height of one line of text."""
        line = _MARGIN + self.legend.fontMetrics().height()
        return max(self.legend.geometry().bottom() + 1, line)

    def fit(self) -> None:
        """Lay out the legend across the top of the view, and the divider below the legend."""
        view, legend = self.notice.parentWidget(), self.legend
        assert view is not None
        wide, middle = view.width(), view.width() // 2
        if legend.wordWrap():  # setWordWrap lays out the text again, even without a change
            legend.setWordWrap(False)
        high = legend.sizeHint().height()
        if legend.sizeHint().width() > wide:
            legend.setWordWrap(True)
            wide = max(wide, legend.minimumSizeHint().width())
            high = legend.heightForWidth(wide)
        legend.setGeometry(QRect(0, 0, wide, high))
        self.divider.setGeometry(middle - 1, high, 2, view.height() - high)


class OffsetScale(QWidget):
    """The colour scale of |offset| from 0° to 180°."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        _ignore_mouse(self)
        letters = self.fontMetrics()
        self.setFixedSize(max(200, letters.horizontalAdvance("0° 60° 120° 180°") + 90),
                          2 * letters.height() + 22)  # fmt: skip
        self.hide()

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self._theme = theme
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the colour bar and its tick labels."""
        painter, theme = QPainter(self), self._theme
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QColor(theme.line))
        painter.setBrush(QColor(theme.raised))
        painter.drawRoundedRect(self.rect().adjusted(0, 0, -1, -1), 4, 4)
        high = self.fontMetrics().height()
        bar = self.rect().adjusted(10, high + 6, -10, -high - 6)
        painter.setPen(QColor(theme.text))
        top = QRectF(10, 4, bar.width(), high)
        painter.drawText(top, Qt.AlignmentFlag.AlignLeft, tr("|offset| in this frame"))
        angles = np.radians(np.linspace(0.0, 180.0, bar.width()))
        for k, colour in enumerate(offset_scale_colours(theme, angles)):
            ink = QColor(*colour.astype(int).tolist())
            painter.fillRect(bar.left() + k, bar.top(), 1, bar.height(), ink)
        painter.setPen(QColor(theme.soft))
        for degrees in (0, 60, 120, 180):
            text = f"{degrees}°"
            wide = self.fontMetrics().horizontalAdvance(text)
            middle = bar.left() + bar.width() * degrees / 180.0
            left = min(max(middle - wide / 2.0, bar.left()), bar.right() - wide + 1)
            painter.drawText(QPointF(left, self.height() - 4 - self.fontMetrics().descent()), text)


def _half_extent(size: QSize, way: Array) -> float:
    """Return the approximate distance from the centre of a box to its border, in pixels.

    `way` is the direction in which the distance is measured, a unit vector (2,).
    """
    return float(np.abs(way) @ size.toTuple()) / 2.0


def _ignore_mouse(widget: _Shown) -> _Shown:
    """Let mouse events pass through a widget, and return the widget."""
    widget.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    return widget
