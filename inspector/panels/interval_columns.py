"""Columns of the table of intervals: which are shown, how wide, in which order of rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, QPoint, Qt
from PySide6.QtWidgets import QHeaderView, QMenu

from inspector.language import tr, tr_as
from inspector.session.settings import Settings
from inspector.widgets.tables import RowTable


@dataclass(frozen=True)
class Column:
    """id: in the settings; name: in the menu, head if empty; figures: they stand on the right."""

    id: str
    head: str
    name: str = ""
    tip: str = ""
    figures: bool = False


COLUMNS = (
    Column("chain", tr("Chain")),
    Column(
        "decision",
        tr_as("column", "Decision"),
        tip=tr("+: overlaps another; <τ: no longer found at this τ"),
    ),
    Column("start", tr_as("column", "Start"), figures=True),
    Column("stop", tr_as("column", "Stop"), figures=True),
    Column("frames", tr("Frames"), tip=tr("How many"), figures=True),
    Column("time", tr_as("column", "Time"), tip=tr("Of the start"), figures=True),
    Column("delta", "δ", tr("δ, the offset"), tr("The offset taken out, at most"), figures=True),
    Column(
        "confidence",
        tr_as("short for confidence", "Conf."),
        tr("Confidence"),
        tr("Confidence, 0 to 1"),
        figures=True,
    ),
    Column(
        "end",
        tr_as("of a limb", "End"),
        tip=tr("Of a flipped limb: its foot or hand is kept or turned along"),
    ),
    Column("kind", tr_as("of error", "Kind")),
    Column(
        "joints",
        tr("Joints"),
        tr("Joints in the file"),
        tr("The file's names of the chain's joints"),
    ),
    Column("note", tr("Note"), tip=tr("Reason and note")),
)
PLACE = {column.id: k for k, column in enumerate(COLUMNS)}
_ALWAYS = "chain"
_SPARED = ("time", "frames", "confidence", "kind", "end", "note", "stop")  # first to last
_PAD = 10  # pixels beside a text
_WIDEST, _LEAST = 190, 74  # pixels of a column of names: at most; of the chains where room is short
_NOTE = 60


def shown_by_room(
    widths: Mapping[str, int], said: Iterable[str], room: int, least: int
) -> list[str]:
    """Columns in their order that fit into so many pixels.

    widths: of the columns by id; said: those that tell anything; least: of the first one.
    """
    shown = [c.id for c in COLUMNS if c.id in said and c.id != "joints"]

    def rest() -> int:
        return room - sum(widths[name] for name in shown if name != _ALWAYS)

    for name in _SPARED:
        if rest() < widths[_ALWAYS] and (name != "stop" or rest() < least) and name in shown:
            shown.remove(name)
    if "note" not in shown and rest() >= widths[_ALWAYS] + _NOTE:
        shown.append("note")  # where one may be written
    return shown


class IntervalColumns(QObject):
    """Shows the columns that were chosen, else those that there is room for; keeps the order.

    A right click on the heading chooses; a click sorts, a third one ends that.
    """

    def __init__(self, table: RowTable, settings: Settings) -> None:
        super().__init__(table)
        self._table, self._settings = table, settings
        self._samples: dict[str, str] = {}
        self._said: frozenset[str] = frozenset()
        self._laid: object = None
        header = table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        header.setMinimumSectionSize(28)
        header.setSortIndicatorClearable(True)
        name = settings.interval_sort.lstrip("-")
        down = settings.interval_sort.startswith("-")
        order = Qt.SortOrder.DescendingOrder if down else Qt.SortOrder.AscendingOrder
        table.setSortingEnabled(True)
        table.sortByColumn(PLACE.get(name, -1), order)
        header.sortIndicatorChanged.connect(self._sorted)
        table.resized.connect(self.fit)
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(self._ask)

    def take(self, samples: Mapping[str, str], said: Iterable[str]) -> None:
        """The widest text of each column, '' if its head is that; columns that tell anything."""
        self._samples, self._said = dict(samples), frozenset(said)
        self.fit()

    def fit(self) -> None:
        """Widths and columns for the room there is; nothing where all is as it was."""
        table, header = self._table, self._table.horizontalHeader()
        room = table.width() - table.verticalScrollBar().sizeHint().width() - 2
        laid = (
            room,
            tuple(self._samples.items()),
            self._said,
            tuple(self._settings.columns),
            header.sortIndicatorSection(),
            table.font().key(),
        )
        if laid == self._laid or not self._samples:
            return
        self._laid = laid
        widths = {column.id: self._width(column) for column in COLUMNS}
        chosen, names = self._settings.columns, widths[_ALWAYS]
        least = names if chosen else min(_LEAST, names)
        if chosen:  # the table scrolls where they need more room
            shown = [c.id for c in COLUMNS if c.id in {_ALWAYS, *chosen}]
        else:
            shown = shown_by_room(widths, self._said, room, least)
        rest = room - sum(widths[name] for name in shown if name != _ALWAYS)
        last_grows = shown[-1] in ("note", "joints")  # else the names take what is left
        header.setStretchLastSection(last_grows)
        widths[_ALWAYS] = max(least, min(rest, names) if last_grows else rest)
        for k, column in enumerate(COLUMNS):
            if table.isColumnHidden(k) != (column.id not in shown):
                table.setColumnHidden(k, column.id not in shown)
            if column.id in shown and table.columnWidth(k) != widths[column.id]:
                table.setColumnWidth(k, widths[column.id])

    def shown(self) -> list[str]:
        """Ids of the columns to be seen."""
        return [c.id for k, c in enumerate(COLUMNS) if not self._table.isColumnHidden(k)]

    def menu(self) -> QMenu:
        """A tick a column, and the way back to what there is room for."""
        menu, shown = QMenu(self._table), self.shown()
        for column in COLUMNS:
            action = menu.addAction(column.name or column.head)
            action.setCheckable(True)
            action.setChecked(column.id in shown)
            action.setEnabled(column.id != _ALWAYS)
            action.toggled.connect(lambda on, name=column.id: self._choose(name, on))
        menu.addSeparator()
        fitting = menu.addAction(tr("Those there is room for"))
        fitting.setCheckable(True)
        fitting.setChecked(not self._settings.columns)
        fitting.triggered.connect(lambda: self._keep([]))
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        return menu

    def _width(self, column: Column) -> int:
        advance = self._table.fontMetrics().horizontalAdvance
        sorted_by = self._table.horizontalHeader().sortIndicatorSection() == PLACE[column.id]
        head = advance(column.head) + (self._table.mark_room if sorted_by else 0)
        width = max(head, advance(self._samples.get(column.id, ""))) + _PAD
        if column.id == "note":
            return max(width, _NOTE)
        return width if column.id == "decision" else min(width, _WIDEST)

    def _ask(self, place: QPoint) -> None:
        self.menu().popup(self._table.horizontalHeader().mapToGlobal(place))

    def _choose(self, name: str, on: bool) -> None:
        wanted = {*self.shown(), name} if on else {*self.shown()} - {name}
        self._keep([c.id for c in COLUMNS if c.id in wanted])

    def _keep(self, columns: Sequence[str]) -> None:
        self._settings.columns = list(columns)
        self.fit()

    def _sorted(self, section: int, order: Qt.SortOrder) -> None:
        down = "-" if order == Qt.SortOrder.DescendingOrder else ""
        name = f"{down}{COLUMNS[section].id}" if 0 <= section < len(COLUMNS) else ""
        self._settings.interval_sort = name
        self.fit()
