"""A grid of panes. It has several columns if a single column would be too tall."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from PySide6.QtCore import Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QGridLayout, QStackedWidget, QWidget

from inspector.timeline.pane import Pane
from inspector.timeline.plot import Plot
from inspector.widgets.building import hint

_ROW, _COLUMN = 88, 440  # height and width, in pixels, that a pane needs to be readable
_NARROW = 280  # width, in pixels, of each of two panes if there is no room for two normal columns


class PaneGrid(QStackedWidget):
    """A widget that shows either the panes from top to bottom or a hint.

    Attributes
    ----------
    shown
        The keys of the visible panes. This is the enlarged pane or, if no pane is enlarged, those
        panes that the user has chosen, that apply to the selection, and for which there is space.
    """

    arranged = Signal()  # a pane was shown, hidden or moved

    def __init__(
        self, panes: Mapping[str, Pane], plots: Mapping[str, Plot], parent: QWidget | None = None
    ) -> None:
        """Create the grid. `plots` contains the description of each pane, keyed like `panes`."""
        super().__init__(parent)
        self._panes, self._plots = panes, plots
        self._chosen = frozenset(key for key, plot in plots.items() if plot.at_first)
        # keys of the panes, the most important first
        self._kept = sorted(plots, key=lambda key: plots[key].priority)
        self._applicable = frozenset(panes)
        self._alone = ""
        self.shown: list[str] = []
        self._columns = 0
        self._announced: list[str] = []  # keys of the chosen panes when `arranged` was last emitted
        page = QWidget(self)
        self._grid = QGridLayout(page)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(0)
        self.hint = hint()
        self.addWidget(page)
        self.addWidget(self.hint)
        for pane in panes.values():
            pane.hide()
            pane.enlarged.connect(lambda key=pane.key: self.enlarge(key))
        self.arrange()

    def show_hint(self, text: str) -> None:
        """Show a hint instead of the panes."""
        self.hint.setText(text)
        self.setCurrentIndex(1)

    @property
    def chosen(self) -> list[str]:
        """The keys of the panes that the user has chosen and that apply to the selection.

        The keys are ordered from top to bottom.
        """
        return [k for k in self._panes if k in self._chosen & self._applicable]

    @property
    def alone(self) -> bool:
        """True while one pane is enlarged."""
        return self._alone in self.chosen

    def show_panes(self, applicable: Collection[str]) -> None:
        """Hide the hint, and show the panes that the user has chosen and that apply.

        `applicable` contains the keys of the panes that apply to the selection.
        """
        self._applicable = frozenset(applicable)
        self.arrange()
        self.setCurrentIndex(0)

    def show_pane(self, key: str, *, shown: bool) -> None:
        """Show or hide a pane."""
        self._chosen = self._chosen | {key} if shown else self._chosen - {key}
        self._alone = ""
        self.arrange()

    def enlarge(self, key: str = "") -> None:
        """Enlarge a pane or, if a pane is already enlarged, show all panes.

        By default, the pane under the mouse is enlarged.
        """
        under = (k for k in self.shown if self._panes[k].underMouse())
        chosen = key or next(under, next((k for k in self._kept if k in self.shown), ""))
        self._alone = "" if self.alone else chosen
        self.arrange()

    def height_for(self, width: float) -> float:
        """Return the height, in pixels, that the panes need at a given width in pixels."""
        count = 1 if self.alone else len(self.chosen)
        return _ROW * float(-(-count // max(1, int(width / _COLUMN))))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Arrange the panes for the new size."""
        super().resizeEvent(event)
        self.arrange()

    def arrange(self) -> None:
        """Arrange the panes in as few columns as the height allows.

        If the widget is too narrow for these columns, fewer panes are shown.
        """
        wanted = [self._alone] if self.alone else self.chosen
        scale = max((pane.scenery.scale for pane in self._panes.values()), default=1.0)
        rows = max(1, int(self.height() / (_ROW * scale)))
        most = max(1, int(self.width() / (_COLUMN * scale)))
        if rows * most == 1 and self.width() >= 2 * _NARROW * scale:
            most = 2  # the angles and the strength belong together
        kept = [k for k in self._kept if k in wanted][: rows * most]
        shown = [k for k in wanted if k in kept]
        columns = max(1, -(-len(shown) // rows))
        if (columns, shown, self.chosen) != (self._columns, self.shown, self._announced):
            self._columns, self.shown, self._announced = columns, shown, self.chosen
            self._place()
            self.arranged.emit()

    def _place(self) -> None:
        for pane in self._panes.values():
            self._grid.removeWidget(pane)
            pane.setVisible(pane.key in self.shown)
        for at in range(max(self._grid.rowCount(), self._grid.columnCount(), self._columns)):
            self._grid.setRowStretch(at, 0)
            self._grid.setColumnStretch(at, int(at < self._columns))
        rest = self.shown
        rows = -(-len(rest) // self._columns)
        for column in range(self._columns):
            # With an odd number, the pane in a row of its own is on the right, so that the
            # detectors stay next to each other.
            count = len(rest) // (self._columns - column)
            for row, key in enumerate(rest[:count]):
                last = row == count - 1
                self._grid.addWidget(self._panes[key], row, column, rows - row if last else 1, 1)
                self._grid.setRowStretch(
                    row, max(self._grid.rowStretch(row), self._plots[key].weight)
                )
                self._panes[key].set_bottom(shown=last)
            rest = rest[count:]
