"""How a cell of a table gets its text: in one call, where Qt would ask the model seven times."""

from __future__ import annotations

from PySide6.QtCore import QAbstractProxyModel, QObject
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QStyledItemDelegate, QStyleOptionViewItem

from inspector.widgets.tables import Index, RowModel

_Feature = QStyleOptionViewItem.ViewItemFeature


class RowDelegate(QStyledItemDelegate):
    """Takes text, side, colour and tick from a model's row; proxy: what stands before the model."""

    def __init__(
        self, model: RowModel, parent: QObject, proxy: QAbstractProxyModel | None = None
    ) -> None:
        super().__init__(parent)
        self._model, self._proxy = model, proxy

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        """What the model's data() says, by the same description."""
        source = self._proxy.mapToSource(index) if self._proxy else index
        row, column = self._model.row(source.row()), source.column()
        option.index = index
        option.displayAlignment = self._model.alignment(column)
        option.text = row.texts[column]
        option.features |= _Feature.HasDisplay
        if (colour := row.colours.get(column)) is not None:
            option.palette.setColor(QPalette.ColorRole.Text, QColor(colour))
        if column == 0 and row.tick is not None:
            option.features |= _Feature.HasCheckIndicator
            option.checkState = self._model.tick(row.tick)
