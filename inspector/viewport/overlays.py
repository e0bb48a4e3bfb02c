"""Overlays of the picture: legend, notice, colour scale, and the line between two pictures."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from PySide6.QtCore import QPoint, QPointF, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QLabel, QWidget

from inspector.language import tr
from inspector.session.open_clip import Show
from inspector.viewport.bone_colours import scale_colour
from inspector.widgets.labels import bold, inked
from inspector.widgets.signed_numbers import signed
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array

_Shown = TypeVar("_Shown", bound=QWidget)
_MARGIN = 10  # pixels between the legend and the corner
EMPTY = tr("Open a clip (Ctrl+O), drop one here, or try the sample")


class Overlays:
    """The widgets over a view, which ignore the mouse."""

    def __init__(self, view: QWidget) -> None:
        # Between two pictures; created first, so that it is below the other widgets.
        self.divider = _let_through(QWidget(view))
        self.divider.hide()
        self.notice = _let_through(QLabel(view))  # a sentence in the middle
        self.notice.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.notice.setWordWrap(True)
        self.legend = _let_through(QLabel(view))  # the key of colours
        self.legend.setTextFormat(Qt.TextFormat.RichText)
        self.legend.hide()
        self.angle = _let_through(QLabel(view))  # at the wrong bone
        self.angle.hide()
        self.scale = OffsetScale(view)
        self._split = False

    def colour(self, theme: Theme, points: float) -> None:
        """Apply the theme's colours; points: font size of the legend."""
        self.notice.setStyleSheet(f"color: {theme.soft}; background: transparent; font-size: 15px")
        self.legend.setStyleSheet(
            f"background: {theme.raised}; color: {theme.text}; border: 1px solid {theme.line};"
            f"border-radius: 4px; padding: 4px 8px; font-size: {points:.1f}pt;"
        )
        self.fit()
        self.angle.setStyleSheet(
            f"background: {theme.raised}; color: {theme.before}; border-radius: 4px;"
            f"padding: 1px 5px; font-weight: bold; font-size: {1.3 * points:.1f}pt;"
        )
        self.divider.setStyleSheet(f"background: {theme.line}")
        self.scale.colour(theme)

    def place(self, *, drawing: bool, by_offset: bool, split: bool) -> None:
        """Place all overlays; those of a figure only while one is drawn."""
        view = self.notice.parentWidget()  # no reference, which would keep OpenGL
        assert view is not None
        high = view.height()
        self._split = split
        self.legend.setVisible(drawing)
        self.notice.setGeometry(view.rect())
        self.scale.setVisible(drawing and by_offset)
        self.scale.move(_MARGIN, high - self.scale.height() - _MARGIN)
        self.divider.setVisible(drawing and split)
        self.fit()

    def show_legend(self, text: str) -> None:
        """Show a legend, rich text."""
        if text != self.legend.text():
            self.legend.setText(text)
            self.fit()

    def show_angle(self, text: str, bone: Array | None = None, thick: float = 0.0) -> None:
        """Show an angle next to a bone in the left picture, or hide it.

        bone: its ends in pixels, (2, 2); thick: its radius in pixels.
        """
        view = self.notice.parentWidget()
        assert view is not None
        if not text or bone is None:
            self.angle.hide()
            return
        if text != self.angle.text():
            self.angle.setText(text)
        size = self.angle.sizeHint()
        room = QSize(view.width() // (2 if self._split else 1), view.height())
        (x, y), (across, down) = bone.mean(axis=0), np.abs(bone[1] - bone[0])
        if down >= across:
            left, top = x + thick, y - size.height() / 2
            if left + size.width() > room.width():
                left = x - thick - size.width()
        else:
            left, top = x - size.width() / 2, y - thick - size.height()
            if top < self.top:
                top = y + thick
        left = min(max(left, 0), room.width() - size.width())
        top = min(max(top, self.top), room.height() - size.height())
        self.angle.setGeometry(QRect(QPoint(round(left), round(top)), size))
        self.angle.show()

    @property
    def top(self) -> int:
        """The height in pixels of the legend, at least one line."""
        line = 2 * _MARGIN + self.legend.fontMetrics().height()
        return max(self.legend.geometry().bottom() + 1, line)

    def fit(self) -> None:
        """Fit the legend into its picture, and start the divider below it if they overlap."""
        view, legend = self.notice.parentWidget(), self.legend
        assert view is not None
        middle = view.width() // 2
        room = (middle if self._split else view.width()) - 2 * _MARGIN
        if legend.wordWrap():  # setting it lays out the text again
            legend.setWordWrap(False)
        size = legend.sizeHint()
        if size.width() > room:
            legend.setWordWrap(True)
            wide = max(room, legend.minimumSizeHint().width())
            size = QSize(wide, legend.heightForWidth(wide))
        legend.setGeometry(QRect(QPoint(_MARGIN, _MARGIN), size))
        top = 0  # in a very narrow view the line begins below the legend
        if legend.geometry().right() >= middle - _MARGIN // 2:
            top = legend.geometry().bottom() + _MARGIN
        self.divider.setGeometry(middle - 1, top, 2, view.height() - top)


def legend_text(
    theme: Theme,
    show: str,
    chain: str,
    degrees: float,
    *,
    tracked: bool,
    swivel: bool = False,
    fault: str = "",
    suggested: bool = False,
) -> str:
    """Return the legend as rich text: the colours of before and after, and the chain's offset.

    show: one of document.Show, or 'split' for two pictures; tracked: with a third figure; swivel:
    the offset is a limb's; fault: text about an error that is only shown, instead of the offset;
    suggested: the picture after correction contains corrections that nobody has decided on.
    """
    before = _key("□" if show == Show.BOTH else "■", theme.before, tr("before"))
    after = _key("■", theme.after, tr("after"))
    if show == "split":
        text = f"◧&nbsp;{before}&nbsp;&nbsp; ◨&nbsp;{after}"
    else:
        both = f"{before}&nbsp;&nbsp; {after}"
        text = {Show.BEFORE: before, Show.AFTER: after, Show.BOTH: both}[Show(show)]
    if suggested and show != Show.BEFORE:
        text += f"&nbsp;&nbsp; {_key('▥', theme.after, tr('suggested'))}"
    if chain:
        colour = theme.before if fault or abs(degrees) >= 0.05 else theme.soft
        angle = f"{signed(degrees)}°"
        words = (
            tr("swivel off by {angle}", angle=angle) if swivel else tr("{angle} off", angle=angle)
        )
        text += f"&nbsp;&nbsp;&nbsp; {_unbroken(bold(chain))}&nbsp; "
        text += inked(_unbroken(fault or words), colour)
    if tracked:
        text += f"&nbsp;&nbsp;&nbsp; {_key('┄', theme.tracked, tr('tracked'))}"
    return text


def trails_text(apart: float) -> str:
    """Return rich text about the distance of hands and feet before and after, in figure heights."""
    same = "&lt; 0.001 %" if apart < 1e-5 else f"{100.0 * apart:.3f} %"
    return "<br>" + tr("hands and feet differ by {share} of the height", share=same)


class OffsetScale(QWidget):
    """The colour scale of |offset|, 0…180°."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        _let_through(self)
        letters = self.fontMetrics()
        self.setFixedSize(max(200, letters.horizontalAdvance("0° 60° 120° 180°") + 90),
                          2 * letters.height() + 22)  # fmt: skip
        self.hide()

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self._theme = theme
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw a bar of colours with numbers."""
        painter, theme = QPainter(self), self._theme
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QColor(theme.line))
        painter.setBrush(QColor(theme.raised))
        painter.drawRoundedRect(self.rect().adjusted(0, 0, -1, -1), 4, 4)
        high = self.fontMetrics().height()
        bar = self.rect().adjusted(10, high + 6, -10, -high - 6)
        painter.setPen(QColor(theme.text))
        top = QRectF(10, 4, bar.width(), high)
        painter.drawText(top, Qt.AlignmentFlag.AlignLeft, tr("|offset| at the frame"))
        angles = np.radians(np.linspace(0.0, 180.0, bar.width()))
        for k, colour in enumerate(scale_colour(theme, angles)):
            ink = QColor(*colour.astype(int).tolist())
            painter.fillRect(bar.left() + k, bar.top(), 1, bar.height(), ink)
        painter.setPen(QColor(theme.soft))
        for degrees in (0, 60, 120, 180):
            text = f"{degrees}°"
            wide = self.fontMetrics().horizontalAdvance(text)
            middle = bar.left() + bar.width() * degrees / 180.0
            left = min(max(middle - wide / 2.0, bar.left()), bar.right() - wide + 1)
            painter.drawText(QPointF(left, self.height() - 4 - self.fontMetrics().descent()), text)


def _unbroken(text: str) -> str:
    return text.replace(" ", "&nbsp;")


def _key(mark: str, colour: str, text: str) -> str:
    return f"{inked(mark, colour)}&nbsp;{text}"


def _let_through(widget: _Shown) -> _Shown:
    """Return the widget, made transparent for the mouse."""
    widget.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    return widget
