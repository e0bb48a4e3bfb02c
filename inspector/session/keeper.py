"""Nothing decided is lost: the session beside the clip, its journal, and the lock on both."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from inspector.session.leftovers import Leftover, holds_more, read_leftover, same_review
from inspector.session.review_lock import ReviewLock
from inspector.session.session_files import (
    JOURNAL_SUFFIX,
    KnownSessions,
    journals,
    refuge_path,
    remember_place,
    session_path,
    written,
)
from twistcore.atomic import free_name
from twistcore.bvh import Clip
from twistcore.errors import TwistError
from twistcore.file_lock import is_held
from twistcore.review import Command, Journal, Recovered, Review, ReviewState, recover
from twistcore.review.journal import command_to_json, state_entry
from twistcore.review.session import session_bytes

_IDLE_MS = 300  # a drag that pauses this long is put on disk
_RETRY_MS = 5000  # what the disk did not take is tried again


class _HeldError(Exception):
    """Another window has the session that was to be written; says who."""


@dataclass(frozen=True, eq=False)
class PutAside:
    """A review that another clip is open instead of, for a while."""

    clip: Clip
    review: Review
    session_file: Path | None
    known: KnownSessions
    journal: Path | None
    steps: int
    leftovers: tuple[Leftover, ...]


class Keeper(QObject):
    """Journal, session file and lock of the open clip.

    The journal is begun with the first command, so that a clip that is only looked at leaves
    nothing behind. A drag is one entry: where it ended. A journal of an earlier run stays until it
    is answered: gone on with, in the same file, or forgotten.
    """

    told = Signal(str, bool)  # a sentence for the person; True if something went wrong
    failing = Signal(str)  # steps are not on disk, said again with every one
    caught_up = Signal()  # what was said to be in the window only is on disk, or given up
    locked = Signal()  # another window has, or has taken, the review

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session_file: Path | None = None
        self.read_only = False
        self.leftovers: list[Leftover] = []  # of earlier runs, not answered, the latest first
        self.notes: list[str] = []  # what went wrong when the clip was taken up
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
        self._known = KnownSessions()
        self._robbed: Path | None = None  # the clip whose lock was just taken from another window
        self._idle = QTimer(self)
        self._idle.setSingleShot(True)
        self._idle.setInterval(_IDLE_MS)
        self._idle.timeout.connect(self.flush)
        self._again = QTimer(self)
        self._again.setInterval(_RETRY_MS)
        self._again.timeout.connect(self.retry)

    # -- one clip after the other -------------------------------------------------------------

    def begin(
        self,
        clip: Clip,
        chains: Sequence[str],
        review: Review,
        session_file: Path | None,
        sha256: str = "",
    ) -> None:
        """Watch over another clip's review; `leftovers` are what earlier runs left of it.

        chains: names of the clip's; sha256: of the session file as it was read.
        """
        self.end()
        self._watch(clip, review, session_file, KnownSessions())
        if session_file is not None:
            self._known.know(session_file, sha256)
        if self.read_only:
            return
        for leftover in self._find_leftovers(frozenset(chains)):
            if holds_more(leftover, clip, review.state):
                self.leftovers.append(leftover)
            elif review.saved:  # it is in the session file, or there is nothing in it
                self.forget(leftover)

    def put_aside(self) -> PutAside | None:
        """What is needed to go on later, once another clip was open meanwhile."""
        if self._clip is None or self._review is None:
            return None
        self.flush()
        journal = self._journal.path if self._journal is not None else None
        return PutAside(
            self._clip,
            self._review,
            self.session_file,
            self._known,
            journal,
            self._steps,
            tuple(self.leftovers),
        )

    def go_on(self, aside: PutAside) -> None:
        """Watch over a review again that was put aside, in the journal that it had."""
        self.end()
        self._watch(aside.clip, aside.review, aside.session_file, aside.known)
        if not self.read_only:
            self.leftovers = [left for left in aside.leftovers if left.path.exists()]
        if self.read_only or aside.review.saved:
            return
        self._detached = True
        if aside.journal is not None:
            with suppress(TwistError):
                recovered = recover(aside.journal, aside.clip)
                if same_review(aside.clip, recovered.review.state, aside.review.state):
                    self._resume(recovered)
                    return
        self._steps = aside.steps
        self._begin_journal(aside.review.state, aside.steps)

    def _watch(
        self, clip: Clip, review: Review, session_file: Path | None, known: KnownSessions
    ) -> None:
        self._clip, self._review = clip, review
        self.session_file, self._known = session_file, known
        self.read_only = not self._take_lock()

    def _find_leftovers(self, chains: frozenset[str]) -> list[Leftover]:
        """Journals beside the clip, its session and in the refuge, the latest first.

        Those that a living window holds are none, unless that was robbed of the lock just now.
        """
        assert self._clip is not None
        robbed, self._robbed = self._robbed == self._clip.path, None
        found = []
        places = dict.fromkeys((*self._places(), session_path(self._clip.path)))
        for path in (path for place in places for path in journals(place)):
            if not robbed and is_held(path):
                continue
            leftover, told = read_leftover(path, self._clip, chains)
            if told:
                self.notes.append(told)
            if leftover is not None:
                found.append(leftover)
        return sorted(found, key=lambda left: written(left.path), reverse=True)

    def end(self) -> None:
        """Let the clip go; its journal stays unless everything in it is saved."""
        self.flush()
        if self._journal is not None:
            self.retry()
        if self._journal is not None:
            if self._review is not None and self._review.saved:
                self._journal.discard()
            else:
                self._journal.close()
        self._journal = None
        self._steps = 0
        self._detached = False
        self._caught_up()
        self.leftovers, self.notes = [], []
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
        self._resume(leftover.recovered)
        self._first, self._detached = 0, False

    def forget(self, leftover: Leftover) -> None:
        """Delete what an earlier run left: it was answered, or there is nothing more in it.

        One with lines that could not be read is only renamed.
        """
        if leftover.recovered.damaged:
            self.keep(leftover, ".damaged")
        else:
            self._done_with(leftover, lambda: leftover.path.unlink(missing_ok=True))

    def keep(self, leftover: Leftover, mark: str = ".earlier") -> str:
        """Keep what an earlier run left under a name that is not offered; '' if that failed."""
        kept = free_name(leftover.path, mark)
        done = self._done_with(leftover, lambda: leftover.path.rename(kept))
        return kept.name if done else ""

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
            journal = self._journal
            if journal is not None and journal.is_there():
                self._write(journal.write_waiting)
            else:
                if journal is not None:
                    journal.close()
                    self._journal = None
                self._begin_journal(self._review.state, self._steps)
        return not self._behind

    def save(self, path: Path | None = None) -> tuple[bool, str]:
        """Write the session file, at `path` if given; whether it was, and what is to be said."""
        if self._clip is None or self._review is None:
            return False, "Nothing was saved: the clip is no longer open for review."
        wanted = path or self.session_file or session_path(self._clip.path)
        if (self.read_only or not self.may_change()) and (
            path is None or path == self.session_file
        ):
            name = self._clip.name
            return False, f"This window cannot save it: {name} is under review in another one."
        self.flush()
        refuge = refuge_path(self._clip.path)
        for place in (wanted,) if path else dict.fromkeys((wanted, refuge)):
            try:
                if place == refuge:
                    place.parent.mkdir(parents=True, exist_ok=True)
                told = self._write_session(place)
            except _HeldError as error:
                return False, f"{place.name} is open in another window ({error})."
            except OSError as error:
                last = error
                continue
            if place != wanted:
                told += f"{wanted}: not saved ({last.strerror}); the session is {place} instead."
            self.session_file = place
            remember_place(self._clip.path, place)
            self._review.mark_saved()
            self.give_up()
            return True, told
        there = self._journal is not None and self._journal.is_there() and self.retry()
        kept = f"in the journal {self._journal.path.name}" if there else "in this window only"
        return False, f"{wanted}: not saved ({last.strerror}). Your decisions stay {kept}."

    @property
    def files(self) -> frozenset[Path]:
        """What only the review itself may write: session, journal, lock."""
        if self._clip is None:
            return frozenset()
        own = [*self._places(), session_path(self._clip.path)]
        beside = [p.with_name(p.name + JOURNAL_SUFFIX) for p in own]
        locks = [p.with_name(p.name + ".lock") for p in beside]
        journal = [self._journal.path] if self._journal is not None else []
        return frozenset((*own, *beside, *locks, *journal))

    # -- places and lock ----------------------------------------------------------------------

    def take_over(self) -> str:
        """Take the lock from its holder; a sentence if that failed, else ''."""
        if self.lock is None or self._clip is None:
            return ""
        try:
            self.read_only = not self.lock.take_over()
        except OSError as error:
            return f"{self.lock.path.name}: the lock cannot be taken ({error.strerror})."
        if self.read_only:
            return f"The lock is held again by {self.lock.holder}."
        self._robbed = self._clip.path
        return ""

    def _places(self) -> tuple[Path, ...]:
        """The session that a journal and a lock belong to, and the one in the refuge."""
        assert self._clip is not None
        wanted = self.session_file or session_path(self._clip.path)
        return tuple(dict.fromkeys((wanted, refuge_path(self._clip.path))))

    def _take_lock(self) -> bool:
        places = self._places()
        self.away = None
        for place in places:
            lock = _lock_of(place)
            try:
                if place == places[-1]:
                    place.parent.mkdir(parents=True, exist_ok=True)
                taken = lock.take()
            except OSError:
                continue
            self.lock = lock
            self.away = place.parent if place != places[0] else None
            return taken
        self.lock = None
        return True  # nowhere to write: nobody else can either

    # -- the files ----------------------------------------------------------------------------

    def _write_session(self, path: Path) -> str:
        """Write it under its own lock, which is then the one that is held; what is to be said."""
        assert self._clip is not None
        assert self._review is not None
        data = session_bytes(self._clip, self._review.state)
        lock = _lock_of(path)
        if self.lock is not None and self.lock.path == lock.path:
            return self._known.write(path, data)
        if not lock.take():
            raise _HeldError(str(lock.holder))
        try:
            told = self._known.write(path, data)
        except OSError:
            lock.release()
            raise
        if self.lock is not None:
            self.lock.release()
        self.lock, self.read_only = lock, False
        return told

    def _resume(self, recovered: Recovered) -> None:
        self._steps = recovered.steps
        try:
            self._journal = Journal.resume(recovered)
        except OSError:
            self._journal = None
            self._begin_journal(recovered.review.state, recovered.steps)

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
                told = f"{journal.path.name} was deleted while it was open; it is now "
                self.told.emit(f"{told}{self._journal.path}.", True)
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
        places = self._places()
        for place in places:
            path = free_name(place, JOURNAL_SUFFIX)
            try:
                if place == places[-1]:
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
            self.caught_up.emit()


def _lock_of(session: Path) -> ReviewLock:
    return ReviewLock(session.with_name(f"{session.name}{JOURNAL_SUFFIX}.lock"))
