"""The tasks of a batch on a Dask cluster: the same ones, each in a process apart there, too."""

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

from twistcore.batch.clip_task import ClipTask, Outcome, process
from twistcore.errors import TwistError
from twistcore.files.ordinary import read_file
from twistcore.work.processes import Apart, ProcessEndedError

if TYPE_CHECKING:
    from twistcore.batch.run import CarryOut

_CONNECT_S = 20.0
_LOOK_S = 1.0
_ALONE_S = 60.0  # without any worker: they may be restarting
_AHEAD = 2  # tasks a thread that wait at the workers, so that none is idle

_own = threading.local()


@contextmanager
def cluster(address: str | None, workers: int | None) -> Iterator[CarryOut]:
    """A way of carrying tasks out on the cluster of an address, or on so many workers here.

    TwistError where Dask is not installed or no scheduler answers.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise TwistError(
            'a cluster needs Dask: expected pip install "twist-inspector[cluster]"'
        ) from None
    local = None
    with _silence():
        try:
            if address is None:
                local = LocalCluster(
                    n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=50
                )
            client = Client(local or address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise TwistError(f"{address}: no Dask scheduler answers ({error})") from None
        try:
            yield partial(_in_cluster, client)
        finally:
            with suppress(Exception):  # of a scheduler that is gone there is nothing to close
                client.close(timeout=2.0)
            if local is not None:
                local.close()


@contextmanager
def _silence() -> Iterator[None]:
    """Without Dask's tracebacks: what they are about is said once, in a sentence."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


def process_apart(task: ClipTask, seconds: float) -> Outcome | Exception:
    """Carry a task out on a worker, in a process of its thread; errors are answers."""
    if not hasattr(_own, "apart"):
        _own.apart = Apart()
    apart: Apart = _own.apart
    return apart.tried(process, task, seconds)


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
                    raise TwistError("the Dask cluster has no worker any more") from None
                continue
            seen = time.monotonic()
            outcome = _outcome(client, future)
            unseen = isinstance(outcome, Outcome) and outcome.unseen and task.data is None
            if unseen and Path(task.source).is_file():  # no disk that the workers share
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
    future = client.submit(process_apart, task, seconds(task), pure=False)
    under_way[future.key] = task, future
    future.add_done_callback(lambda done: finished.put(done.key))


def _outcome(client: Any, future: Any) -> Outcome | Exception:
    """TwistError where the scheduler is gone, and with it all tasks."""
    from distributed import KilledWorker

    try:
        found: Outcome | Exception = future.result(timeout=_CONNECT_S)
    except KilledWorker:
        return ProcessEndedError()
    except BaseException as error:
        if not isinstance(error, Exception) and "Cancel" not in type(error).__name__:
            raise
        if client.status != "running" or future.cancelled() or future.status == "lost":
            raise TwistError("the Dask scheduler is gone") from None
        return error if isinstance(error, Exception) else ProcessEndedError()
    return found


def _threads(client: Any) -> int:
    """Of all workers; TwistError where the scheduler is gone."""
    with suppress(Exception):
        if client.status == "running":
            return sum(client.nthreads().values())
    raise TwistError("the Dask scheduler is gone")
