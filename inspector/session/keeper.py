"""Nothing decided is lost: session, journal and lock of a clip, and what earlier runs left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal, SignalInstance

from inspector.language import of_core, tr
from inspector.session.leftovers import Leftover, holds_more, read_leftover
from inspector.session.opening import Analysed
from inspector.session.review_journal import KeptReview, ReviewJournal
from inspector.session.review_lock import ReviewLock
from inspector.session.session_files import (
    JOURNAL_SUFFIX,
    at_first,
    journals,
    kept_sessions,
    make_latest,
    remember_place,
    write_known,
    written,
)
from twistcore.errors import TwistError
from twistcore.files.atomic import free_name
from twistcore.files.lock import is_held
from twistcore.files.ordinary import is_there
from twistcore.review import Review
from twistcore.review.session import session_bytes


@dataclass(frozen=True, eq=False)
class PutAside:
    """A review that another clip is open instead of, for a while."""

    kept: KeptReview
    journal: Path | None
    steps: int
    leftovers: tuple[Leftover, ...]


class Keeper(QObject):
    """Session file, journal and lock of the open clip.

    A journal of an earlier run stays until it is answered: gone on with, in the same file, or
    forgotten.
    """

    locked = Signal()  # another window has, or has taken, the review

    def __init__(self, told: SignalInstance, parent: QObject) -> None:
        """`told`: a sentence for the person; True if something went wrong."""
        super().__init__(parent)
        self.told = told
        self.read_only = False
        self.leftovers: list[Leftover] = []  # of earlier runs, not answered, the latest first
        self.notes: list[str] = []  # what went wrong when the clip was taken up
        self.away: Path | None = None  # the refuge, where the clip's folder cannot be written
        self.lock: ReviewLock | None = None
        self.journal = ReviewJournal(told, lambda: not self.read_only, self)
        self._kept: KeptReview | None = None
        self._robbed: Path | None = None  # the clip whose lock was just taken from another window

    # -- one clip after the other -------------------------------------------------------------

    def begin(self, data: Analysed) -> None:
        """Watch over another clip's review; `leftovers` are what earlier runs left of it."""
        known = {data.session: data.session_sha256} if data.session is not None else {}
        self._watch(KeptReview(data.clip, data.review, data.session, known))
        if self.read_only:
            return
        for leftover in self._find_leftovers(data):
            if holds_more(leftover, data.clip, data.review.state):
                self.leftovers.append(leftover)
            elif data.review.saved:  # it is in the session file, or there is nothing in it
                self.forget(leftover)

    @property
    def review(self) -> Review:
        """The review that it watches over."""
        assert self._kept is not None
        return self._kept.review

    @property
    def session_file(self) -> Path | None:
        """Where its session is, once it has one."""
        return self._kept.session_file if self._kept is not None else None

    def put_aside(self) -> PutAside | None:
        """What is needed to go on later, once another clip was open meanwhile."""
        if self._kept is None:
            return None
        self.journal.flush()
        return PutAside(self._kept, self.journal.path, self.journal.steps, tuple(self.leftovers))

    def go_on(self, aside: PutAside) -> None:
        """Watch over a review again that was put aside, in the journal that it had."""
        self._watch(aside.kept)
        if self.read_only:
            return
        self.leftovers = [left for left in aside.leftovers if is_there(left.path)]
        if not aside.kept.review.saved:
            self.journal.go_on(aside.journal, aside.steps)

    def _watch(self, kept: KeptReview) -> None:
        self.end()
        self._kept = kept
        self.journal.watch(kept)
        self.read_only = not self._take_lock(kept)

    def _find_leftovers(self, data: Analysed) -> list[Leftover]:
        """Journals beside the clip, its session and in the refuge, the latest first.

        Those that a living window holds are none, unless that was robbed of the lock just now.
        """
        assert self._kept is not None
        robbed, self._robbed = self._robbed == data.clip.path, None
        found = []
        for path in (path for place in self._kept.all_places for path in journals(place)):
            if not robbed and is_held(path):
                continue
            leftover, told = read_leftover(path, data.clip, data.analysis)
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
        self._kept = None

    def continue_with(self, leftover: Leftover) -> None:
        """Go on with a recovered review, in its own journal.

        One that knows nothing of limbs gives way to a new one, once that is on disk.
        """
        self.journal.continue_with(leftover.recovered, anew=leftover.completed)
        if not leftover.completed:
            self.leftovers.remove(leftover)
        elif self.journal.on_disk:
            self.forget(leftover)

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
            why = of_core(str(error.strerror))
            told = tr("{path}: it stays where it is ({why}).", path=leftover.path, why=why)
            self.told.emit(told, True)
            return False
        return True

    # -- the session file ---------------------------------------------------------------------

    def save(self, path: Path | None = None) -> tuple[bool, str]:
        """Write the session file, at `path` if given; whether it was, and what is to be said."""
        kept = self._kept
        if kept is None:
            return False, tr("Nothing was saved: the clip is no longer open for review.")
        if (self.read_only or not self.may_change()) and path in (None, kept.session_file):
            name = kept.clip.name
            told = tr(
                "This window cannot save it: {name} is under review in another one.", name=name
            )
            return False, told
        self.journal.flush()
        places = (path,) if path else kept.places
        try:
            place, told, trouble = at_first(places, lambda p: self._write_session(kept, p))
        except TwistError as error:
            return False, str(error)
        except OSError as error:
            why = of_core(str(error.strerror))
            told = tr("{path}: not saved ({why}).", path=places[0], why=why)
            stay = tr("Your decisions stay {place}.", place=self.journal.where())
            return False, f"{told} {stay}"
        if trouble is not None:
            told += tr(
                "{path}: not saved ({why}); the session is {place} instead.",
                path=places[0],
                why=of_core(str(trouble.strerror)),
                place=place,
            )
        kept.session_file = place
        make_latest(place, kept_sessions(kept.clip.path))
        remember_place(kept.clip.path, place)
        kept.review.mark_saved()
        self.journal.give_up()
        return True, told

    def _write_session(self, kept: KeptReview, path: Path) -> str:
        """Write it under its own lock, which is then the one that is held; what is to be said.

        TwistError where another window has that session.
        """
        data = session_bytes(kept.clip, kept.review.state)
        lock = _lock_of(path)
        if self.lock is not None and self.lock.path == lock.path:
            return write_known(path, data, kept.known)
        if not lock.take():
            told = tr(
                "{name} is open in another window ({holder}).", name=path.name, holder=lock.holder
            )
            raise TwistError(told)
        try:
            told = write_known(path, data, kept.known)
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
        if self._kept is None:
            return frozenset()
        ends = ("", JOURNAL_SUFFIX, f"{JOURNAL_SUFFIX}.lock")
        own = {p.with_name(p.name + end) for p in self._kept.all_places for end in ends}
        return frozenset(own if self.journal.path is None else {*own, self.journal.path})

    # -- places and lock ----------------------------------------------------------------------

    def may_change(self) -> bool:
        """Whether the review is this window's to change; if not, `locked` says so."""
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
        """Take the lock from its holder; a sentence if that failed, else ''."""
        if self.lock is None or self._kept is None:
            return ""
        try:
            self.read_only = not self.lock.take_over()
        except OSError as error:
            name, why = self.lock.path.name, of_core(str(error.strerror))
            return tr("{name}: the lock cannot be taken ({why}).", name=name, why=why)
        if self.read_only:
            return tr("The lock is held again by {holder}.", holder=self.lock.holder)
        self._robbed = self._kept.clip.path
        return ""

    def _take_lock(self, kept: KeptReview) -> bool:
        def take(place: Path) -> tuple[ReviewLock, bool]:
            lock = _lock_of(place)
            return lock, lock.take()

        self.lock = self.away = None
        try:
            place, (self.lock, taken), trouble = at_first(kept.places, take)
        except OSError:
            return True  # nowhere to write: nobody else can either
        self.away = place.parent if trouble else None
        return taken


def _lock_of(session: Path) -> ReviewLock:
    return ReviewLock(session.with_name(f"{session.name}{JOURNAL_SUFFIX}.lock"))
