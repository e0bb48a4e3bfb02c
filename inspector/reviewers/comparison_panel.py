"""The list of differences between two reviews of a clip, with buttons to settle them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from html import escape

from PySide6.QtCore import QItemSelectionModel, QModelIndex, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHeaderView, QWidget

from inspector.language import plural, tr, translate_core_sentence
from inspector.panels.interval_rows import limb_end_state_text, verdict_text
from inspector.panels.reject_reasons import translate_reject_reason
from inspector.panels.rig_names import label_of, label_without_chain
from inspector.reviewers.second_review import DifferenceRow, SecondReview
from inspector.session.document import Document
from inspector.widgets.building import action_button, hbox, vbox
from inspector.widgets.labels import Caption, capitalised
from inspector.widgets.signed_numbers import interval_angle_text
from inspector.widgets.tables import RowModel, RowTable, SecondaryTextDelegate, TableRow
from inspector.widgets.theme import Colours
from twistcore.detection import Interval
from twistcore.files.encoding import escape_control_characters
from twistcore.review import Decision, Judged, Settle
from twistcore.review.agreement import PairDifference, decided_by_person

_BUTTONS = {  # short texts for the buttons, keyed by action id
    "keep_mine": tr("Keep mine"),
    "take_theirs": tr("Take theirs"),
    "next_difference": tr("Next"),
    "take_undecided": tr("Take theirs if I am undecided"),
}
_MOST = 300  # maximum number of letters of a decision with its note
_PAUSE_MS = 30  # time without a change of the review; longer than between two steps of a drag
_SELECT = QItemSelectionModel.SelectionFlag.ClearAndSelect | QItemSelectionModel.SelectionFlag.Rows


class DifferencesModel(RowModel[DifferenceRow]):
    """The rows of the table, each with an interval and both reviewers' decisions."""

    heads = ("", "", "")  # set for each comparison, because they contain the reviewers' names
    middle = (0,)

    def __init__(self, document: Document, colours: Colours) -> None:
        super().__init__(colours)
        self._document = document

    def key(self, thing: DifferenceRow) -> int:
        """Return the key that identifies a row."""
        return thing.key

    def describe(self, thing: DifferenceRow) -> TableRow:
        """Return the texts of a row: the interval, and the decisions of both reviewers.

        If only the corrections differ, the texts also contain the values that differ.
        """
        pair, sides = thing.pair, (thing.pair.mine, thing.pair.theirs)
        name = f"{self.label(pair.either.interval)} {self.correction(pair.either)[0]}"
        texts = [verdict_text(judged) if judged else "–" for judged in sides]
        if pair.difference == PairDifference.CORRECTION:
            both = [self.correction(judged) for judged in sides if judged]
            differing = [k for k, (a, b) in enumerate(zip(*both, strict=True)) if a != b]
            shown = [" ".join(one[k] for k in differing or (0, 1)) for one in both]
            texts = [f"{mark[0]} {text}" for mark, text in zip(texts, shown, strict=True)]
        colours = {
            k: getattr(self.theme, str(judged.decision))
            for k, judged in enumerate(sides, start=1)
            if judged is not None
        }
        return TableRow(
            texts=(name, *texts),
            colours={**colours, **({0: self.theme.soft} if thing.settled else {})},
            tips=(name, *texts),
            secondary=tr("settled") if thing.settled else "",
        )

    def correction(self, judged: Judged) -> tuple[str, str, str]:
        """Return a correction as three texts: its frames, its angle and the state of the end.

        The end is the foot, hand or next joint. Its state is 'kept' or 'turned'.
        """
        interval, first = judged.interval, self._document.first_frame
        frames = f"{interval.start + first}–{interval.stop + first}"
        return (
            frames,
            interval_angle_text(interval.kind, interval.shown),
            limb_end_state_text(judged),
        )

    def label(self, interval: Interval) -> str:
        """Return the label of an error.

        If the open review does not have its chain, return the name of the chain or 'Whole body'.
        """
        try:
            return label_of(interval, self._document.find_chain(interval.chain), listed=True)
        except KeyError:
            return label_without_chain(interval)


class ComparisonPanel(QWidget):
    """A table of the differences between two reviews. Selecting a row shows its interval."""

    shown = Signal(object)  # with the selected interval, which may be from either review

    def __init__(
        self, document: Document, colours: Colours, actions: Mapping[str, QAction]
    ) -> None:
        super().__init__()
        self._document = document
        self._second: SecondReview | None = None
        self._key: int | None = None  # the key of the current row
        self.model = DifferencesModel(document, colours)
        self.table = RowTable(self.model)
        self.table.setAccessibleName(tr("Differences between the reviews"))
        self.table.setItemDelegate(SecondaryTextDelegate(self.model, self.table))
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.table.selectionModel().currentRowChanged.connect(self._row_selected)
        self.summary, self.detail = Caption(), Caption(soft=True)
        self._actions = [actions[name] for name in _BUTTONS]
        *one, every = map(action_button, self._actions, _BUTTONS.values())
        parts = self.summary, (self.table, 1), self.detail, hbox(*one, None), hbox(every, None)
        vbox(*parts, owner=self, margins=(4, 4, 4, 4), spacing=4)
        self._later = QTimer(self, singleShot=True, interval=_PAUSE_MS)
        self._later.timeout.connect(self._refresh)
        document.intervals_changed.connect(self._later.start)
        document.interval_changed.connect(self._follow)
        document.numbering_changed.connect(self.model.redraw)
        self.compare(None)

    def compare(self, second: SecondReview | None) -> None:
        """List the differences between the open review and `second`. None clears the list."""
        self._second, self._key = second, None
        mine, theirs = (second.mine, second.theirs) if second else ("", "")
        self.model.heads = (tr("Interval"), f"{tr('Mine')}\n{mine}", f"{tr('Theirs')}\n{theirs}")
        self.model.reset_rows(())
        text = tr("Open another review of this clip: File → Compare with another review…")
        self.summary.set_text(text)
        for action in self._actions:
            action.setEnabled(second is not None)
        self.detail.set_text("")
        self._refresh()

    @property
    def rows(self) -> list[DifferenceRow]:
        """The rows of the table, including settled differences."""
        return list(self.model.things)

    @property
    def current(self) -> DifferenceRow | None:
        """The selected difference, or None."""
        return next((row for row in self.model.things if row.key == self._key), None)

    # -- actions ---------------------------------------------------------------------------------

    def step(self) -> None:
        """Go to the next difference that is not settled, or report that all are settled."""
        rows, now = self.rows, self.current
        at = 0 if now is None else rows.index(now) + 1
        if ahead := [row for row in (*rows[at:], *rows[:at]) if not row.settled]:
            self._select(ahead[0].key)
            self._show(ahead[0])
        else:
            self._say(tr("All differences between the reviews are settled."))

    def keep_mine(self) -> None:
        """Confirm the user's decision on the selected difference.

        If only the other review has the interval, reject it.
        """
        if (row := self._chosen()) is None:
            return
        mine, theirs = row.pair.mine, row.pair.theirs
        if mine is None and theirs is not None:
            new = replace(theirs, id=self._document.review.state.next_id, supported=theirs.by_hand)
            self._settle(replace(new, decision=Decision.REJECTED, note="", reason=""))
        elif mine is not None and mine.decision != Decision.UNDECIDED:
            self._settle(mine)
        else:
            self._say(
                tr(
                    "You have not decided on this interval. Accept it, reject it, or take the "
                    "other reviewer's decision."
                )
            )

    def take_theirs(self) -> None:
        """Use the other reviewer's decision and correction for the selected difference."""
        if (row := self._chosen()) is None:
            return
        if (taken := row.pair.taken(self._document.review.state.next_id)) is not None:
            self._settle(taken)
        else:
            self._say(tr("The other reviewer has not decided on this interval."))

    def take_undecided(self) -> None:
        """Use the other reviewer's decisions on all intervals that the user has not decided on.

        These decisions are stored with the other reviewer's name.
        """
        second, state = self._second, self._document.review.state
        if not (taken := second.left_to_them(state) if second else ()):
            self._say(
                tr("You have already decided on every interval that the other reviewer decided on.")
            )
        elif self._document.do(Settle(taken)):
            self._say(plural("1 decision was adopted.", "{n} decisions were adopted.", len(taken)))

    def _settle(self, judged: Judged) -> None:
        if self._document.settle(judged):
            self._refresh()

    def _chosen(self) -> DifferenceRow | None:
        if self.current is None:
            self._say(tr("Select a difference between the reviews first."))
        return self.current

    def _say(self, text: str) -> None:
        self._document.message.emit(text, False)

    # -- the list --------------------------------------------------------------------------------

    def _refresh(self) -> None:
        """Update the rows. If the current difference has just been settled, go to the next one."""
        self._later.stop()
        if self._second is None:
            return
        before = self.current
        self.model.show(self._second.rows(self._document.review.state))
        left = sum(not row.settled for row in self.rows)
        count = tr("Differences: {count}, not settled: {left}", count=len(self.rows), left=left)
        agreement = translate_core_sentence(self._second.agreement.summary)
        self.summary.set_text(escape(f"{capitalised(agreement)}. {count}.", quote=False))
        now = self.current
        settled = before is not None and not before.settled and now is not None and now.settled
        if settled and not self.visibleRegion().isEmpty():
            self.step()
        else:
            self._follow()

    def _follow(self) -> None:
        """Select the row of the interval that is selected in the document."""
        if self._second is None or self._later.isActive():
            return  # a call of `_refresh` follows
        selected = self._document.interval_id
        of_interval = {r.pair.mine.id: r.key for r in self.model.things if r.pair.mine is not None}
        if selected is not None:
            self._select(of_interval.get(selected))
        elif self.current is not None and self.current.pair.mine is not None:
            self._select(None)
        self.detail.set_text(self._described())

    def _select(self, key: int | None) -> None:
        self._key = key
        row = self.model.row_of(key) if key is not None else None
        selection = self.table.selectionModel()
        if row is None:
            selection.clear()
        elif selection.currentIndex().row() != row or not selection.hasSelection():
            selection.setCurrentIndex(self.model.index(row, 0), _SELECT)

    def _row_selected(self, current: QModelIndex) -> None:
        if not current.isValid():
            return
        row = self.model.things[current.row()]
        if row.key != self._key:
            self._key = row.key
            self._show(row)

    def _show(self, row: DifferenceRow) -> None:
        """Select a row's interval in the document.

        If only the other review has the interval, go to its frames.
        """
        document, judged = self._document, row.pair.either
        if row.pair.mine is not None:
            document.select_interval(judged.id, jump=True)
        else:
            document.select_interval(None)
            listed = judged.interval.chain in {c.name for c in document.listed_chains}
            if listed and not document.is_of_chain(judged.interval):
                document.select_chain(judged.interval.chain)
            document.go_to(judged.interval.seen_at)
        self.detail.set_text(self._described())
        self.shown.emit(judged)

    # -- texts -----------------------------------------------------------------------------------

    def _described(self) -> str:
        """Return a description of the selected difference and both decisions, as rich text."""
        if (row := self.current) is None or (difference := row.pair.difference) is None:
            return ""
        sides = (tr("Mine"), row.pair.mine), (tr("Theirs"), row.pair.theirs)
        lines = [f"<b>{escape(capitalised(translate_core_sentence(difference)))}</b>"]
        words = [f"{side}: {self._decision(judged)}" for side, judged in sides if judged]
        lines += [escape(escape_control_characters(text, most=_MOST)) for text in words]
        return "<br>".join(lines)

    def _decision(self, judged: Judged) -> str:
        """Return the text for a decision: its correction, reviewer, time, reason and note."""
        words = [" ".join((verdict_text(judged), *self.model.correction(judged))).rstrip()]
        if decided_by_person(judged):
            words += [judged.reviewer, judged.decided_at[:16].replace("T", " ")]
        return ", ".join(
            filter(None, (*words, translate_reject_reason(judged.reason), judged.note))
        )
