"""Work off the GUI thread: one function, one answer on the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, QRunnable, QThreadPool, Signal


class Task(QObject):
    """Runs `work()` in the pool; `finished(result)` or `failed(exception)` arrive in this thread.

    After `cancel()` neither is emitted.
    """

    finished = Signal(object)
    failed = Signal(object)
    _done = Signal(object, object)

    def __init__(self, work: Callable[[], Any], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._cancelled = False
        self._done.connect(self._deliver)
        self._runner = _Runner(work, self._done.emit)

    def start(self) -> None:
        """Hand the work to the pool."""
        QThreadPool.globalInstance().start(self._runner)

    def cancel(self) -> None:
        """Forget the answer; work that has begun runs out unheard."""
        self._cancelled = True

    def _deliver(self, result: object, error: object) -> None:
        if not self._cancelled:
            if error is not None:
                self.failed.emit(error)
            else:
                self.finished.emit(result)
        self.deleteLater()


class _Runner(QRunnable):
    def __init__(self, work: Callable[[], Any], done: Callable[[object, object], None]) -> None:
        super().__init__()
        self._work, self._tell = work, done

    def run(self) -> None:
        """Called in a thread of the pool."""
        try:
            result, error = self._work(), None
        except Exception as caught:  # whatever went wrong is told in the GUI thread
            result, error = None, caught
        try:
            self._tell(result, error)
        except RuntimeError:
            return  # the program was closed meanwhile: nobody is left to tell
