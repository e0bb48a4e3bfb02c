"""A folder that `twistcore batch` left: what it found in its clips, and how their review goes."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from inspector.folder.queued_clip import ClipState, QueuedClip
from inspector.session.session_files import decided_in, kept_sessions
from inspector.widgets.background import Task
from twistcore.batch.clip_task import signature_of
from twistcore.batch.decisions import decisions_of
from twistcore.batch.manifest import DONE, FAILED, ClipGlance, Manifest
from twistcore.file_marks import sha256_of


class BatchFolder(QObject):
    """The clips of a manifest, wherever they lie; decisions about them are noted in it."""

    failed = Signal(str)  # a sentence: decisions could not be noted

    def __init__(self, folder: Path, parent: QObject) -> None:
        super().__init__(parent)
        self.folder = folder
        self.sources: dict[Path, str] = {}

    def clips(self) -> list[QueuedClip]:
        """All of them as the manifest has them; who changed since is to be analysed again.

        Raises TwistError.
        """
        with Manifest.open(self.folder) as manifest:
            glances = manifest.glances()
        self.sources = {Path(glance.source): glance.source for glance in glances}
        return [_queued(glance) for glance in glances]

    def note(self, path: Path) -> None:
        """Keep in the manifest how far a clip's review is by its session; in the background."""
        if (source := self.sources.get(path)) is None:
            return
        task = Task(lambda _: self._noted(path, source), self)
        task.failed.connect(
            lambda error: self.failed.emit(
                f"{path.name}: decisions not noted in the batch: {error}"
            )
        )
        task.finished.connect(task.deleteLater)
        task.failed.connect(task.deleteLater)
        task.start()

    def _noted(self, path: Path, source: str) -> None:
        sessions = kept_sessions(path)
        with Manifest.open(self.folder) as manifest:
            manifest.note_decisions(source, decisions_of(sessions[0]) if sessions else {})


def _queued(glance: ClipGlance) -> QueuedClip:
    path = Path(glance.source)
    if glance.state == FAILED:
        return QueuedClip(path, ClipState.FAILED, reason=glance.reason)
    if "://" in glance.source:
        reason = f"{glance.source}: not on a disk of this machine; open a copy of it"
        return QueuedClip(path, ClipState.FAILED, reason=reason)
    known = QueuedClip(path, decided=decided_in(path))
    if glance.state != DONE or not _is_same(path, glance):
        return known
    return QueuedClip(
        path,
        ClipState.READY,
        glance.severity,
        glance.intervals,
        reason=glance.unchecked,
        decided=known.decided,
        unchecked=bool(glance.unchecked),
    )


def _is_same(path: Path, glance: ClipGlance) -> bool:
    """Whether a file is the one that was processed; read where its time does not tell."""
    with suppress(OSError):
        if glance.signature:
            return signature_of(path)[0] == glance.signature
        return sha256_of(path) == glance.sha256
    return False
