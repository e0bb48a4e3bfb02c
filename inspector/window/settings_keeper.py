"""Write changed settings to disk within a second, so that they survive a crash."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from inspector.session.settings import Settings, save_changes

_LOOK_MS = 450  # a change that stays the same for two looks is written, within a second


class SettingsKeeper(QObject):
    """Checks the settings regularly, and writes the ones that have changed."""

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
            Function that returns the geometry and layout of the window, or None while they must not
            be saved.
        tell
            Function that shows a message, called once if writing fails.
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
            self._seen = deepcopy(self._settings)  # still changing, for example in a drag
        else:
            self.write()

    def _note_layout(self) -> None:
        if (looks := self._look()) is None:
            return
        for name, now in zip(("geometry", "layout"), looks, strict=True):
            if not self._began and getattr(self._settings, name):
                setattr(self._written, name, now)  # adapted to the screen, not by the person
            setattr(self._settings, name, now)
        self._began = True

    def write(self) -> str:
        """Write the settings that have changed; return an error message, or '' on success."""
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
        """Write for the last time, because the window closes; return an error message, or ''."""
        self._timer.stop()
        self._note_layout()
        self._tell = lambda _: None
        return self.write()
