"""Text over the 3D view: the legend in its corner, and what to do when nothing can be shown."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QLabel, QWidget

from inspector.session.document import Show
from inspector.viewport.bone_colours import scale_colour
from inspector.widgets.theme import Theme

EMPTY = "Open a BVH (Ctrl+O), drop one here, or try the sample"


def make_notice(parent: QWidget) -> QLabel:
    """A sentence in the middle of the view."""
    label = QLabel(parent)
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.setWordWrap(True)
    label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    return label


def make_legend(parent: QWidget) -> QLabel:
    """The small key of colours."""
    label = QLabel(parent)
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    label.hide()
    return label


def make_divider(parent: QWidget) -> QWidget:
    """The line between two pictures side by side."""
    line = QWidget(parent)
    line.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    line.hide()
    return line


def legend_text(theme: Theme, show: str, chain: str, degrees: float) -> str:
    """Rich text: what is before and after, by colour and form, and the chain's offset now.

    show: one of document.Show, or 'split' for one beside the other.
    """
    before = _key("□" if show == Show.BOTH else "■", theme.before, "before")
    after = _key("■", theme.after, "after")
    if show == "split":
        text = f"◧&nbsp;{before}&nbsp;&nbsp; ◨&nbsp;{after}"
    else:
        both = f"{before}&nbsp;&nbsp; {after}"
        text = {Show.BEFORE: before, Show.AFTER: after, Show.BOTH: both}[Show(show)]
    if chain:
        colour = theme.before if abs(degrees) >= 0.05 else theme.soft
        number = f"{degrees:+.1f}°".replace("-", "−") if abs(degrees) >= 0.05 else "0.0°"
        text += f"&nbsp;&nbsp;&nbsp; <b>{chain}</b>&nbsp; "
        text += f"<span style='color:{colour}'>{number} off</span>"
    return text


def trails_text(apart: float) -> str:
    """Rich text: how far before and after are apart, in shares of the figure's height."""
    same = "&lt; 0.001 %" if apart < 1e-5 else f"{100.0 * apart:.3f} %"
    return f"<br>hands and feet: {same} of the height apart"


def companion_text(theme: Theme) -> str:
    """Rich text: the key of the third figure."""
    return f"&nbsp;&nbsp;&nbsp; {_key('┄', theme.tracked, 'tracked')}"


class OffsetScale(QWidget):
    """The colours of |offset|, 0…180°."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        letters = self.fontMetrics()
        self.setFixedSize(max(200, letters.horizontalAdvance("0° 60° 120° 180°") + 90),
                          2 * letters.height() + 22)  # fmt: skip
        self.hide()

    def set_theme(self, theme: Theme) -> None:
        """Draw in other colours."""
        self._theme = theme
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """A bar of colours with its numbers."""
        painter, theme = QPainter(self), self._theme
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QColor(theme.line))
        painter.setBrush(QColor(theme.raised))
        painter.drawRoundedRect(self.rect().adjusted(0, 0, -1, -1), 4, 4)
        high = self.fontMetrics().height()
        bar = self.rect().adjusted(10, high + 6, -10, -high - 6)
        painter.setPen(QColor(theme.text))
        top = QRectF(10, 4, bar.width(), high)
        painter.drawText(top, Qt.AlignmentFlag.AlignLeft, "|offset| at the frame")
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


def legend_style(theme: Theme, points: float) -> str:
    """Style sheet of the legend, in type of a size."""
    return (
        f"background: {theme.raised}; color: {theme.text}; border: 1px solid {theme.line};"
        f"border-radius: 4px; padding: 4px 8px; font-size: {points:.1f}pt;"
    )


def _key(mark: str, colour: str, text: str) -> str:
    return f"<span style='color:{colour}'>{mark}</span>&nbsp;{text}"
