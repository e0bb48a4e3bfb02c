"""One function over many files in many processes, where a bad file stops no other.

Each process is its own, with a pipe for orders and answers: whoever dies, hangs or takes too much
memory is known by name, and costs its own file alone.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import IO, Any, Generic, TypeVar

from twistcore.errors import TwistError
from twistcore.work.with_parent import end_with_parent

Name = TypeVar("Name")
Result = TypeVar("Result")

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_SERVE = "from twistcore.work.processes import serve; serve({parent})"
_GRACE_S = 5.0  # a process whose parent is gone ends itself so long behind its time
# Limits are of processor time: what else a machine does is no clip's fault. A process that only
# waits, as for a disk that does not answer, is ended after so many times as long.
_WAITING = 10.0
_OUT_OF_TIME = getattr(signal, "SIGPROF", None)  # ends a process that has used its time
_ENDED_FOR_TIME = 111 if _OUT_OF_TIME is None else -_OUT_OF_TIME  # the exit code then
_LOOKS_S = 0.2  # how often a process then looks at its time
_LENGTH = struct.Struct("<Q")


class ProcessEndedError(Exception):
    """A process ended before it gave its answer: killed, or crashed."""


class ProcessTimeError(Exception):
    """A process took longer than it may, and was ended.

    args: the seconds of processor time; or those that it was waited for, and True.
    """


class Apart:
    """A process that carries out one call after the other, and is started anew when it has died.

    It has one BLAS thread, as the cores are busy with files, and no ear for Ctrl+C, which reaches
    every process of a terminal while the parent alone decides. It ends with the parent.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._guard = threading.Lock()
        self._closed = False

    def call(self, work: Callable[[Name], Result], name: Name, seconds: float | None) -> Result:
        """What `work` makes of a name, both pickled; raises what it raises.

        seconds: of processor time, after which the process is ended, None for never. Raises
        ProcessEndedError and ProcessTimeError.
        """
        order = _packed((work, name, seconds))
        process = self._running()
        assert process.stdin is not None
        assert process.stdout is not None
        late = threading.Event()

        def end() -> None:
            late.set()
            process.kill()

        timer = None if seconds is None else threading.Timer(_WAITING * seconds, end)
        if timer is not None:
            timer.daemon = True
            timer.start()
        try:
            process.stdin.write(order)
            process.stdin.flush()
            answer, fine = pickle.loads(_received(process.stdout))
        except (OSError, EOFError, pickle.UnpicklingError):
            self._bury()
            if late.is_set() and seconds is not None:
                raise ProcessTimeError(_WAITING * seconds, True) from None
            if process.returncode == _ENDED_FOR_TIME:
                raise ProcessTimeError(seconds) from None
            raise ProcessEndedError from None
        finally:
            if timer is not None:
                timer.cancel()
        if late.is_set():  # it answered as it was ended
            self._bury()
        if not fine:
            raise answer
        result: Result = answer
        return result

    def tried(
        self, work: Callable[[Name], Result], name: Name, seconds: float | None
    ) -> Result | Exception:
        """The same, with what is raised as the answer.

        A name whose process died is tried once more, in another: it may have been ended for what a
        neighbour did.
        """
        for last in (False, True):
            try:
                return self.call(work, name, seconds)
            except ProcessEndedError as error:
                if last or self._closed:
                    return error
            except Exception as error:  # a defect of ours must not stop the other files, either
                return error
        raise AssertionError

    def close(self) -> None:
        """End the process at once, whatever it is doing. Safe to call in any thread."""
        with self._guard:
            self._closed = True
            process, self._process = self._process, None
        _end(process)

    def _running(self) -> subprocess.Popen[bytes]:
        with self._guard:
            if self._closed:
                raise ProcessEndedError
            if self._process is None or self._process.poll() is not None:
                self._process = _started()
            return self._process

    def _bury(self) -> None:
        with self._guard:
            process, self._process = self._process, None
        _end(process)


def each(
    work: Callable[[Name], Result],
    names: Iterable[Name],
    workers: int,
    *,
    apart: bool = False,
    seconds: Callable[[Name], float] | None = None,
) -> Iterator[tuple[Name, Result | Exception]]:
    """What `work` makes of every name, as it comes, or the exception that it ended with.

    In this process where one worker is enough, unless `apart`; else in others: `work` and all that
    it takes and gives are pickled. seconds: of processor time that a name may take, apart. Those
    whose process died are tried once more (:meth:`Apart.tried`). Names are taken as they are
    needed, no more than twice as many as there are workers ahead of the reader. The processes are
    gone when this ends, at once where it ends early.
    """
    if isinstance(names, Sequence):
        workers = min(workers, len(names))
    if workers <= 1 and not apart:
        for name in names:
            yield name, _tried(work, name)
        return
    yield from _Crew(work, iter(names), seconds).results(max(workers, 1))


def reason(name: object, error: Exception) -> str:
    """One sentence about a file that could not be processed."""
    if isinstance(error, TwistError):
        return str(error)
    if isinstance(error, OSError):
        return f"{name}: cannot be read ({error.strerror})"
    if isinstance(error, MemoryError):
        return f"{name}: there is not enough memory to open it"
    if isinstance(error, ProcessTimeError):
        seconds, *waited = error.args
        limit = f"{seconds:.0f}" if seconds >= 10.0 else f"{seconds:.2g}"
        if any(waited):
            return f"{name}: did not answer for {limit} s and was stopped"
        return f"{name}: took longer than {limit} s of processor time and was stopped"
    if isinstance(error, ProcessEndedError):
        return f"{name}: the system ended its process, perhaps because memory ran out"
    return " ".join(f"{name}: {type(error).__name__}: {error}".splitlines())


class _Crew(Generic[Name, Result]):
    """Threads that drive a process each, and put what comes into one queue."""

    def __init__(
        self,
        work: Callable[[Name], Result],
        names: Iterator[Name],
        seconds: Callable[[Name], float] | None,
    ) -> None:
        self.work, self.names, self.seconds = work, names, seconds
        self.taking = threading.Lock()  # an iterator is no more than one thread's at a time
        self.stopped = threading.Event()
        self.outbox: queue.Queue[tuple[Name, Result | Exception] | BaseException | None]

    def results(self, workers: int) -> Iterator[tuple[Name, Result | Exception]]:
        self.outbox = queue.Queue(workers)  # who reads slowly holds the processes up
        crew = [Apart() for _ in range(workers)]
        threads = [threading.Thread(target=self._drive, args=(a,), daemon=True) for a in crew]
        for thread in threads:
            thread.start()
        left = workers
        try:
            while left:
                found = self.outbox.get()
                if found is None:
                    left -= 1
                elif isinstance(found, BaseException):
                    raise found
                else:
                    yield found
        finally:  # do not wait for files that nobody will see
            self.stopped.set()
            for apart in crew:
                apart.close()
            for thread in threads:
                while thread.is_alive():
                    with contextlib.suppress(queue.Empty):
                        self.outbox.get_nowait()
                    thread.join(0.01)

    def _drive(self, apart: Apart) -> None:
        try:
            while not self.stopped.is_set():
                with self.taking:
                    try:
                        name = next(self.names)
                    except StopIteration:
                        break
                limit = self.seconds(name) if self.seconds else None
                self.outbox.put((name, apart.tried(self.work, name, limit)))
        except BaseException as error:  # whoever gives the names failed: the reader is told
            self.outbox.put(error)
        self.outbox.put(None)


def _tried(work: Callable[[Name], Result], name: Name) -> Result | Exception:
    try:
        return work(name)
    except Exception as error:  # a defect of ours must not stop the other files, either
        return error


def _started() -> subprocess.Popen[bytes]:
    """A process that serves; spawned, not forked: a fork of a program with threads may hang."""
    path = os.pathsep.join(dict.fromkeys(str(Path(entry).absolute()) for entry in sys.path))
    own: dict[str, Any] = {"process_group": 0}
    if sys.platform == "win32":
        own = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return subprocess.Popen(
        [sys.executable, "-c", _SERVE.format(parent=os.getpid())],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, **dict.fromkeys(_THREADS, "1"), "PYTHONPATH": path},
        **own,
    )


def _end(process: subprocess.Popen[bytes] | None) -> None:
    if process is None:
        return
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(OSError):  # what was not sent is of no use any more
                pipe.close()


# -- in the other process --------------------------------------------------------------------------


def serve(parent: int) -> None:
    """Carry out what comes in on standard input, until that ends or `parent` has."""
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if _OUT_OF_TIME is not None:
        signal.signal(_OUT_OF_TIME, signal.SIG_DFL)
    orders = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what anything prints must not stand among the answers
    while True:
        try:
            order = _received(orders)
        except (EOFError, OSError):
            return
        try:
            packed = _packed((_carried_out(order), True))
        except Exception as error:
            packed = _packed_error(error)
        try:
            answers.write(packed)
            answers.flush()
        except OSError:  # nobody waits any more
            return


def _carried_out(order: bytes) -> object:
    work, name, seconds = pickle.loads(order)
    if seconds is None:
        return work(name)
    alarm = getattr(signal, "setitimer", None)
    if alarm is None or _OUT_OF_TIME is None:
        with _watched(seconds):
            return work(name)
    alarm(signal.ITIMER_PROF, seconds)
    # The parent looks after a process that waits; this ends one whose parent was killed.
    alarm(signal.ITIMER_REAL, _WAITING * seconds + _GRACE_S)
    try:
        return work(name)
    finally:
        alarm(signal.ITIMER_PROF, 0.0)
        alarm(signal.ITIMER_REAL, 0.0)


@contextlib.contextmanager
def _watched(seconds: float) -> Iterator[None]:
    """End this process once it has used so much processor time, where no signal does."""
    end, done = time.process_time() + seconds, threading.Event()

    def watch() -> None:
        while not done.wait(_LOOKS_S):
            if time.process_time() > end:
                os._exit(_ENDED_FOR_TIME)

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        done.set()


def _packed_error(error: Exception) -> bytes:
    try:
        packed = _packed((error, False))
        pickle.loads(packed[_LENGTH.size :])
    except Exception:  # an exception that does not come out of a pickle is told in words
        packed = _packed((RuntimeError(f"{type(error).__name__}: {error}"), False))
    return packed


def _packed(thing: object) -> bytes:
    data = pickle.dumps(thing, protocol=pickle.HIGHEST_PROTOCOL)
    return _LENGTH.pack(len(data)) + data


def _received(pipe: IO[bytes]) -> bytes:
    """The next message; EOFError where the other side has gone."""
    head = pipe.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    (length,) = _LENGTH.unpack(head)
    data = pipe.read(length)
    if len(data) < length:
        raise EOFError
    return data
