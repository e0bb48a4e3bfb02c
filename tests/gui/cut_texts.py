"""Which texts of the window are cut, or end with '…'."""

from collections.abc import Iterator

from PySide6.QtCore import QRect, Qt
from PySide6.QtWidgets import QStyle, QStyleOptionViewItem, QTabBar, QTableView, QToolButton

from inspector.widgets.tables import RowDelegate, RowTable
from inspector.widgets.text_forms import form_that_fits

_HIGH = 1000  # pixels: more than any text needs


def cut_cells(table: QTableView) -> Iterator[str]:
    """Yield the texts that do not fit into their cells, by what the table's delegate draws."""
    model = table.model()
    shown = [c for c in range(model.columnCount()) if not table.isColumnHidden(c)]
    for row in range(model.rowCount()):
        delegate = table.itemDelegate()
        described = isinstance(delegate, RowDelegate) and delegate.described(model.index(row, 0))
        if described and described.below and table.columnSpan(row, 0) > 1:
            yield from _cut_in_two_lines(table, row, described, shown)
            continue
        spans = [k for k in shown if table.columnSpan(row, k) > 1]
        for column in shown:
            if spans and column > spans[0]:
                continue
            index, option = model.index(row, column), QStyleOptionViewItem()
            table.initViewItemOption(option)
            option.rect = table.visualRect(index)
            table.itemDelegateForIndex(index).initStyleOption(option, index)
            part = QStyle.SubElement.SE_ItemViewItemText
            room = table.style().subElementRect(part, option, table).width()
            needed = option.fontMetrics.horizontalAdvance(option.text)
            if option.text and needed > room - 2 * _margin(table):
                yield option.text


def _cut_in_two_lines(table: RowTable, row: int, described, shown: list[int]) -> Iterator[str]:
    letters = table.fontMetrics()
    for column in shown:
        text = described.lead if column == 0 else described.texts[column]
        room = table.columnWidth(column) - 2 * _margin(table)
        if column not in described.left and letters.horizontalAdvance(text) > room:
            yield text
    width = table.viewport().width() - table.indent_below
    text = form_that_fits(described.below, letters.horizontalAdvance, width)
    needed = letters.boundingRect(QRect(0, 0, width, _HIGH), Qt.TextFlag.TextWordWrap, text)
    second_line = table.rowHeight(row) - table.verticalHeader().defaultSectionSize()
    if needed.height() > second_line or needed.width() > width:
        yield text


def _margin(table: QTableView) -> int:
    return table.style().pixelMetric(QStyle.PixelMetric.PM_FocusFrameHMargin, None, table) + 1


def cut_tabs(bar: QTabBar) -> Iterator[str]:
    """Yield the texts of tabs that are cut, or that are only seen after scrolling."""
    for button in bar.findChildren(QToolButton):
        if button.isVisible():
            yield from (bar.tabText(k) for k in range(bar.count()))
            return
    for k in range(bar.count()):
        text = bar.tabText(k).replace("&", "")
        seen = bar.tabRect(k).intersected(bar.rect())
        if bar.isTabVisible(k) and bar.fontMetrics().horizontalAdvance(text) > seen.width():
            yield text
