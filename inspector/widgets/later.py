"""Delay work until pending events are handled, and combine quick changes into one undo step."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, QTimer, Signal

_BURST_MS = 800


class Latest(QObject):
    """A queue that executes only the latest request, after Qt has handled the pending events."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._work: Callable[[], None] | None = None
        self._timer = QTimer(self, singleShot=True, interval=0)
        self._timer.timeout.connect(self.flush)

    def ask(self, work: Callable[[], None]) -> None:
        """Request a call of `work`. It replaces a request that has not been executed yet."""
        self._work = work
        self._timer.start()

    def forget(self) -> None:
        """Discard the pending request."""
        self._timer.stop()
        self._work = None

    def flush(self) -> None:
        """Execute the pending request now, if there is one."""
        self._timer.stop()
        work, self._work = self._work, None
        if work is not None:
            work()


class RedrawRequests(QObject):
    """A collector of redraw requests for a view. It emits `due` once for all requests.

    The signal is queued. It arrives after the change and before Qt's next repaint, so that tables,
    plots and the 3D view are painted together. The view calls `take` when it draws.
    """

    due = Signal()
    _requested = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.pending = self._all = False
        self._requested.connect(self.due, Qt.ConnectionType.QueuedConnection)

    def mark(self, *_: object) -> None:
        """Request a redraw of the parts of the view that have changed."""
        if not self.pending:
            self.pending = True
            self._requested.emit()

    def mark_all(self, *_: object) -> None:
        """Request a redraw of the whole view, not only of the parts that have changed."""
        self._all = True
        self.mark()

    def take(self) -> tuple[bool, bool]:
        """Return whether to redraw anything, and whether to redraw everything. Reset both flags."""
        taken = self.pending, self._all
        self.pending = self._all = False
        return taken


class Burst(QObject):
    """A provider of ids that combine quick changes, such as in a spin box, into one undo step."""

    def __init__(self, begin_drag: Callable[[], int], parent: QObject) -> None:
        """Create the provider. `begin_drag` is a function that returns a new id."""
        super().__init__(parent)
        self._begin_drag, self._drag = begin_drag, 0
        self._timer = QTimer(self, singleShot=True, interval=_BURST_MS)

    @property
    def active(self) -> bool:
        """True shortly after a change. The next change then gets the same id."""
        return self._timer.isActive()

    def drag(self) -> int:
        """Return the id for the next change. Changes with the same id become one undo step."""
        if not self.active:
            self._drag = self._begin_drag()
        self._timer.start()
        return self._drag
