"""The panes below each other, in columns where height is short; or a hint in their place."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from PySide6.QtCore import Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QGridLayout, QStackedWidget, QWidget

from inspector.timeline.pane import Pane
from inspector.timeline.plot import Plot
from inspector.widgets.building import hint

_ROW, _COLUMN = 88, 440  # pixels that a pane needs to be read


class PaneGrid(QStackedWidget):
    """`panes` from top to bottom, by key; `shown`: the keys of those that are seen.

    They are those that a person wants of those that mean something for what is selected, as many as
    there is room for; or the one that a person wants to see alone.
    """

    arranged = Signal()  # others are seen, or elsewhere

    def __init__(
        self, panes: Mapping[str, Pane], plots: Mapping[str, Plot], parent: QWidget | None = None
    ) -> None:
        """`plots`: what the panes are, by the same keys."""
        super().__init__(parent)
        self._panes, self._plots = panes, plots
        self._wanted = frozenset(key for key, plot in plots.items() if plot.at_first)
        self._kept = sorted(plots, key=lambda key: plots[key].priority)  # where room is short
        self._meant = frozenset(panes)
        self._alone = ""
        self.shown: list[str] = []
        self._columns = 0
        self._told: list[str] = []  # what was wanted when it was last said that they changed
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
        """Words instead of the panes."""
        self.hint.setText(text)
        self.setCurrentIndex(1)

    @property
    def wanted(self) -> list[str]:
        """The keys of the panes that are wanted and mean something, from top to bottom."""
        return [k for k in self._panes if k in self._wanted & self._meant]

    @property
    def alone(self) -> bool:
        """Whether one is seen alone by a person's wish."""
        return self._alone in self.wanted

    def show_panes(self, meant: Collection[str]) -> None:
        """The panes again, those that mean something."""
        self._meant = frozenset(meant)
        self.arrange()
        self.setCurrentIndex(0)

    def show_pane(self, key: str, *, shown: bool) -> None:
        """Show or hide one of them."""
        self._wanted = self._wanted | {key} if shown else self._wanted - {key}
        self._alone = ""
        self.arrange()

    def enlarge(self, key: str = "") -> None:
        """Show one of them alone, that under the mouse if none is named; or all again."""
        under = (k for k in self.shown if self._panes[k].underMouse())
        chosen = key or next(under, next((k for k in self._kept if k in self.shown), ""))
        self._alone = "" if self.alone else chosen
        self.arrange()

    def height_for(self, width: float) -> float:
        """Pixels that all that are wanted need to be read, on such a width."""
        count = 1 if self.alone else len(self.wanted)
        return _ROW * float(-(-count // max(1, int(width / _COLUMN))))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """More or less room may change the number of columns."""
        super().resizeEvent(event)
        self.arrange()

    def arrange(self) -> None:
        """As few columns as there is height for; where width is short too, fewer panes."""
        wanted = [self._alone] if self.alone else self.wanted
        scale = max((pane.scenery.scale for pane in self._panes.values()), default=1.0)
        rows = max(1, int(self.height() / (_ROW * scale)))
        most = max(1, int(self.width() / (_COLUMN * scale)))
        kept = [k for k in self._kept if k in wanted][: rows * most]
        shown = [k for k in wanted if k in kept]
        columns = max(1, -(-len(shown) // rows))
        if (columns, shown, self.wanted) != (self._columns, self.shown, self._told):
            self._columns, self.shown, self._told = columns, shown, self.wanted
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
            # An odd one goes to the right: the detectors stay together.
            count = len(rest) // (self._columns - column)
            for row, key in enumerate(rest[:count]):
                last = row == count - 1
                self._grid.addWidget(self._panes[key], row, column, rows - row if last else 1, 1)
                self._grid.setRowStretch(
                    row, max(self._grid.rowStretch(row), self._plots[key].weight)
                )
                self._panes[key].set_bottom(shown=last)
            rest = rest[count:]
