"""The table of a folder's clips, with their severity and the progress of their reviews."""

from __future__ import annotations

from collections.abc import Callable
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

from inspector.folder.informative_intervals import InformativeIntervals
from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import ClipState, QueuedClip, reason_text
from inspector.language import plural, tr, tr_as
from inspector.session.document import Document
from inspector.widgets.building import hbox, use_secondary_text_colour, vbox
from inspector.widgets.labels import escape_tool_tip_text
from inspector.widgets.tables import Index, RowDelegate, RowModel, RowTable, TableRow
from inspector.widgets.theme import Colours
from twistcore.review import Decision

_ROWS = 10  # number of visible rows, if there is room
_COUNT_MS = 60  # delay after which the list is updated during a drag of τ
_NEWS_MS = 160  # delay after which the list is updated during an analysis
_SEVERITY, _EXPORT = 1, 3  # columns
_HEADS = (tr("Clip"), tr("Severity"), tr_as("of a clip", "Review"), tr_as("of a clip", "Export"))
_NAME_WIDTH = 90  # pixels
_WIDTHS = (72, 84, 66)  # minimum width of the other columns, in pixels
_PAD = 8  # pixels next to a text
_BAR = 3  # height in pixels of the bar that shows a severity
_CLEAN, _PARTLY, _CUT, _UNCHECKED, _FAILED = (
    tr_as("a clip or clips", "clean"),
    tr_as("a clip or clips", "partly checked"),
    tr_as("a clip or clips", "truncated"),
    tr_as("a clip or clips", "not checked"),
    tr_as("a clip or clips", "failed"),
)
# The entries of the filter, each with a function that returns True for the clips to show.
_Lets = Callable[[QueuedClip], bool]
STATES: tuple[tuple[str, _Lets], ...] = (
    (tr_as("clips", "All"), lambda _: True),
    (tr_as("clips", "To do"), lambda c: c.to_do),
    (tr_as("clips", "Done"), lambda c: c.done),
    (tr_as("clips", "Clean"), lambda c: c.clean),
    (tr_as("clips", "Not exported"), lambda c: not c.exported and c.state != ClipState.FAILED),
    (tr_as("clips", "To restore"), lambda c: c.waits),
    (tr_as("clips", "Failed"), lambda c: c.state == ClipState.FAILED or c.unchecked),
)
_WORKING = {
    ClipState.WAITING: tr_as("a clip", "waiting"),
    ClipState.ANALYSING: tr_as("a clip", "analysing"),
}


class _ClipModel(RowModel[QueuedClip]):
    heads = _HEADS
    right = (_SEVERITY,)
    head_tips = (
        tr("Name of the clip. ↺ marks a clip with unsaved decisions that can be restored."),
        tr("Root mean square of the clip's errors over all frames. Click a heading to sort."),
        tr("Intervals decided / all intervals"),
        tr("✓: the clip was exported"),
    )

    def key(self, thing: QueuedClip) -> Path:
        return thing.path

    def describe(self, thing: QueuedClip) -> TableRow:
        colour = None
        if thing.state == ClipState.FAILED:
            colour = self.theme.rejected
        elif thing.done:
            colour = self.theme.accepted
        elif thing.state != ClipState.READY or thing.unchecked:
            colour = self.theme.soft
        name = f"↺ {thing.title}" if thing.waits else thing.title
        return TableRow(
            texts=(name, _severity(thing), _review(thing), "✓" if thing.exported else ""),
            colours=dict.fromkeys(range(len(_HEADS)), colour) if colour else {},
            tips=(_tip(thing),),
            spoken=_spoken(thing),
        )


def _sorted_by(clip: QueuedClip) -> tuple[Any, ...]:
    """Return the sort keys of a clip, one per column.

    In the review column, clips are sorted by the number of undecided intervals.
    """
    decided, of = clip.counts
    left = clip.state == ClipState.READY, of - decided, of
    return clip.title.casefold(), clip.severity, left, clip.exported


def _severity(clip: QueuedClip) -> str:
    known = clip.state == ClipState.READY and clip.severity >= 0.0 and not clip.unchecked
    return f"{clip.severity:.1f}°" if known else ""


def _review(clip: QueuedClip) -> str:
    if clip.state == ClipState.FAILED:
        return _FAILED
    if clip.counts[1] and (clip.decided or clip.state == ClipState.READY):
        return f"{clip.counts[0]} / {clip.counts[1]}"
    if clip.state == ClipState.READY:
        if clip.unchecked or clip.missing:
            return _UNCHECKED if clip.unchecked else _CUT
        return _PARTLY if clip.unexamined else _CLEAN
    return "…" if clip.state == ClipState.ANALYSING else ""


def _tip(clip: QueuedClip) -> str:
    name = clip.label or clip.path.name
    if clip.state == ClipState.FAILED:
        return reason_text(clip)
    if clip.unchecked:
        return tr("{name} could not be checked: {reason}", name=name, reason=reason_text(clip))
    if clip.state != ClipState.READY:
        return f"{name}: {_WORKING[clip.state]}"
    found = tr("{n} intervals, severity {severity:.1f}°", n=clip.intervals, severity=clip.severity)
    lines = [f"{name}: {found}"]
    if clip.missing:
        lines.append(
            plural(
                "{n} frame is missing at the end of the file",
                "{n} frames are missing at the end of the file",
                clip.missing,
            )
        )
    if clip.unexamined:
        lines.append(
            plural(
                "{n} arm or leg was not examined: open the clip to see why",
                "{n} arms and legs were not examined: open the clip to see why",
                clip.unexamined,
            )
        )
    if clip.waits:
        lines.append(tr("the last review was not saved: open the clip to restore its decisions"))
    if clip.exported:
        lines.append(tr("exported as {name}", name=clip.exported))
    return "\n".join(lines)


def _spoken(clip: QueuedClip) -> dict[int, str]:
    """Return the screen-reader text of each cell with a symbol or a bar, keyed by column."""
    words = {}
    if clip.waits:
        words[0] = tr("{name}: unsaved decisions can be restored", name=clip.title)
    if clip.state == ClipState.READY:
        words[_SEVERITY] = tr("severity {severity:.1f}°", severity=max(clip.severity, 0.0))
    if clip.exported:
        words[_EXPORT] = tr("exported as {name}", name=clip.exported)
    return words


class _SeverityBar(RowDelegate):
    """Draws a bar below the severity of each clip.

    The length of the bar is proportional to the square root of the severity.
    """

    def __init__(self, model: _ClipModel, parent: QWidget) -> None:
        super().__init__(model, parent)
        self._clips = model
        self.worst = 0.0

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        super().paint(painter, option, index)
        severity = self._clips.things[index.row()].severity
        if severity <= 0.0 or self.worst <= 0.0:
            return
        room = QRectF(option.rect).adjusted(4, 0, -6, 0)
        room.setTop(room.bottom() - _BAR)
        room.setWidth(max(2.0, room.width() * (severity / self.worst) ** 0.5))
        painter.fillRect(room, QColor(self._clips.theme.before))

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(70, super().sizeHint(option, index).height())


class ClipsPanel(QWidget):
    """The table of the folder's clips. A double click or Enter opens a clip."""

    chosen = Signal(object)  # with the Path of the clip

    def __init__(
        self,
        queue: FolderQueue,
        document: Document,
        colours: Colours,
        informative: InformativeIntervals,
    ) -> None:
        super().__init__()
        self._queue, self._document, self._informative = queue, document, informative
        self._model = _ClipModel(colours)
        # (column, True if descending); None for the initial order, worst first
        self._order: tuple[int, bool] | None = None
        self.table = RowTable(self._model, room=2)
        self.table.setAccessibleName(tr("Clips in the folder"))
        self.table.setAccessibleDescription(tr("Press Enter to open the clip"))
        self.table.setItemDelegate(RowDelegate(self._model, self.table))
        self._severities = _SeverityBar(self._model, self.table)
        self.table.setItemDelegateForColumn(_SEVERITY, self._severities)
        self._lay_out_heads()
        self.text = QLineEdit(placeholderText=tr("Filter by name"), clearButtonEnabled=True)
        self.text.setAccessibleName(tr("Filter by name"))
        self.wanted = QComboBox()
        self.wanted.addItems([words for words, _ in STATES])
        self.wanted.setAccessibleName(tr("Listed clips"))
        self.text.textChanged.connect(self._refresh)
        self.wanted.currentTextChanged.connect(self._refresh)
        self.bar = QProgressBar(textVisible=False)
        self.bar.setAccessibleName(tr("Clips analysed"))
        self.bar.setMaximumHeight(6)
        self.status, self.tau, self.precision = (
            use_secondary_text_colour(QLabel()),
            use_secondary_text_colour(QLabel()),
            use_secondary_text_colour(QLabel()),
        )
        # A long text must not make the dock wider
        for label in (self.status, self.tau, self.precision):
            label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
            label.setWordWrap(True)
        self.stop = QPushButton(tr("Stop"))
        self.stop.setToolTip(tr("Stop analysing; the results so far are kept"))
        self.stop.clicked.connect(queue.cancel)
        above = hbox((self.text, 1), self.wanted, margins=(4, 2, 4, 0))
        foot = hbox((self.status, 1), self.stop, margins=(4, 0, 4, 0))
        under = hbox((self.tau, 1), margins=(4, 0, 4, 0))
        last = hbox((self.precision, 1), margins=(4, 0, 4, 0))
        parts = (above, (self.table, 1), self.bar, foot, under, last)
        vbox(*parts, owner=self, margins=(0, 0, 0, 3), spacing=2)
        # Emitted by Enter and by a double click; with `doubleClicked` as well, a clip would open
        # twice.
        self.table.activated.connect(lambda at: self.chosen.emit(self._model.things[at.row()].path))
        self._news = QTimer(self, singleShot=True, interval=_NEWS_MS)
        self._news.timeout.connect(self._refresh)
        queue.changed.connect(self._take_news)
        queue.finished.connect(self._refresh)
        queue.profile_changed.connect(self._refresh)
        informative.changed.connect(self._show_precision)
        document.opened.connect(self._mark_open)
        self._count = QTimer(self, singleShot=True, interval=_COUNT_MS)
        self._count.timeout.connect(self._count_open)
        document.opened.connect(self._count_open)
        document.intervals_changed.connect(self._count.start)
        self._refresh()
        self._show_precision()

    def sizeHint(self) -> QSize:
        """Return a size at which a few rows of the table are visible."""
        table = self.table
        rows = _ROWS * table.verticalHeader().defaultSectionSize()
        height = rows + table.horizontalHeader().sizeHint().height() + 2 * table.frameWidth()
        others = super().sizeHint().height() - table.sizeHint().height()
        return QSize(super().sizeHint().width(), height + others)

    def _lay_out_heads(self) -> None:
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        advance = self.fontMetrics().horizontalAdvance
        words = (_HEADS[1],), (_HEADS[2], _CLEAN, _PARTLY, _CUT, _UNCHECKED, _FAILED), (_HEADS[3],)
        for column, (least, texts) in enumerate(zip(_WIDTHS, words, strict=True), start=1):
            header.resizeSection(column, max(least, *(advance(text) + _PAD for text in texts)))
        self.table.keep_room(_NAME_WIDTH, (_EXPORT, _SEVERITY))
        header.setSectionsClickable(True)
        header.sectionClicked.connect(self._sort_by)

    def _count_open(self) -> None:
        """Update the number of decided intervals of the open clip."""
        data = self._document.data
        if data is not None and (intervals := self._document.intervals):
            decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
            self._queue.note(data.clip.path, (decided, len(intervals)))

    def _sort_by(self, column: int) -> None:
        """Sort by a column after a click on its heading.

        A second click reverses the order. A third click restores the initial order, in which the
        worst clip is first.
        """
        downwards = column == _SEVERITY
        first, second = (column, downwards), (column, not downwards)
        self._order = {first: second, second: None}.get(self._order or (-1, False), first)
        header = self.table.horizontalHeader()
        header.setSortIndicatorShown(self._order is not None)
        if self._order is not None:
            order = Qt.SortOrder.DescendingOrder if self._order[1] else Qt.SortOrder.AscendingOrder
            header.setSortIndicator(self._order[0], order)
        self._refresh()

    def listed(self) -> list[QueuedClip]:
        """Return the listed clips in the order of the table."""
        (_, passes), text = STATES[self.wanted.currentIndex()], self.text.text().casefold()
        clips = [c for c in self._queue.ordered if passes(c) and text in c.title.casefold()]
        if self._order is not None:
            column, downwards = self._order
            clips.sort(key=lambda c: _sorted_by(c)[column], reverse=downwards)
        return clips

    def _take_news(self) -> None:
        """Update the table. While clips are being analysed, wait a moment to collect changes."""
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
        self.bar.setUpdatesEnabled(False)  # without this, each value would repaint the window
        self.bar.setRange(0, max(total, 1))
        self.bar.setValue(done)
        self.bar.setUpdatesEnabled(True)
        self.bar.setVisible(self._queue.running)
        self.stop.setVisible(self._queue.running)
        text = self._progress() if self._queue.running else self._totals()
        self.status.setText(text)
        self.status.setToolTip(escape_tool_tip_text(text))
        exports = len(self._queue.exports)
        left = plural("{n} export not listed", "{n} exports not listed", exports)
        text = f"τ: {self._queue.profile_text}" + (f"; {left}" if exports else "")
        self.tau.setText(text if self._queue.folder is not None else "")
        names = "\n".join(sorted(path.name for path in self._queue.exports)[:20])
        change = tr("Choose Tuning → Use τ for the folder to use the open clip's τ for all clips.")
        left = tr("Exports that are not listed:")
        self.tau.setToolTip(
            escape_tool_tip_text(f"{change}\n\n{left}\n{names}") if exports else change
        )
        self._mark_open()

    def _progress(self) -> str:
        done, total = self._queue.progress
        return tr(
            "{done} of {total} analysed, about {left:.0f} s left",
            done=done,
            total=total,
            left=self._queue.seconds_left,
        )

    def _totals(self) -> str:
        clips = self._queue.clips.values()
        through, of, decided, intervals = self._queue.totals
        parts = []
        if of:
            words = tr(
                "{through} of {of} clips done, {decided} of {intervals} intervals decided",
                through=through,
                of=of,
                decided=decided,
                intervals=intervals,
            )
            parts.append(words)
        counts = (
            (sum(c.clean for c in clips), _CLEAN),
            (sum(bool(c.unexamined) and not c.unchecked for c in clips), _PARTLY),
            (sum(bool(c.missing) for c in clips), _CUT),
            (sum(c.unchecked for c in clips), _UNCHECKED),
            (sum(c.state == ClipState.FAILED for c in clips), _FAILED),
        )
        parts += [f"{count} {what}" for count, what in counts if count]
        return "; ".join(parts)

    def _show_precision(self) -> None:
        text = self._informative.words()
        self.precision.setText(text)
        self.precision.setVisible(bool(text))

    def _mark_open(self) -> None:
        data = self._document.data
        at = self._model.row_of(data.clip.path) if data is not None else None
        if at is not None:
            self.table.selectRow(at)
        else:
            self.table.clearSelection()
