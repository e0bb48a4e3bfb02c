"""Ignore verdict keys that repeat or that are pressed too early.

A verdict key (accept or reject) takes effect only once per press, and only after the interval has
been painted. While a key is held down, Qt reports many automatic repeats as new presses, because
the next press may not have arrived when Qt handles the release. A repeat has the same time stamp as
the release before it; a real press has a later time stamp.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QAction, QGuiApplication, QKeyEvent, QWindow


class VerdictKeyFilter(QObject):
    """Ignores the keys of verdict actions until the selected interval is visible to the user.

    `is_drawn` is a function that returns True if the selected interval has been painted.
    """

    def __init__(
        self, actions: Iterable[QAction], is_drawn: Callable[[], bool], parent: QObject
    ) -> None:
        super().__init__(parent)
        self._is_drawn = is_drawn
        self._released = 0, 0  # the last released key and its time stamp in milliseconds
        self._repeats = False
        for action in actions:
            action.installEventFilter(self)
        app = QGuiApplication.instance()
        assert isinstance(app, QGuiApplication)
        app.focusWindowChanged.connect(self._watch)
        self._watch(QGuiApplication.focusWindow())

    def _watch(self, window: QWindow | None) -> None:
        if window is not None:
            window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Ignore a repeated key, and any key before the interval has been painted.

        Mouse clicks are never ignored, because they are slower than repeated keys.
        """
        if isinstance(event, QKeyEvent):
            press = event.key(), event.timestamp()
            if event.type() == QEvent.Type.KeyRelease:
                self._released = press
            elif event.type() == QEvent.Type.ShortcutOverride:
                self._repeats = event.isAutoRepeat() or press == self._released
            return False
        return event.type() == QEvent.Type.Shortcut and (self._repeats or not self._is_drawn())
