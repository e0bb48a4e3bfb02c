"""Save changed settings within a second, so that a crash does not lose them.

This module also remembers how the figure is drawn for each kind of error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from pathlib import Path

from PySide6.QtCore import QObject, QTimer
from PySide6.QtGui import QAction

from inspector.session.document import Document
from inspector.session.settings import Settings, save_changes

_LOOK_MS = 450  # a changed setting is written if two checks find the same value

_LOOKS = "skin", "side_by_side"


class KeptLooks(QObject):
    """Draws the figure in the way the user prefers for the selected interval's kind of error."""

    def __init__(
        self,
        document: Document,
        settings: Settings,
        actions: Mapping[str, QAction],
        is_busy: Callable[[], bool],
        parent: QObject,
    ) -> None:
        """Draw the figure in the way that the user chose last.

        `is_busy` is a function that returns True while a lesson or the teaching tab decides how to
        draw the figure.
        """
        super().__init__(parent)
        self._document, self._settings, self._is_busy = document, settings, is_busy
        self._actions = {look: actions[look] for look in _LOOKS}
        for look, action in self._actions.items():
            action.setChecked(settings.value(look))
            # Do not use `toggled`, because lessons switch both actions for a while.
            action.triggered.connect(lambda on, name=look: self._remember(name, on))
        document.interval_changed.connect(self._follow)

    def _remember(self, look: str, on: bool) -> None:
        self._settings.put(look, on)
        if (judged := self._document.interval) is not None and not self._is_busy():
            shown = [name for name, action in self._actions.items() if action.isChecked()]
            kept = self._settings.looks_by_kind
            self._settings.looks_by_kind = {**kept, str(judged.interval.kind): shown}

    def _follow(self) -> None:
        if (judged := self._document.interval) is None or self._is_busy():
            return
        last = [look for look in _LOOKS if self._settings.value(look)]
        shown = self._settings.looks_by_kind.get(str(judged.interval.kind), last)
        for look, action in self._actions.items():
            action.setChecked(look in shown)


class SettingsKeeper(QObject):
    """Checks the settings regularly, and writes changed settings to disk."""

    def __init__(
        self,
        settings: Settings,
        path: Path | None,
        look: Callable[[], tuple[str, str] | None],
        tell: Callable[[str], object],
        parent: QObject,
    ) -> None:
        """Start checking the settings.

        Parameters
        ----------
        path
            The file to write, or None to write nothing.
        look
            A function that returns the geometry and layout of the window, or None to save neither.
        tell
            A function that shows a message. It is called once if writing fails.
        """
        super().__init__(parent)
        self._settings, self._path, self._look, self._tell = settings, path, look, tell
        self._written = deepcopy(settings)  # the settings on disk or at the start
        self._seen = deepcopy(settings)
        self._began = False
        self._reported = ""
        self._timer = QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._compare)
        if path is not None:
            self._timer.start()

    def _compare(self) -> None:
        self._note_layout()
        if self._settings == self._written:
            return
        if self._settings != self._seen:
            # A value is still changing, for example in a drag
            self._seen = deepcopy(self._settings)
        else:
            self.write()

    def _note_layout(self) -> None:
        if (looks := self._look()) is None:
            return
        for name, now in zip(("geometry", "layout"), looks, strict=True):
            if not self._began and getattr(self._settings, name):
                setattr(self._written, name, now)  # changed by the program for this screen
            setattr(self._settings, name, now)
        self._began = True

    def write(self) -> str:
        """Write the changed settings. Return an error message, or '' on success."""
        if self._path is None or self._settings == self._written:
            return ""
        trouble = save_changes(self._path, self._settings, self._written)
        if not trouble:
            self._written = deepcopy(self._settings)
        elif trouble != self._reported:
            self._tell(trouble)
        self._reported = trouble
        return trouble

    def end(self) -> str:
        """Write the settings when the window closes. Return an error message, or '' on success."""
        self._timer.stop()
        self._note_layout()
        self._tell = lambda _: None
        return self.write()
