"""Read a folder written by `twistcore batch`: its results and the progress of its reviews."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal

from inspector.folder.queued_clip import FAR_AWAY, ClipState, QueuedClip
from inspector.language import tr, translate_core_sentence
from inspector.session.session_files import decided_counts, find_existing_sessions
from inspector.widgets.background import Task
from twistcore.batch.clip_task import file_change_signature
from twistcore.batch.decisions import count_decisions
from twistcore.batch.manifest import DONE, FAILED, ClipGlance, Manifest
from twistcore.batch.run import LOCK
from twistcore.detection import DEFAULT_METHOD
from twistcore.errors import TwistError
from twistcore.files.lock import is_file_locked
from twistcore.files.marks import cached_sha256
from twistcore.tuning import Profile

# Options of a batch that the window cannot use, keyed by their names in the manifest.
_ELSEWHERE = {"fps": "--fps", "kinds": "--kinds", "chains": "--chain", "rig": "--rig"}


class BatchFolder(QObject):
    """The clips in a batch's manifest (database), with the progress of their reviews.

    Attributes
    ----------
    options
        A description of those options of the batch that differ from the defaults.
    """

    failed = Signal(str)  # with the reason why decisions cannot be recorded

    def __init__(self, folder: Path, parent: QObject) -> None:
        super().__init__(parent)
        self.folder = folder
        self.options = ""
        self._glances: dict[Path, ClipGlance] = {}
        self._parameters: dict[str, dict[str, Any]] = {}
        self._noting = 0
        self._then: Callable[[], None] | None = None

    @property
    def under_way(self) -> bool:
        """Return True while a batch is still writing to the folder."""
        return is_file_locked(self.folder / LOCK)

    def clips(self) -> list[QueuedClip]:
        """Return the clips in the manifest. Raises TwistError.

        A clip is marked for a new analysis if it has changed since the batch, or if the batch used
        options that the window does not support.
        """
        with Manifest.open(self.folder) as manifest:
            glances, self._parameters = manifest.glances(), manifest.parameters()
        self._glances = {Path(glance.source): glance for glance in glances}
        used = {glance.mark for glance in glances if glance.mark}
        words = {_options_text(self._parameters.get(mark, {})) for mark in used}
        self.options = "; ".join(sorted(words - {""}))
        return [self._queued(glance) for glance in glances]

    def profile_of(self, path: Path) -> Profile | None:
        """Return the τ and detector that the batch used for a clip, or None for the defaults."""
        glance = self._glances.get(path)
        given = self._parameters.get(glance.mark, {}) if glance is not None else {}
        if glance is None or not _options_text(given):
            return None
        tau: Mapping[str, float] = {}
        if given["tau_deg"] is not None or given["profile_rad"] is not None:
            try:
                with Manifest.open(self.folder) as manifest:
                    tau = (manifest.record(glance.source).result or {}).get("tau_deg", {})
            except TwistError as error:
                self.failed.emit(str(error))
        return Profile({k: math.radians(v) for k, v in tau.items()}, given["method"])

    def _queued(self, glance: ClipGlance) -> QueuedClip:
        path = Path(glance.source)
        known = QueuedClip(path, label=glance.name)
        if glance.state == FAILED:
            return replace(known, state=ClipState.FAILED, reason=glance.reason)
        if "://" in glance.source:
            reason = f"{glance.source}: {FAR_AWAY}"
            return replace(known, state=ClipState.FAILED, reason=reason)
        known = replace(known, decided=decided_counts(path))
        given = self._parameters.get(glance.mark, {})
        if glance.state != DONE or any(given.get(k) for k in _ELSEWHERE):
            return known
        if not _is_same(path, glance):
            return known
        return replace(
            known,
            state=ClipState.READY,
            severity=glance.severity,
            intervals=glance.intervals,
            reason=glance.unchecked,
            unchecked=bool(glance.unchecked),
            missing=glance.missing_frames,
            unexamined=glance.unexamined,
        )

    # -- decisions ----------------------------------------------------------------------------

    def note(self, path: Path) -> None:
        """Record the progress of a clip's review in the manifest, in the background."""
        if (glance := self._glances.get(path)) is None:
            return
        self._noting += 1
        task = Task(lambda _: self._record(path, glance.source), self)
        task.failed.connect(lambda error: self._report_failure(path, error))
        for over in (task.finished, task.failed):
            over.connect(self._count_down)
            over.connect(task.deleteLater)
        task.start()

    def when_recorded(self, then: Callable[[], None]) -> None:
        """Call `then` as soon as all decisions are recorded in the manifest."""
        if self._noting:
            self._then = then
        else:
            then()

    def _report_failure(self, path: Path, error: Exception) -> None:
        message = tr(
            "Your decisions on {name} could not be saved in the batch folder: {error}",
            name=path.name,
            error=translate_core_sentence(str(error)),
        )
        self.failed.emit(message)

    def _count_down(self) -> None:
        self._noting -= 1
        if not self._noting and self._then is not None:
            then, self._then = self._then, None
            then()

    def _record(self, path: Path, source: str) -> None:
        sessions = find_existing_sessions(path)
        with Manifest.open(self.folder) as manifest:
            manifest.note_decisions(source, count_decisions(sessions[0]) if sessions else {})


def _options_text(given: Mapping[str, Any]) -> str:
    """Return a description of a batch's options that differ from the defaults."""
    parts = []
    if given.get("tau_deg") is not None:
        parts.append(f"τ {given['tau_deg']:g}°")
    if given.get("profile_rad") is not None:
        parts.append(tr("τ from a profile"))
    if given.get("method", DEFAULT_METHOD) != DEFAULT_METHOD:
        parts.append(tr("detector {name}", name=given["method"]))
    if elsewhere := [option for name, option in _ELSEWHERE.items() if given.get(name)]:
        listed = ", ".join(elsewhere)
        parts.append(tr("{options} (ignored in this window)", options=listed))
    return ", ".join(parts)


def _is_same(path: Path, glance: ClipGlance) -> bool:
    """Return True if a file is unchanged since the batch processed it."""
    with suppress(OSError):
        if glance.signature:
            return file_change_signature(path)[0] == glance.signature
        return cached_sha256(path) == glance.sha256
    return False
