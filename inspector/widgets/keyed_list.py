"""A list with two columns: labels and their keyboard shortcuts."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter, QPalette
from PySide6.QtWidgets import (
    QListWidget,
    QListWidgetItem,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
)

from inspector.widgets.tables import Index

_KEY = Qt.ItemDataRole.UserRole + 1
_SIDE = Qt.AlignmentFlag.AlignVCenter
_PAD = 8  # pixels between a shortcut and its neighbours


class KeyedList(QListWidget):
    """A list of labels and their keyboard shortcuts.

    If `keys_first` is True, the shortcuts are to the left of the labels. If it is False, they are
    at the right edge.
    """

    def __init__(self, *, keys_first: bool) -> None:
        super().__init__()
        self.keys_first = keys_first
        self.setUniformItemSizes(True)
        self.setItemDelegate(_KeyedRows(self))

    def add(self, words: str, key: str, data: object = None) -> None:
        """Add a row with a label and its shortcut. `data` is stored in the row's UserRole."""
        item = QListWidgetItem(words)
        item.setData(_KEY, key)
        if key:
            item.setData(Qt.ItemDataRole.AccessibleTextRole, f"{words}, {key}")
        item.setData(Qt.ItemDataRole.UserRole, data)
        self.addItem(item)


class _KeyedRows(QStyledItemDelegate):
    def __init__(self, owner: KeyedList) -> None:
        super().__init__(owner)
        self._owner = owner

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Paint the background of the row, then the label and the shortcut in their columns."""
        option = QStyleOptionViewItem(option)
        self.initStyleOption(option, index)
        words, option.text = option.text, ""
        style, role = option.widget.style(), QPalette.ColorRole
        style.drawControl(QStyle.ControlElement.CE_ItemViewItem, option, painter, option.widget)
        key, letters = str(index.data(_KEY)), option.fontMetrics
        room = option.rect.adjusted(_PAD // 2, 0, -_PAD, 0)
        if self._owner.keys_first:
            wide, at = letters.horizontalAdvance("0") + 2 * _PAD, Qt.AlignmentFlag.AlignHCenter
            beside, rest = room.adjusted(0, 0, wide - room.width(), 0), room.adjusted(wide, 0, 0, 0)
        else:
            wide, at = letters.horizontalAdvance(key) + _PAD, Qt.AlignmentFlag.AlignRight
            beside, rest = room, room.adjusted(0, 0, -wide, 0)
        chosen = bool(option.state & QStyle.StateFlag.State_Selected)
        inks = (role.HighlightedText,) * 2 if chosen else (role.Text, role.PlaceholderText)
        fitting = letters.elidedText(words, Qt.TextElideMode.ElideRight, rest.width())
        left = Qt.AlignmentFlag.AlignLeft
        for ink, place, side, text in (
            (inks[0], rest, left, fitting),
            (inks[1], beside, at, key),
        ):
            painter.setPen(option.palette.color(ink))
            painter.drawText(place, side | _SIDE, text)
