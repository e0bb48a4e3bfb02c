"""One function over many files in many processes, where a bad file stops no other."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

from twistcore.errors import TwistError

Name = TypeVar("Name")
Result = TypeVar("Result")

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def each(
    work: Callable[[Name], Result], names: Sequence[Name], workers: int
) -> Iterator[tuple[Name, Result | Exception]]:
    """What `work` makes of every name, as it comes, or the exception that it ended with.

    In this process where one worker is enough, else in spawned ones: `work` and all that it takes
    and gives are pickled. Whoever was under way when a process died is tried again alone, so that
    only the one that kills its process comes back with a BrokenProcessPool.
    """
    workers = min(workers, len(names))
    if workers <= 1:
        for name in names:
            yield name, _tried(work, name)
        return
    todo, doubtful = deque(names), deque[Name]()
    while todo or doubtful:
        alone = bool(doubtful)
        queue = deque([doubtful.popleft()]) if alone else todo
        for name, result in _pooled(work, 1 if alone else workers, queue):
            if isinstance(result, BrokenProcessPool) and not alone:
                doubtful.append(name)
            else:
                yield name, result


def reason(name: object, error: Exception) -> str:
    """One sentence about a file that could not be processed."""
    if isinstance(error, TwistError):
        return str(error)
    if isinstance(error, OSError):
        return f"{name}: cannot be read ({error.strerror})"
    if isinstance(error, MemoryError):
        return f"{name}: there is not enough memory for it"
    if isinstance(error, BrokenProcessPool):
        return f"{name}: its process was ended by the system, perhaps for want of memory"
    return " ".join(f"{name}: {type(error).__name__}: {error}".splitlines())


def _tried(work: Callable[[Name], Result], name: Name) -> Result | Exception:
    try:
        return work(name)
    except Exception as error:  # a defect of ours must not stop the other files, either
        return error


def _pooled(
    work: Callable[[Name], Result], workers: int, queue: deque[Name]
) -> Iterator[tuple[Name, Result | Exception]]:
    """What processes make of names from the queue, until it is empty or a process has died.

    No more are handed out than there are workers: who is handed out may have killed a process.
    The processes are gone when this ends, at once where it ends early.
    """
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    jobs: dict[Future[Result], Name] = {}
    broken = False
    try:
        while jobs or (queue and not broken):
            with _starting_workers():  # they start as jobs come in
                while queue and not broken and len(jobs) < workers:
                    try:
                        jobs[pool.submit(work, queue[0])] = queue[0]
                        queue.popleft()
                    except BrokenProcessPool:  # a process has died since
                        broken = True
            for job in wait(jobs, return_when=FIRST_COMPLETED).done:
                name, error = jobs.pop(job), job.exception()
                broken |= isinstance(error, BrokenProcessPool)
                if error is not None and not isinstance(error, Exception):
                    raise error
                yield name, job.result() if error is None else error
    except BaseException:  # do not wait for files that nobody will see
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _starting_workers() -> Iterator[None]:
    """What processes started inside inherit: one BLAS thread each, and no ear for Ctrl+C.

    The cores are busy with files; and Ctrl+C reaches every process of a terminal, while the parent
    alone decides.
    """
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    main = threading.current_thread() is threading.main_thread()
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN) if main else None
    try:
        yield
    finally:
        if main:
            signal.signal(signal.SIGINT, handler)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
