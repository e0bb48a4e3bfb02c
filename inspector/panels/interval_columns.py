"""The columns of the interval table: their visibility, their widths and the sort order."""

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
    """A column of the interval table.

    Attributes
    ----------
    id
        The name of the column in the settings.
    head
        The heading.
    name
        The text in the menu of columns. If it is '', the menu shows the heading.
    tip
        The tool tip of the heading.
    figures
        True for a column of numbers, which is right-aligned.
    """

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
        tip=tr(
            "+: the interval overlaps another interval of its chain.\n<τ: the interval is "
            "no longer found at this threshold.\n✎: the interval was edited by hand."
        ),
    ),
    Column("start", tr_as("column", "Start"), tip=tr("First frame"), figures=True),
    Column("stop", tr_as("column", "Stop"), tip=tr("First frame after the interval"), figures=True),
    Column("frames", tr("Frames"), tip=tr("Number of frames"), figures=True),
    Column("time", tr_as("column", "Time"), tip=tr("Time of the first frame"), figures=True),
    Column(
        "delta",
        "δ",
        tr("δ, the offset"),
        tr("Largest offset in the interval: the angle that the correction removes"),
        figures=True,
    ),
    Column(
        "confidence",
        tr_as("short for confidence", "Conf."),
        tr("Confidence"),
        tr("Confidence, from 0 to 1: the probability that the correction is right"),
        figures=True,
    ),
    Column(
        "end",
        tr_as("of a limb", "Foot/hand"),
        tip=tr("Whether a flip also turned the limb's foot or hand"),
    ),
    Column("kind", tr_as("of error", "Kind"), tip=tr("Kind of error")),
    Column(
        "joints",
        tr("Joints"),
        tr("Joints in the file"),
        tr("Names of the chain's joints in the file"),
    ),
    Column("note", tr("Note"), tip=tr("Reason for the decision, and your note")),
)
PLACE = {column.id: k for k, column in enumerate(COLUMNS)}
_ALWAYS = "chain"
# These columns are hidden in this order if there is not enough space
_SPARED = ("time", "frames", "note", "stop", "kind", "end", "confidence")
# In a low table, the name of a group begins in the column 'stop'.
_SPARED_LOW = ("time", "frames", "note", "confidence", "kind", "end", "stop")
_PAD = 10  # pixels on either side of a text
# Pixels: maximum width of a column of names, minimum width of the first column
_WIDEST, _LEAST = 190, 74
_NOTE = 60


def columns_that_fit(
    widths: Mapping[str, int], filled: Iterable[str], room: int, *, low: bool = False
) -> list[str]:
    """Return the ids of the columns that fit into `room` pixels, from left to right.

    Parameters
    ----------
    widths
        The width of each column in pixels, keyed by id.
    filled
        The ids of the columns that contain text in any row.
    low
        True for a table of low height, in which the names of groups are next to their chains.
    """
    shown = [c.id for c in COLUMNS if c.id in filled and c.id != "joints"]

    def rest() -> int:
        return room - sum(widths[name] for name in shown if name != _ALWAYS)

    spared = []
    for name in _SPARED_LOW if low else _SPARED:
        if rest() < widths[_ALWAYS] and name in shown:
            shown.remove(name)
            spared.append(name)
    for name in reversed(spared):  # a narrow column may fit where a wide one did not
        if rest() - widths[name] >= widths[_ALWAYS]:
            shown.append(name)
            spared.remove(name)
    if "note" not in shown and not spared and rest() >= widths[_ALWAYS] + _NOTE:
        shown.append("note")
    return sorted(shown, key=PLACE.__getitem__)


class IntervalColumns(QObject):
    """The manager of a table's columns, which also stores the sort order.

    It shows the columns that the user has chosen or, by default, all columns that fit. A right
    click on a heading opens the menu of columns. A click on a heading sorts by this column, and the
    third click restores the original order.
    """

    def __init__(self, table: RowTable, settings: Settings) -> None:
        super().__init__(table)
        self._table, self._settings = table, settings
        self._samples: dict[str, str] = {}
        self._with_text: frozenset[str] = frozenset()
        self._laid: object = None
        self._low = False
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

    def take(self, samples: Mapping[str, str], filled: Iterable[str]) -> None:
        """Set the widest text of each column, and the columns that are not empty.

        `samples` contains the widest texts, keyed by column id. An empty string means that the
        heading is the widest text. `filled` contains the ids of the columns that have text in any
        row.
        """
        self._samples, self._with_text = dict(samples), frozenset(filled)
        self.fit()

    def set_low(self, low: bool) -> None:
        """Set whether the table has a low height, and choose the columns again."""
        self._low = low
        self.fit()

    def fit(self) -> None:
        """Choose the visible columns and their widths again, if anything has changed."""
        table, header = self._table, self._table.horizontalHeader()
        room = table.width() - table.verticalScrollBar().sizeHint().width() - 2
        numbers = table.numbers_width
        laid = (
            room,
            self._low,
            numbers,
            tuple(self._samples.items()),
            self._with_text,
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
        for numbered in (numbers, 0):  # in a narrow table, names are more useful than row numbers
            if chosen:  # if they do not fit, the table scrolls
                shown = [c.id for c in COLUMNS if c.id in {_ALWAYS, *chosen}]
            else:
                shown = columns_that_fit(widths, self._with_text, room - numbered, low=self._low)
            rest = room - numbered - sum(widths[name] for name in shown if name != _ALWAYS)
            if chosen or rest >= names:
                break
        if not chosen and rest < names <= rest + widths["start"]:
            shown.remove("start")  # the last resort, if the names fit without this column
            rest += widths["start"]
        table.verticalHeader().setVisible(numbered > 0)
        last_grows = shown[-1] in ("note", "joints")  # if False, the first column fills the rest
        header.setStretchLastSection(last_grows)
        widths[_ALWAYS] = max(least, min(rest, names) if last_grows else rest)
        for k, column in enumerate(COLUMNS):
            if table.isColumnHidden(k) != (column.id not in shown):
                table.setColumnHidden(k, column.id not in shown)
            if column.id in shown and table.columnWidth(k) != widths[column.id]:
                table.setColumnWidth(k, widths[column.id])

    def shown(self) -> list[str]:
        """Return the ids of the visible columns."""
        return [c.id for k, c in enumerate(COLUMNS) if not self._table.isColumnHidden(k)]

    def menu(self) -> QMenu:
        """Return the menu of columns. Its last entry shows all columns that fit."""
        menu, shown = QMenu(self._table), self.shown()
        for column in COLUMNS:
            action = menu.addAction(column.name or column.head)
            action.setCheckable(True)
            action.setChecked(column.id in shown)
            action.setEnabled(column.id != _ALWAYS)
            action.toggled.connect(lambda on, name=column.id: self._choose(name, on))
        menu.addSeparator()
        fitting = menu.addAction(tr("All columns that fit"))
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
        names = {*self.shown(), name} if on else {*self.shown()} - {name}
        self._keep([c.id for c in COLUMNS if c.id in names])

    def _keep(self, columns: Sequence[str]) -> None:
        self._settings.columns = list(columns)
        self.fit()

    def _sorted(self, section: int, order: Qt.SortOrder) -> None:
        down = "-" if order == Qt.SortOrder.DescendingOrder else ""
        name = f"{down}{COLUMNS[section].id}" if 0 <= section < len(COLUMNS) else ""
        self._settings.interval_sort = name
        self.fit()
