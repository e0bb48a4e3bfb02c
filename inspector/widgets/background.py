"""Work off the GUI thread: one function, one answer on the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, QRunnable, QThreadPool, Signal

from twistcore.progress import Cancelled, Tell


class Task(QObject):
    """Runs `work(tell)` in the pool; `finished` or `failed` (an exception) arrive in this thread.

    Work that takes long tells how far it is; `progress(share)` arrives in this thread. After
    `cancel()` nothing is emitted.
    """

    finished = Signal(object)
    failed = Signal(object)
    progress = Signal(float)
    _done = Signal(object, object)
    _told = Signal(float)

    def __init__(self, work: Callable[[Tell], Any], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._cancelled = False
        self._percent = 0
        self._done.connect(self._deliver)
        self._told.connect(self._pass_on)
        self._runner = _Runner(lambda: work(self.tell), self._done.emit)

    def start(self) -> None:
        """Hand the work to the pool."""
        QThreadPool.globalInstance().start(self._runner)

    def cancel(self) -> None:
        """Forget the answer; work under way ends when it next tells how far it is."""
        self._cancelled = True

    def tell(self, share: float) -> None:
        """For the work, in its thread: what share is done, 0…1; raises Cancelled after `cancel`."""
        if self._cancelled:
            raise Cancelled
        if (percent := int(100.0 * share)) != self._percent:
            self._percent = percent
            self._told.emit(share)

    def _pass_on(self, share: float) -> None:
        if not self._cancelled:
            self.progress.emit(share)

    def _deliver(self, result: object, error: object) -> None:
        if not self._cancelled:
            if error is not None:
                self.failed.emit(error)
            else:
                self.finished.emit(result)
        self.deleteLater()


class OneTask(QObject):
    """One work at a time: another takes the place of what is under way."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._task: Task | None = None

    @property
    def running(self) -> bool:
        """Whether an answer is still to come."""
        return self._task is not None

    def run(
        self,
        work: Callable[[Tell], Any],
        done: Callable[[Any], object],
        failed: Callable[[Any], object] = lambda _: None,
        progress: Callable[[float], object] = lambda _: None,
    ) -> None:
        """Run `work(tell)` in the pool; once nothing is under way any more `done` or `failed`."""
        self.cancel()
        self._task = Task(work, self)
        self._task.finished.connect(lambda result: self._end(done, result))
        self._task.failed.connect(lambda error: self._end(failed, error))
        self._task.progress.connect(progress)
        self._task.start()

    def cancel(self) -> None:
        """Forget what is under way."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def _end(self, tell: Callable[[Any], object], result: Any) -> None:
        self._task = None
        tell(result)


class _Runner(QRunnable):
    def __init__(self, work: Callable[[], Any], done: Callable[[object, object], None]) -> None:
        super().__init__()
        self._work, self._tell = work, done

    def run(self) -> None:
        """Called in a thread of the pool."""
        try:
            result, error = self._work(), None
        except (Exception, Cancelled) as caught:  # whatever went wrong is told in the GUI thread
            result, error = None, caught
        try:
            self._tell(result, error)
        except RuntimeError:
            return  # the program was closed meanwhile: nobody is left to tell


def wait_for_tasks(milliseconds: int) -> bool:
    """Let what runs come to its end; False if it did not in this time."""
    return QThreadPool.globalInstance().waitForDone(milliseconds)
