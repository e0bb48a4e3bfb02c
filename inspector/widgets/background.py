"""Work off the GUI thread: one function, one answer on the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QRunnable, QThreadPool, Signal
from shiboken6 import isValid

from twistcore.work.progress import Cancelled, Tell


class _Post(QObject):
    """Brings what threads say into the GUI thread.

    It outlives every task: a task's own signal, emitted by a thread, could still be at it while
    the GUI thread, which has the answer already, deletes the task.
    """

    said = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.said.connect(self._hear)

    def _hear(self, work: Callable[[], None]) -> None:
        work()


_post: _Post | None = None


class Task(QObject):
    """Runs `work(tell)` in the pool; `finished` or `failed` (an exception) arrive in this thread.

    Work that takes long tells how far it is; `progress(share)` arrives in this thread. After
    `cancel()` nothing is emitted.
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
        """Hand the work to the pool."""
        global _post
        _post = _post or _Post()
        QThreadPool.globalInstance().start(_Runner(self, _post))

    def cancel(self) -> None:
        """Forget the answer; work under way ends when it next tells how far it is."""
        self._cancelled = True

    def tell(self, share: float) -> None:
        """For the work, in its thread: what share is done, 0…1; raises Cancelled after `cancel`."""
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
        """In a thread of the pool: do the work; what is to be done with it in the GUI thread."""
        try:
            return partial(self._deliver, self._work(self.tell), None)
        except (Exception, Cancelled) as caught:  # whatever went wrong is told in the GUI thread
            return partial(self._deliver, None, caught)

    def _deliver(self, result: object, error: object) -> None:
        self._work = lambda _: None  # what it holds is let go here, not in the thread
        if not isValid(self):
            return  # what it was for was closed meanwhile
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
    def __init__(self, task: Task, post: _Post) -> None:
        super().__init__()
        self._task, self._post = task, post

    def run(self) -> None:
        """Called in a thread of the pool."""
        answer = self._task.run()
        with suppress(RuntimeError):  # the program is at its end: nobody is left to tell
            self._post.said.emit(answer)


def wait_for_tasks(milliseconds: int) -> bool:
    """Let what runs come to its end; False if it did not in this time."""
    return QThreadPool.globalInstance().waitForDone(milliseconds)
