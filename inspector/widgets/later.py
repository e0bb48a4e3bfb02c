"""Work put off until the pending events are through."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer


class Latest(QObject):
    """Carries out only the last of many requests, once the pending events are through."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._work: Callable[[], None] | None = None
        self._timer = QTimer(self, singleShot=True, interval=0)
        self._timer.timeout.connect(self.flush)

    def ask(self, work: Callable[[], None]) -> None:
        """Replace what is pending."""
        self._work = work
        self._timer.start()

    def flush(self) -> None:
        """Do it now, if anything is pending."""
        self._timer.stop()
        work, self._work = self._work, None
        if work is not None:
            work()
