"""Run the tasks of a batch on the workers of a Dask cluster, each in a separate process."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twistcore.batch.clip_task import ClipTask, Outcome, run_task
from twistcore.errors import TwistError
from twistcore.files.ordinary import read_file
from twistcore.work.processes import Apart, ProcessEndedError

if TYPE_CHECKING:
    from twistcore.batch.run import CarryOut

_CONNECT_S = 20.0
_LOOK_S = 1.0
_ALONE_S = 60.0  # seconds to wait without any worker, since workers may be restarting
_AHEAD = 2  # tasks per thread sent in advance, so that no worker is idle

_own = threading.local()


@contextmanager
def open_dask_cluster(address: str | None, workers: int | None) -> Iterator[CarryOut]:
    """Yield a function that runs tasks on a Dask cluster.

    A local cluster accepts only connections with its own temporary certificate, because anyone who
    reaches a scheduler can run any code. For a `tls://` address, the certificates come from Dask's
    configuration.

    Parameters
    ----------
    address
        The address of the scheduler, or None to start a cluster on this machine.
    workers
        Number of workers of a cluster on this machine. By default, Dask chooses it.

    Raises
    ------
    TwistError
        If Dask is not installed or no scheduler answers.
    """
    try:
        from distributed import Client, LocalCluster
        from distributed.security import Security

        security = Security.temporary() if address is None else None
    except ImportError:
        raise TwistError(
            'a cluster requires Dask: install it with pip install "twist-inspector[cluster]"'
        ) from None
    local: Any = None
    with _silence():
        try:
            if address is None:
                local = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs=50,
                    security=security,
                )
                local.loop.add_callback(local.scheduler.http_server.stop)  # open in any case
            client = Client(local or address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise TwistError(f"{address}: the Dask scheduler does not answer ({error})") from None
        try:
            if local is not None:
                client.register_worker_callbacks(_close_pages)
            yield partial(_in_cluster, client)
        finally:
            with suppress(Exception):  # the scheduler may already be gone
                client.close(timeout=2.0)
            if local is not None:
                local.close()


def _close_pages(dask_worker: Any) -> None:
    """Close the HTTP port of a worker.

    Dask passes the worker to any function that has an argument called `dask_worker`.
    """
    dask_worker.http_server.stop()


@contextmanager
def _silence() -> Iterator[None]:
    """Suppress Dask's log messages, since every problem is reported in one sentence."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


def run_in_separate_process(task: ClipTask, seconds: float) -> Outcome | Exception:
    """Run a task on a worker in a separate process. Exceptions are returned, not raised.

    `seconds` is the processor time allowed for the task.
    """
    if not hasattr(_own, "apart"):
        _own.apart = Apart()
    apart: Apart = _own.apart
    return apart.tried(run_task, task, seconds)


def _in_cluster(
    client: Any, tasks: Sequence[ClipTask], seconds: Callable[[ClipTask], float]
) -> Iterator[tuple[ClipTask, Outcome | Exception]]:
    todo = deque(tasks)
    under_way: dict[str, tuple[ClipTask, Any]] = {}
    finished: queue.Queue[str] = queue.Queue()
    seen, looked, threads = time.monotonic(), -_LOOK_S, 0
    try:
        while todo or under_way:
            if time.monotonic() - looked >= _LOOK_S:
                threads, looked = _threads(client), time.monotonic()
            while todo and len(under_way) < max(_AHEAD * threads, 2):
                _send(client, todo.popleft(), seconds, under_way, finished)
            try:
                task, future = under_way.pop(finished.get(timeout=_LOOK_S))
            except queue.Empty:
                seen = time.monotonic() if threads else seen
                if time.monotonic() - seen > _ALONE_S:
                    raise TwistError("the Dask cluster has no workers left") from None
                continue
            seen = time.monotonic()
            outcome = _outcome(client, future)
            unseen = isinstance(outcome, Outcome) and outcome.unseen and task.data is None
            if unseen and Path(task.source).is_file():  # the workers do not share this disk
                todo.appendleft(replace(task, data=read_file(task.source)))
                continue
            yield replace(task, data=None), outcome
    finally:
        with suppress(Exception):
            client.cancel([future for _, future in under_way.values()])


def _send(
    client: Any,
    task: ClipTask,
    seconds: Callable[[ClipTask], float],
    under_way: dict[str, tuple[ClipTask, Any]],
    finished: queue.Queue[str],
) -> None:
    future = client.submit(run_in_separate_process, task, seconds(task), pure=False)
    under_way[future.key] = task, future
    future.add_done_callback(lambda done: finished.put(done.key))


def _outcome(client: Any, future: Any) -> Outcome | Exception:
    """Return the outcome of a task. Raises TwistError if the scheduler has stopped."""
    from distributed import KilledWorker

    try:
        found: Outcome | Exception = future.result(timeout=_CONNECT_S)
    except KilledWorker:
        return ProcessEndedError()
    except BaseException as error:
        if not isinstance(error, Exception) and "Cancel" not in type(error).__name__:
            raise
        if client.status != "running" or future.cancelled() or future.status == "lost":
            raise TwistError("the Dask scheduler has stopped") from None
        return error if isinstance(error, Exception) else ProcessEndedError()
    return found


def _threads(client: Any) -> int:
    """Return the total number of threads of the workers.

    Raises TwistError if the scheduler has stopped.
    """
    with suppress(Exception):
        if client.status == "running":
            return sum(client.nthreads().values())
    raise TwistError("the Dask scheduler has stopped")
