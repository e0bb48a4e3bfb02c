"""Protect the review of the open clip with a session file, a journal and a lock.

This module also finds the journals of earlier runs, and restores or deletes them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal, SignalInstance

from inspector.language import tr, translate_core_sentence
from inspector.session.leftovers import Leftover, leftover_has_more_decisions, read_leftover
from inspector.session.opening import Analysed
from inspector.session.review_journal import KeptReview, ReviewJournal
from inspector.session.review_lock import ReviewLock
from inspector.session.session_files import (
    JOURNAL_SUFFIX,
    ensure_latest_modification_time,
    find_existing_sessions,
    first_success,
    journals,
    modified_ns,
    remember_session_path,
    write_session_with_backup,
)
from twistcore.errors import TwistError
from twistcore.files.atomic import first_unused_path
from twistcore.files.lock import is_file_locked
from twistcore.files.ordinary import path_exists
from twistcore.review import Review
from twistcore.review.session import session_bytes


@dataclass(frozen=True, eq=False)
class PutAside:
    """A review to be continued later, for example while a lesson has another clip open.

    Attributes
    ----------
    kept
        The review with its clip and session file.
    journal
        The path of the review's journal, or None if there is none.
    steps
        The number of steps in the journal.
    leftovers
        Journals of earlier runs that the user has neither restored nor discarded.
    """

    kept: KeptReview
    journal: Path | None
    steps: int
    leftovers: tuple[Leftover, ...]


class Keeper(QObject):
    """Manages the session file, journal and lock of the open clip.

    The journal of an earlier run is not deleted until the user restores or discards it.
    """

    locked = Signal()  # another window holds the review

    def __init__(self, message: SignalInstance, parent: QObject) -> None:
        """Create a keeper that does not protect a clip yet.

        `message` is a signal that takes a sentence to show, and True if the sentence reports an
        error.
        """
        super().__init__(parent)
        self.message = message
        self.read_only = False
        # Journals of earlier runs that the user has neither restored nor discarded, latest first.
        self.leftovers: list[Leftover] = []
        self.notes: list[str] = []  # sentences about problems with opening the clip
        self.away: Path | None = None  # the folder of the journal if the clip's folder is read-only
        self.lock: ReviewLock | None = None
        self.journal = ReviewJournal(message, lambda: not self.read_only, self)
        self._kept: KeptReview | None = None
        # The clip of which this window has just taken over the lock
        self._robbed: Path | None = None

    # -- opening clips ------------------------------------------------------------------------

    def begin(self, data: Analysed) -> None:
        """Start protecting the review of a newly opened clip, and find journals of earlier runs."""
        known = {data.session: data.session_sha256} if data.session is not None else {}
        self._watch(KeptReview(data.clip, data.review, data.session, known))
        if self.read_only:
            return
        for leftover in self._find_leftovers(data):
            if leftover_has_more_decisions(leftover, data.clip, data.review.state):
                self.leftovers.append(leftover)
            elif data.review.saved:  # the session file has all of its steps, or it is empty
                self.forget(leftover)

    @property
    def review(self) -> Review:
        """The review of the open clip."""
        assert self._kept is not None
        return self._kept.review

    @property
    def session_file(self) -> Path | None:
        """Return the path of the session file, or None if there is no file yet."""
        return self._kept.session_file if self._kept is not None else None

    def put_aside(self) -> PutAside | None:
        """Return the open review in a form that `resume` can continue later.

        Returns None if no clip is open.
        """
        if self._kept is None:
            return None
        self.journal.flush()
        return PutAside(self._kept, self.journal.path, self.journal.steps, tuple(self.leftovers))

    def resume(self, aside: PutAside) -> None:
        """Continue a review that was put aside, and record its next steps in the same journal."""
        self._watch(aside.kept)
        if self.read_only:
            return
        self.leftovers = [left for left in aside.leftovers if path_exists(left.path)]
        if not aside.kept.review.saved:
            self.journal.resume(aside.journal, aside.steps)

    def _watch(self, kept: KeptReview) -> None:
        self.end()
        self._kept = kept
        self.journal.watch(kept)
        self.read_only = not self._take_lock(kept)

    def _find_leftovers(self, data: Analysed) -> list[Leftover]:
        """Return the journals of this clip from earlier runs, the latest first.

        The journals may be next to the clip, next to its session, or in the folder for reviews of
        clips in read-only folders. Journals that another window uses are skipped, unless this
        window has just taken over the lock.
        """
        assert self._kept is not None
        robbed, self._robbed = self._robbed == data.clip.path, None
        found = []
        for path in (path for place in self._kept.all_places for path in journals(place)):
            if not robbed and is_file_locked(path):
                continue
            leftover, message = read_leftover(path, data.clip, data.analysis)
            if message:
                self.notes.append(message)
            if leftover is not None:
                found.append(leftover)
        return sorted(found, key=lambda left: modified_ns(left.path), reverse=True)

    def end(self) -> None:
        """Stop protecting the clip. Delete its journal only if all steps in it are saved."""
        self.journal.end()
        self.leftovers, self.notes = [], []
        if self.lock is not None:
            self.lock.release()
        self.lock = None
        self._kept = None

    def continue_with(self, leftover: Leftover) -> None:
        """Continue a recovered review and record its next steps in its journal.

        If the program has added limbs to the review, a new journal is started instead. The old
        journal is deleted as soon as the new one is on disk.
        """
        self.journal.continue_with(leftover.recovered, fresh=leftover.completed)
        if not leftover.completed:
            self.leftovers.remove(leftover)
        elif self.journal.on_disk:
            self.forget(leftover)

    def forget(self, leftover: Leftover) -> None:
        """Delete a journal that is no longer needed.

        If the journal has unreadable lines, it is renamed instead.
        """
        if leftover.recovered.damaged:
            self.keep(leftover, ".damaged")
        else:
            self._done_with(leftover, lambda: leftover.path.unlink(missing_ok=True))

    def keep(self, leftover: Leftover, mark: str = ".earlier") -> str:
        """Rename a journal so that the user is not asked about it again.

        `mark` is added to its name. Returns the new name, or '' on failure.
        """
        kept = first_unused_path(leftover.path, mark)
        done = self._done_with(leftover, lambda: leftover.path.rename(kept))
        return kept.name if done else ""

    def _done_with(self, leftover: Leftover, work: Callable[[], object]) -> bool:
        if leftover in self.leftovers:
            self.leftovers.remove(leftover)
        try:
            work()
        except OSError as error:
            why = translate_core_sentence(str(error.strerror))
            message = tr(
                "{path} could not be moved and stays where it is ({why}).",
                path=leftover.path,
                why=why,
            )
            self.message.emit(message, True)
            return False
        return True

    # -- the session file ---------------------------------------------------------------------

    def save(self, path: Path | None = None) -> tuple[bool, str]:
        """Write the session file to `path` or, by default, to its usual path.

        Returns a tuple: True on success or False on failure, and a sentence to show.
        """
        kept = self._kept
        if kept is None:
            return False, tr("Nothing was saved: the clip is no longer open for review.")
        if (self.read_only or not self.may_change()) and path in (None, kept.session_file):
            name = kept.clip.name
            message = tr(
                "The session was not saved, because {name} is under review in another window.",
                name=name,
            )
            return False, message
        self.journal.flush()
        places = (path,) if path else kept.places
        try:
            place, message, trouble = first_success(places, lambda p: self._write_session(kept, p))
        except TwistError as error:
            return False, str(error)
        except OSError as error:
            why = translate_core_sentence(str(error.strerror))
            message = tr("{path} was not saved ({why}).", path=places[0], why=why)
            return False, f"{message} {self.journal.where()}"
        if trouble is not None:
            message += tr(
                "{path} was not saved ({why}). The session was saved as {place} instead.",
                path=places[0],
                why=translate_core_sentence(str(trouble.strerror)),
                place=place,
            )
        kept.session_file = place
        ensure_latest_modification_time(place, find_existing_sessions(kept.clip.path))
        remember_session_path(kept.clip.path, place)
        kept.review.mark_saved()
        self.journal.give_up()
        return True, message

    def _write_session(self, kept: KeptReview, path: Path) -> str:
        """Lock a session, write it, and return a sentence to show.

        Raises TwistError if another window holds the lock of that session.
        """
        data = session_bytes(kept.clip, kept.review.state)
        lock = _lock_of(path)
        if self.lock is not None and self.lock.path == lock.path:
            return write_session_with_backup(path, data, kept.known)
        if not lock.take():
            message = tr(
                "{name} is open in another window ({holder}). Save the session under another name.",
                name=path.name,
                holder=lock.holder,
            )
            raise TwistError(message)
        try:
            message = write_session_with_backup(path, data, kept.known)
        except OSError:
            lock.release()
            raise
        if self.lock is not None:
            self.lock.release()
        self.lock, self.read_only = lock, False
        return message

    @property
    def files(self) -> frozenset[Path]:
        """Return the files that exports must not overwrite: session, journal and lock."""
        if self._kept is None:
            return frozenset()
        ends = ("", JOURNAL_SUFFIX, f"{JOURNAL_SUFFIX}.lock")
        own = {p.with_name(p.name + end) for p in self._kept.all_places for end in ends}
        return frozenset(own if self.journal.path is None else {*own, self.journal.path})

    # -- places and lock ----------------------------------------------------------------------

    def may_change(self) -> bool:
        """Return True if this window may change the review. If not, emit `locked`.

        The lock is checked first, because another window may have taken it over.
        """
        kept, lock = self._kept, self.lock
        if kept and lock and not self.read_only and not lock.is_ours():
            self.journal.flush()
            self.read_only = lock.holder is not None or not self._take_lock(kept)
            if self.read_only:
                self.journal.close()
        if self.read_only:
            self.locked.emit()
        return not self.read_only

    def take_over(self) -> str:
        """Take the lock over from another window.

        Returns '' on success, or a sentence with the reason for the failure.
        """
        if self.lock is None or self._kept is None:
            return ""
        try:
            self.read_only = not self.lock.take_over()
        except OSError as error:
            name, why = self.lock.path.name, translate_core_sentence(str(error.strerror))
            return tr(
                "The review could not be taken over from the other window: the lock "
                "file {name} cannot be changed ({why}).",
                name=name,
                why=why,
            )
        if self.read_only:
            return tr(
                "The review is being edited in another window again ({holder}).",
                holder=self.lock.holder,
            )
        self._robbed = self._kept.clip.path
        return ""

    def _take_lock(self, kept: KeptReview) -> bool:
        def take(place: Path) -> tuple[ReviewLock, bool]:
            lock = _lock_of(place)
            return lock, lock.take()

        self.lock = self.away = None
        try:
            place, (self.lock, taken), trouble = first_success(kept.places, take)
        except OSError:
            return True  # no folder is writable, so other windows cannot write either
        self.away = place.parent if trouble else None
        return taken


def _lock_of(session: Path) -> ReviewLock:
    return ReviewLock(session.with_name(f"{session.name}{JOURNAL_SUFFIX}.lock"))
