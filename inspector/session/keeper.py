"""Nothing decided is lost: session, journal and lock of a clip, and what earlier runs left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from inspector.session.leftovers import Leftover, holds_more, read_leftover
from inspector.session.review_journal import ReviewJournal
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
from twistcore.file_lock import is_held
from twistcore.review import Review
from twistcore.review.session import session_bytes


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
    """Session file, journal and lock of the open clip.

    A journal of an earlier run stays until it is answered: gone on with, in the same file, or
    forgotten.
    """

    told = Signal(str, bool)  # a sentence for the person; True if something went wrong
    locked = Signal()  # another window has, or has taken, the review

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session_file: Path | None = None
        self.read_only = False
        self.leftovers: list[Leftover] = []  # of earlier runs, not answered, the latest first
        self.notes: list[str] = []  # what went wrong when the clip was taken up
        self.away: Path | None = None  # the refuge, where the clip's folder cannot be written
        self.lock: ReviewLock | None = None
        self.journal = ReviewJournal(self._places, lambda: not self.read_only, self)
        self.journal.told.connect(self.told)
        self._clip: Clip | None = None
        self._review: Review | None = None
        self._known = KnownSessions()
        self._robbed: Path | None = None  # the clip whose lock was just taken from another window

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

    @property
    def review(self) -> Review:
        """The review that it watches over."""
        assert self._review is not None
        return self._review

    def put_aside(self) -> PutAside | None:
        """What is needed to go on later, once another clip was open meanwhile."""
        if self._clip is None or self._review is None:
            return None
        self.journal.flush()
        return PutAside(
            self._clip,
            self._review,
            self.session_file,
            self._known,
            self.journal.path,
            self.journal.steps,
            tuple(self.leftovers),
        )

    def go_on(self, aside: PutAside) -> None:
        """Watch over a review again that was put aside, in the journal that it had."""
        self.end()
        self._watch(aside.clip, aside.review, aside.session_file, aside.known)
        if not self.read_only:
            self.leftovers = [left for left in aside.leftovers if left.path.exists()]
        if not self.read_only and not aside.review.saved:
            self.journal.go_on(aside.journal, aside.steps)

    def _watch(
        self, clip: Clip, review: Review, session_file: Path | None, known: KnownSessions
    ) -> None:
        self._clip, self._review = clip, review
        self.session_file, self._known = session_file, known
        self.journal.watch(clip, review)
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
        self.journal.end()
        self.leftovers, self.notes = [], []
        if self.lock is not None:
            self.lock.release()
        self.lock = None
        self._clip = self._review = None

    def continue_with(self, leftover: Leftover) -> None:
        """Go on with a recovered review, in its own journal."""
        self._review = leftover.recovered.review
        self.journal.continue_with(leftover.recovered)
        self.leftovers.remove(leftover)

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

    # -- the session file ---------------------------------------------------------------------

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
        self.journal.flush()
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
            self.journal.give_up()
            return True, told
        stay = f"Your decisions stay {self.journal.where()}."
        return False, f"{wanted}: not saved ({last.strerror}). {stay}"

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

    @property
    def files(self) -> frozenset[Path]:
        """What only the review itself may write: session, journal, lock."""
        if self._clip is None:
            return frozenset()
        own = [*self._places(), session_path(self._clip.path)]
        beside = [p.with_name(p.name + JOURNAL_SUFFIX) for p in own]
        locks = [p.with_name(p.name + ".lock") for p in beside]
        journal = [self.journal.path] if self.journal.path is not None else []
        return frozenset((*own, *beside, *locks, *journal))

    # -- places and lock ----------------------------------------------------------------------

    def may_change(self) -> bool:
        """Whether the review is this window's to change; if not, `locked` says so."""
        if not self.read_only and not (self.lock is None or self.lock.is_ours()):
            self.journal.flush()
            self.read_only = self.lock.holder is not None or not self._take_lock()
            if self.read_only:
                self.journal.close()
        if self.read_only:
            self.locked.emit()
        return not self.read_only

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


def _lock_of(session: Path) -> ReviewLock:
    return ReviewLock(session.with_name(f"{session.name}{JOURNAL_SUFFIX}.lock"))
