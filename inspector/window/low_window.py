"""A low window, as of a laptop at 200 %: what only frames is smaller, or away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

_LOW = 640  # pixels of a window's height
_STYLE = """
QDockWidget::title { padding: 2px 8px; }
QToolBar { padding: 0 6px; }
QToolBar QToolButton { padding: 1px 5px; }
QTabBar::tab { padding: 2px 11px; }
QHeaderView::section { padding: 2px 4px; }
"""
_REASONS = "title_away"  # a dock's property: who wants it without its title


class Compact(Protocol):
    """What can do with less height."""

    def set_low(self, low: bool) -> None:
        """There is little height, or enough again."""


class LowWindow:
    """Follows the height of the window."""

    def __init__(
        self, window: QMainWindow, docks: Mapping[str, QDockWidget], parts: Sequence[Compact]
    ) -> None:
        """`parts`: what can do with less height."""
        self._window, self._docks, self._parts = window, docks, parts
        self.low = False
        # Once a change is through: in the midst of it a dock still has the neighbours it had.
        self._soon = QTimer(window, singleShot=True, interval=0)
        self._soon.timeout.connect(self._name_docks)
        for dock in docks.values():
            for changed in (dock.topLevelChanged, dock.dockLocationChanged, dock.visibilityChanged):
                changed.connect(lambda _: self._soon.start())

    def follow(self) -> None:
        """The window has a size."""
        low = self._window.height() < _LOW
        if low == self.low:
            return
        self.low = low
        self._window.setStyleSheet(_STYLE if low else "")
        for part in self._parts:
            part.set_low(low)
        self._name_docks()

    def _name_docks(self) -> None:
        """A dock behind a tab has its name on it: a title says it again."""
        for dock in self._docks.values():
            tabbed = not dock.isFloating() and bool(self._window.tabifiedDockWidgets(dock))
            show_title(dock, "low", shown=not (self.low and tabbed))


def is_seen(dock: QDockWidget) -> bool:
    """Whether it is in sight: behind another's tab it is 'visible', too, but beside the window.

    Its visible region does not tell: what it holds may cover all of it.
    """
    within = dock.window().rect().intersects(dock.geometry())
    return dock.isVisible() and (dock.isFloating() or within)


def show_title(dock: QDockWidget, by: str, *, shown: bool) -> None:
    """Show a dock's title or take it away; it is away while anybody wants it to be."""
    before = frozenset(dock.property(_REASONS) or ())
    reasons = before - {by} if shown else before | {by}
    if reasons == before:
        return
    dock.setProperty(_REASONS, sorted(reasons))
    if bool(reasons) != bool(before):
        title = dock.titleBarWidget()
        dock.setTitleBarWidget(QWidget() if reasons else None)  # type: ignore[arg-type]  # its stubs know no None
        if title is not None:
            title.deleteLater()
