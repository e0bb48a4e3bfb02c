"""Keys of verdicts work only once the picture of the selected interval was painted."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QAction


class DrawnFirst(QObject):
    """Drops the keys of actions until the person can have seen what they decide about."""

    def __init__(
        self, actions: Iterable[QAction], is_drawn: Callable[[], bool], parent: QObject
    ) -> None:
        super().__init__(parent)
        self._is_drawn = is_drawn
        for action in actions:
            action.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Stop a key that comes before the picture; clicks are slower."""
        return event.type() == QEvent.Type.Shortcut and not self._is_drawn()
