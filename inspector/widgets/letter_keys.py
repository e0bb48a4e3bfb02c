"""Keys of the program while a number is being edited."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractSpinBox


class LetterKeys(QObject):
    """Lets A, R, N, Space … through spin boxes to the actions: they only need figures."""

    def __init__(self, parent: QObject, *boxes: QAbstractSpinBox) -> None:
        super().__init__(parent)
        for box in boxes:
            box.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """A plain letter or Space is no number: leave it to the shortcuts."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            plain = event.modifiers() in (
                Qt.KeyboardModifier.NoModifier,
                Qt.KeyboardModifier.ShiftModifier,
            )
            if plain and (event.text().isalpha() or event.text() in (" ", "[", "]")):
                event.ignore()
                return True
        return super().eventFilter(watched, event)
