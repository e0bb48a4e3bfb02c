"""Nothing decided is lost: the session beside the clip, its journal, and the lock on both.

Where the clip's folder cannot be written, they are in a folder of the person's own: the refuge.
"""

from __future__ import annotations

import errno
import hashlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import platformdirs
from PySide6.QtCore import QLockFile, QObject, QTimer, Signal

from twistcore.bvh import Clip
from twistcore.errors import TwistError
from twistcore.review import Command, Journal, Recovered, Review, recover, write_session
from twistcore.review.journal import command_to_json, state_entry

SESSION_SUFFIX = ".twist.json"
_JOURNAL_SUFFIX = ".journal"
_IDLE_MS = 300  # a drag that pauses this long is put on disk
_NOT_ALLOWED = (errno.EACCES, errno.EPERM, errno.EROFS)


def session_path(clip: Path) -> Path:
    """Where a clip's session lies unless the person says otherwise."""
    return clip.with_name(clip.stem + SESSION_SUFFIX)


def refuge_path(clip: Path) -> Path:
    """Where the session lies if the clip's folder cannot be written."""
    mark = hashlib.sha256(str(clip.resolve()).encode()).hexdigest()[:12]
    folder = platformdirs.user_state_path("twist-inspector", appauthor=False)
    return folder / f"{clip.stem}-{mark}{SESSION_SUFFIX}"


def kept_session(clip: Path) -> Path | None:
    """The session that there is of a clip, the newer one if the refuge has one too."""
    there = [p for p in (refuge_path(clip), session_path(clip)) if p.exists()]
    return max(there, key=_written, default=None)


def _written(path: Path) -> int:
    return path.stat().st_mtime_ns


def set_aside(path: Path, why: str) -> str:
    """Rename a file that is of no use; returns the sentence that says so."""
    aside = path.with_name(path.name + ".damaged")
    try:
        path.replace(aside)
    except OSError as error:
        return f"{why}. It cannot be set aside ({error.strerror})."
    return f"{why}. It was set aside as {aside.name}."


@dataclass(frozen=True, eq=False)
class Leftover:
    """A journal that an earlier run left behind, and what it holds."""

    path: Path
    recovered: Recovered


class Keeper(QObject):
    """Journal, session file and lock of the open clip.

    The journal is begun with the first command, so that a clip that is only looked at leaves
    nothing behind. A drag is one entry: where it ended.
    """

    trouble = Signal(str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session_file: Path | None = None
        self.read_only = False
        self.away: Path | None = None  # the refuge, where the clip's folder cannot be written
        self._clip: Clip | None = None
        self._review: Review | None = None
        self._journal: Journal | None = None
        self._lock: QLockFile | None = None
        self._pending: Command | None = None
        self._first = 0  # position of the review's history at which the journal begins
        self._detached = False  # the journal no longer knows the review's history
        self._told = False
        self._idle = QTimer(self)
        self._idle.setSingleShot(True)
        self._idle.setInterval(_IDLE_MS)
        self._idle.timeout.connect(self.flush)

    # -- one clip after the other -------------------------------------------------------------

    def begin(self, clip: Clip, review: Review, session_file: Path | None) -> Leftover | None:
        """Watch over another clip's review; returns what an earlier run left unsaved."""
        self.end()
        self._clip, self._review = clip, review
        self.session_file = session_file
        self._told = False
        self.read_only = not self._take_lock()
        if self.read_only:
            return None
        there = [path for path in reversed(self._journal_paths()) if path.exists()]
        for path in sorted(there, key=_written, reverse=True):
            if (leftover := self._leftover(path)) is not None:
                return leftover
        return None

    def end(self) -> None:
        """Let the clip go; its journal stays unless everything in it is saved."""
        self.flush()
        if self._journal is not None:
            if self._review is not None and self._review.saved:
                self._journal.discard()
            else:
                self._journal.close()
        self._journal = None
        if self._lock is not None:
            self._lock.unlock()
        self._lock = None
        self._clip = self._review = None

    def give_up(self) -> None:
        """The person gives unsaved decisions up: the journal goes."""
        self._pending = None
        if self._journal is not None:
            self._journal.discard()
            self._journal = None

    def continue_with(self, review: Review, leftover: Leftover) -> None:
        """Go on with a recovered review; its journal is replaced by one that begins with it."""
        self._review = review
        self._start_journal(answered=leftover.path)
        if self._journal is not None and leftover.path != self._journal.path:
            self.forget(leftover)

    def forget(self, leftover: Leftover) -> None:
        """Delete what an earlier run left."""
        try:
            leftover.path.unlink(missing_ok=True)
        except OSError as error:
            self.trouble.emit(f"{leftover.path}: not deleted ({error.strerror}).")

    # -- recording ----------------------------------------------------------------------------

    def record(self, command: Command, drag: int = 0) -> None:
        """Put a command on disk; a step of a drag waits for the drag's end."""
        if self._pending is not None and not command.continues(self._pending):
            self.flush()
        if drag:
            self._pending = command
            self._idle.start()
            if self._journal is None:
                self._start_journal(before_last=True)
        else:
            self._append(command_to_json(command))

    def record_step(self, entry: Mapping[str, Any]) -> None:
        """Put an undo or redo on disk; what is older than the journal, as the whole state."""
        self.flush()
        if self._clip is None or self._review is None:
            return
        if self._journal is None:
            self._start_journal()
            self._detached = True
        if self._review.position < self._first:
            self._detached = True
        state = state_entry(self._clip, self._review.state)
        self._append(state if self._detached else entry)

    def flush(self) -> None:
        """Put a waiting drag on disk."""
        self._idle.stop()
        if self._pending is not None:
            pending, self._pending = self._pending, None
            self._append(command_to_json(pending))

    def save(self) -> str:
        """Write the session file; a sentence if that failed, else ''."""
        if self._clip is None or self._review is None:
            return ""
        wanted = self.session_file or session_path(self._clip.path)
        if self.read_only:
            return f"{wanted.name} is open in another window; this one cannot save it."
        self.flush()
        refuge = refuge_path(self._clip.path)
        for path in (wanted, refuge):
            try:
                if path == refuge:
                    path.parent.mkdir(parents=True, exist_ok=True)
                write_session(path, self._clip, self._review.state)
            except OSError as error:
                last = error
                if error.errno in _NOT_ALLOWED:
                    continue
                break
            self.session_file = path
            self._review.mark_saved()
            self.give_up()
            return ""
        kept = "in the journal" if self._journal is not None else "in this window only"
        return f"{wanted}: not saved ({last.strerror}). Your decisions stay {kept}."

    # -- paths and lock -----------------------------------------------------------------------

    @property
    def journal_path(self) -> Path:
        """Beside the session."""
        assert self._clip is not None
        path = self.session_file or session_path(self._clip.path)
        return path.with_name(path.name + _JOURNAL_SUFFIX)

    def _journal_paths(self) -> tuple[Path, Path]:
        """Where the journal is to be, and where it goes if that folder cannot be written."""
        assert self._clip is not None
        refuge = refuge_path(self._clip.path)
        return self.journal_path, refuge.with_name(refuge.name + _JOURNAL_SUFFIX)

    def _take_lock(self) -> bool:
        wanted, refuge = self._journal_paths()
        self.away = None
        for path in (wanted, refuge):
            if path == refuge:
                with suppress(OSError):
                    path.parent.mkdir(parents=True, exist_ok=True)
            lock = QLockFile(str(path.with_name(path.name + ".lock")))
            lock.setStaleLockTime(0)  # never by age: Qt looks whether the process is still alive
            if lock.tryLock(0):
                self._lock = lock
                self.away = path.parent if path != wanted else None
                return True
            if lock.error() == QLockFile.LockError.LockFailedError:
                return False
        return True  # nowhere to write: nobody else can either

    def _leftover(self, path: Path) -> Leftover | None:
        try:
            recovered = recover(path)
        except TwistError as error:
            self.trouble.emit(set_aside(path, str(error)))
            return None
        assert self._clip is not None
        if recovered.session.sha256 != self._clip.sha256:
            why = f"{path.name} belongs to another version of the clip"
            self.trouble.emit(set_aside(path, why))
            return None
        if recovered.damaged:
            self.trouble.emit(
                f"{path.name}: {recovered.damaged} entries are damaged; those before are kept."
            )
        return Leftover(path, recovered)

    # -- the journal --------------------------------------------------------------------------

    def _append(self, entry: Mapping[str, Any]) -> None:
        if self.read_only or self._clip is None:
            return
        if self._journal is None:
            self._start_journal(before_last=True)
        if self._journal is None:
            return
        try:
            self._journal.append(entry)
        except OSError as error:
            self._complain(error)
            self._journal.close()
            self._journal = None

    def _start_journal(self, *, before_last: bool = False, answered: Path | None = None) -> None:
        """Begin a journal with the review as it is, or as it was before its last command.

        What an earlier run left is kept under another name, unless it was answered.
        """
        if self.read_only or self._clip is None or self._review is None:
            return
        state = self._review.state_before_last if before_last else self._review.state
        wanted, refuge = self._journal_paths()
        for path in (wanted, refuge):
            try:
                if path == refuge:
                    path.parent.mkdir(parents=True, exist_ok=True)
                if path.exists() and self._journal is None and path != answered:
                    path.replace(path.with_name(path.name + ".unanswered"))
                if self._journal is not None:
                    self._journal.close()
                self._journal = Journal(path, self._clip, state)
                self._first = self._review.position - (1 if before_last else 0)
                self._detached = False
            except OSError as error:
                self._journal = None
                last = error
                continue
            return
        self._complain(last)

    def _complain(self, error: OSError) -> None:
        if not self._told:
            self._told = True
            self.trouble.emit(
                f"The journal cannot be written ({error.strerror}): save the session soon."
            )
