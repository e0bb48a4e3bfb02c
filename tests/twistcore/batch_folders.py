"""Folders of small clips for tests of a batch, and tasks that fail in every way there is."""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from twistcore.batch.clip_task import ClipTask, Outcome, run_task
from twistcore.batch.inputs import find_input_clips
from twistcore.batch.parameters import Parameters
from twistcore.batch.run import run_batch
from twistcore.work.processes import map_in_processes

ROOT = Path(__file__).parents[2]
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)
COMMAND = (sys.executable, "-m", "twistcore", "batch")


def clips(folder: Path, source: Path, count: int, frames: int = 120) -> list[Path]:
    """So many clips of different bytes: the first frames of another, each from another one on."""
    lines = source.read_text("utf-8").splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if line.startswith("Frames:"))
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for k in range(count):
        rows = lines[at + 2 + k : at + 2 + k + frames]
        made.append(folder / f"clip_{k:02}.bvh")
        text = [*lines[:at], f"Frames: {len(rows)}\n", lines[at + 1], *rows]
        made[-1].write_text("".join(text), "utf-8")
        os.utime(made[-1], (1e9, 1e9))  # long ago: its time says whether it changed
    return made


def environment(**more: str) -> dict[str, str]:
    """Of a process that runs the command from this checkout."""
    return {**os.environ, "PYTHONPATH": str(ROOT), **more}


def as_its_name_says(task: ClipTask) -> Outcome:
    """Carry a task out in a process that dies, hangs or has no memory if the name says so."""
    if "dies" in task.name:
        os.kill(os.getpid(), KILL)
    if "hangs" in task.name:
        time.sleep(600.0)
    if "greedy" in task.name:
        return _greedy(task)
    return run_task(task)


def slowly(task: ClipTask) -> Outcome:
    """The same after a while, so that others can be ended meanwhile."""
    time.sleep(0.15)
    return run_task(task)


def run_slowly(folder: str, out: str) -> None:
    """A whole run over two processes, in one that is to be ended."""
    sources = find_input_clips([folder]).sources
    run_batch(Path(out), sources, Parameters(refine=True), _two_slow_ones)


def _two_slow_ones(
    tasks: Sequence[ClipTask], seconds: Callable[[ClipTask], float]
) -> Iterator[tuple[ClipTask, Outcome | Exception]]:
    return map_in_processes(slowly, tasks, 2, apart=True, seconds=seconds)


def _greedy(task: ClipTask) -> Outcome:
    from twistcore.batch import clip_result

    def much(*_: object) -> None:
        bytearray(10**10)  # more than it may have, though there were enough

    clip_result.process_clip = much  # type: ignore[assignment]
    try:
        return run_task(task)
    finally:
        del sys.modules[clip_result.__name__]
