"""The queue of a folder's clips, which worker processes analyse in the background."""

from __future__ import annotations

import math
import multiprocessing
import os
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import groupby
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from PySide6.QtCore import QFileSystemWatcher, QObject, QTimer, Signal

from inspector.folder.batch_folder import BatchFolder
from inspector.folder.queued_clip import (
    GONE,
    KILLED,
    NOT_BEGUN,
    TOO_SLOW,
    ClipState,
    QueuedClip,
)
from inspector.folder.survey_worker import survey_clips_from_pipe
from inspector.language import tr
from inspector.session.leftovers import clips_to_restore
from inspector.session.session_files import decided_counts, modified_ns
from twistcore.batch import ClipSurvey, is_batch_folder
from twistcore.batch.manifest import FILE as MANIFEST
from twistcore.errors import TwistError
from twistcore.export.exported_clips import find_exports_and_their_sources
from twistcore.files.atomic import same_file
from twistcore.files.ordinary import path_exists
from twistcore.formats.clip_files import clip_paths_in_folder
from twistcore.tuning import Profile

_POLL_MS = 40
_ENOUGH = 20  # this many analysed clips are enough to know a bad one, in a folder of any size
_PATIENCE_S = 20.0  # time limit for a clip; a second per megabyte is added
_BATCH_MS = 3_000  # time between checks of whether a running batch has ended
_SETTLE_MS = 500  # time without changes in the folder until it is read again


@dataclass(eq=False)
class _Worker:
    process: BaseProcess
    pipe: Connection
    path: Path | None = None
    until: float = 0.0

    def kill(self) -> None:
        self.pipe.close()
        self.process.kill()
        self.process.join(1.0)
        self.process.close()


class FolderQueue(QObject):
    """The clips of a folder, and the processes that survey the clips.

    `changed` is emitted after every change.
    """

    changed = Signal()
    finished = Signal()
    profile_changed = Signal()
    failed = Signal(str)  # with an error message about the manifest of a batch

    def __init__(self, workers: int = 0, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.folder: Path | None = None
        self.clips: dict[Path, QueuedClip] = {}
        # The τ for all clips; None for the automatic τ of each clip
        self.profile: Profile | None = None
        self.profile_name = ""
        # Exported clips in the folder, which are not surveyed
        self.exports: frozenset[Path] = frozenset()
        self.batch: BatchFolder | None = None  # None unless `twistcore batch` wrote the folder
        self._from_batch: set[Path] = set()  # clips whose results are those of the batch
        self._elsewhere: dict[Path, str] = {}  # file names of exports in this run, keyed by clip
        self._count = workers or max(1, (os.cpu_count() or 2) - 1)  # leave one core to the window
        self._workers: list[_Worker] = []
        self._started = 0.0
        self._poll = QTimer(self, interval=_POLL_MS)
        self._poll.timeout.connect(self._poll_workers)
        self._settle = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._settle.timeout.connect(self.rescan)
        self._again = QTimer(self, singleShot=True, interval=_BATCH_MS)
        self._again.timeout.connect(self.rescan)
        self._watcher = QFileSystemWatcher(self)
        self._watcher.directoryChanged.connect(lambda _: self._settle.start())
        self._watcher.fileChanged.connect(lambda _: self._settle.start())

    # -- state for the views ------------------------------------------------------------------

    @property
    def ordered(self) -> list[QueuedClip]:
        """All clips in order: surveyed clips (worst first), waiting clips, failed clips."""

        def rank(clip: QueuedClip) -> tuple[int, float, str]:
            group = {ClipState.READY: 0, ClipState.FAILED: 2}.get(clip.state, 1)
            return group, -clip.severity, clip.path.name

        return sorted(self.clips.values(), key=rank)

    @property
    def progress(self) -> tuple[int, int]:
        """The number of clips that are surveyed or have failed, and the total number of clips."""
        over = sum(c.state in (ClipState.READY, ClipState.FAILED) for c in self.clips.values())
        return over, len(self.clips)

    @property
    def seconds_left(self) -> float:
        """The estimated time, in seconds, until all clips are surveyed."""
        done, total = self.progress
        passed = time.monotonic() - self._started
        return passed / done * (total - done) if done else 0.0

    @property
    def running(self) -> bool:
        """Return True while a survey is running."""
        return self._poll.isActive()

    @property
    def knows_enough(self) -> bool:
        """Return True if a tenth of the clips, or 20 clips, have been analysed."""
        done, total = self.progress
        return done >= min(_ENOUGH, math.ceil(total / 10))

    def worse_than(self, path: Path) -> QueuedClip | None:
        """Return the worst clip that still needs a review, or None.

        The result is None if no such clip is worse than the clip at `path`.
        """
        if path not in self.clips:
            return None
        least = self.clips[path].severity
        worst = next((clip for clip in self.ordered if clip.to_do), None)
        return worst if worst is not None and worst.severity > least else None

    def next_after(self, path: Path | None) -> Path | None:
        """Return the next clip, from worst to best, with undecided intervals or unsaved decisions.

        The search starts after `path` and wraps around at the end of the list. Returns None if
        there is no such clip.
        """
        ordered = self.ordered
        at = next((k for k, c in enumerate(ordered, 1) if c.path == path), 0)
        behind = (c for c in (*ordered[at:], *ordered[:at]) if c.to_do and c.path != path)
        return next((c.path for c in behind), None)

    def listed(self, path: Path) -> Path:
        """Return the path under which the folder lists the clip at `path`.

        If the folder does not list this clip, `path` itself is returned.
        """
        own = (p for p in self.clips if p.name == path.name and same_file(p, path))
        return path if path in self.clips else next(own, path)

    @property
    def totals(self) -> tuple[int, int, int, int]:
        """The number of finished clips, clips with intervals, decided intervals, all intervals."""
        clips = [c for c in self.clips.values() if c.state != ClipState.FAILED]
        due = [c for c in clips if c.done or c.to_do]
        counts = [c.counts for c in clips]
        through = sum(not c.to_do for c in due)
        return through, len(due), sum(n for n, _ in counts), sum(n for _, n in counts)

    @property
    def profile_text(self) -> str:
        """A text that describes the source of τ for surveying and opening clips."""
        if self.profile_name:
            return self.profile_name
        if self.batch is not None:
            if options := self.batch.options:
                return tr("from the batch ({options})", options=options)
            return tr("from the batch, automatic for each clip")
        return tr("automatic for each clip")

    def profile_of(self, path: Path) -> Profile | None:
        """Return the τ and the detector that the folder or the batch sets for a clip, or None."""
        if self.profile is not None or self.batch is None:
            return self.profile if path in self.clips else None
        return self.batch.profile_of(path)

    # -- the folder ---------------------------------------------------------------------------

    def open(self, folder: Path, profile: Profile | None = None, name: str = "") -> None:
        """Survey (analyse) the clips of a folder, with the τ of a profile if given.

        Any running survey of a different folder is stopped. In a folder written by `twistcore
        batch`, only clips without a result are surveyed.
        """
        self.close()
        if is_batch_folder(folder):
            self.batch = BatchFolder(folder, self)
            self.batch.failed.connect(self.failed)
            self._watcher.addPath(str(folder / MANIFEST))  # a batch may still be running
        self.folder = folder
        self.profile, self.profile_name = profile, name
        self.clips, self._from_batch = {}, set()
        self.exports = frozenset()
        self._watcher.addPath(str(folder))
        self._started = time.monotonic()
        self.rescan()

    def rescan(self) -> None:
        """Add clips that are new in the folder, and mark clips that are missing."""
        if self.folder is None:
            return
        if self.batch is not None:
            self._take_batch(self.batch)
            return
        there = clip_paths_in_folder(self.folder)
        exported = find_exports_and_their_sources(there)
        self.exports = frozenset(exported)
        clips = [path for path in there if path not in exported]
        latest = {exported[path]: path.name for path in sorted(exported, key=modified_ns)}
        waiting = clips_to_restore(self.folder, clips)
        for path in clips:
            if path not in self.clips or self.clips[path].reason == GONE:
                self.clips[path] = QueuedClip(path, decided=decided_counts(path))
            name = latest.get(path.name, self._elsewhere.get(path, ""))
            self._put(path, exported=name, waits=path in waiting)
        for path in self.exports & self.clips.keys():
            del self.clips[path]
        for path in self.clips.keys() - clips:
            self._put(path, state=ClipState.FAILED, reason=GONE)
        self._continue()

    def _take_batch(self, batch: BatchFolder) -> None:
        """Use the results in the manifest of a batch, and survey the remaining clips.

        If a profile sets τ, the results of the batch are not used.
        """
        try:
            clips = batch.clips()
        except TwistError as error:
            self.failed.emit(str(error))
            return
        for clip in clips:
            before = self.clips.get(clip.path)
            # The known number is newer than the manifest's, for example if the clip is open
            if before is not None and before.decided is not None:
                clip = replace(clip, decided=before.decided)
            known = clip.state != ClipState.WAITING and (
                self.profile is None or clip.state == ClipState.FAILED
            )
            if known:
                self.clips[clip.path] = clip
                self._from_batch.add(clip.path)
            elif before is None or before.reason == GONE or clip.path in self._from_batch:
                self.clips[clip.path] = QueuedClip(
                    clip.path, decided=clip.decided, label=clip.label
                )
                self._from_batch.discard(clip.path)
        waiting, latest = set[Path](), dict[Path, str]()
        for folder, paths in groupby(sorted(self.clips), key=lambda path: path.parent):
            waiting |= clips_to_restore(folder, list(paths))
            exported = find_exports_and_their_sources(clip_paths_in_folder(folder))
            by_time = sorted(exported, key=modified_ns)
            latest |= {folder / exported[path]: path.name for path in by_time}
        for path, clip in self.clips.items():
            if clip.state != ClipState.FAILED and not path_exists(path):
                self._put(path, state=ClipState.FAILED, reason=GONE)
            name = latest.get(path, self._elsewhere.get(path, ""))
            self._put(path, exported=name, waits=path in waiting)
        if not batch.under_way:
            self._continue()
            return
        if any(c.state == ClipState.WAITING for c in self.clips.values()):
            self._again.start()  # the batch analyses these clips unless it ends early
        self.changed.emit()

    def _continue(self) -> None:
        """Start surveying the waiting clips."""
        if any(c.state == ClipState.WAITING for c in self.clips.values()):
            self._poll.start()
            self._poll_workers()
        self.changed.emit()

    def _put(self, path: Path, **known: Any) -> None:
        """Update fields in the entry of a clip, if the folder still lists the clip."""
        if path in self.clips:
            self.clips[path] = replace(self.clips[path], **known)

    def use_profile(self, profile: Profile | None, name: str = "") -> None:
        """Survey the folder again with the τ of a profile; None stands for automatic τ."""
        self.cancel()
        self.profile, self.profile_name = profile, name
        self.clips = {
            path: QueuedClip(path, decided=c.decided, label=c.label)
            for path, c in self.clips.items()
        }
        self.profile_changed.emit()
        self._started = time.monotonic()
        self.rescan()

    def refresh(self, path: Path) -> None:
        """Read the session of a clip again after the session was saved."""
        self.note(path, decided_counts(path))
        if self.batch is not None:
            self.batch.note(path)

    def note(self, path: Path, decided: tuple[int, int] | None) -> None:
        """Record the progress of a clip's review: the number of decided and of all intervals."""
        if path in self.clips and self.clips[path].decided != decided:
            self._put(path, decided=decided)
            self.changed.emit()

    def note_export(self, path: Path, export: Path) -> None:
        """Record that a clip was exported."""
        self._elsewhere[path] = export.name
        self.rescan()

    def cancel(self) -> None:
        """Stop surveying, but keep the results obtained so far."""
        self._stop()
        for path, clip in self.clips.items():
            if clip.state == ClipState.ANALYSING:
                self.clips[path] = replace(clip, state=ClipState.WAITING)
        self.changed.emit()

    def close(self) -> None:
        """Close the folder and end the worker processes."""
        self.cancel()
        if watched := self._watcher.directories() + self._watcher.files():
            self._watcher.removePaths(watched)
        self.folder = self.batch = None

    # -- the processes ------------------------------------------------------------------------

    def _poll_workers(self) -> None:
        """Collect results, remove dead workers and assign clips to idle workers.

        A timer calls this method.
        """
        changed = bool([w for w in tuple(self._workers) if self._check(w)])
        waiting = [p for p, c in self.clips.items() if c.state == ClipState.WAITING]
        while waiting and len(self._workers) < self._count:
            self._workers.append(_spawn())
        for worker in self._workers:
            if worker.path is None and waiting:
                self._give(worker, waiting.pop(0))
                changed = True
        if not waiting and all(w.path is None for w in self._workers):
            self._stop()
            self.finished.emit()
        if changed:
            self.changed.emit()

    def _give(self, worker: _Worker, path: Path) -> None:
        size = 0
        with suppress(OSError):
            size = path.stat().st_size
        worker.path = path
        worker.until = time.monotonic() + _PATIENCE_S + size / 1e6
        self._put(path, state=ClipState.ANALYSING)
        try:
            worker.pipe.send((path, self.profile))
        except OSError:
            self._end(worker, NOT_BEGUN)

    def _check(self, worker: _Worker) -> bool:
        """Handle an answer, a timeout or the end of a worker process.

        Returns False if none of these has occurred.
        """
        if worker.path is None:
            return False
        try:
            if worker.pipe.poll():
                self._take(worker.path, worker.pipe.recv())
                worker.path = None
            elif time.monotonic() > worker.until:
                self._end(worker, TOO_SLOW)
            else:
                return False
        except (EOFError, OSError):
            self._end(worker, KILLED)
        return True

    def _take(self, path: Path, answer: ClipSurvey | str) -> None:
        if isinstance(answer, str):
            self._put(path, state=ClipState.FAILED, reason=answer)
        else:
            self._put(
                path,
                state=ClipState.READY,
                severity=answer.severity,
                intervals=answer.intervals,
                reason=answer.unchecked,
                unchecked=bool(answer.unchecked),
                missing=answer.missing_frames,
                unexamined=answer.unexamined,
                automatic=answer.automatic,
            )

    def _end(self, worker: _Worker, reason: str) -> None:
        if worker.path is not None:
            self._put(worker.path, state=ClipState.FAILED, reason=reason)
        worker.kill()
        self._workers.remove(worker)

    def _stop(self) -> None:
        self._poll.stop()
        for worker in self._workers:
            worker.kill()
        self._workers = []


def _spawn() -> _Worker:
    # Spawn, because a fork of a program with threads and an X connection may hang.
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=survey_clips_from_pipe, args=(theirs,), daemon=True)
    process.start()
    theirs.close()
    return _Worker(process, ours)
