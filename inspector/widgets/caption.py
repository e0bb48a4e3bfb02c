"""Words over a plot that change with every step of a drag, and leave the window's layout alone."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy, QWidget


class Caption(QWidget):
    """Rich text as wide as there is room, broken into lines; it grows with them, never shrinks.

    The label is laid out by hand: in a layout it would ask for a new one with every text.
    """

    def __init__(self, *, soft: bool = False, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = QLabel(self)
        self.label.setTextFormat(Qt.TextFormat.RichText)
        self.label.setWordWrap(True)
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
