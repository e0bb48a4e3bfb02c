"""Labels whose changing text moves nothing around them.

An ordinary label asks for a new layout with every text, and the window lays itself out and repaints
once more for each step of a drag.
"""

from __future__ import annotations

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy, QWidget


class SteadyLabel(QLabel):
    """A line of figures; it grows where they need more room and never shrinks."""

    def setText(self, text: str) -> None:
        """Show a text, in more room if it needs more."""
        if text != self.text():
            super().setText(text)
            self._grow()

    def changeEvent(self, event: QEvent) -> None:
        """Another font needs other room."""
        super().changeEvent(event)
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.StyleChange):
            self.setMinimumSize(0, 0)  # a hint is never smaller than the minimum
            self.setFixedSize(self.sizeHint())

    def _grow(self) -> None:
        wanted, has = self.sizeHint(), self.maximumSize()
        fixed = self.minimumSize() == has
        room = QSize(wanted).expandedTo(has) if fixed else wanted
        if not fixed or room != has:
            self.setFixedSize(room)


def inked(text: str, colour: str) -> str:
    """Rich text in a colour, '#rrggbb'."""
    return f"<span style='color:{colour}'>{text}</span>"


class Caption(QWidget):
    """Rich text as wide as there is room, broken into lines; it grows with them, never shrinks.

    The label in it is placed by hand: no layout, no new one with every text.
    """

    def __init__(self, *, soft: bool = False) -> None:
        super().__init__()
        self.label = QLabel(self, textFormat=Qt.TextFormat.RichText, wordWrap=True)
        if soft:
            self.label.setObjectName("soft")
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setFixedHeight(self.fontMetrics().height() + 2)

    def text(self) -> str:
        """What it says, as rich text."""
        return self.label.text()

    def set_text(self, text: str) -> None:
        """Say something else."""
        if text != self.text():
            self.label.setText(text)
            self._fit(self.height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Another width needs other lines."""
        super().resizeEvent(event)
        self._fit(self.fontMetrics().height() + 2)

    def _fit(self, least: int) -> None:
        height = max(least, self.label.heightForWidth(self.width()))
        if height != self.height():
            self.setFixedHeight(height)
        self.label.setGeometry(0, 0, self.width(), height)


class ElidedLabel(QLabel):
    """A line that makes nothing wider: where there is no room its end is left out."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def paintEvent(self, event: QPaintEvent) -> None:
        """As much of the text as there is room for."""
        painter = QPainter(self)
        end = Qt.TextElideMode.ElideRight
        text = self.fontMetrics().elidedText(self.text(), end, self.width())
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignVCenter, text)
        painter.end()
