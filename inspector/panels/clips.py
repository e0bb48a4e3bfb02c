"""The clips of the folder: worst first, with their review state and the queue's progress."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QProgressBar,
    QPushButton,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QVBoxLayout,
    QWidget,
)

from inspector.document import Document
from inspector.folder import ClipState, FolderQueue, QueuedClip
from inspector.theme import Theme

_Index = QModelIndex | QPersistentModelIndex
_HEADS = ("Clip", "Severity", "Review")
_SEVERITY = Qt.ItemDataRole.UserRole


class _ClipModel(QAbstractTableModel):
    def __init__(self, queue: FolderQueue, theme: Theme) -> None:
        super().__init__()
        self._queue = queue
        self.theme = theme
        self.rows: list[QueuedClip] = []

    def refresh(self) -> None:
        new = self._queue.ordered
        if [c.path for c in new] == [c.path for c in self.rows]:
            self.rows = new
            if new:
                self.dataChanged.emit(self.index(0, 0), self.index(len(new) - 1, len(_HEADS) - 1))
            return
        self.beginResetModel()
        self.rows = new
        self.endResetModel()

    def rowCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(_HEADS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return _HEADS[section]
        return None

    def data(self, index: _Index, role: int = 0) -> Any:
        if not index.isValid():
            return None
        clip = self.rows[index.row()]
        if role == Qt.ItemDataRole.DisplayRole:
            return (clip.path.stem, "", _review(clip))[index.column()]
        if role == _SEVERITY:
            return clip.severity
        if role == Qt.ItemDataRole.ToolTipRole:
            return _tip(clip)
        if role == Qt.ItemDataRole.ForegroundRole:
            if clip.state == ClipState.FAILED:
                return QColor(self.theme.rejected)
            if clip.done:
                return QColor(self.theme.accepted)
            if clip.state != ClipState.READY:
                return QColor(self.theme.soft)
        return None


def _review(clip: QueuedClip) -> str:
    if clip.state == ClipState.FAILED:
        return "failed"
    if clip.decided:
        return f"{clip.decided[0]} / {clip.decided[1]}"
    if clip.state == ClipState.READY:
        return f"0 / {clip.intervals}" if clip.intervals else "clean"
    return "…" if clip.state == ClipState.ANALYSING else ""


def _tip(clip: QueuedClip) -> str:
    if clip.reason:
        return clip.reason
    if clip.state != ClipState.READY:
        return f"{clip.path.name}: {clip.state}"
    return f"{clip.path.name}: {clip.intervals} intervals, {clip.severity:.3f}° a frame"


class _SeverityBar(QStyledItemDelegate):
    """A bar on a square root scale, against the worst clip of the folder."""

    def __init__(self, model: _ClipModel, parent: QWidget) -> None:
        super().__init__(parent)
        self._model = model

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: _Index) -> None:
        super().paint(painter, option, index)
        severity = index.data(_SEVERITY)
        worst = max((c.severity for c in self._model.rows), default=0.0)
        if severity is None or severity <= 0.0 or worst <= 0.0:
            return
        room = QRectF(option.rect).adjusted(4, 7, -6, -7)
        room.setWidth(max(2.0, room.width() * (severity / worst) ** 0.5))
        painter.fillRect(room, QColor(self._model.theme.before))

    def sizeHint(self, option: QStyleOptionViewItem, index: _Index) -> QSize:
        return QSize(70, super().sizeHint(option, index).height())


class ClipsPanel(QWidget):
    """Table of the folder's clips; a double click or Enter opens one."""

    chosen = Signal(object)  # Path

    def __init__(
        self, queue: FolderQueue, document: Document, theme: Theme, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._queue, self._document = queue, document
        self._model = _ClipModel(queue, theme)
        self.table = QTableView()
        self.table.setModel(self._model)
        self.table.setItemDelegateForColumn(1, _SeverityBar(self._model, self.table))
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.setShowGrid(False)
        self.table.setTabKeyNavigation(False)
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.table.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.resizeSection(1, 80)
        header.resizeSection(2, 70)
        self.bar = QProgressBar()
        self.bar.setTextVisible(False)
        self.bar.setMaximumHeight(6)
        self.status = QLabel()
        self.status.setObjectName("soft")
        self.stop = QPushButton("Stop")
        self.stop.setToolTip("Stop analysing; what is known stays")
        self.stop.clicked.connect(queue.cancel)
        foot = QHBoxLayout()
        foot.addWidget(self.status, 1)
        foot.addWidget(self.stop)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 4)
        layout.setSpacing(3)
        layout.addWidget(self.table, 1)
        layout.addWidget(self.bar)
        layout.addLayout(foot)
        self.table.doubleClicked.connect(lambda index: self._choose(index.row()))
        self.table.activated.connect(lambda index: self._choose(index.row()))
        queue.changed.connect(self._refresh)
        queue.finished.connect(self._refresh)
        document.opened.connect(self._mark_open)
        self._refresh()

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._model.theme = theme
        self._model.refresh()

    def _choose(self, row: int) -> None:
        self.chosen.emit(self._model.rows[row].path)

    def _refresh(self) -> None:
        self._model.refresh()
        done, total = self._queue.progress
        self.bar.setRange(0, max(total, 1))
        self.bar.setValue(done)
        self.bar.setVisible(self._queue.running)
        self.stop.setVisible(self._queue.running)
        failed = sum(c.state == ClipState.FAILED for c in self._model.rows)
        if self._queue.running:
            left = self._queue.seconds_left
            self.status.setText(f"{done} of {total} analysed, about {left:.0f} s left")
        else:
            told = f", {failed} failed" if failed else ""
            self.status.setText(f"{total} clips{told}" if total else "")
        self._mark_open()

    def _mark_open(self) -> None:
        data = self._document.data
        for row, clip in enumerate(self._model.rows):
            if data is not None and clip.path == data.clip.path:
                self.table.selectRow(row)
