"""The clips of the folder: worst first, with their review state and the queue's progress."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QRectF, QSize, Signal
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import (
    QHeaderView,
    QLabel,
    QProgressBar,
    QPushButton,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from inspector.session.document import Document
from inspector.session.queue import ClipState, FolderQueue, QueuedClip
from inspector.widgets.building import hbox, soft, vbox
from inspector.widgets.tables import SORT_ROLE, Index, Row, RowModel, RowTable
from inspector.widgets.theme import Theme

_HEADS = ("Clip", "Severity", "Review")


class _ClipModel(RowModel[QueuedClip]):
    heads = _HEADS

    def key(self, thing: QueuedClip) -> Path:
        return thing.path

    def describe(self, thing: QueuedClip) -> Row:
        colour = None
        if thing.state == ClipState.FAILED:
            colour = self.theme.rejected
        elif thing.done:
            colour = self.theme.accepted
        elif thing.state != ClipState.READY:
            colour = self.theme.soft
        return Row(
            texts=(thing.path.stem, "", _review(thing)),
            sort=(thing.path.stem, thing.severity, _review(thing)),
            colours=dict.fromkeys(range(len(_HEADS)), colour) if colour else {},
            tips=(_tip(thing),),
        )


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

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        super().paint(painter, option, index)
        severity = index.data(SORT_ROLE)
        worst = max((c.severity for c in self._model.things), default=0.0)
        if severity is None or severity <= 0.0 or worst <= 0.0:
            return
        room = QRectF(option.rect).adjusted(4, 7, -6, -7)
        room.setWidth(max(2.0, room.width() * (severity / worst) ** 0.5))
        painter.fillRect(room, QColor(self._model.theme.before))

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(70, super().sizeHint(option, index).height())


class ClipsPanel(QWidget):
    """Table of the folder's clips; a double click or Enter opens one."""

    chosen = Signal(object)  # Path

    def __init__(self, queue: FolderQueue, document: Document, theme: Theme) -> None:
        super().__init__()
        self._queue, self._document = queue, document
        self._model = _ClipModel(theme)
        self.table = RowTable(self._model)
        self.table.setItemDelegateForColumn(1, _SeverityBar(self._model, self.table))
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.resizeSection(1, 80)
        header.resizeSection(2, 70)
        self.bar = QProgressBar(textVisible=False)
        self.bar.setMaximumHeight(6)
        self.status = soft(QLabel())
        self.stop = QPushButton("Stop")
        self.stop.setToolTip("Stop analysing; what is known stays")
        self.stop.clicked.connect(queue.cancel)
        foot = hbox((self.status, 1), self.stop)
        vbox((self.table, 1), self.bar, foot, owner=self, margins=(0, 0, 0, 4), spacing=3)
        for signal in (self.table.doubleClicked, self.table.activated):
            signal.connect(lambda at: self.chosen.emit(self._model.things[at.row()].path))
        queue.changed.connect(self._refresh)
        queue.finished.connect(self._refresh)
        document.opened.connect(self._mark_open)
        self._refresh()

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._model.set_theme(theme)

    def _refresh(self) -> None:
        self._model.show(self._queue.ordered)
        self.table.viewport().update()  # the bars measure against the worst, which may be new
        done, total = self._queue.progress
        self.bar.setUpdatesEnabled(False)  # else every value repaints the window at once
        self.bar.setRange(0, max(total, 1))
        self.bar.setValue(done)
        self.bar.setUpdatesEnabled(True)
        self.bar.setVisible(self._queue.running)
        self.stop.setVisible(self._queue.running)
        failed = sum(c.state == ClipState.FAILED for c in self._model.things)
        if self._queue.running:
            left = self._queue.seconds_left
            self.status.setText(f"{done} of {total} analysed, about {left:.0f} s left")
        else:
            told = f", {failed} failed" if failed else ""
            self.status.setText(f"{total} clips{told}" if total else "")
        self._mark_open()

    def _mark_open(self) -> None:
        data = self._document.data
        at = self._model.row_of(data.clip.path) if data is not None else None
        if at is not None:
            self.table.selectRow(at)
