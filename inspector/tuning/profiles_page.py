"""A page about all chains, with a table that compares either profiles or detectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from PySide6.QtCore import QModelIndex, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHeaderView, QMenu, QStackedWidget, QToolButton, QWidget

from inspector.language import tr
from inspector.session.document import Document
from inspector.tuning.detectors_table import DetectorsModel, first_row_of_chain
from inspector.tuning.tau_costs import Costs
from inspector.tuning.tau_table import Column, ComparisonModel
from inspector.tuning.wishes import Wishes
from inspector.widgets.building import Wrapping, action_button, hbox, vbox
from inspector.widgets.labels import Caption
from inspector.widgets.tables import RowTable
from inspector.widgets.theme import Colours

_OF_FILES = ("load_profile", "save_profile", "profile_to_folder", "automatic_folder")
_BUTTONS = {  # short texts for the buttons
    "compare_profiles": tr("Compare…"),
    "take_profile": tr("Use"),
    "close_comparison": tr("Close"),
    "both_costs": tr("Both detectors"),
}


_BOTH = tr(
    "The first row of each chain shows its suggested τ. The brackets show the confidence interval "
    "of the FSR over the repetitions."
)


class ProfilesPage(QWidget):
    """A table of τ and its cost for each chain, or a table of all detectors.

    `chosen` is emitted with a chain's name when the user clicks on the chain. `called` is emitted
    when the page should come to the front.
    """

    chosen = Signal(str)
    called = Signal()

    def __init__(
        self,
        document: Document,
        colours: Colours,
        costs: Costs,
        wishes: Wishes,
        actions: Mapping[str, QAction],
    ) -> None:
        super().__init__()
        self._costs, self._actions = costs, actions
        self.model = ComparisonModel(document, colours, costs)
        self.detectors = DetectorsModel(document, colours, costs, wishes)
        self.table, self.both_table = RowTable(self.model, room=5), RowTable(self.detectors, room=5)
        self.table.setAccessibleName(tr("τ of every chain and its cost"))
        self.both_table.setAccessibleName(tr("Cost of τ with both detectors"))
        self._tables = QStackedWidget()
        for table in (self.table, self.both_table):
            header = table.horizontalHeader()
            header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
            table.setHorizontalScrollMode(table.ScrollMode.ScrollPerPixel)
            table.clicked.connect(self._choose)
            table.resized.connect(partial(self._fit, table))
            self._tables.addWidget(table)
        self.note = Caption(soft=True)
        files = QToolButton(popupMode=QToolButton.ToolButtonPopupMode.InstantPopup)
        files.setText(tr("Profile"))
        files.setToolTip(tr("Load or save the τ values, or use them for the folder"))
        menu = QMenu(files)
        menu.addActions([actions[name] for name in _OF_FILES])
        files.setMenu(menu)
        self.buttons = {name: action_button(actions[name], w) for name, w in _BUTTONS.items()}
        always = files, self.buttons["compare_profiles"], self.buttons["both_costs"]
        beside = self.buttons["take_profile"], self.buttons["close_comparison"]
        rows = hbox(*always, spacing=4), hbox(*beside, None, spacing=4)
        rows[0].setAlignment(Qt.AlignmentFlag.AlignLeft)
        vbox(
            (self._tables, 1),
            self.note,
            Wrapping(*rows, spacing=4),
            owner=self,
            margins=(0, 4, 0, 0),
            spacing=4,
        )
        self._show_buttons()

    def set_compared(self, others: Sequence[Column]) -> None:
        """Set the profiles to compare.

        One profile is compared with the current τ, and two profiles are compared with each other.
        """
        self.model.set_compared(others)
        self._actions["both_costs"].setChecked(False)
        self._need()
        self.called.emit()

    def show_both(self, both: bool) -> None:
        """Show the table of all detectors, or the table of τ if `both` is False."""
        self._tables.setCurrentIndex(int(both))
        self._need()
        self.called.emit()
        self.refresh()

    def _need(self) -> None:
        """Request measurements for all detectors in the visible table."""
        both = self._tables.currentWidget() is self.both_table
        own = (self.model.method(c) for c in self.model.columns if c.profile.method)
        self._costs.needs(self.detectors.methods if both else own)
        self._show_buttons()

    def _show_buttons(self) -> None:
        for name in ("take_profile", "close_comparison"):
            self._actions[name].setEnabled(bool(self.model.others))
            self.buttons[name].setVisible(bool(self.model.others))

    def refresh(self) -> None:
        """Update the numbers in both tables."""
        both = self._tables.currentWidget() is self.both_table
        (self.detectors if both else self.model).refresh()
        note = _BOTH if both else self.model.note
        self.note.set_plain(note)
        self.note.setVisible(bool(note))
        self._fit(self.both_table if both else self.table)

    def _fit(self, table: RowTable) -> None:
        """Stretch a table's first column to fill the width, or let the table scroll if needed."""
        header, model = table.horizontalHeader(), table.model()
        if model.rowCount():
            own = max(table.sizeHintForColumn(0), header.sectionSizeHint(0))
            others = sum(header.sectionSize(k) for k in range(1, header.count()))
            mode = QHeaderView.ResizeMode
            wide = own + others <= table.viewport().width()
            header.setSectionResizeMode(0, mode.Stretch if wide else mode.ResizeToContents)

    def show_chain(self, name: str) -> None:
        """Select the row of a chain in both tables."""
        if (row := self.model.row_of(name)) is not None:
            self.table.selectRow(row)
        if (row := first_row_of_chain(self.detectors.things, name)) is not None:
            self.both_table.selectRow(row)

    def _choose(self, index: QModelIndex) -> None:
        model = index.model()
        assert isinstance(model, ComparisonModel | DetectorsModel)
        if name := model.things[index.row()].chain:
            self.chosen.emit(name)
