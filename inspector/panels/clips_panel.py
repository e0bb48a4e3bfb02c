"""The clips of the folder: worst first, with their review state and the queue's progress."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from PySide6.QtCore import QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import (
    QComboBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QStyleOptionViewItem,
    QWidget,
)

from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import ClipState, QueuedClip
from inspector.session.document import Document
from inspector.widgets.building import hbox, soft, vbox
from inspector.widgets.tables import Index, Row, RowDelegate, RowModel, RowTable
from inspector.widgets.theme import Theme
from twistcore.review import Decision

_ROWS = 10  # clips that are to be seen at least, where there is room
_COUNT_MS = 60  # while τ is dragged the list does not follow every step
_NEWS_MS = 160  # nor, while clips are analysed, every one of them
_HEADS = ("Clip", "Severity", "Review", "Export")
_NAME_WIDTH = 90  # pixels
# What the filter lets through, by its words.
STATES: Mapping[str, Callable[[QueuedClip], bool]] = {
    "All": lambda _: True,
    "To do": lambda c: c.to_do,
    "Done": lambda c: c.done,
    "Clean": lambda c: c.clean,
    "Not exported": lambda c: not c.exported and c.state != ClipState.FAILED,
    "To restore": lambda c: c.waits,
    "Failed": lambda c: c.state == ClipState.FAILED or c.unchecked,
}


class _ClipModel(RowModel[QueuedClip]):
    heads = _HEADS
    head_tips = (
        "Name of the clip; ↺: decisions of it wait to be restored",
        "Mean error a frame; a click on a head sorts by it",
        "Intervals decided, of those there are",
        "Whether it was exported",
    )

    def key(self, thing: QueuedClip) -> Path:
        return thing.path

    def describe(self, thing: QueuedClip) -> Row:
        colour = None
        if thing.state == ClipState.FAILED:
            colour = self.theme.rejected
        elif thing.done:
            colour = self.theme.accepted
        elif thing.state != ClipState.READY or thing.unchecked:
            colour = self.theme.soft
        name = f"↺ {thing.title}" if thing.waits else thing.title
        return Row(
            texts=(name, "", _review(thing), "✓" if thing.exported else ""),
            colours=dict.fromkeys(range(len(_HEADS)), colour) if colour else {},
            tips=(_tip(thing),),
        )


def _sorted_by(clip: QueuedClip) -> tuple[Any, ...]:
    """Values to sort by, a column each; of reviews, what is left to do."""
    decided, of = clip.counts
    left = clip.state == ClipState.READY, of - decided, of
    return clip.title.casefold(), clip.severity, left, clip.exported


def _review(clip: QueuedClip) -> str:
    if clip.state == ClipState.FAILED:
        return "failed"
    if clip.counts[1] and (clip.decided or clip.state == ClipState.READY):
        return f"{clip.counts[0]} / {clip.counts[1]}"
    if clip.state == ClipState.READY:
        return "not checked" if clip.unchecked else "clean"
    return "…" if clip.state == ClipState.ANALYSING else ""


def _tip(clip: QueuedClip) -> str:
    name = clip.label or clip.path.name
    if clip.state == ClipState.FAILED:
        return clip.reason
    if clip.unchecked:
        return f"{name}: not checked, {clip.reason}"
    if clip.state != ClipState.READY:
        return f"{name}: {clip.state}"
    told = [f"{name}: {clip.intervals} intervals, {clip.severity:.3f}° a frame"]
    if clip.waits:
        told.append("a review of it ended without saving: open it to restore its decisions")
    if clip.exported:
        told.append(f"exported as {clip.exported}")
    return "\n".join(told)


class _SeverityBar(RowDelegate):
    """A bar on a square root scale, against the worst clip that is listed."""

    def __init__(self, model: _ClipModel, parent: QWidget) -> None:
        super().__init__(model, parent)
        self._clips = model
        self.worst = 0.0

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        super().paint(painter, option, index)
        severity = self._clips.things[index.row()].severity
        if severity <= 0.0 or self.worst <= 0.0:
            return
        room = QRectF(option.rect).adjusted(4, 5, -6, -5)
        room.setWidth(max(2.0, room.width() * (severity / self.worst) ** 0.5))
        painter.fillRect(room, QColor(self._clips.theme.before))

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(70, super().sizeHint(option, index).height())


class ClipsPanel(QWidget):
    """Table of the folder's clips; a double click or Enter opens one."""

    chosen = Signal(object)  # Path

    def __init__(self, queue: FolderQueue, document: Document, theme: Theme) -> None:
        super().__init__()
        self._queue, self._document = queue, document
        self._model = _ClipModel(theme)
        self._order: tuple[int, bool] | None = None  # column, whether downwards; None: worst first
        self.table = RowTable(self._model, room=2)
        self.table.setItemDelegate(RowDelegate(self._model, self.table))
        self._severities = _SeverityBar(self._model, self.table)
        self.table.setItemDelegateForColumn(_HEADS.index("Severity"), self._severities)
        self._lay_out_heads()
        self.text = QLineEdit(placeholderText="Filter by name", clearButtonEnabled=True)
        self.wanted = QComboBox()
        self.wanted.addItems(list(STATES))
        self.text.textChanged.connect(self._refresh)
        self.wanted.currentTextChanged.connect(self._refresh)
        self.bar = QProgressBar(textVisible=False)
        self.bar.setMaximumHeight(6)
        self.status, self.tau = soft(QLabel()), soft(QLabel())
        for label in (self.status, self.tau):  # a long text makes the dock no wider
            label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.stop = QPushButton("Stop")
        self.stop.setToolTip("Stop analysing; what is known stays")
        self.stop.clicked.connect(queue.cancel)
        above = hbox((self.text, 1), self.wanted, margins=(4, 2, 4, 0))
        foot = hbox((self.status, 1), self.stop, margins=(4, 0, 4, 0))
        under = hbox((self.tau, 1), margins=(4, 0, 4, 0))
        parts = (above, (self.table, 1), self.bar, foot, under)
        vbox(*parts, owner=self, margins=(0, 0, 0, 3), spacing=2)
        # By Enter or a double click; `doubleClicked` would open a clip a second time.
        self.table.activated.connect(lambda at: self.chosen.emit(self._model.things[at.row()].path))
        self._news = QTimer(self, singleShot=True, interval=_NEWS_MS)
        self._news.timeout.connect(self._refresh)
        queue.changed.connect(self._take_news)
        queue.finished.connect(self._refresh)
        queue.profile_changed.connect(self._refresh)
        document.opened.connect(self._mark_open)
        self._count = QTimer(self, singleShot=True, interval=_COUNT_MS)
        self._count.timeout.connect(self._count_open)
        document.opened.connect(self._count_open)
        document.intervals_changed.connect(self._count.start)
        self._refresh()

    def sizeHint(self) -> QSize:
        """With room for some rows."""
        table = self.table
        rows = _ROWS * table.verticalHeader().defaultSectionSize()
        wanted = rows + table.horizontalHeader().sizeHint().height() + 2 * table.frameWidth()
        others = super().sizeHint().height() - table.sizeHint().height()
        return QSize(super().sizeHint().width(), wanted + others)

    def _lay_out_heads(self) -> None:
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for column, width in enumerate((72, 84, 66), start=1):
            header.resizeSection(column, width)
        self.table.keep_room(_NAME_WIDTH, (_HEADS.index("Export"), _HEADS.index("Severity")))
        header.setSectionsClickable(True)
        header.sectionClicked.connect(self._sort_by)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._model.set_theme(theme)

    def _count_open(self) -> None:
        """The open clip's row follows its review."""
        data = self._document.data
        if data is not None and (intervals := self._document.intervals):
            decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
            self._queue.note(data.clip.path, (decided, len(intervals)))

    def _sort_by(self, column: int) -> None:
        """One way, the other way, then worst first again."""
        downwards = column == _HEADS.index("Severity")
        first, second = (column, downwards), (column, not downwards)
        self._order = {first: second, second: None}.get(self._order or (-1, False), first)
        header = self.table.horizontalHeader()
        header.setSortIndicatorShown(self._order is not None)
        if self._order is not None:
            order = Qt.SortOrder.DescendingOrder if self._order[1] else Qt.SortOrder.AscendingOrder
            header.setSortIndicator(self._order[0], order)
        self._refresh()

    def listed(self) -> list[QueuedClip]:
        """The clips that are listed, in their order."""
        wanted, text = STATES[self.wanted.currentText()], self.text.text().casefold()
        clips = [c for c in self._queue.ordered if wanted(c) and text in c.title.casefold()]
        if self._order is not None:
            column, downwards = self._order
            clips.sort(key=lambda c: _sorted_by(c)[column], reverse=downwards)
        return clips

    def _take_news(self) -> None:
        """At once, except of clips that are analysed: those follow fast upon each other."""
        if not self._queue.running:
            self._refresh()
        elif not self._news.isActive():
            self._news.start()

    def _refresh(self) -> None:
        clips = self.listed()
        self._model.show(clips)
        worst = max((c.severity for c in clips), default=0.0)
        if worst != self._severities.worst:
            self._severities.worst = worst
            self.table.viewport().update()
        done, total = self._queue.progress
        self.bar.setUpdatesEnabled(False)  # else every value repaints the window at once
        self.bar.setRange(0, max(total, 1))
        self.bar.setValue(done)
        self.bar.setUpdatesEnabled(True)
        self.bar.setVisible(self._queue.running)
        self.stop.setVisible(self._queue.running)
        told = self._progress() if self._queue.running else self._totals()
        self.status.setText(told)
        self.status.setToolTip(told)
        exports = len(self._queue.exports)
        listed = f"; {exports} export{'s' * (exports > 1)} not listed" if exports else ""
        told = f"τ: {self._queue.profile_told}{listed}"
        self.tau.setText(told if self._queue.folder is not None else "")
        names = "\n".join(sorted(path.name for path in self._queue.exports)[:20])
        change = "Tuning, Use τ for the folder: the τ of the open clip for all of them"
        self.tau.setToolTip(f"{change}\n\nNot listed:\n{names}" if exports else change)
        self._mark_open()

    def _progress(self) -> str:
        done, total = self._queue.progress
        return f"{done} of {total} analysed, about {self._queue.seconds_left:.0f} s left"

    def _totals(self) -> str:
        clips = self._queue.clips.values()
        through, of, decided, intervals = self._queue.totals
        decisions = f"{decided} of {intervals} intervals decided"
        told = [f"{through} of {of} clips, {decisions}"] if of else []
        counts = {
            "clean": sum(c.clean for c in clips),
            "not checked": sum(c.unchecked for c in clips),
            "failed": sum(c.state == ClipState.FAILED for c in clips),
        }
        told += [f"{count} {what}" for what, count in counts.items() if count]
        return "; ".join(told)

    def _mark_open(self) -> None:
        data = self._document.data
        at = self._model.row_of(data.clip.path) if data is not None else None
        if at is not None:
            self.table.selectRow(at)
        else:
            self.table.clearSelection()
