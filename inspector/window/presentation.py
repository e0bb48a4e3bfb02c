"""The presentation mode for a lecture hall, with large text and few panels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from PySide6.QtCore import QByteArray, Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QDockWidget, QMainWindow, QScrollArea, QStatusBar, QToolBar, QWidget

from inspector.panels.reviewer_line import ReviewerLine
from inspector.timeline.timeline import Timeline
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import bring_to_front
from inspector.widgets.late_panel import LatePanel
from inspector.window.low_window import is_seen, show_title

_KEPT = ("curves", "teaching", "guide")  # docks that stay visible if they are visible
_SCALE = 1.7  # scale of text and lines
# The curves' share of the window's height, without and with a lesson
_CURVES_SHARE, _WITH_LESSON = 0.42, 0.33
_LESSON_SHARE = 0.27  # share of the window's width for the page of a lesson


@runtime_checkable
class Scaled(Protocol):
    """A widget whose text can be enlarged."""

    def set_scale(self, scale: float) -> None:
        """Scale the text; 1 is the normal size."""


class Presentation:
    """The presentation mode, which shows only the figure, transport, curves and lesson."""

    def __init__(
        self,
        window: QMainWindow,
        docks: Mapping[str, QDockWidget],
        viewport: Viewport,
        timeline: Timeline,
    ) -> None:
        """Prepare the presentation mode. `docks` are the window's docks, keyed by object name."""
        self._window, self._docks = window, docks
        self._viewport, self._timeline = viewport, timeline
        self._layout: QByteArray | None = None
        self._full = False
        self._shown: dict[str, bool] = {}  # for the docks that a lesson shows and hides
        self._escape = QShortcut(QKeySequence(Qt.Key.Key_Escape), window)
        # A floating dock is a separate window, in which Esc must also end the presentation.
        self._escape.setContext(Qt.ShortcutContext.ApplicationShortcut)
        self._escape.setEnabled(False)
        self.escaped = self._escape.activated

    def enter(self) -> None:
        """Enlarge the text, hide the other panels and switch to full screen."""
        if self._layout is not None:
            return
        window = self._window
        self._layout, self._full = window.saveState(), window.isFullScreen()
        for name, dock in self._docks.items():
            if name not in _KEPT or not is_seen(dock):
                dock.hide()
        self._shown = self._shown_docks()
        self._show_titles(shown=False)
        for kind in (QToolBar, QStatusBar, ReviewerLine):
            for bar in window.findChildren(kind):
                bar.hide()
        window.menuBar().hide()
        self._scale(_SCALE)
        self._escape.setEnabled(True)
        self.set_full_screen(True)
        lesson = is_seen(self._docks["guide"])
        height = round((_WITH_LESSON if lesson else _CURVES_SHARE) * window.height())
        window.resizeDocks([self._docks["curves"]], [height], Qt.Orientation.Vertical)
        if lesson:
            width = round(_LESSON_SHARE * window.width())
            window.resizeDocks([self._docks["guide"]], [width], Qt.Orientation.Horizontal)

    def leave(self) -> None:
        """End the presentation, and restore the window."""
        if self._layout is None:
            return
        window, layout = self._window, self._layout
        self._layout = None
        before, now = self._shown, self._shown_docks()
        self._scale(1.0)
        self._escape.setEnabled(False)
        self._show_titles(shown=True)
        window.menuBar().show()
        window.statusBar().show()
        window.statusBar().clearMessage()  # Qt would draw it on top of the frame
        self.set_full_screen(self._full)
        window.restoreState(layout)
        # A lesson may have begun, ended or opened a page with a different tab
        if now["guide"] != before["guide"]:
            self._docks["guide"].setVisible(now["guide"])
        if now["teaching"] != before["teaching"]:
            bring_to_front(self._docks["teaching" if now["teaching"] else "intervals"])

    def set_full_screen(self, on: bool) -> None:
        """Turn full screen on or off.

        When full screen ends, a window that was maximised before is maximised again.
        """
        full, now = Qt.WindowState.WindowFullScreen, self._window.windowState()
        self._window.setWindowState(now | full if on else now & ~full)

    def _shown_docks(self) -> dict[str, bool]:
        """Return whether each dock that a lesson controls is visible, keyed by name."""
        return {name: not self._docks[name].isHidden() for name in ("teaching", "guide")}

    def _show_titles(self, *, shown: bool) -> None:
        """Show or hide the titles of the docks that remain visible."""
        for name in _KEPT:
            show_title(self._docks[name], "presentation", shown=shown)

    def _scale(self, scale: float) -> None:
        for part in (self._viewport, self._timeline, *map(self._content, _KEPT)):
            if isinstance(part, Scaled):
                part.set_scale(scale)

    def _content(self, name: str) -> QWidget | None:
        """Return the content of the dock with this name, without its scroll area."""
        shown = self._docks[name].widget()
        if isinstance(shown, LatePanel):
            shown.build()
        return shown.widget() if isinstance(shown, QScrollArea) else shown
