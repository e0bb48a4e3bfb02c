"""Tables for the panels. They redraw only the rows that have changed."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from PySide6.QtCore import (
    QAbstractItemModel,
    QAbstractProxyModel,
    QAbstractTableModel,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QRect,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QPainter, QPalette, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionHeader,
    QStyleOptionViewItem,
    QTableView,
)

from inspector.widgets.labels import escape_tool_tip_text
from inspector.widgets.text_forms import form_that_fits
from inspector.widgets.theme import Colours, Theme
from twistcore.files.encoding import escape_control_characters

_Thing = TypeVar("_Thing")
_Feature = QStyleOptionViewItem.ViewItemFeature
Index = QModelIndex | QPersistentModelIndex
SORT_ROLE = Qt.ItemDataRole.UserRole
_TOP = QModelIndex()  # the parent of all rows
_LEFT, _RIGHT = (
    side | Qt.AlignmentFlag.AlignVCenter
    for side in (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight)
)
_MARK_ROOM = 4 * "\N{NO-BREAK SPACE}"
_BESIDE = 12  # pixels between a text and the secondary text after it
_INDENT_BELOW = 3 * "\N{NO-BREAK SPACE}"  # precedes the second line of a row
_HIGHEST = 200  # pixels: maximum height of a second line that is wrapped
_END = Qt.TextElideMode.ElideRight
_MOST = 500  # maximum number of letters in a cell, because the layout of millions takes minutes
_FEW = 64  # maximum number of rows to add or remove one by one; for more, the table is reset


@dataclass(frozen=True)
class TableRow:
    """The texts, colours and tool tips of a table row.

    Attributes
    ----------
    texts
        The text of each column.
    sort
        The value of each column for sorting the rows, or () to sort by the texts.
    colours
        The text colours '#rrggbb', keyed by column.
    tips
        One tool tip for all columns, or one tool tip per column.
    tick
        The state of the check box in the first column, or None for no check box.
    secondary
        Secondary text after the text of the first column. A SecondaryTextDelegate draws it.
    spoken
        The screen-reader text of cells that show symbols, bars or no text, keyed by column.
    left
        The columns that are aligned to the left in this row, even if the model aligns them to the
        right.
    below
        The text of a second line across all columns, and shorter forms of it. A TwoLineDelegate
        draws the first form that fits into one line, or the last one in several lines.
    lead
        The text of the first column in a row with a second line.
    """

    texts: tuple[str, ...]
    sort: tuple[Any, ...] = ()
    colours: Mapping[int, str] = field(default_factory=dict)
    tips: tuple[str, ...] = ()
    tick: bool | None = None
    secondary: str = ""
    spoken: Mapping[int, str] = field(default_factory=dict)
    left: tuple[int, ...] = ()
    below: tuple[str, ...] = ()
    lead: str = ""


class RowModel(QAbstractTableModel, Generic[_Thing]):
    """A table model with one row per object in `things`. Subclasses define `key` and `describe`.

    A row is not redrawn if its object equals the previous object with the same key. The objects
    must therefore be immutable, and must compare equal only if their rows look the same.
    """

    heads: tuple[str, ...] = ()
    head_tips: tuple[str, ...] = ()
    right: Collection[int] = ()  # columns whose texts are aligned to the right
    middle: Collection[int] = ()  # columns of long names, which are shortened in the middle

    def __init__(self, colours: Colours) -> None:
        super().__init__()
        self._colours = colours
        colours.changed.connect(self.redraw)
        self.things: Sequence[_Thing] = ()
        self._keys: list[Hashable] = []
        self._rows: dict[Hashable, TableRow] = {}

    def key(self, thing: _Thing) -> Hashable:
        """Return the key that identifies the row of an object."""
        raise NotImplementedError

    def describe(self, thing: _Thing) -> TableRow:
        """Return the texts, colours and tool tips for an object. Called only for visible rows."""
        raise NotImplementedError

    # -- change -------------------------------------------------------------------------------

    def show(self, things: Sequence[_Thing]) -> None:
        """Show a row for each object in `things`, and redraw only changed rows."""
        keys = [self.key(t) for t in things]
        if keys != self._keys:
            self._change_rows(things, keys)
        else:
            before, self.things = self.things, things
            changed = [k for k, (a, b) in enumerate(zip(before, things, strict=True)) if a != b]
            for row in changed:
                self._rows.pop(keys[row], None)
            spans = [(row, row) for row in changed]
            for first, last in [(changed[0], changed[-1])] if len(changed) > _FEW else spans:
                self.dataChanged.emit(self.index(first, 0), self._last(last))

    def reset_rows(self, things: Sequence[_Thing]) -> None:
        """Discard all rows and show new ones, for example when the headings change."""
        self.beginResetModel()
        self.things, self._keys = things, [self.key(t) for t in things]
        self._rows.clear()
        self.endResetModel()

    @property
    def theme(self) -> Theme:
        """The current theme."""
        return self._colours.theme

    def redraw(self) -> None:
        """Redraw all rows, for example after the theme or the frame numbering has changed."""
        self._rows.clear()
        if self.things:
            self.dataChanged.emit(self.index(0, 0), self._last(len(self.things) - 1))

    def _change_rows(self, things: Sequence[_Thing], keys: list[Hashable]) -> None:
        new, old = set(keys), set(self._keys)
        if new == old:
            self._reorder(things, keys)
            return
        gone = [row for row, key in enumerate(self._keys) if key not in new]
        come = [row for row, key in enumerate(keys) if key not in old]
        stay = [key for key in self._keys if key in new]
        if len(gone) + len(come) > _FEW or stay != [key for key in keys if key in old]:
            self.reset_rows(things)
            return
        left = list(self.things)
        for row in reversed(gone):
            self.beginRemoveRows(QModelIndex(), row, row)
            del left[row]
            self._rows.pop(self._keys.pop(row), None)
            self.things = left
            self.endRemoveRows()
        for row in come:
            self.beginInsertRows(QModelIndex(), row, row)
            left.insert(row, things[row])
            self._keys.insert(row, keys[row])
            self.things = left
            self.endInsertRows()
        self.show(things)

    def _reorder(self, things: Sequence[_Thing], keys: list[Hashable]) -> None:
        """Show the same objects in a different order, without losing the selection."""
        self.layoutAboutToBeChanged.emit()
        old, before = self.persistentIndexList(), self._keys
        self.things, self._keys = things, keys
        self._rows.clear()
        place = {key: row for row, key in enumerate(keys)}
        new = [self.index(place[before[i.row()]], i.column()) for i in old]
        self.changePersistentIndexList(old, new)
        self.layoutChanged.emit()

    def _last(self, row: int) -> QModelIndex:
        return self.index(row, len(self.heads) - 1)

    # -- Qt -----------------------------------------------------------------------------------

    def row(self, row: int) -> TableRow:
        """Return the description of the row with this number."""
        return self.row_for(self.things[row])

    def row_for(self, thing: _Thing) -> TableRow:
        """Return the description of the row for an object in the table."""
        key = self.key(thing)
        if key not in self._rows:
            self._rows[key] = self.describe(thing)
        return self._rows[key]

    def row_of(self, key: Hashable) -> int | None:
        """Return the number of the row with this key, or None if there is no such row."""
        return self._keys.index(key) if key in self._keys else None

    def rowCount(self, parent: Index = _TOP) -> int:
        """Return the number of rows. Rows have no children."""
        return 0 if parent.isValid() else len(self.things)

    def columnCount(self, parent: Index = _TOP) -> int:
        """Return the number of columns. Rows have no children."""
        return 0 if parent.isValid() else len(self.heads)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        """Return the text, the tool tip or the alignment of a heading."""
        if orientation == Qt.Orientation.Horizontal:
            if role == Qt.ItemDataRole.DisplayRole:
                return escape_control_characters(self.heads[section], lines=True)
            if role == Qt.ItemDataRole.ToolTipRole and self.head_tips:
                return escape_tool_tip_text(self.head_tips[section])
            if role == Qt.ItemDataRole.TextAlignmentRole:
                return self.alignment(section)
        return None

    def data(self, index: Index, role: int = 0) -> Any:
        """Return the data of a cell from the description of its row."""
        if not index.isValid():
            return None
        column = index.column()
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return self.alignment(column)
        if role == Qt.ItemDataRole.DisplayRole:
            return escape_control_characters(self.row(index.row()).texts[column], most=_MOST)
        if role == Qt.ItemDataRole.ForegroundRole:
            colour = self.row(index.row()).colours.get(column)
            return None if colour is None else QColor(colour)
        if role == Qt.ItemDataRole.CheckStateRole and column == 0:
            tick = self.row(index.row()).tick
            return None if tick is None else _tick(tick)
        if role == Qt.ItemDataRole.ToolTipRole:
            tips = self.row(index.row()).tips
            return escape_tool_tip_text(tips[column % len(tips)]) if tips else None
        if role == Qt.ItemDataRole.AccessibleTextRole:
            return escape_control_characters(self.spoken(index.row(), column), most=_MOST)
        if role == SORT_ROLE:
            row = self.row(index.row())
            return (row.sort or row.texts)[column]
        return None

    def spoken(self, row: int, column: int) -> str:
        """Return the screen-reader text of a cell."""
        shown = self.row(row)
        secondary = shown.secondary if column == 0 else ""
        return shown.spoken.get(column) or ", ".join(filter(None, (shown.texts[column], secondary)))

    def alignment(self, column: int) -> Qt.AlignmentFlag:
        """Return the alignment of a column."""
        return _RIGHT if column in self.right else _LEFT


class RowTable(QTableView):
    """A table with headings and without a grid.

    The height of a row is the height of a line of text plus `room` pixels.
    """

    resized = Signal()

    def __init__(self, model: QAbstractItemModel, *, several: bool = False, room: int = 8) -> None:
        """Build the table. `several` is True if the user can select several rows."""
        super().__init__(showGrid=False, wordWrap=False)
        mode = QAbstractItemView.SelectionMode
        self.setHorizontalHeader(_Heading(Qt.Orientation.Horizontal, self))
        self.setTabKeyNavigation(False)  # Tab goes to the next widget, not to the next cell
        self.setModel(model)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(mode.ExtendedSelection if several else mode.SingleSelection)
        self.verticalHeader().hide()
        self._has_numbers = False
        self.set_room(room)
        self._first, self._spared = 0, tuple[int, ...]()
        self._widths: dict[int, int] = {}  # widths of columns, including hidden ones

    def set_room(self, room: int) -> None:
        """Set the height of a row, as the number of pixels in addition to a line of text."""
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + room)

    def set_line_below(self, row: int, forms: Sequence[str]) -> None:
        """Give a row a second line across all columns, or remove this line if there are no forms.

        `forms` contains the text of the line and its shorter forms.
        """
        usual = height = self.verticalHeader().defaultSectionSize()
        if forms:
            self.setSpan(row, 0, 1, self.model().columnCount())
            width = self.viewport().width() - self.indent_below
            metrics = self.fontMetrics()
            text = form_that_fits(forms, metrics.horizontalAdvance, width)
            room = QRect(0, 0, width, _HIGHEST)
            lines = metrics.boundingRect(room, Qt.TextFlag.TextWordWrap, text).height()
            height = usual + min(lines, _HIGHEST)
        if self.rowHeight(row) != height:
            self.setRowHeight(row, height)

    @property
    def indent_below(self) -> int:
        """The width, in pixels, to the left and right of a second line, without its text."""
        return self.fontMetrics().horizontalAdvance(_INDENT_BELOW) + 2 * self.text_margin

    @property
    def text_margin(self) -> int:
        """The width, in pixels, on either side of the text in a cell."""
        return self.style().pixelMetric(QStyle.PixelMetric.PM_FocusFrameHMargin, None, self) + 1

    def show_numbers(self) -> None:
        """Show the row numbers of the model at the left edge."""
        numbers = self.verticalHeader()
        numbers.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        numbers.setHighlightSections(False)
        numbers.setSectionsClickable(False)
        numbers.setDefaultAlignment(_RIGHT)
        numbers.setMinimumWidth(numbers.fontMetrics().horizontalAdvance("00") + _BESIDE)
        numbers.show()
        self._has_numbers = True

    @property
    def numbers_width(self) -> int:
        """The width, in pixels, that the row numbers need, or 0 if the table has none."""
        numbers = self.verticalHeader()
        needs = max(numbers.sizeHint().width(), numbers.minimumWidth())
        return needs if self._has_numbers else 0

    def keep_room(self, first: int, spared: Sequence[int]) -> None:
        """Hide columns if the first column would be narrower than `first` pixels.

        The columns in `spared` are hidden one by one, in this order, until the first column is wide
        enough. The first column fills the remaining width of the table.
        """
        self._first, self._spared = first, tuple(spared)
        self._hide_spared()

    def _hide_spared(self) -> None:
        room = self.viewport().width() - self._first
        left = sum(self._width_of(k) for k in range(1, self.horizontalHeader().count()))
        for column in self._spared:
            self.setColumnHidden(column, left > room)
            left -= self._width_of(column) if left > room else 0

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Hide columns if the first column would become too narrow."""
        if self._spared:
            self._hide_spared()
        super().resizeEvent(event)
        self.resized.emit()

    def _width_of(self, column: int) -> int:
        """Return the width of a column, even if it is hidden."""
        return self._widths.setdefault(column, self.columnWidth(column))

    @property
    def mark_room(self) -> int:
        """The width, in pixels, that the sort indicator needs in a heading."""
        return self.fontMetrics().horizontalAdvance(_MARK_ROOM)


class _Heading(QHeaderView):
    """A header that reserves space for the sort indicator next to right-aligned headings.

    By default, Qt draws the indicator over these headings.
    """

    def __init__(self, orientation: Qt.Orientation, parent: QTableView) -> None:
        super().__init__(orientation, parent)
        self.setSectionsClickable(True)

    def initStyleOptionForIndex(self, option: QStyleOptionHeader, section: int) -> None:
        """Add space for the sort indicator after a right-aligned heading."""
        super().initStyleOptionForIndex(option, section)
        marked = self.isSortIndicatorShown() and self.sortIndicatorSection() == section
        if marked and option.textAlignment & Qt.AlignmentFlag.AlignRight:
            option.text = "\n".join(line + _MARK_ROOM for line in option.text.split("\n"))


class RowDelegate(QStyledItemDelegate):
    """A delegate that draws cells from the row descriptions of a model.

    It calls the model once per cell. Qt's delegate would call the model seven times. `proxy` is the
    table's proxy model, or None if the table shows the model directly.
    """

    def __init__(
        self, model: RowModel[Any], parent: QObject, proxy: QAbstractProxyModel | None = None
    ) -> None:
        super().__init__(parent)
        self._model, self._proxy = model, proxy

    def described(self, index: Index) -> TableRow:
        """Return the description of the row that contains a cell."""
        source = self._proxy.mapToSource(index) if self._proxy else index
        return self._model.row(source.row())

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        """Set the properties of a cell from the description of its row.

        Qt's delegate would call `data` for each property instead.
        """
        row, column = self.described(index), index.column()
        assert isinstance(index, QModelIndex)
        option.index = index
        option.displayAlignment = _LEFT if column in row.left else self._model.alignment(column)
        option.text = row.texts[column]
        if column in self._model.middle:
            option.textElideMode = Qt.TextElideMode.ElideMiddle
        option.features |= _Feature.HasDisplay
        if (colour := row.colours.get(column)) is not None:
            option.palette.setColor(QPalette.ColorRole.Text, QColor(colour))
        if column == 0 and row.tick is not None:
            option.features |= _Feature.HasCheckIndicator
            option.checkState = _tick(row.tick)


class TwoLineDelegate(RowDelegate):
    """A delegate that draws a second line below the cells of rows that span all columns.

    :meth:`RowTable.set_line_below` lets a row span all columns.
    """

    def __init__(
        self, model: RowModel[Any], table: RowTable, proxy: QAbstractProxyModel | None = None
    ) -> None:
        super().__init__(model, table, proxy)
        self._table = table

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw the cell or, if it spans all columns, both lines of the row."""
        row, table = self.described(index), self._table
        if not row.below or table.columnSpan(index.row(), 0) == 1:
            super().paint(painter, option, index)
            return
        high, whole = table.verticalHeader().defaultSectionSize(), option.rect
        self._draw(painter, option, index, "", whole)
        lead = table.columnViewportPosition(0)
        for column in range(index.model().columnCount()):
            if table.isColumnHidden(column) or not row.texts[column] or column in row.left:
                continue
            text = row.lead if column == 0 else row.texts[column]
            left = whole.left() + table.columnViewportPosition(column) - lead
            cell = QRect(left, whole.top(), table.columnWidth(column), high)
            self._draw(painter, option, index.model().index(index.row(), column), text, cell)
        indent = table.fontMetrics().horizontalAdvance(_INDENT_BELOW)
        width = min(whole.width(), table.viewport().width()) - indent
        letters = option.fontMetrics
        text = form_that_fits(row.below, letters.horizontalAdvance, width - 2 * table.text_margin)
        gap = (high - letters.height()) // 2
        below = QRect(whole.left() + indent, whole.top() + high - gap, width, whole.height() - high)
        self._draw(painter, option, index, text, below)

    def _draw(
        self, painter: QPainter, option: QStyleOptionViewItem, index: Index, text: str, room: QRect
    ) -> None:
        """Draw a text of a row in `room`, with the background of the row."""
        part = QStyleOptionViewItem(option)
        self.initStyleOption(part, index)
        part.rect, part.text = room, text
        if index.column() == 0 and text in self.described(index).below:
            part.features |= _Feature.WrapText
            part.textElideMode = Qt.TextElideMode.ElideNone
            part.displayAlignment = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop
        style = self._table.style()
        style.drawControl(QStyle.ControlElement.CE_ItemViewItem, part, painter, self._table)


class SecondaryTextDelegate(RowDelegate):
    """A delegate that draws secondary text, if it fits, after the text of the first column."""

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw the cell and, if the row has one, its secondary text."""
        super().paint(painter, option, index)
        row = self.described(index)
        if not row.secondary:
            return
        option = QStyleOptionViewItem(option)
        self.initStyleOption(option, index)
        style = option.widget.style()
        room = style.subElementRect(
            QStyle.SubElement.SE_ItemViewItemText, option, option.widget
        ).adjusted(0, 0, -_BESIDE // 2, 0)
        room.setLeft(room.left() + option.fontMetrics.horizontalAdvance(row.texts[0]) + _BESIDE)
        if room.width() < _BESIDE:
            return
        selected = bool(option.state & QStyle.StateFlag.State_Selected)
        ink = QPalette.ColorRole.HighlightedText if selected else QPalette.ColorRole.PlaceholderText
        painter.save()
        painter.setPen(option.palette.color(ink))
        text = option.fontMetrics.elidedText(row.secondary, _END, room.width())
        painter.drawText(room, _LEFT, text)
        painter.restore()


def _tick(on: bool) -> Qt.CheckState:
    return Qt.CheckState.Checked if on else Qt.CheckState.Unchecked
