"""Nothing decided is lost: the session beside the clip, its journal, and the lock on both."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from inspector.leftovers import Leftover, holds_more, read_leftover
from inspector.lock import ReviewLock
from inspector.session_files import (
    JOURNAL_SUFFIX,
    journals,
    refuge_path,
    session_path,
    written,
)
from twistcore.atomic import free_name, write_atomically
from twistcore.bvh import Clip
from twistcore.review import Command, Journal, Review, ReviewState
from twistcore.review.journal import command_to_json, state_entry
from twistcore.review.session import session_bytes

_IDLE_MS = 300  # a drag that pauses this long is put on disk
_RETRY_MS = 5000  # what the disk did not take is tried again


class Keeper(QObject):
    """Journal, session file and lock of the open clip.

    The journal is begun with the first command, so that a clip that is only looked at leaves
    nothing behind. A drag is one entry: where it ended. A journal of an earlier run stays until it
    is answered: gone on with, in the same file, or forgotten.
    """

    told = Signal(str, bool)  # a sentence for the person; True if something went wrong
    failing = Signal(str)  # steps are not on disk, said again with every one
    locked = Signal()  # another window has, or has taken, the review

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session_file: Path | None = None
        self.read_only = False
        self.leftovers: list[Leftover] = []  # of earlier runs, not answered, the latest first
        self.away: Path | None = None  # the refuge, where the clip's folder cannot be written
        self.lock: ReviewLock | None = None
        self._clip: Clip | None = None
        self._review: Review | None = None
        self._journal: Journal | None = None
        self._pending: Command | None = None
        self._steps = 0  # of the review, not in a session file
        self._first = 0  # position of the review's history at which the journal begins
        self._detached = False  # the journal no longer knows the review's history
        self._behind = False  # the disk has not taken everything
        self._known: dict[Path, str] = {}  # session files as this program read or wrote them
        self._idle = QTimer(self)
        self._idle.setSingleShot(True)
        self._idle.setInterval(_IDLE_MS)
        self._idle.timeout.connect(self.flush)
        self._again = QTimer(self)
        self._again.setInterval(_RETRY_MS)
        self._again.timeout.connect(self.retry)

    # -- one clip after the other -------------------------------------------------------------

    def begin(
        self, clip: Clip, review: Review, session_file: Path | None, *, resumed: bool = False
    ) -> None:
        """Watch over another clip's review; `leftovers` are what earlier runs left of it.

        resumed: the review was put aside in this program, and its journal is gone on with.
        """
        self.end()
        self._clip, self._review = clip, review
        self.session_file = session_file
        self._known = {}
        if session_file is not None:
            self._know(session_file)
        self.read_only = not self._take_lock()
        if self.read_only:
            return
        found = self._find_leftovers()
        self.leftovers = [left for left in found if holds_more(left, clip, review.state)]
        same = [left for left in found if left not in self.leftovers]
        if resumed and not review.saved:
            if same and same[0].same_clip:
                self._resume(same.pop(0))
                self._detached = True
            else:
                self._begin_journal(review.state, steps=1)
        for leftover in same:
            self.forget(leftover)

    def _find_leftovers(self) -> list[Leftover]:
        """Journals beside the session and in the refuge, the latest first."""
        assert self._clip is not None
        found = []
        for path in (path for place in self._places() for path in journals(place)):
            leftover, told = read_leftover(path, self._clip)
            if told:
                self.told.emit(told, True)
            if leftover is not None:
                found.append(leftover)
        return sorted(found, key=lambda left: written(left.path), reverse=True)

    def end(self) -> None:
        """Let the clip go; its journal stays unless everything in it is saved."""
        self.flush()
        if self._journal is not None:
            self.retry()
            if self._review is not None and self._review.saved:
                self._journal.discard()
            else:
                self._journal.close()
        self._journal = None
        self._steps = 0
        self._detached = False
        self._caught_up()
        self.leftovers = []
        if self.lock is not None:
            self.lock.release()
        self.lock = None
        self._clip = self._review = None

    def give_up(self) -> None:
        """The person gives unsaved decisions up, or they are saved: the journal goes."""
        self._pending = None
        self._steps = 0
        self._detached = False
        self._caught_up()
        if self._journal is not None:
            self._journal.discard()
            self._journal = None

    def continue_with(self, leftover: Leftover) -> None:
        """Go on with a recovered review, in its own journal."""
        self.give_up()  # nothing was done in the review that was open
        self.leftovers.remove(leftover)
        self._review = leftover.recovered.review
        self._resume(leftover)
        self._first, self._detached = 0, False

    def forget(self, leftover: Leftover) -> None:
        """Delete what an earlier run left: it was answered, or there is nothing more in it."""
        self._done_with(leftover, lambda: leftover.path.unlink(missing_ok=True))

    def put_aside(self, leftover: Leftover) -> str:
        """Keep what an earlier run left under a name that is not offered; '' if that failed."""
        aside = free_name(leftover.path, ".earlier")
        done = self._done_with(leftover, lambda: leftover.path.rename(aside))
        return aside.name if done else ""

    def _done_with(self, leftover: Leftover, work: Callable[[], object]) -> bool:
        if leftover in self.leftovers:
            self.leftovers.remove(leftover)
        try:
            work()
        except OSError as error:
            self.told.emit(f"{leftover.path}: it stays where it is ({error.strerror}).", True)
            return False
        return True

    @property
    def on_disk(self) -> bool:
        """Whether every step of the review is in its journal."""
        return self._pending is None and not self._behind

    # -- recording ----------------------------------------------------------------------------

    def may_change(self) -> bool:
        """Whether the review is this window's to change; if not, `locked` says so."""
        if not self.read_only and not (self.lock is None or self.lock.is_ours()):
            self.flush()
            self.read_only = self.lock.holder is not None or not self._take_lock()
            if self.read_only and self._journal is not None:
                self._journal.close()  # it is offered to whoever has the review now
                self._journal = None
        if self.read_only:
            self.locked.emit()
        return not self.read_only

    def record(self, command: Command, drag: int = 0) -> None:
        """Put a command on disk; a step of a drag waits for the drag's end."""
        if self._pending is not None and not command.continues(self._pending):
            self.flush()
        if drag:
            self._pending = command
            self._idle.start()
            if self._journal is None and not self.read_only:
                self._begin_before_last()
        else:
            self._append(command_to_json(command))

    def record_step(self, entry: Mapping[str, Any]) -> None:
        """Put an undo or redo on disk; what is older than the journal, as the whole state."""
        self.flush()
        if self._clip is None or self._review is None:
            return
        if self._journal is None or self._review.position < self._first:
            self._detached = True
        state = state_entry(self._clip, self._review.state)
        self._append(state if self._detached else entry)

    def flush(self) -> None:
        """Put a waiting drag on disk."""
        self._idle.stop()
        if self._pending is not None:
            pending, self._pending = self._pending, None
            self._append(command_to_json(pending))

    def retry(self) -> bool:
        """Try again to put on disk what it did not take; True if all is there."""
        if self._behind and self._clip is not None and self._review is not None:
            if self._journal is None:
                self._begin_journal(self._review.state, self._steps)
            else:
                self._write(self._journal.write_waiting)
        return not self._behind

    def save(self, path: Path | None = None) -> tuple[bool, str]:
        """Write the session file, at `path` if given; whether it was, and what is to be said."""
        if self._clip is None or self._review is None:
            return True, ""
        wanted = path or self.session_file or session_path(self._clip.path)
        if self.read_only or not self.may_change():
            return False, f"{wanted.name} is open in another window; this one cannot save it."
        self.flush()
        refuge = refuge_path(self._clip.path)
        for place in (wanted,) if path else (wanted, refuge):
            try:
                if place == refuge:
                    place.parent.mkdir(parents=True, exist_ok=True)
                told = self._write_session(place)
            except OSError as error:
                last = error
                continue
            if place != wanted:
                told += f"{wanted}: not saved ({last.strerror}); the session is {place} instead."
            self.session_file = place
            self._review.mark_saved()
            self.give_up()
            return True, told
        there = self._journal is not None and self._journal.is_there() and self.retry()
        kept = f"in the journal {self._journal.path.name}" if there else "in this window only"
        return False, f"{wanted}: not saved ({last.strerror}). Your decisions stay {kept}."

    # -- places and lock ----------------------------------------------------------------------

    def take_over(self) -> str:
        """Take the lock from its holder; a sentence if that failed, else ''."""
        if self.lock is None:
            return ""
        try:
            self.read_only = not self.lock.take_over()
        except OSError as error:
            return f"{self.lock.path.name}: the lock cannot be taken ({error.strerror})."
        return "" if not self.read_only else f"The lock is held again by {self.lock.holder}."

    def _places(self) -> tuple[Path, Path]:
        """The session whose journal and lock are to be kept, and the one in the refuge."""
        assert self._clip is not None
        return self.session_file or session_path(self._clip.path), refuge_path(self._clip.path)

    def _take_lock(self) -> bool:
        wanted, refuge = self._places()
        self.away = None
        for place in (wanted, refuge):
            lock = ReviewLock(place.with_name(f"{place.name}{JOURNAL_SUFFIX}.lock"))
            try:
                if place == refuge:
                    place.parent.mkdir(parents=True, exist_ok=True)
                taken = lock.take()
            except OSError:
                continue
            self.lock = lock
            self.away = place.parent if place != wanted else None
            if lock.left_by is not None:
                self.told.emit(f"A lock was left behind by {lock.left_by}; it is yours now.", False)
            return taken
        self.lock = None
        return True  # nowhere to write: nobody else can either

    # -- the files ----------------------------------------------------------------------------

    def _know(self, path: Path) -> None:
        self._known[path] = hashlib.sha256(path.read_bytes()).hexdigest()

    def _write_session(self, path: Path) -> str:
        """Write it; another review that lies there is kept beside it, and a sentence says so."""
        assert self._clip is not None
        assert self._review is not None
        told = ""
        if path.exists():
            there = path.read_bytes()
            if hashlib.sha256(there).hexdigest() != self._known.get(path):
                kept = free_name(path, ".earlier")
                write_atomically(kept, there)
                told = f"{path.name} held another review; that one is now {kept.name}. "
        data = session_bytes(self._clip, self._review.state)
        write_atomically(path, data)
        self._known[path] = hashlib.sha256(data).hexdigest()
        return told

    def _resume(self, leftover: Leftover) -> None:
        self._steps = leftover.recovered.steps
        try:
            self._journal = Journal.resume(leftover.recovered)
        except OSError as error:
            self._journal = None
            self._complain(error)

    def _append(self, entry: Mapping[str, Any]) -> None:
        if self.read_only or self._clip is None or self._review is None:
            return
        self._steps += 1
        journal = self._journal
        if journal is not None and journal.is_there():
            self._write(lambda: journal.append(entry))
            return
        if journal is not None:  # deleted, or its folder was
            journal.close()
            self._journal = None
            self._begin_journal(self._review.state, self._steps)
            if self._journal is not None:
                told = f"{journal.path.name} was deleted while it was open; it is now {{}}."
                self.told.emit(told.format(self._journal.path), True)
        elif self._detached:  # an undo of what was saved
            self._begin_journal(self._review.state, self._steps)
        elif (begun := self._begin_before_last()) is not None:
            self._write(lambda: begun.append(entry))

    def _begin_before_last(self) -> Journal | None:
        """Begin a journal with the review as it was before its last command, None if it cannot."""
        assert self._review is not None
        before = max(0, self._steps - 1)
        if self._begin_journal(self._review.state_before_last, before):
            self._first, self._detached = self._review.position - 1, False
        return self._journal

    def _begin_journal(self, state: ReviewState, steps: int) -> bool:
        """Begin a journal with a state that unsaved steps led to; False if no disk takes it."""
        assert self._clip is not None
        wanted, refuge = self._places()
        for place in (wanted, refuge):
            path = free_name(place, JOURNAL_SUFFIX)
            try:
                if place == refuge:
                    place.parent.mkdir(parents=True, exist_ok=True)
                self._journal = Journal(path, self._clip, state, steps)
            except OSError as error:
                last = error
                continue
            self._detached = True
            self._caught_up()
            return True
        self._complain(last)
        return False

    def _write(self, work: Callable[[], None]) -> None:
        try:
            work()
        except OSError as error:
            self._complain(error)
        else:
            self._caught_up()

    def _complain(self, error: OSError) -> None:
        self._behind = True
        self._again.start()
        waiting = self._journal.waiting if self._journal is not None else self._steps
        steps = "step is" if waiting == 1 else f"{waiting} steps are"
        self.failing.emit(
            f"The journal cannot be written ({error.strerror}): the last {steps} in this window "
            "only."
        )

    def _caught_up(self) -> None:
        if self._behind:
            self._behind = False
            self._again.stop()
            if self._steps:
                self.told.emit("All steps are on disk again.", False)
