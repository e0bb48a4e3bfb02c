"""The panes below each other, in one column or two; or a hint in their place."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QGridLayout, QStackedWidget, QWidget

from inspector.timeline.pane import Pane
from inspector.widgets.building import hint

_WEIGHTS = {"theta": 4, "delta": 3, "height": 3, "strength": 4, "offset": 3, "other": 4}
_ROW = 88  # pixels that a pane needs before the panes go into two columns


class PaneGrid(QStackedWidget):
    """`panes` from top to bottom, by key; `shown`: the keys of those that are seen.

    They are those that a person wants of those that mean something for what is selected.
    """

    def __init__(
        self, panes: Mapping[str, Pane], shown: list[str], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._panes, self._wanted = panes, frozenset(shown)
        self._meant = frozenset(panes)
        self._arranged: tuple[int, tuple[str, ...]] | None = None
        page = QWidget(self)
        self._grid = QGridLayout(page)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(0)
        self.hint = hint()
        self.addWidget(page)
        self.addWidget(self.hint)
        self._arrange()

    def show_hint(self, text: str) -> None:
        """Words instead of the panes."""
        self.hint.setText(text)
        self.setCurrentIndex(1)

    @property
    def shown(self) -> list[str]:
        """The keys of the panes that are seen, from top to bottom."""
        return [k for k in self._panes if k in self._wanted & self._meant]

    def show_panes(self, meant: Collection[str]) -> None:
        """The panes again, those that mean something."""
        self._meant = frozenset(meant)
        self._arrange()
        self.setCurrentIndex(0)

    def show_pane(self, key: str, *, shown: bool) -> None:
        """Show or hide one of them."""
        self._wanted = self._wanted | {key} if shown else self._wanted - {key}
        self._arrange()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """More or less height may change the number of columns."""
        super().resizeEvent(event)
        self._arrange()

    def _arrange(self) -> None:
        """One column where there is height for it, else two."""
        shown = self.shown
        columns = 1 if len(shown) < 2 or self.height() >= _ROW * len(shown) else 2
        if (columns, tuple(shown)) == self._arranged:
            return
        self._arranged = (columns, tuple(shown))
        for pane in self._panes.values():
            self._grid.removeWidget(pane)
            pane.setVisible(pane.key in shown)
        left = len(shown) // columns  # an odd one goes to the right: the detectors stay together
        rows = len(shown) - left if columns == 2 else left
        for row in range(len(self._panes)):
            self._grid.setRowStretch(row, 0)
        for place, key in enumerate(shown):
            pane = self._panes[key]
            col = int(place >= left)
            row = place - left if col else place
            last = place in (left - 1, len(shown) - 1)
            span = rows - row if last else 1
            self._grid.addWidget(pane, row, col, span, 1)
            self._grid.setRowStretch(row, max(self._grid.rowStretch(row), _WEIGHTS[key]))
            pane.set_bottom(shown=last)
        for col in range(2):
            self._grid.setColumnStretch(col, 1 if col < columns else 0)
