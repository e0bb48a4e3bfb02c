"""The layout for low windows, for example on a laptop at 200 % scaling.

This layout has fewer titles and smaller margins.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

_LOW = 640  # windows with fewer pixels of height are low
_STYLE = """
QDockWidget::title { padding: 2px 8px; }
QToolBar QToolButton { padding: 1px 5px; }
QTabBar::tab { padding: 2px 7px; }
QHeaderView::section { padding: 2px 4px; }
"""
_REASONS = "title_away"  # property of a dock: the parts of the program that hide its title


class Compact(Protocol):
    """A widget with a second layout for low windows."""

    def set_low(self, low: bool) -> None:
        """Switch to the layout for low windows, or back to the normal one."""


class LowWindow:
    """Switches the window and its parts between the normal layout and the low one."""

    def __init__(
        self, window: QMainWindow, docks: Mapping[str, QDockWidget], parts: Sequence[Compact]
    ) -> None:
        """Prepare both layouts. The normal layout is in use initially.

        `parts` are the widgets that have a second layout for low windows.
        """
        self._window, self._docks, self._parts = window, docks, parts
        self.low = False
        # Wait until the change is over, because during it a dock still has its old neighbours.
        self._soon = QTimer(window, singleShot=True, interval=0)
        self._soon.timeout.connect(self._name_docks)
        for dock in docks.values():
            for changed in (dock.topLevelChanged, dock.dockLocationChanged, dock.visibilityChanged):
                changed.connect(lambda _: self._soon.start())

    def follow(self) -> None:
        """Use the layout that fits the current height of the window."""
        low = self._window.height() < _LOW
        if low == self.low:
            return
        self.low = low
        self._window.setStyleSheet(_STYLE if low else "")
        for part in self._parts:
            part.set_low(low)
        self._name_docks()

    def _name_docks(self) -> None:
        """In a low window, hide the titles of tabbed docks, because the tabs already show them."""
        for dock in self._docks.values():
            tabbed = not dock.isFloating() and bool(self._window.tabifiedDockWidgets(dock))
            show_title(dock, "low", shown=not (self.low and tabbed))


def is_seen(dock: QDockWidget) -> bool:
    """Return True if a dock is visible on the screen.

    `isVisible` is not enough, because Qt also reports docks behind other tabs as visible. Such
    docks are positioned outside the window. The visible region cannot be used either, because the
    dock's content may cover it completely.
    """
    within = dock.window().rect().intersects(dock.geometry())
    return dock.isVisible() and (dock.isFloating() or within)


def show_title(dock: QDockWidget, by: str, *, shown: bool) -> None:
    """Show or hide the title of a dock on behalf of one part of the program.

    `by` is the name of that part. The title is visible only if no part of the program hides it.
    """
    before = frozenset(dock.property(_REASONS) or ())
    reasons = before - {by} if shown else before | {by}
    if reasons == before:
        return
    dock.setProperty(_REASONS, sorted(reasons))
    if bool(reasons) != bool(before):
        title = dock.titleBarWidget()
        dock.setTitleBarWidget(QWidget() if reasons else None)  # type: ignore[arg-type]  # the stubs lack None
        if title is not None:
            title.deleteLater()
