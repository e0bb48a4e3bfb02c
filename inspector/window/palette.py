"""The command palette, in which the user finds any action by a part of its name."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QObject, QPoint, Qt
from PySide6.QtGui import QAction, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QDialog, QLineEdit, QWidget

from inspector.language import tr
from inspector.widgets.building import vbox
from inspector.widgets.keyed_list import KeyedList

_ROWS = 12


class CommandPalette(QDialog):
    """A search line above a list of matching actions.

    Enter runs the selected action.
    """

    def __init__(self, actions: Mapping[str, QAction], parent: QWidget) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self._actions = actions
        self.line = QLineEdit()
        self.line.setPlaceholderText(tr("What do you want to do?"))
        self.line.setAccessibleName(tr("What do you want to do?"))
        self.list = KeyedList(keys_first=False)
        self.list.setObjectName("palette")
        self.list.setAccessibleName(tr("Matching actions"))
        vbox(self.line, self.list, owner=self, margins=(6, 6, 6, 6))
        self.line.textChanged.connect(self._filter)
        self.line.returnPressed.connect(self._do)
        self.line.installEventFilter(self)
        self.list.itemActivated.connect(self._do)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._filter("")
        self.list.ensurePolished()
        width = min(560, parent.width() - 40)
        self.resize(width, self.list.sizeHintForRow(0) * _ROWS + 60)
        self.move(parent.mapToGlobal(QPoint((parent.width() - width) // 2, 60)))

    def _filter(self, typed: str) -> None:
        self.list.clear()
        words = typed.lower().split()
        for name, action in self._actions.items():
            text = action.text().replace("&", "")
            keys = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
            if action.isEnabled() and all(w in f"{text} {keys}".lower() for w in words):
                self.list.add(text, keys, name)
        self.list.setCurrentRow(0)

    def _do(self) -> None:
        item = self.list.currentItem()
        self.close()
        if item is not None:
            self._actions[item.data(Qt.ItemDataRole.UserRole)].trigger()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Move the selection with Up and Down while the search line has the focus."""
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            step = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1}.get(Qt.Key(event.key()), 0)
            if step:
                row = self.list.currentRow() + step
                self.list.setCurrentRow(max(0, min(row, self.list.count() - 1)))
                return True
        return super().eventFilter(watched, event)
