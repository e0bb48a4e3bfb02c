"""The table of intervals: sorted, filtered, judged."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import (
    QItemSelectionModel,
    QModelIndex,
    QSortFilterProxyModel,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QComboBox, QHeaderView, QStackedWidget, QWidget

from inspector.session.document import Document
from inspector.widgets.building import RIGHT, hbox, hint, soft, vbox
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.tables import SORT_ROLE, Index, Row, RowDelegate, RowModel, RowTable
from inspector.widgets.theme import Theme
from twistcore.detection import Kind
from twistcore.review import Decision, Judged
from twistcore.review.model import APPLIED, overlapping

_HEADS = ("Chain", "Kind", "Decision", "Start", "Stop", "Frames", "δ", "Time", "Conf.", "Note")
_SAMPLES = (
    "Right Shoulder",
    "twist",
    "✓ accepted +",
    "00000",
    "00000",
    "Frames",
    "−180.0°",
    "000.00 s",
    "Conf.",
)
_SPARED = ("Conf.", "Frames", "Time", "Kind")  # left out in this order where room is short
_NOTE_WIDTH = 60
MARKS = {
    Decision.UNDECIDED: "· undecided",
    Decision.ACCEPTED: "✓ accepted",
    Decision.REJECTED: "✗ rejected",
}
KINDS = {  # in the table, and as filters
    Kind.COUNTER_TWIST: ("twist", "Counter-twists"),
    Kind.LIMB_FLIP: ("flip", "Limb flips"),
    Kind.LONE_JUMP: ("jump", "Lone jumps"),
}
_OF_KIND = {name: kind for kind, (_, name) in KINDS.items()}
FILTERS = ("All", "Undecided", "Accepted", "Rejected", "This chain", *_OF_KIND)


class _IntervalModel(RowModel[tuple[Judged, bool]]):
    """Things are pairs: an interval of the review, and whether it shares frames with another."""

    heads = _HEADS
    right = range(3, 9)

    def __init__(self, document: Document, theme: Theme) -> None:
        super().__init__(theme)
        self._document = document

    def key(self, thing: tuple[Judged, bool]) -> int:
        return thing[0].id

    def describe(self, thing: tuple[Judged, bool]) -> Row:
        judged, shared = thing
        interval, document = judged.interval, self._document
        assert document.data is not None
        delta, first = float(np.degrees(interval.shown)), document.first_frame
        seconds = interval.start * document.data.motion.frame_time
        seen = (interval.kind, judged.decision) == (Kind.LONE_JUMP, Decision.ACCEPTED)
        decision = "✓ seen" if seen else MARKS[judged.decision]
        if judged.verdict == APPLIED:
            decision = "✓ automatic"
        decision += (" +" if shared else "") + ("" if judged.supported else " (below τ)")
        confidence = -1.0 if interval.confidence is None else interval.confidence
        cells: tuple[tuple[str, object], ...] = (  # what is shown, and what it is sorted by
            (document.find_chain(interval.chain).list_label, interval.chain),
            (KINDS[interval.kind][0], interval.kind.value),
            (decision, judged.decision.value),
            (str(interval.start + first), interval.start),
            (str(interval.stop + first), interval.stop),
            (str(interval.frames), interval.frames),
            (f"{delta:+.1f}°".replace("-", "−"), abs(delta)),
            (f"{seconds:.2f} s", interval.start),
            ("–" if interval.confidence is None else f"{confidence:.2f}", confidence),
            (judged.note, judged.note),
        )
        return Row(
            texts=tuple(text for text, _ in cells),
            sort=tuple(value for _, value in cells),
            colours={_HEADS.index("Decision"): getattr(self.theme, str(judged.decision))},
            tips=(_tip(judged, shared),),
        )


def _tip(judged: Judged, shared: bool) -> str:
    interval = judged.interval
    parts = [f"{interval.chain}, {interval.kind}, {interval.frames} frames"]
    if interval.kind == Kind.LONE_JUMP:
        parts.append(f"{interval.joint} jumps about its own axis; nothing is taken out")
    elif abs(interval.residual) > 1e-9:
        parts.append(f"left over behind the last edge: {np.degrees(interval.residual):+.2f}°")
    if shared:
        parts.append("overlaps another interval of its chain: their offsets add")
    if judged.reason:
        parts.append(f"reason: {judged.reason}")
    if judged.edited:
        parts.append("edited by hand")
    if judged.by_hand:
        parts.append("made by hand")
    if not judged.supported:
        parts.append("the detector no longer finds it at this τ")
    if judged.verdict == APPLIED:
        parts.append("applied automatically: no person looked at it")
    if judged.reviewer or judged.decided_at:
        parts.append(f"decided {judged.decided_at} {judged.reviewer}".strip())
    return "\n".join(parts)


class _Filter(QSortFilterProxyModel):
    def __init__(self, model: _IntervalModel, document: Document) -> None:
        super().__init__()
        self._model, self._document = model, document
        self.chosen = FILTERS[0]
        self.setSortRole(SORT_ROLE)
        self.setSourceModel(model)

    def filterAcceptsRow(self, row: int, parent: Index) -> bool:
        del parent
        judged, _ = self._model.things[row]
        return judged.id == self._document.interval_id or self.passes(judged)

    @property
    def narrow(self) -> bool:
        """Whether it may keep something back."""
        return self.chosen != FILTERS[0] or bool(self._document.hidden)

    def passes(self, judged: Judged) -> bool:
        """Whether an interval is listed that is not selected: what one works on always is."""
        if judged.interval.chain in self._document.hidden:
            return False
        if self.chosen == "This chain":
            return judged.interval.chain == self._document.chain
        if self.chosen in _OF_KIND:
            return judged.interval.kind == _OF_KIND[self.chosen]
        return self.chosen in ("All", judged.decision.value.capitalize())


class IntervalsPanel(QWidget):
    """Table of intervals with a filter; its current row is the document's interval."""

    activated = Signal()  # a double click: look at it

    def __init__(self, document: Document, theme: Theme) -> None:
        super().__init__()
        self._document = document
        self._refreshing = self._clicked = False
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._filter_anew)
        self._model = _IntervalModel(document, theme)
        self._proxy = _Filter(self._model, document)
        self.table = self._make_table()
        self.filter = QComboBox()
        self.filter.addItems(FILTERS)
        self.filter.setToolTip("Which intervals are listed")
        self.filter.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.filter.currentTextChanged.connect(self._filter_changed)
        self.count = soft(SteadyLabel(alignment=RIGHT))
        self._hint = hint()
        self._stack = QStackedWidget()
        self._stack.addWidget(self._hint)
        self._stack.addWidget(self.table)
        top = hbox(self.filter, None, self.count)
        vbox(top, (self._stack, 1), owner=self, margins=(4, 4, 4, 4))
        document.opened.connect(self._refresh)
        document.intervals_changed.connect(self._refresh)
        document.numbering_changed.connect(self._model.redraw)
        document.hidden_changed.connect(self._filter_anew)
        document.interval_changed.connect(self._interval_changed)
        document.chain_changed.connect(self._chain_changed)
        self._refresh()

    def _make_table(self) -> RowTable:
        table = RowTable(self._proxy, several=True)
        table.setItemDelegate(RowDelegate(self._model, table, self._proxy))
        table.setSortingEnabled(True)
        table.sortByColumn(-1, Qt.SortOrder.AscendingOrder)
        header = table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        header.setMinimumSectionSize(28)
        header.setStretchLastSection(True)
        metrics = self.fontMetrics()
        for column, sample in enumerate(_SAMPLES):
            table.setColumnWidth(column, metrics.horizontalAdvance(sample) + 14)
        table.setColumnWidth(len(_SAMPLES), _NOTE_WIDTH)  # at least: it takes what is left
        table.selectionModel().currentRowChanged.connect(self._row_selected)
        table.doubleClicked.connect(self.activated)
        return table

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Where room is short, what other columns tell as well is not shown."""
        super().resizeEvent(event)
        self._fit_columns()

    def _fit_columns(self) -> None:
        intervals = [j.interval for j in self._document.intervals]
        said = {
            "Conf.": any(i.confidence is not None for i in intervals),
            "Kind": any(i.kind != Kind.COUNTER_TWIST for i in intervals),
        }
        table, metrics = self.table, self.fontMetrics()
        widths = {
            head: metrics.horizontalAdvance(sample) + 14
            for head, sample in zip(_HEADS, _SAMPLES, strict=False)
            if said.get(head, True)
        }
        needed = sum(widths.values()) + _NOTE_WIDTH
        room = self.width() - table.verticalScrollBar().sizeHint().width() - 12
        for head in _SPARED:
            hide = head not in widths or needed > room
            table.setColumnHidden(_HEADS.index(head), hide)
            if hide:
                needed -= widths.get(head, 0)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._model.set_theme(theme)

    def order_by(self, order: str) -> None:
        """List by 'time' or by 'chain'; a click on a head lists otherwise."""
        column = _HEADS.index("Start") if order == "time" else -1
        self.table.sortByColumn(column, Qt.SortOrder.AscendingOrder)

    def selected_ids(self) -> tuple[int, ...]:
        """Ids of the selected rows, top to bottom."""
        rows = sorted(i.row() for i in self.table.selectionModel().selectedRows())
        return tuple(self._judged(row).id for row in rows)

    def shown_ids(self) -> tuple[int, ...]:
        """Ids of the rows that are listed, top to bottom."""
        return tuple(self._judged(row).id for row in range(self._proxy.rowCount()))

    def _judged(self, proxy_row: int) -> Judged:
        source = self._proxy.mapToSource(self._proxy.index(proxy_row, 0))
        return self._model.things[source.row()][0]

    def _refresh(self) -> None:
        intervals = self._document.intervals
        shared = overlapping(intervals)
        self._refreshing = True  # rows that vanish must not select others
        self._model.show([(j, j.id in shared) for j in intervals])
        self.table.doItemsLayout()  # now: put off, it would repaint the panel twice
        self._refreshing = False
        decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
        self._fit_columns()
        self.count.setText(f"{decided} of {len(intervals)} decided" if intervals else "")
        if not self._document.data:
            self._hint.setText("Open a BVH: its suspicious intervals are listed here.")
        elif not self._document.data.chains:
            self._hint.setText("No chain in this skeleton, so nothing to find.")
        elif not intervals:
            self._hint.setText("Nothing found at this τ.\nLower the τ line to look closer.")
        else:
            self._hint.setText("No interval passes this filter.")
        self._stack.setCurrentIndex(1 if self._proxy.rowCount() else 0)
        self._select_row()

    def _filter_changed(self, text: str) -> None:
        self._proxy.chosen = text
        if (judged := self._document.interval) and not self._proxy.passes(judged):
            self._document.select_interval(None)  # A and R never judge what is not asked for
        self._filter_anew()

    def _chain_changed(self) -> None:
        if self._proxy.chosen == "This chain":
            self._filter_anew()

    def _filter_anew(self) -> None:
        self._refreshing = True
        self._proxy.invalidate()
        self._refresh()

    def _interval_changed(self) -> None:
        """Under a filter the selected row is listed, and the last one no longer for being that."""
        if not self._proxy.narrow:
            self._select_row()
        elif self._clicked:
            self._later.start()  # no row goes while the table still deals with the click
        else:
            self._filter_anew()

    def _select_row(self) -> None:
        at = self._model.row_of(self._document.interval_id)
        index = self._proxy.mapFromSource(self._model.index(-1 if at is None else at, 0))
        if not index.isValid():
            self.table.clearSelection()
            return
        selection = self.table.selectionModel()
        if self.table.currentIndex().row() != index.row() or not selection.hasSelection():
            rows = QItemSelectionModel.SelectionFlag.Rows
            once = QItemSelectionModel.SelectionFlag.ClearAndSelect
            selection.setCurrentIndex(index, once | rows)
        self.table.scrollTo(index)

    def _row_selected(self, current: QModelIndex) -> None:
        if current.isValid() and not self._refreshing:
            self._clicked = True
            self._document.select_interval(self._judged(current.row()).id, jump=True)
            self._clicked = False
