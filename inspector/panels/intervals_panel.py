"""The table of intervals, which can be sorted and filtered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from PySide6.QtCore import QItemSelectionModel, QModelIndex, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QStackedWidget, QWidget

from inspector.language import of_core, tr, tr_as
from inspector.panels.interval_columns import COLUMNS, PLACE, IntervalColumns
from inspector.panels.interval_filter import (
    OF_CHAIN,
    FilteredRows,
    FilterLine,
    IntervalFilter,
    short_word,
)
from inspector.panels.reject_reasons import shown_reason
from inspector.panels.rig_names import joints_of
from inspector.session.document import Document
from inspector.session.examined import reason_unexamined, unexamined_sentences
from inspector.session.settings import Settings
from inspector.widgets.building import RIGHT, hbox, hint, soft, vbox
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.signed_numbers import angle_of, plain, signed
from inspector.widgets.tables import RowDelegate, RowModel, RowTable, TableRow
from inspector.widgets.theme import Colours
from twistcore.detection import Kind
from twistcore.review import Decision, Judged
from twistcore.review.model import APPLIED, overlapping_ids
from twistcore.skeleton.helper import Helper

_ROOM, _ROOM_LOW = 8, 3  # pixels of a row in addition to its text
_NOTED = 500  # letters of a note that its cell shows
_WITH_COUNT = 430  # pixels: in a narrower list only the status bar shows the count
MARKS = {
    Decision.UNDECIDED: tr("· undecided"),
    Decision.ACCEPTED: tr("✓ accepted"),
    Decision.REJECTED: tr("✗ rejected"),
}
_KEPT, _TURNED = tr_as("the limb's end is", "kept"), tr_as("the limb's end is", "turned")
_SHARED, _UNSUPPORTED, _EDITED = " +", " <τ", " ✎"
_EVERYTHING = IntervalFilter()


class _IntervalModel(RowModel[tuple[Judged, bool]]):
    """The rows of the table, each a pair: an interval, and whether it overlaps another one."""

    heads = tuple(column.head for column in COLUMNS)
    head_tips = tuple(column.tip or column.name for column in COLUMNS)
    right = tuple(k for k, column in enumerate(COLUMNS) if column.figures)
    middle = (PLACE["chain"],)

    def __init__(self, document: Document, colours: Colours) -> None:
        super().__init__(colours)
        self._document = document

    def key(self, thing: tuple[Judged, bool]) -> int:
        return thing[0].id

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        """Return a heading, or the number of an interval, which stays the same in any order."""
        if orientation == Qt.Orientation.Vertical and role == Qt.ItemDataRole.DisplayRole:
            return str(self.key(self.things[section]))
        return super().headerData(section, orientation, role)

    def describe(self, thing: tuple[Judged, bool]) -> TableRow:
        judged, shared = thing
        document = self._document
        interval, own = document.displayed(judged).interval, judged.interval.confidence
        assert document.data is not None
        delta, first = float(np.degrees(interval.shown)), document.first_frame
        seconds = interval.start * document.data.motion.frame_time
        seen = not interval.repairable and judged.decision == Decision.ACCEPTED
        decision = tr("✓ seen") if seen else MARKS[judged.decision]
        if judged.verdict == APPLIED:
            decision = tr("✓ automatic")
        decision += (_SHARED if shared else "") + ("" if judged.supported else _UNSUPPORTED)
        decision += _EDITED if judged.edited else ""
        sure = -1.0 if interval.confidence is None else interval.confidence
        chain = document.find_chain(interval.chain)
        joints = joints_of(chain, document.data.motion.skeleton)
        end = _end(judged)
        label = of_core(chain.label if isinstance(chain, Helper) else chain.list_label)
        note = " · ".join(filter(None, (shown_reason(judged.reason), judged.note)))[:_NOTED]
        cells: dict[str, tuple[str, object]] = {  # the text, and the value to sort by
            "chain": (label, interval.chain),
            "decision": (decision, judged.decision.value),
            "start": (str(interval.start + first), interval.start),
            "stop": (str(interval.stop + first), interval.stop),
            "frames": (str(interval.frames), interval.frames),
            "time": (f"{seconds:.2f} s", interval.start),
            "delta": (angle_of(interval.kind, interval.shown), abs(delta)),
            "confidence": ("–" if interval.confidence is None else f"{sure:.2f}", sure),
            "end": (end, end),
            "kind": (short_word(interval.kind), interval.kind.value),
            "joints": (joints, joints),
            "note": (note, note),
        }
        return TableRow(
            texts=tuple(cells[column.id][0] for column in COLUMNS),
            sort=tuple(cells[column.id][1] for column in COLUMNS),
            colours={
                PLACE["decision"]: getattr(self.theme, str(judged.decision)),
                PLACE["joints"]: self.theme.soft,
                PLACE["kind"]: getattr(self.theme, interval.kind.info.colour, self.theme.text),
            },
            tips=(_tip(document.displayed(judged), shared, f"{label} ({joints})", own),),
            spoken={PLACE["decision"]: decision.partition(" ")[2]},
        )


def _end(judged: Judged) -> str:
    """Return whether the foot or hand of a flip is kept or turned, or '' for other kinds."""
    if judged.interval.kind != Kind.LIMB_FLIP:
        return ""
    return _TURNED if judged.interval.carried else _KEPT


def _tip(judged: Judged, shared: bool, chain: str, own: float | None) -> str:
    interval = judged.interval
    kind, joint = of_core(interval.kind), interval.joint
    parts = [tr("{chain}, {kind}, {n} frames", chain=chain, kind=kind, n=interval.frames)]
    if tip := interval.kind.info.tip:
        size = f"{plain(np.degrees(interval.residual))}°"
        parts.append(of_core(tip.format(joint=joint, size=size)))
    elif not interval.kind.known:
        parts.append(tr("found by a newer version of the program; not corrected"))
    elif abs(interval.residual) > 1e-9:
        left = signed(np.degrees(interval.residual), 2)
        parts.append(tr("{angle}° remain after the end", angle=left))
    if own != interval.confidence and own is not None and not judged.edited:
        line = tr(
            "confidence as learned from your decisions (the detector's own is {own:.2f})", own=own
        )
        parts.append(line)
    if shared:
        parts.append(tr("overlaps another interval of its chain; their offsets are added"))
    if judged.reason:
        parts.append(tr("reason: {reason}", reason=shown_reason(judged.reason)))
    if judged.edited:
        parts.append(tr("edited by hand"))
    if judged.by_hand:
        parts.append(tr("made by hand"))
    if not judged.supported:
        parts.append(tr("no longer found at this τ"))
    if judged.verdict == APPLIED:
        parts.append(tr("corrected automatically; not yet reviewed by anyone"))
    if judged.reviewer or judged.decided_at:
        by, at = judged.reviewer, judged.decided_at
        parts.append(tr("decided {at} {reviewer}", at=at, reviewer=by).strip())
    return "\n".join(parts)


class IntervalsPanel(QWidget):
    """The interval table with its filter; the current row is the document's selected interval."""

    activated = Signal()  # a double click on a row
    selected = Signal(int)  # the number of selected rows

    def __init__(
        self, document: Document, colours: Colours, settings: Settings | None = None
    ) -> None:
        """Build the panel. settings: store which columns are shown and how rows are sorted."""
        super().__init__()
        self._document = document
        self._refreshing = self._clicked = False
        self._with_text = {"chain", "decision", "start", "stop", "frames", "time", "delta"}
        self._marks: set[str] = set()
        self._names: dict[str, tuple[str, str]] = {}  # by chain
        self._measured: dict[int, Judged] = {}  # intervals that the columns fit already, by id()
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._filter_again)
        self._model = _IntervalModel(document, colours)
        self._proxy = FilteredRows(self._model, self._is_listed)
        self.table = RowTable(self._proxy, several=True)
        self.table.setAccessibleName(tr("Intervals"))
        self.table.show_numbers()
        self.table.setItemDelegate(RowDelegate(self._model, self.table, self._proxy))
        self.table.selectionModel().currentRowChanged.connect(self._row_selected)
        self.table.selectionModel().selectionChanged.connect(self._count_selected)
        self.table.doubleClicked.connect(self.activated)
        self.columns = IntervalColumns(self.table, settings or Settings())
        self.filters = FilterLine()
        self.filter, self.search = self.filters.choice, self.filters.search
        self.filters.changed.connect(self._filter_changed)
        self.filters.left.connect(self.table.setFocus)
        self.count = soft(SteadyLabel(alignment=RIGHT))
        self._hint = hint()
        self._stack = QStackedWidget()
        self._stack.addWidget(self._hint)
        self._stack.addWidget(self.table)
        top = hbox((self.filters, 1), self.count)
        vbox(top, (self._stack, 1), owner=self)
        self.set_low(False)
        document.opened.connect(self._take_clip)
        document.intervals_changed.connect(self._refresh)
        document.chains_changed.connect(self._forget_names)
        document.numbering_changed.connect(self._model.redraw)
        document.order_changed.connect(self._refresh)
        for other in (self._model.redraw, self._filter_again):
            document.confidence_changed.connect(other)
        document.hidden_changed.connect(self._filter_again)
        document.interval_changed.connect(self._interval_changed)
        document.chain_changed.connect(self._chain_changed)
        self._refresh()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Hide the number of intervals in a narrow window."""
        super().resizeEvent(event)
        self.count.setVisible(self.width() >= _WITH_COUNT)

    def set_low(self, low: bool) -> None:
        """Switch to the layout for low windows, with rows close together."""
        layout = self.layout()
        assert layout is not None
        layout.setContentsMargins(*((4, 2, 4, 0) if low else (4, 4, 4, 4)))
        layout.setSpacing(3 if low else -1)  # -1: as the style has it
        self.table.set_room(_ROOM_LOW if low else _ROOM)

    def search_here(self) -> None:
        """Move the keyboard focus to the search line."""
        self.search.setFocus()
        self.search.selectAll()

    def list_all(self) -> Callable[[], None]:
        """Clear the filter; return a function that restores it."""
        return self.filters.list_all()

    def _forget_names(self) -> None:
        self._names.clear()
        self._measured.clear()

    def _take_clip(self) -> None:
        self._forget_names()
        self._marks.clear()
        self._with_text -= {"confidence", "kind", "end", "note"}
        self._refresh()

    def _fit_columns(self, shared: bool) -> None:
        """Fit the columns to the texts of new intervals; as long as a clip
        is open, they never shrink.
        """
        document = self._document
        if (data := document.data) is None or not document.intervals:
            return
        known = self._measured
        fresh = [j for j in document.intervals if id(j) not in known]  # must be quick: drags of τ
        self._measured = {id(j): j for j in document.intervals}
        if shared:
            self._marks.add(_SHARED)
        if not all(j.supported for j in fresh):
            self._marks.add(_UNSUPPORTED)
        if any(j.edited for j in fresh):
            self._marks.add(_EDITED)
        for name, has_text in (
            ("confidence", lambda j: j.interval.confidence is not None),
            ("kind", lambda j: j.interval.kind != Kind.COUNTER_TWIST),
            ("end", lambda j: j.interval.kind == Kind.LIMB_FLIP),
            ("note", lambda j: j.note or j.reason),
        ):
            if name not in self._with_text and any(map(has_text, fresh)):
                self._with_text.add(name)
        for name in {j.interval.chain for j in fresh}:
            self._name(name)
        advance = self.fontMetrics().horizontalAdvance
        labels, joints = zip(*self._names.values(), strict=True)
        last = str(document.frames + document.first_frame)
        kinds = {*Kind, *(j.interval.kind for j in document.intervals)}
        widest = max(MARKS.values(), key=advance)
        marks = "".join(m for m in (_SHARED, _UNSUPPORTED, _EDITED) if m in self._marks)
        self.columns.take(
            {
                "chain": max(labels, key=advance),
                "decision": widest + marks,
                "start": last,
                "stop": last,
                "frames": last,
                "time": f"{document.frames * data.motion.frame_time:.2f} s",
                "delta": "−180.0°",
                "confidence": "0.00",
                "end": max(_KEPT, _TURNED, key=advance),
                "kind": max(map(short_word, kinds), key=advance),
                "joints": max(joints, key=advance),
            },
            self._with_text,
        )

    def _is_listed(self, judged: Judged) -> bool:
        """True for the selected interval and for all intervals that pass the filter."""
        return judged.id == self._document.interval_id or self._passes(judged)

    def _passes(self, judged: Judged) -> bool:
        document = self._document
        return judged.interval.chain not in document.hidden and self.filters.current.admits(
            document.displayed(judged), document.chain, self._search_text
        )

    def _name(self, chain: str) -> tuple[str, str]:
        """Return the label of a chain and the names of its joints in the file."""
        if chain not in self._names and (data := self._document.data) is not None:
            found = self._document.find_chain(chain)
            label = of_core(found.list_label)
            self._names[chain] = label, joints_of(found, data.motion.skeleton)
        return self._names[chain]

    def _search_text(self, judged: Judged) -> str:
        """Return the text of an interval for the search, in the chosen language and in English."""
        name = judged.interval.chain
        label, joints = self._name(name)
        kind = short_word(judged.interval.kind)
        verdict, reason = judged.verdict, judged.reason
        parts = label, name, joints, kind, verdict, of_core(verdict), judged.decision.value
        words = of_core(judged.decision), _end(judged), reason, shown_reason(reason), judged.note
        return " ".join((*parts, *words))

    def order_by(self, order: str) -> None:
        """Sort by 'time', or list the worst or the chains first; clicks on headings change this."""
        column = PLACE["start"] if order == "time" else -1
        self.table.sortByColumn(column, Qt.SortOrder.AscendingOrder)

    def selected_ids(self) -> tuple[int, ...]:
        """Return the ids of the selected rows from top to bottom."""
        rows = sorted(i.row() for i in self.table.selectionModel().selectedRows())
        return tuple(self._judged(row).id for row in rows)

    def context_menu(self, actions: Sequence[QAction]) -> None:
        """Offer these actions in the menu of a right click on a row."""
        self.table.addActions(list(actions))
        self.table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def shown_ids(self) -> tuple[int, ...]:
        """Return the ids of the listed rows from top to bottom."""
        return tuple(self._judged(row).id for row in range(self._proxy.rowCount()))

    def _judged(self, proxy_row: int) -> Judged:
        source = self._proxy.mapToSource(self._proxy.index(proxy_row, 0))
        return self._model.things[source.row()][0]

    def _refresh(self) -> None:
        intervals = self._document.intervals
        shared = overlapping_ids(intervals)
        self._refreshing = True  # a row that vanishes must not select another
        if self._document.order == "worst":
            intervals = tuple(sorted(intervals, key=self._document.severity, reverse=True))
        self._model.show([(j, j.id in shared) for j in intervals])
        self.table.doItemsLayout()  # now: a later layout would repaint the panel twice
        self._refreshing = False
        self._fit_columns(bool(shared))
        self.count.setText(self._count_text())
        if not self._document.data:
            text = tr("Open a clip to list its suspicious intervals here.")
        elif not intervals and (blind := reason_unexamined(self._document.data)):
            text = blind
        elif not intervals:
            text = tr(
                "Nothing found at this threshold τ.\nLower the τ line to find smaller errors."
            )
            text = "\n".join((text, *unexamined_sentences(self._document.data)))
        else:
            text = tr("No interval matches this filter.")
        self._hint.setText(text)
        self._stack.setCurrentIndex(1 if self._proxy.rowCount() else 0)
        self._select_row()

    def _count_text(self) -> str:
        intervals, listed = self._document.intervals, self._proxy.rowCount()
        if not intervals:
            return ""
        if listed < len(intervals):
            return tr("{listed} of {total} listed", listed=listed, total=len(intervals))
        decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
        return tr("{done} of {total} decided", done=decided, total=len(intervals))

    def _filter_changed(self) -> None:
        if (judged := self._document.interval) and not self._passes(judged):
            self._document.select_interval(None)  # A and R must not judge a hidden interval
        self._filter_again()

    def _chain_changed(self) -> None:
        if self.filters.current.chosen == OF_CHAIN:
            self._filter_again()

    def _filter_again(self) -> None:
        self._refreshing = True
        self._proxy.invalidate()
        self._refresh()

    @property
    def _is_filtered(self) -> bool:
        """True if intervals may be missing from the table because of the
        filter or a hidden chain.
        """
        return self.filters.current != _EVERYTHING or bool(self._document.hidden)

    def _interval_changed(self) -> None:
        """Select the row; if there is a filter, refresh the list, where the
        selected row always appears.
        """
        if not self._is_filtered:
            self._select_row()
        elif self._clicked:
            self._later.start()  # the table must finish the click before rows go
        else:
            self._filter_again()

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

    def _count_selected(self) -> None:
        self.selected.emit(len(self.table.selectionModel().selectedRows()))

    def _row_selected(self, current: QModelIndex) -> None:
        if current.isValid() and not self._refreshing:
            self._clicked = True
            self._document.select_interval(self._judged(current.row()).id, jump=True)
            self._clicked = False
