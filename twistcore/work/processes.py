"""Apply a function to many files in several processes, so that a bad file does not stop the others.

Each process has a separate pipe for requests and results. If a process dies, hangs or takes too
much memory, only the file that it was working on is lost.
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
_SERVE = "from twistcore.work.processes import serve_parent_calls; serve_parent_calls({parent})"
_GRACE_S = 5.0  # extra seconds until a process whose parent was killed ends itself
# Limits are in processor time, so that other load on the machine does not matter. A
# process that only waits, for example for a dead disk, is ended after this multiple of the limit.
_WAITING = 10.0
_OUT_OF_TIME = getattr(signal, "SIGPROF", None)  # signal that ends a process at its time limit
_ENDED_FOR_TIME = 111 if _OUT_OF_TIME is None else -_OUT_OF_TIME  # exit code of such a process
_LOOKS_S = 0.2  # seconds between checks of the time on systems without a signal
_LENGTH = struct.Struct("<Q")


class ProcessEndedError(Exception):
    """Raised if a process was killed or crashed before it returned a result."""


class ProcessTimeError(Exception):
    """Raised if a process exceeded its time limit and was terminated.

    `args` contains the limit in seconds of processor time. For a process that was only waiting, it
    contains the waiting time in seconds and True.
    """


class Apart:
    """A separate process that runs one function call after another.

    After a crash, a new process replaces the old one. The process uses one BLAS thread, because
    other processes use the other cores. It ignores Ctrl+C, which the terminal sends to child
    processes, too, because only the parent decides when to stop. It ends when its parent ends.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._guard = threading.Lock()
        self._closed = False

    def call(self, work: Callable[[Name], Result], name: Name, seconds: float | None) -> Result:
        """Run `work(name)` in the process and return the result.

        Parameters
        ----------
        work, name
            The function and its argument, which are pickled.
        seconds
            The limit of processor time, after which the process is terminated, or None for no
            limit.

        Raises
        ------
        ProcessEndedError
            If the process died.
        ProcessTimeError
            If the process exceeded the limit.
        Exception
            Any exception that `work` raised.
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
            self._discard_process()
            if late.is_set() and seconds is not None:
                raise ProcessTimeError(_WAITING * seconds, True) from None
            if process.returncode == _ENDED_FOR_TIME:
                raise ProcessTimeError(seconds) from None
            raise ProcessEndedError from None
        finally:
            if timer is not None:
                timer.cancel()
        if late.is_set():  # the result arrived while the process was being ended
            self._discard_process()
        if not fine:
            raise answer
        result: Result = answer
        return result

    def tried(
        self, work: Callable[[Name], Result], name: Name, seconds: float | None
    ) -> Result | Exception:
        """Return `work(name)`, or the exception that it raised.

        If the process died, the call is repeated once in a new process, because something other
        than the call may have ended it. The parameters are those of :meth:`call`.
        """
        for last in (False, True):
            try:
                return self.call(work, name, seconds)
            except ProcessEndedError as error:
                if last or self._closed:
                    return error
            except Exception as error:  # a bug in this program must not stop the other files
                return error
        raise AssertionError

    def close(self) -> None:
        """End the process, even during a call. Thread-safe."""
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

    def _discard_process(self) -> None:
        with self._guard:
            process, self._process = self._process, None
        _end(process)


def map_in_processes(
    work: Callable[[Name], Result],
    names: Iterable[Name],
    workers: int,
    *,
    apart: bool = False,
    seconds: Callable[[Name], float] | None = None,
) -> Iterator[tuple[Name, Result | Exception]]:
    """Yield each name with the result or the exception of `work(name)`, in order of completion.

    A process that died is replaced, and its name is tried again once. Names are read as needed:
    each worker is at most two names ahead of the caller. The processes end when the iterator is
    exhausted, or immediately if it is closed early.

    Parameters
    ----------
    work
        The function. It is pickled for use in other processes, as are its argument and result.
    names
        The arguments.
    workers
        Number of processes. A single worker runs in this process unless `apart` is True.
    apart
        True to always use separate processes.
    seconds
        A function that returns the limit of processor time for a name in a separate process.
    """
    if isinstance(names, Sequence):
        workers = min(workers, len(names))
    if workers <= 1 and not apart:
        for name in names:
            yield name, _tried(work, name)
        return
    yield from _Crew(work, iter(names), seconds).results(max(workers, 1))


def describe_failure(name: object, error: Exception) -> str:
    """Return a sentence with the reason why a file could not be processed."""
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
            return f"{name} did not answer for {limit} s, so the program stopped it"
        return f"{name} took longer than {limit} s of processor time, so the program stopped it"
    if isinstance(error, ProcessEndedError):
        return f"{name}: the system ended the process, perhaps because memory ran out"
    return " ".join(f"{name}: {type(error).__name__}: {error}".splitlines())


class _Crew(Generic[Name, Result]):
    """A group of threads that each control one process and put the results into a common queue."""

    def __init__(
        self,
        work: Callable[[Name], Result],
        names: Iterator[Name],
        seconds: Callable[[Name], float] | None,
    ) -> None:
        self.work, self.names, self.seconds = work, names, seconds
        self.taking = threading.Lock()  # only one thread at a time may use an iterator
        self.stopped = threading.Event()
        self.outbox: queue.Queue[tuple[Name, Result | Exception] | BaseException | None]

    def results(self, workers: int) -> Iterator[tuple[Name, Result | Exception]]:
        self.outbox = queue.Queue(workers)  # a slow reader makes the processes wait
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
        finally:  # no further results are needed
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
        except BaseException as error:  # from the iterator of names; the reader raises it
            self.outbox.put(error)
        self.outbox.put(None)


def _tried(work: Callable[[Name], Result], name: Name) -> Result | Exception:
    try:
        return work(name)
    except Exception as error:  # a bug in this program must not stop the other files
        return error


def _started() -> subprocess.Popen[bytes]:
    """Start a worker process, which runs the calls that it receives.

    The process is spawned, because a forked process may hang if this program has threads.
    """
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
            with contextlib.suppress(OSError):  # unsent data is no longer needed
                pipe.close()


# -- in the worker process -------------------------------------------------------------------------


def serve_parent_calls(parent: int) -> None:
    """Run the calls requested on standard input until it is closed or process `parent` ends."""
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if _OUT_OF_TIME is not None:
        signal.signal(_OUT_OF_TIME, signal.SIG_DFL)
    orders = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # so that printed text is not mixed with the answers
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
        except OSError:  # the parent is no longer waiting
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
    # The parent ends a process that only waits. This alarm ends a process whose parent was killed.
    alarm(signal.ITIMER_REAL, _WAITING * seconds + _GRACE_S)
    try:
        return work(name)
    finally:
        alarm(signal.ITIMER_PROF, 0.0)
        alarm(signal.ITIMER_REAL, 0.0)


@contextlib.contextmanager
def _watched(seconds: float) -> Iterator[None]:
    """End this process if it uses more than `seconds` of processor time inside the context.

    This is needed on systems that do not send a signal at such a limit.
    """
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
    except Exception:  # an exception that cannot be unpickled is sent as text
        packed = _packed((RuntimeError(f"{type(error).__name__}: {error}"), False))
    return packed


def _packed(thing: object) -> bytes:
    data = pickle.dumps(thing, protocol=pickle.HIGHEST_PROTOCOL)
    return _LENGTH.pack(len(data)) + data


def _received(pipe: IO[bytes]) -> bytes:
    """Return the next message from a pipe. Raises EOFError if the other side has closed it."""
    head = pipe.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    (length,) = _LENGTH.unpack(head)
    data = pipe.read(length)
    if len(data) < length:
        raise EOFError
    return data
