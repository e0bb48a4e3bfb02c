"""The table of intervals, with a filter and a menu of columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from PySide6.QtCore import QEvent, QItemSelectionModel, QModelIndex, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QMouseEvent, QResizeEvent, QShortcutEvent
from PySide6.QtWidgets import QStackedWidget, QWidget

from inspector.language import plural, tr, translate_core_sentence
from inspector.panels.interval_columns import COLUMNS, PLACE, IntervalColumns
from inspector.panels.interval_filter import OF_CHAIN, FilterLine, IntervalFilter
from inspector.panels.interval_groups import IntervalGroups
from inspector.panels.interval_rows import (
    EDITED,
    ENDS,
    INDENT,
    MARKS,
    NAME,
    SHARED,
    UNSUPPORTED,
    GroupRow,
    IntervalModel,
    ListRow,
    SortedRows,
    limb_end_state_text,
)
from inspector.panels.reject_reasons import translate_reject_reason
from inspector.panels.rig_names import joints_of_error, label_of
from inspector.session.document import Document
from inspector.session.examined import reason_unexamined, unexamined_sentences
from inspector.session.settings import Settings
from inspector.widgets.building import RIGHT, hbox, hint, use_secondary_text_colour, vbox
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.tables import RowTable, TwoLineDelegate
from inspector.widgets.theme import Colours
from twistcore.detection import Interval, Kind
from twistcore.review import Decision, Judged

_ROOM, _ROOM_LOW = 8, 3  # pixels by which a row is higher than its text
_GAPS = 24  # pixels: the margins of the panel, and the gap between the filter and the count
_EVERYTHING = IntervalFilter()
_FOLDING = {"Right": True, "Left": False}


class IntervalsPanel(QWidget):
    """The interval table with its filter. The current row is the selected interval."""

    activated = Signal()  # a row was double-clicked
    # With the number of selected intervals, including those in a selected group
    ids_changed = Signal(tuple)
    row_selected = Signal()  # an interval was selected in the table

    def __init__(
        self, document: Document, colours: Colours, settings: Settings | None = None
    ) -> None:
        """Build the panel. `settings` stores the visible columns and the sort order."""
        super().__init__()
        self._document = document
        self._groups = IntervalGroups(document)
        self._refreshing = self._clicked = self._low = self._had_groups = False
        # Within `visit_order`: the ids of the intervals in the group that is visited one by one
        self._stepping: tuple[int, ...] | None = None
        self._keeps_selection = False  # within `keep_selection`
        self._with_text = {"chain", "decision", "start", "stop", "frames", "time", "delta"}
        self._marks: set[str] = set()
        # Label and joints, keyed by the label's chain, and by whether an error is of the whole body
        self._names: dict[tuple[str, bool], tuple[str, str]] = {}
        # Intervals for whose texts the columns are wide enough, keyed by id()
        self._measured: dict[int, Judged] = {}
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._refresh)
        self._model = IntervalModel(document, colours)
        self._proxy = SortedRows(self._model)
        self.table = RowTable(self._proxy, several=True)
        self.table.setAccessibleName(tr("Intervals"))
        self.table.show_numbers()
        self.table.setItemDelegate(TwoLineDelegate(self._model, self.table, self._proxy))
        self.table.selectionModel().currentRowChanged.connect(self._row_selected)
        self.table.selectionModel().selectionChanged.connect(self._report_number)
        self.table.doubleClicked.connect(self.activated)
        self.table.viewport().installEventFilter(self)
        self._proxy.layoutChanged.connect(lambda: None if self._refreshing else self._span_names())
        self.columns = IntervalColumns(self.table, settings or Settings())
        self.filters = FilterLine()
        self.filter, self.search = self.filters.choice, self.filters.search
        self.filters.changed.connect(self._filter_changed)
        self.filters.left.connect(self.table.setFocus)
        self.count = use_secondary_text_colour(SteadyLabel(alignment=RIGHT))
        self._hint = hint()
        self._stack = QStackedWidget()
        self._stack.addWidget(self._hint)
        self._stack.addWidget(self.table)
        top = hbox((self.filters, 1), self.count)
        vbox(top, (self._stack, 1), owner=self)
        self.set_low(False)
        self.table.resized.connect(self._span_names)  # after the columns have their new widths
        document.opened.connect(self._take_clip)
        document.intervals_changed.connect(self._refresh)
        document.chains_changed.connect(self._take_chains)
        document.numbering_changed.connect(self._model.redraw)
        document.order_changed.connect(self._refresh)
        for other in (self._model.redraw, self._refresh):
            document.confidence_changed.connect(other)
        document.hidden_changed.connect(self._refresh)
        document.interval_changed.connect(self._interval_changed)
        document.chain_changed.connect(self._chain_changed)
        self._refresh()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show the number of intervals only if the panel is wide enough.

        If it is not, only the status bar shows the number.
        """
        super().resizeEvent(event)
        self._show_count()

    def _show_count(self) -> None:
        needed = self.filters.sizeHint().width() + self.count.sizeHint().width() + _GAPS
        self.count.setVisible(self.width() >= needed)

    def set_low(self, low: bool) -> None:
        """Set whether to use the layout for windows of low height.

        In this layout, rows are lower, and the name of a group is next to its chain.
        """
        layout = self.layout()
        assert layout is not None
        layout.setContentsMargins(*((4, 2, 4, 0) if low else (4, 4, 4, 4)))
        layout.setSpacing(3 if low else -1)  # -1 stands for the style's default
        self.table.set_room(_ROOM_LOW if low else _ROOM)
        self._low = low
        self.columns.set_low(low)
        self._span_names()

    def search_here(self) -> None:
        """Move the focus to the search line."""
        self.search.setFocus()
        self.search.selectAll()

    def list_all(self) -> Callable[[], None]:
        """Clear the filter, and return a function that restores it."""
        return self.filters.list_all()

    def group_errors(self, on: bool) -> None:
        """Group errors that belong together, or list all intervals separately if `on` is False."""
        self._groups.on, self._groups.whole = on, False
        self._refresh()

    def unfold_with(self, *actions: QAction) -> None:
        """Let the Right and Left keys unfold and fold the selected group, if there is one.

        In other cases, the keys trigger `actions`. The Right key also moves the focus to the table,
        so that the Down and Up keys go through the intervals of the group. While the table has the
        focus, the Left key also folds the group of the selected interval.
        """
        for action in actions:
            action.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Unfold or fold a group after a click on its arrow or after a key press.

        Keys are handled only while the table is visible.
        """
        if isinstance(event, QShortcutEvent):
            on, group = _FOLDING.get(event.key().toString()), self._groups.selected
            if on is False and self.window().focusWidget() is self.table:
                group = group or self._groups.entered
            seen = not self.table.visibleRegion().isEmpty()
            if seen and on is not None and group is not None and group.unfolded != on:
                self._unfold(group, on)
                if on:
                    self.table.setFocus(Qt.FocusReason.ShortcutFocusReason)
                return True
        elif isinstance(event, QMouseEvent) and event.type() == QEvent.Type.MouseButtonPress:
            index = self.table.indexAt(event.position().toPoint())
            from_left = event.position().x() - self.table.columnViewportPosition(0)
            group = self._group_at(index) if index.column() == 0 else None
            arrow = self.table.fontMetrics().horizontalAdvance(INDENT)
            if group and event.button() == Qt.MouseButton.LeftButton and from_left <= arrow:
                self._unfold(group, not group.unfolded)
        return super().eventFilter(watched, event)

    def _group_at(self, index: QModelIndex) -> GroupRow | None:
        thing = self._thing(index.row()) if index.isValid() else None
        return thing if isinstance(thing, GroupRow) else None

    def _unfold(self, group: GroupRow, on: bool) -> None:
        entered = self._groups.entered
        if entered is not None and entered.id == group.id and not on:
            self._groups.whole = True  # the row of the selected interval disappears
        self._groups.unfold(group, on)
        self._refresh()

    def _forget_names(self) -> None:
        self._names.clear()
        self._measured.clear()

    def _take_clip(self) -> None:
        self._groups.forget()
        self._take_chains()

    def _take_chains(self) -> None:
        """Measure the columns again for the intervals of other chains."""
        self._forget_names()
        self._marks.clear()
        self._with_text -= {"confidence", "kind", "end", "note"}
        self._refresh()

    def _fit_columns(self, shared: bool) -> None:
        """Widen the columns for new intervals. Columns never shrink while a clip is open."""
        document = self._document
        if (data := document.data) is None or not document.intervals:
            return
        known = self._measured
        # While the user drags τ, few intervals are new.
        fresh = [j for j in document.intervals if id(j) not in known]
        self._measured = {id(j): j for j in document.intervals}
        if shared:
            self._marks.add(SHARED)
        if self._groups.count:
            self._marks.add(INDENT)
        if not all(j.supported for j in fresh):
            self._marks.add(UNSUPPORTED)
        if any(j.edited for j in fresh):
            self._marks.add(EDITED)
        for name, has_text in (
            ("confidence", lambda j: j.interval.confidence is not None),
            ("kind", lambda j: j.interval.kind != Kind.COUNTER_TWIST),
            ("end", lambda j: j.interval.kind.info.below),
            ("note", lambda j: j.note or j.reason),
        ):
            if name not in self._with_text and any(map(has_text, fresh)):
                self._with_text.add(name)
        for judged in fresh:
            self._name(judged.interval)
        advance = self.fontMetrics().horizontalAdvance
        labels, joints = zip(*self._names.values(), strict=True)
        last = str(document.frames + document.first_frame)
        kinds = {*Kind, *(j.interval.kind for j in document.intervals)}
        widest = max(MARKS.values(), key=advance)
        marks = "".join(m for m in (SHARED, UNSUPPORTED, EDITED) if m in self._marks)
        self.columns.take(
            {
                "chain": INDENT * (INDENT in self._marks) + max(labels, key=advance),
                "decision": widest + marks,
                "start": last,
                "stop": last,
                "frames": last,
                "time": f"{document.frames * data.motion.frame_time:.2f} s",
                "delta": "−180.0°",
                "confidence": "0.00",
                "end": max(ENDS, key=advance),
                "kind": max(map(translate_core_sentence, kinds), key=advance),
                "joints": max(joints, key=advance),
            },
            self._with_text,
        )

    def _is_listed(self, judged: Judged) -> bool:
        """Return True if an interval is selected or passes the filter."""
        return judged.id == self._document.interval_id or self._passes(judged)

    def _passes(self, judged: Judged) -> bool:
        document, interval = self._document, judged.interval
        return not document.hides(interval) and self.filters.current.admits(
            document.displayed(judged), document.is_of_chain(interval), self._search_text
        )

    def _name(self, interval: Interval) -> tuple[str, str]:
        """Return the label of an error and the names of its joints in the file."""
        key = interval.chain, interval.kind.info.whole_body
        if key not in self._names and (data := self._document.data) is not None:
            chain = self._document.find_chain(interval.chain)
            label = label_of(interval, chain, listed=True)
            self._names[key] = label, joints_of_error(interval, chain, data.motion.skeleton)
        return self._names[key]

    def _search_text(self, judged: Judged) -> str:
        """Return the searchable text of an interval, in the chosen language and in English."""
        label, joints = self._name(judged.interval)
        name = "" if judged.interval.kind.info.whole_body else judged.interval.chain
        kind = translate_core_sentence(judged.interval.kind)
        verdict, reason = judged.verdict, judged.reason
        parts = (
            label,
            name,
            joints,
            kind,
            verdict,
            translate_core_sentence(verdict),
            judged.decision.value,
        )
        words = (
            translate_core_sentence(judged.decision),
            limb_end_state_text(judged),
            reason,
            translate_reject_reason(reason),
            judged.note,
        )
        return " ".join((*parts, *words))

    def order_by(self, order: str) -> None:
        """Sort the table by 'time', 'worst' or 'chain'."""
        column = PLACE["start"] if order == "time" else -1
        self.table.sortByColumn(column, Qt.SortOrder.AscendingOrder)

    def selected_ids(self) -> tuple[int, ...]:
        """Return the ids of the selected intervals, including those in selected groups.

        The ids are in row order.
        """
        things = map(self._thing, self._selected_rows())
        return tuple(dict.fromkeys(k for thing in things for k in thing.ids))

    def ids_in_selected_groups(self) -> tuple[int, ...]:
        """Return the ids of the intervals in the selected rows of groups, in row order."""
        things = map(self._thing, self._selected_rows())
        groups = (thing for thing in things if isinstance(thing, GroupRow))
        return tuple(dict.fromkeys(k for group in groups for k in group.ids))

    @contextmanager
    def keep_selection(self) -> Iterator[None]:
        """Keep the selected rows within this context, even if another interval is selected."""
        self._keeps_selection = True
        try:
            yield
        finally:
            self._keeps_selection = False

    def _selected_rows(self) -> list[int]:
        return sorted(i.row() for i in self.table.selectionModel().selectedRows())

    @property
    def has_several_selected(self) -> bool:
        """True if several rows are selected."""
        return len(self._selected_rows()) > 1

    def context_menu(self, actions: Sequence[QAction]) -> None:
        """Set the actions in the rows' context menu."""
        self.table.addActions(list(actions))
        self.table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def shown_ids(self) -> tuple[int, ...]:
        """Return the ids of all listed intervals from top to bottom.

        These include the intervals of folded groups.
        """
        return tuple(
            k
            for thing in self._listed_things()
            if not (isinstance(thing, GroupRow) and thing.unfolded)
            for k in thing.ids
        )

    @contextmanager
    def visit_order(self) -> Iterator[tuple[int, ...]]:
        """Yield the ids of the intervals to visit, from top to bottom and one for each group.

        Within this context, selecting an interval of a group selects the whole group. If a single
        interval of a group is already selected, the intervals of this group are visited one by one.
        """
        entered, now = self._groups.entered, self._document.interval_id
        stops = []
        for thing in self._listed_things():
            if isinstance(thing, GroupRow):
                if entered is None or thing.id != entered.id:
                    stops.append(now if now in thing.ids else thing.undecided.id)
            elif thing.group is None or (entered is not None and thing.group.id == entered.id):
                stops.append(thing.id)
        self._stepping = entered.ids if entered else ()
        try:
            yield tuple(k for k in stops if k is not None)
        finally:
            self._stepping = None

    def _listed_things(self) -> Iterator[ListRow]:
        return map(self._thing, range(self._proxy.rowCount()))

    def _thing(self, proxy_row: int) -> ListRow:
        source = self._proxy.mapToSource(self._proxy.index(proxy_row, 0))
        return self._model.things[source.row()]

    def _refresh(self) -> None:
        intervals = self._document.intervals
        listed = [judged for judged in intervals if self._is_listed(judged)]
        if self._document.order == "worst":
            intervals = tuple(sorted(intervals, key=self._document.severity, reverse=True))
        else:  # errors of the whole body precede the chains
            intervals = tuple(sorted(intervals, key=lambda j: not j.interval.kind.info.whole_body))
        rows = self._groups.rows(listed, intervals)
        self._refreshing = True  # the removal of a row must not select another row
        self._model.show(rows)
        self._span_names()
        self.table.doItemsLayout()  # lay out now; a later layout would repaint the panel twice
        self._refreshing = False
        self._fit_columns(any(not isinstance(row, GroupRow) and row.shared for row in rows))
        self.count.setText(self._count_text(len(listed)))
        self._show_count()
        if not self._document.data:
            text = tr("Open a clip to list its suspicious intervals here.")
        elif not intervals and (blind := reason_unexamined(self._document.data)):
            text = blind
        elif not intervals:
            by_detector = tr(
                "Nothing was found at this threshold τ.\nLower the τ line to find smaller errors."
            )
            by_hand = tr("The list is empty. Insert an interval\nwhere you see an error.")
            text = by_hand if self._document.data.blind else by_detector
            text = "\n".join((text, *unexamined_sentences(self._document.data)))
        else:
            text = tr("No interval matches this filter.")
        self._hint.setText(text)
        self._stack.setCurrentIndex(1 if self._proxy.rowCount() else 0)
        self._select_row()
        self._report_number()

    def _span_names(self) -> None:
        """Show the name of each group in a second line across all columns.

        In a low window, the name extends over the columns that have no text in the group's row.
        """
        self.table.clearSpans()
        if not self._groups.count and not self._had_groups:
            return
        self._had_groups = bool(self._groups.count)
        for row, thing in enumerate(self._listed_things()):
            group = thing if isinstance(thing, GroupRow) else None
            below = self._model.row_for(group).below if group and not self._low else ()
            self.table.set_line_below(row, below)
            if group and self._low:
                self.table.setSpan(row, NAME, 1, len(COLUMNS) - NAME)

    def _count_text(self, listed: int) -> str:
        intervals = self._document.intervals
        if not intervals:
            return ""
        decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
        text = tr("{done} of {total} decided", done=decided, total=len(intervals))
        if listed < len(intervals):
            text = tr("{listed} of {total} listed", listed=listed, total=len(intervals))
        groups = self._groups.count
        return f"{text} · {plural('{n} group', '{n} groups', groups)}" if groups else text

    def _filter_changed(self) -> None:
        if (judged := self._document.interval) and not self._passes(judged):
            self._document.select_interval(None)  # A and R must not decide on a hidden interval
        self._refresh()

    def _chain_changed(self) -> None:
        if self.filters.current.chosen == OF_CHAIN:
            self._refresh()

    @property
    def _is_filtered(self) -> bool:
        """True if the filter or a hidden chain may exclude intervals from the table."""
        return self.filters.current != _EVERYTHING or bool(self._document.hidden)

    def _interval_changed(self) -> None:
        """Select the row of the interval that is selected in the document.

        If the filter or a folded group may hide the row, update the table first.
        """
        groups, now = self._groups, self._document.interval_id
        if not self._clicked:
            groups.whole = self._stepping is not None and now not in self._stepping
        unfolds = groups.entered is not None and not groups.entered.unfolded
        if not self._is_filtered and not unfolds:
            self._select_row()
        elif self._clicked:
            self._later.start()  # the table must handle the click before rows are removed
        else:
            self._refresh()

    def _select_row(self) -> None:
        group = self._groups.selected
        at = self._model.row_of(group.id if group else self._document.interval_id)
        index = self._proxy.mapFromSource(self._model.index(-1 if at is None else at, 0))
        if not index.isValid():
            self.table.clearSelection()
            return
        selection = self.table.selectionModel()
        if self._keeps_selection:
            selection.setCurrentIndex(index, QItemSelectionModel.SelectionFlag.NoUpdate)
        elif self.table.currentIndex().row() != index.row() or not selection.hasSelection():
            rows = QItemSelectionModel.SelectionFlag.Rows
            once = QItemSelectionModel.SelectionFlag.ClearAndSelect
            selection.setCurrentIndex(index, once | rows)
        self.table.scrollTo(index)

    def _row_selected(self, current: QModelIndex) -> None:
        if not current.isValid() or self._refreshing:
            return
        thing, document = self._thing(current.row()), self._document
        self._groups.whole = isinstance(thing, GroupRow)
        judged = thing.undecided if isinstance(thing, GroupRow) else thing.judged
        if self._groups.whole and document.interval_id in thing.ids:
            return  # the interval is already selected as a part of its group
        moved = document.interval_id != judged.id  # if not, it was selected elsewhere
        self._clicked = True
        document.select_interval(judged.id, jump=True)
        self._clicked = False
        if moved:
            self.row_selected.emit()

    def _report_number(self) -> None:
        if not self._refreshing:
            self.ids_changed.emit(self.selected_ids())
