"""Work put off until the pending events are through, and steps that belong together."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, QTimer, Signal

_BURST_MS = 800


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

    def forget(self) -> None:
        """Nothing is pending any more: what it was about is gone."""
        self._timer.stop()
        self._work = None

    def flush(self) -> None:
        """Do it now, if anything is pending."""
        self._timer.stop()
        work, self._work = self._work, None
        if work is not None:
            work()


class Stale(QObject):
    """What of a view is to be drawn again: `due` once for all that a change has asked for.

    It comes queued, once the change is through and before Qt's next repaint, so that tables, plots
    and picture are painted at once. Whoever draws `take`s it.
    """

    due = Signal()
    _asked = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.pending = self._all = False
        self._asked.connect(self.due, Qt.ConnectionType.QueuedConnection)

    def mark(self, *_: object) -> None:
        """Something is to be drawn again."""
        if not self.pending:
            self.pending = True
            self._asked.emit()

    def mark_all(self, *_: object) -> None:
        """Everything is."""
        self._all = True
        self.mark()

    def take(self) -> tuple[bool, bool]:
        """Whether anything, and whether everything was to be drawn; now nothing is."""
        taken = self.pending, self._all
        self.pending = self._all = False
        return taken


class Burst(QObject):
    """Steps in quick succession, as of a spin box, are one step of the history."""

    def __init__(self, begin_drag: Callable[[], int], parent: QObject) -> None:
        """`begin_drag`: gives the number under which the steps are one."""
        super().__init__(parent)
        self._begin_drag, self._drag = begin_drag, 0
        self._timer = QTimer(self, singleShot=True, interval=_BURST_MS)

    @property
    def going_on(self) -> bool:
        """Whether the last step was just now."""
        return self._timer.isActive()

    def drag(self) -> int:
        """The number for one more step."""
        if not self.going_on:
            self._drag = self._begin_drag()
        self._timer.start()
        return self._drag
