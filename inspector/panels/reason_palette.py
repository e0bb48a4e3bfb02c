"""A list of reasons for a rejection. The user presses a digit or types a different reason."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, QPoint, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QDialog, QFrame, QLabel, QLineEdit, QWidget

from inspector.language import tr
from inspector.panels.reject_reasons import (
    REASONS,
    reject_reason_in_english,
    translate_reject_reason,
)
from inspector.widgets.building import use_secondary_text_colour, vbox
from inspector.widgets.keyed_list import KeyedList

_MOST = 9
_STEPS = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1}


class ReasonPalette(QDialog):
    """A popup with reasons. The keys 1 to 9 select a reason, and Enter accepts a typed reason.

    Lists the usual reasons first, then `reasons`.
    """

    chosen = Signal(str)

    def __init__(self, reasons: Sequence[str], title: str, parent: QWidget) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.line = QLineEdit(placeholderText=tr("Press 1-9, or type a reason and press Enter"))
        self.line.setAccessibleName(tr("Reason"))
        self.list = KeyedList(keys_first=True)
        self.list.setAccessibleName(tr("Reasons"))
        self.list.setSpacing(2)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._reasons = list(dict.fromkeys((*REASONS, *reasons)))[:_MOST]
        for k, reason in enumerate(self._reasons, 1):
            self.list.add(translate_reject_reason(reason), str(k))
        self.title = use_secondary_text_colour(QLabel(title))
        frame = QFrame()
        frame.setObjectName("bar")
        vbox(self.title, self.line, self.list, owner=frame, margins=(10, 8, 10, 10))
        vbox(frame, owner=self, margins=(0, 0, 0, 0))
        self.line.installEventFilter(self)
        self.line.returnPressed.connect(self._take_line)
        self.list.itemClicked.connect(lambda item: self._take(self.list.row(item)))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        width = min(380, parent.width() - 40)
        rows = (self.list.sizeHintForRow(0) + 2 * self.list.spacing()) * len(
            self._reasons
        ) + 2 * self.list.frameWidth()
        self.list.setFixedHeight(rows)
        self.resize(width, self.sizeHint().height())
        self.move(parent.mapToGlobal(QPoint((parent.width() - width) // 2, 60)))

    def _take_line(self) -> None:
        if text := self.line.text().strip():
            self._end(reject_reason_in_english(text))
        else:
            self._take(self.list.currentRow())

    def _take(self, row: int) -> None:
        if 0 <= row < len(self._reasons):
            self._end(self._reasons[row])

    def _end(self, reason: str) -> None:
        self.close()
        self.chosen.emit(reason)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle the keys that are pressed in the input field.

        Up and Down move in the list. While the field is empty, a digit selects a reason.
        """
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            if step := _STEPS.get(Qt.Key(event.key()), 0):
                row = self.list.currentRow() + step
                self.list.setCurrentRow(max(0, min(row, self.list.count() - 1)))
                return True
            if event.text().isdigit() and not self.line.text():
                self._take(int(event.text()) - 1)
                return True
        return super().eventFilter(watched, event)
