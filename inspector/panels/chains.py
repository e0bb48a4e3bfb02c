"""The chains of the clip: what was found in each, and how far it can be trusted."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLabel,
    QStackedLayout,
    QTableView,
    QWidget,
)

from inspector.document import Document
from inspector.theme import Theme
from twistcore.chain import uncorrectable_joints
from twistcore.refinement import children_off_axis
from twistcore.review import Decision

_Index = QModelIndex | QPersistentModelIndex
_HEADS = ("Chain", "Done", "Peak", "τ", "Azimuth")
_TIPS = (
    "Side and segment of the parent joint; the tick shows or hides its intervals",
    "Intervals decided of those found",
    "Largest strength in the clip: m(t) for the paper's method",
    "Threshold of this chain",
    "Median reliability of the azimuth: low on a straight limb",
)


class _ChainModel(QAbstractTableModel):
    def __init__(self, document: Document, theme: Theme) -> None:
        super().__init__()
        self._document = document
        self.theme = theme
        self._peak: list[float] = []
        self._reliability: list[float] = []

    def reset(self) -> None:
        self.beginResetModel()
        data = self._document.data
        chains = data.chains if data else ()
        self._peak = [np.degrees(data.analysis.strength(c.name).max()) for c in chains]  # type: ignore[union-attr]
        self._reliability = [
            float(np.median(data.signals[c.name].azimuth_reliability))  # type: ignore[union-attr]
            for c in chains
        ]
        self.endResetModel()

    def refresh(self) -> None:
        if rows := self.rowCount():
            self.dataChanged.emit(self.index(0, 0), self.index(rows - 1, len(_HEADS) - 1))

    def rowCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() or not self._document.data else len(self._document.data.chains)

    def columnCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(_HEADS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        if orientation == Qt.Orientation.Horizontal:
            if role == Qt.ItemDataRole.DisplayRole:
                return _HEADS[section]
            if role == Qt.ItemDataRole.ToolTipRole:
                return _TIPS[section]
            if role == Qt.ItemDataRole.TextAlignmentRole:
                return _alignment(section)
        return None

    def data(self, index: _Index, role: int = 0) -> Any:
        data = self._document.data
        if data is None or not index.isValid():
            return None
        chain = data.chains[index.row()]
        found = self._document.review.state.of_chain(chain.name)
        decided = sum(j.decision != Decision.UNDECIDED for j in found)
        if role == Qt.ItemDataRole.DisplayRole:
            stuck = uncorrectable_joints(data.motion, chain)
            return (
                f"{chain.label} (fixed)" if stuck else chain.label,
                f"{decided} / {len(found)}" if found else "–",
                f"{self._peak[index.row()]:.1f}°",
                f"{np.degrees(self._document.review.state.tau[chain.name]):.1f}°",
                f"{100 * self._reliability[index.row()]:.0f} %",
            )[index.column()]
        if role == Qt.ItemDataRole.CheckStateRole and index.column() == 0:
            shown = chain.name not in self._document.hidden
            return Qt.CheckState.Checked if shown else Qt.CheckState.Unchecked
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(index.column())
        if role == Qt.ItemDataRole.ToolTipRole:
            stuck = uncorrectable_joints(data.motion, chain)
            notes = list(chain.warnings)
            if stuck:
                notes.append(f"not corrected: {', '.join(stuck)} without three rotation channels")
            beside = children_off_axis(data.motion, chain)
            if beside:
                notes.append(f"beside the bone, so a correction moves them: {', '.join(beside)}")
            return "\n".join((f"{chain.name}: {_TIPS[index.column()]}", *notes))
        if role == Qt.ItemDataRole.ForegroundRole:
            if index.column() == 1 and found:
                done = decided == len(found)
                return QColor(self.theme.accepted if done else self.theme.undecided)
            if index.column() == 4 and self._reliability[index.row()] < 0.2:
                return QColor(self.theme.warning)
            if not found:
                return QColor(self.theme.soft)
        return None

    def flags(self, index: _Index) -> Qt.ItemFlag:
        tick = Qt.ItemFlag.ItemIsUserCheckable if index.column() == 0 else Qt.ItemFlag.NoItemFlags
        return super().flags(index) | tick

    def setData(self, index: _Index, value: Any, role: int = 0) -> bool:
        data = self._document.data
        if role != Qt.ItemDataRole.CheckStateRole or data is None:
            return False
        shown = Qt.CheckState(value) == Qt.CheckState.Checked
        self._document.set_hidden(data.chains[index.row()].name, not shown)
        return True


def _alignment(column: int) -> Qt.AlignmentFlag:
    side = Qt.AlignmentFlag.AlignLeft if column == 0 else Qt.AlignmentFlag.AlignRight
    return side | Qt.AlignmentFlag.AlignVCenter


class ChainsPanel(QWidget):
    """Table of chains; the selected row is the document's chain."""

    def __init__(self, document: Document, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self._model = _ChainModel(document, theme)
        self.table = QTableView()
        self.table.setModel(self._model)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.setShowGrid(False)
        self.table.setWordWrap(False)
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.table.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(len(_HEADS) - 1, QHeaderView.ResizeMode.Stretch)
        self.table.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._hint = QLabel("The chains of a clip appear here.")
        self._hint.setObjectName("soft")
        self._hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._hint.setWordWrap(True)
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self._hint)
        self._stack.addWidget(self.table)
        self.table.selectionModel().currentRowChanged.connect(self._row_selected)
        document.opened.connect(self._reset)
        document.method_changed.connect(self._reset)
        document.hidden_changed.connect(self._model.refresh)
        document.intervals_changed.connect(self._model.refresh)
        document.chain_changed.connect(self._select_row)
        self._reset()

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._model.theme = theme
        self._model.refresh()

    def _reset(self) -> None:
        self._model.reset()
        self._stack.setCurrentIndex(1 if self._model.rowCount() else 0)
        if self._document.data and not self._model.rowCount():
            self._hint.setText("This skeleton has no chain of parent, child and grandchild.")
        self._select_row()

    def _select_row(self) -> None:
        for row, chain in enumerate(self._document.data.chains if self._document.data else ()):
            if chain.name == self._document.chain:
                self.table.setCurrentIndex(self._model.index(row, 0))

    def _row_selected(self, current: QModelIndex) -> None:
        if self._document.data and current.isValid():
            self._document.select_chain(self._document.data.chains[current.row()].name)
