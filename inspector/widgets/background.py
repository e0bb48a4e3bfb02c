"""Run work in background threads, and deliver the results in the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QRunnable, QThreadPool, Signal
from shiboken6 import isValid

from twistcore.work.progress import Cancelled, Tell


class _Post(QObject):
    """An object that executes calls from background threads in the GUI thread.

    This object outlives all tasks. A signal of the task itself would not be safe: when the GUI
    thread has received the result, it could delete the task while the background thread is still
    emitting the signal.
    """

    said = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.said.connect(self._hear)

    def _hear(self, work: Callable[[], None]) -> None:
        work()


_post: _Post | None = None


class Task(QObject):
    """A task that calls `work(tell)` in a background thread.

    When the work is done, `finished` is emitted with the result. If the work raises an exception,
    `failed` is emitted with the exception. To report progress, the work calls `tell(share)`, which
    emits `progress(share)`. All signals are emitted in the GUI thread, but none after `cancel()`.
    """

    finished = Signal(object)
    failed = Signal(object)
    progress = Signal(float)

    def __init__(self, work: Callable[[Tell], Any], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._cancelled = False
        self._percent = 0
        self._work: Callable[[Tell], Any] = work

    def start(self) -> None:
        """Start the work in Qt's thread pool."""
        global _post
        _post = _post or _Post()
        QThreadPool.globalInstance().start(_Runner(self, _post))

    def cancel(self) -> None:
        """Discard the result, and stop the work when it next reports its progress."""
        self._cancelled = True

    def tell(self, share: float) -> None:
        """Report the share of the work that is done, 0…1. Called by the work in its thread.

        Raises Cancelled if `cancel` was called.
        """
        if self._cancelled:
            raise Cancelled
        if (percent := int(100.0 * share)) != self._percent:
            self._percent = percent
            assert _post is not None
            _post.said.emit(partial(self._pass_on, share))

    def _pass_on(self, share: float) -> None:
        if not self._cancelled and isValid(self):
            self.progress.emit(share)

    def run(self) -> Callable[[], None]:
        """Do the work in the current thread, and return a function that delivers the result.

        The returned function must be called in the GUI thread.
        """
        try:
            return partial(self._deliver, self._work(self.tell), None)
        except (Exception, Cancelled) as caught:  # the GUI thread reports every error
            return partial(self._deliver, None, caught)

    def _deliver(self, result: object, error: object) -> None:
        self._work = lambda _: None  # free its objects in this thread
        if not isValid(self):
            return  # the owner was closed in the meantime
        if not self._cancelled:
            if error is not None:
                self.failed.emit(error)
            else:
                self.finished.emit(result)
        self.deleteLater()


class OneTask(QObject):
    """A runner for one background task at a time. A new task cancels the running one."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._task: Task | None = None

    @property
    def running(self) -> bool:
        """True while a task is running or its result has not been delivered yet."""
        return self._task is not None

    def run(
        self,
        work: Callable[[Tell], Any],
        done: Callable[[Any], object],
        failed: Callable[[Any], object] = lambda _: None,
        progress: Callable[[float], object] = lambda _: None,
    ) -> None:
        """Run `work(tell)` in a thread, then call `done` with the result.

        If the work raises an exception, `failed` is called with the exception instead. If this task
        is cancelled or replaced, neither is called. `progress` is called with the share of the work
        that is done, 0…1.
        """
        self.cancel()
        self._task = Task(work, self)
        self._task.finished.connect(lambda result: self._end(done, result))
        self._task.failed.connect(lambda error: self._end(failed, error))
        self._task.progress.connect(progress)
        self._task.start()

    def cancel(self) -> None:
        """Cancel the running task, if any."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def _end(self, tell: Callable[[Any], object], result: Any) -> None:
        self._task = None
        tell(result)


class _Runner(QRunnable):
    def __init__(self, task: Task, post: _Post) -> None:
        super().__init__()
        self._task, self._post = task, post

    def run(self) -> None:
        """Do the task's work in the background thread, and deliver the result."""
        answer = self._task.run()
        with suppress(RuntimeError):  # the program is closing
            self._post.said.emit(answer)


def run_in_gui_thread(call: Callable[[], None]) -> None:
    """Execute a call in the GUI thread. The work of a task calls this in its own thread."""
    with suppress(RuntimeError):  # the program is closing
        assert _post is not None
        _post.said.emit(call)


def wait_for_tasks(milliseconds: int) -> bool:
    """Wait for all running tasks. Return False if any of them is still running after this time."""
    return QThreadPool.globalInstance().waitForDone(milliseconds)
