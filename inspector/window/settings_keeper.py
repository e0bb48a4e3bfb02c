"""Settings are on disk a moment after they change, whatever becomes of the program then."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from inspector.session.settings import Settings, save_changes

_LOOK_MS = 450  # what has changed at one look and stands at the next is written: within a second


class SettingsKeeper(QObject):
    """Looks at the settings now and then, and writes what has changed in them."""

    def __init__(
        self,
        settings: Settings,
        path: Path | None,
        look: Callable[[], tuple[str, str] | None],
        tell: Callable[[str], object],
        parent: QObject,
    ) -> None:
        """path: where to write; None: nowhere.

        look: the window's geometry and layout now, None while they are not to be kept; tell: what
        is said, once, where the disk does not take them.
        """
        super().__init__(parent)
        self._settings, self._path, self._look, self._tell = settings, path, look, tell
        self._written = deepcopy(settings)  # as they are on disk, or were at the start
        self._seen = deepcopy(settings)
        self._began = False
        self._told = ""
        self._timer = QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._compare)
        if path is not None:
            self._timer.start()

    def _compare(self) -> None:
        self._note_layout()
        if self._settings == self._written:
            return
        if self._settings != self._seen:
            self._seen = deepcopy(self._settings)  # it may be on the move
        else:
            self.write()

    def _note_layout(self) -> None:
        if (looks := self._look()) is None:
            return
        for name, now in zip(("geometry", "layout"), looks, strict=True):
            if not self._began and getattr(self._settings, name):
                setattr(self._written, name, now)  # as the screen has it: no change of a person's
            setattr(self._settings, name, now)
        self._began = True

    def write(self) -> str:
        """Write what has changed now; a sentence if that failed, else ''."""
        if self._path is None or self._settings == self._written:
            return ""
        trouble = save_changes(self._path, self._settings, self._written)
        if not trouble:
            self._written = deepcopy(self._settings)
        elif trouble != self._told:
            self._tell(trouble)
        self._told = trouble
        return trouble

    def end(self) -> str:
        """The window is going: the last look; a sentence if writing failed, else ''."""
        self._timer.stop()
        self._note_layout()
        self._tell = lambda _: None
        return self.write()
