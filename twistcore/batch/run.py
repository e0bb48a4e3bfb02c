"""Run a batch: process all clips that have no result yet, and store each result immediately."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Protocol

from twistcore.batch.clip_task import ClipTask, Outcome
from twistcore.batch.corrected_files import FOLDER, is_corrected_file_unchanged, write_corrected
from twistcore.batch.inputs import Source, assign_batch_names
from twistcore.batch.manifest import DONE, FAILED, Manifest, ManifestRow, manifest_timestamp
from twistcore.batch.parameters import Parameters
from twistcore.batch.run_plan import Plan, make_plan, shard_sources
from twistcore.errors import TwistError
from twistcore.files.atomic import remove_half_written_files
from twistcore.files.lock import lock_file
from twistcore.files.ordinary import check_no_links
from twistcore.work.memory import SPARE
from twistcore.work.processes import describe_failure

LOCK = "manifest.lock"

# Processor time allowed for a clip. Even restless motion needs only a few seconds per megabyte.
_PATIENCE_S, _PER_MEGABYTE_S = 300.0, 60.0
# Storing results takes about 8 ms for any number of clips, so results are stored together.
_TOGETHER_S = 0.1
_IN_VAIN = 20  # a run stops after this many consecutive clips whose results could not be stored


class CarryOut(Protocol):
    """The type of a function that runs tasks, in local processes or on a cluster."""

    def __call__(
        self, tasks: Sequence[ClipTask], seconds: Callable[[ClipTask], float]
    ) -> Iterator[tuple[ClipTask, Outcome | Exception]]:
        """Yield each task with its outcome or exception, in order of completion.

        `seconds` is a function that returns the processor time, in seconds, allowed for a task.
        Raises TwistError if no further task can be run.
        """
        ...


@dataclass(frozen=True)
class Limits:
    """The time and memory allowed for each clip.

    Parameters
    ----------
    seconds
        Processor time, None for five minutes plus one minute per megabyte.
    memory
        Bytes of memory allowed in addition to the usual need of a clip of this size.
    """

    seconds: float | None = None
    memory: int = SPARE

    def seconds_of(self, task: ClipTask) -> float:
        """Return the processor time allowed for a task, in seconds."""
        return (
            _PATIENCE_S + _PER_MEGABYTE_S * task.size / 1e6
            if self.seconds is None
            else self.seconds
        )


@dataclass
class RunSummary:
    """The clip counts of a batch run, and its failures.

    Parameters
    ----------
    done
        Number of clips processed in this run.
    known
        Number of clips with a result from an earlier run.
    failed
        A sentence for each failed clip.
    unreadable
        Number of failed clips whose content cannot be processed.
    stopped
        The reason why the run ended early, or an empty string.
    left
        Number of clips that were not processed.
    names
        Names of the clips processed in this run.
    """

    done: int = 0
    known: int = 0
    failed: list[str] = field(default_factory=list)
    unreadable: int = 0
    stopped: str = ""
    left: int = 0
    names: set[str] = field(default_factory=set)


Tell = Callable[[Source, bool], None]  # called for each finished clip, with True if it succeeded


def run_batch(
    folder: Path,
    sources: Iterable[Source],
    parameters: Parameters,
    carry_out: CarryOut,
    *,
    limits: Limits = Limits(),
    part: tuple[int, int] = (1, 1),
    begin: Callable[[Plan], Tell] = lambda _plan: lambda _source, _fine: None,
) -> RunSummary:
    """Process the clips that have no result yet, and store their results in a batch folder.

    Parameters
    ----------
    folder
        The batch folder, which is created if needed.
    sources
        The clips.
    parameters
        The processing parameters.
    carry_out
        A function that runs the tasks.
    limits
        The time and memory allowed for each clip.
    part
        The index of this shard, counted from 1, and the number of shards. Only this shard's clips
        are processed.
    begin
        A function that is called with the plan of the run. It returns a function that is called for
        each finished clip.

    Raises
    ------
    TwistError
        If another run writes into the folder, or if its manifest is damaged.
    """
    with lock_batch_folder(folder), Manifest.open(folder, create=True) as manifest:
        rows = manifest.rows()
        named = assign_batch_names(sources, {row.source: row.name for row in rows.values()})
        mine = shard_sources(named, *part)
        plan = make_plan(manifest, mine, parameters, partial(is_corrected_file_unchanged, folder))
        with manifest.transaction():
            manifest.put_parameters(parameters)
            manifest.put_rows(plan.notes)
        summary = RunSummary(known=plan.known, left=len(plan.todo))
        summary.failed = [row.reason for row in plan.failed]
        summary.unreadable = len(plan.failed)
        if plan.todo:
            if parameters.refine:
                remove_half_written_files(folder / FOLDER)
            run = _Run(folder, manifest, plan, parameters, summary, begin(plan))
            run.go(carry_out, limits)
        return summary


class _Run:
    """A batch run in progress, which stores the results and corrected files of finished clips."""

    def __init__(
        self,
        folder: Path,
        manifest: Manifest,
        plan: Plan,
        parameters: Parameters,
        summary: RunSummary,
        tell: Tell,
    ) -> None:
        self.folder, self.manifest, self.summary, self.tell = folder, manifest, summary, tell
        self.parameters, self.mark = parameters, parameters.mark
        self.rows = plan.rows
        self.todo = {source.path: source for source in plan.todo}
        self.in_vain = 0
        self.pending: list[tuple[Source, ManifestRow, Outcome]] = []
        self.noted = time.monotonic()

    def go(self, carry_out: CarryOut, limits: Limits) -> None:
        tasks = [
            ClipTask(s.path, s.name, s.size, self.parameters, limits.memory)
            for s in self.todo.values()
        ]
        found = carry_out(tasks, limits.seconds_of)
        try:
            for task, outcome in found:
                self._take(self.todo[task.source], outcome)
                if time.monotonic() - self.noted > _TOGETHER_S:
                    self._note()
                if self.in_vain >= _IN_VAIN:
                    raise TwistError("the manifest can no longer be written")
        except TwistError as error:
            self.summary.stopped = str(error)
        except KeyboardInterrupt:
            self.summary.stopped = "stopped"
        finally:
            self._note()
            close = getattr(found, "close", None)
            if close is not None:
                close()

    def _take(self, source: Source, outcome: Outcome | Exception) -> None:
        if isinstance(outcome, Exception):
            outcome = Outcome(reason=describe_failure(source.name, outcome), again=True)
        row = ManifestRow(
            source.path,
            source.name,
            DONE if outcome.result is not None else FAILED,
            outcome.reason,
            outcome.again,
            self.mark,
            outcome.sha256,
            outcome.bytes,
            outcome.signature,
            outcome.seconds,
            outcome.peak_bytes,
            manifest_timestamp(),
        )
        known = self.rows.get(source.path)
        if outcome.corrected is not None:
            try:
                row = write_corrected(
                    self.folder, row, known, outcome.corrected, outcome.companions
                )
            except (TwistError, OSError) as error:
                row = _failed(row, _write_problem(source.name, error))
        if known is not None and not row.corrected:  # the earlier corrected file still exists
            row = replace(row, corrected_sha256=known.corrected_sha256)
        self.pending.append((source, row, outcome))

    def _note(self) -> None:
        """Store all pending outcomes in one transaction or, if that fails, one by one."""
        pending, self.pending = self.pending, []
        try:
            self._put(pending)
            noted = [(source, row) for source, row, _ in pending]
            self.in_vain = 0
        except TwistError:
            noted = [(one[0], self._note_one(one)) for one in pending]
        self.noted = time.monotonic()
        for (source, row), (_, _, outcome) in zip(noted, pending, strict=True):
            fine = row.state == DONE
            self.summary.left -= 1
            self.summary.done += fine
            if fine:
                self.summary.names.add(source.name)
            else:
                self.summary.failed.append(row.reason)
                self.summary.unreadable += outcome.unseen or not row.again
            self.tell(source, fine)

    def _note_one(self, one: tuple[Source, ManifestRow, Outcome]) -> ManifestRow:
        """Store one outcome, and return its row. If this fails, the row is marked as failed."""
        source, row, _ = one
        try:
            self._put([one])
        except TwistError as error:
            self.in_vain += 1
            row = _failed(
                row,
                f"{source.name}: the clip was processed, but its result cannot be "
                f"recorded: {error}",
            )
            # The manifest already has a row for the clip, so this may work even on a full disk.
            with suppress(TwistError), self.manifest.transaction():
                self.manifest.put_rows([row])
        else:
            self.in_vain = 0
        return row

    def _put(self, some: Sequence[tuple[Source, ManifestRow, Outcome]]) -> None:
        if not some:
            return
        with self.manifest.transaction():
            self.manifest.put_rows(row for _, row, _ in some)
            for _, row, outcome in some:
                if row.state == DONE and outcome.result is not None:
                    self.manifest.put_result(row, outcome.result)


def _failed(row: ManifestRow, why: str) -> ManifestRow:
    return replace(row, state=FAILED, reason=" ".join(why.splitlines()), again=True)


def _write_problem(name: str, error: TwistError | OSError) -> str:
    if isinstance(error, OSError):
        return f"{name}: the corrected clip cannot be written ({error.strerror})"
    return f"{name}: {error}"


@contextmanager
def lock_batch_folder(folder: Path) -> Iterator[None]:
    """Lock the folder for this run, creating it if needed.

    Raises TwistError if another run has locked it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in (LOCK, FOLDER):
        check_no_links(folder, folder / name)
    handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        if not lock_file(handle):
            raise TwistError(
                f"{folder}: another run of twistcore batch is writing to this folder; wait "
                "until it has ended"
            )
        yield
    finally:
        os.close(handle)
