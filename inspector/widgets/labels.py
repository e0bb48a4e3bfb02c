"""A label whose changing figures leave the window's layout alone."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QSize
from PySide6.QtWidgets import QLabel


class SteadyLabel(QLabel):
    """It grows where a text needs more room and never shrinks.

    An ordinary label asks for a new layout with every text, and the window lays itself out and
    repaints once more for each step of a drag.
    """

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
