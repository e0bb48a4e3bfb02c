"""Every step of the open review in its journal on disk, or tried again until it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal, SignalInstance

from inspector.language import of_core, plural, tr
from inspector.session.leftovers import same_review
from inspector.session.session_files import JOURNAL_SUFFIX, at_first, refuge_path, session_path
from twistcore.errors import TwistError
from twistcore.files.atomic import free_name
from twistcore.formats.clip import Clip
from twistcore.review import Command, Journal, Recovered, Review, ReviewState, Sign, recover
from twistcore.review.journal import command_to_json, state_entry

_IDLE_MS = 300  # a drag that pauses this long is put on disk
_RETRY_MS = 5000  # what the disk did not take is tried again


@dataclass(eq=False)
class KeptReview:
    """A review that is watched over, of which clip, and the session that it goes into.

    known: SHA-256 of session files as this program read or wrote them.
    """

    clip: Clip
    review: Review
    session_file: Path | None
    known: dict[Path, str]

    @property
    def places(self) -> tuple[Path, ...]:
        """The session that a journal and a lock belong to, and the one in the refuge."""
        wanted = self.session_file or session_path(self.clip.path)
        return tuple(dict.fromkeys((wanted, refuge_path(self.clip.path))))

    @property
    def all_places(self) -> tuple[Path, ...]:
        """These and the session beside the clip."""
        return tuple(dict.fromkeys((*self.places, session_path(self.clip.path))))


class ReviewJournal(QObject):
    """The journal of the open review.

    It is begun with the first command, so that a clip that is only looked at leaves nothing
    behind. A drag is one entry: where it ended.
    """

    failing = Signal(str)  # steps are not on disk, said again with every one
    caught_up = Signal()  # what was said to be in the window only is on disk, or given up

    def __init__(
        self, told: SignalInstance, may_write: Callable[[], bool], parent: QObject
    ) -> None:
        super().__init__(parent)
        self.steps = 0  # of the review, not in a session file
        self._told, self._may_write = told, may_write
        self._kept: KeptReview | None = None
        self._journal: Journal | None = None
        self._pending: Command | None = None
        self._first = 0  # position of the review's history at which the journal begins
        self._detached = False  # the journal no longer knows the review's history
        self._behind = False  # the disk has not taken everything
        self._idle = QTimer(self, singleShot=True, interval=_IDLE_MS)
        self._idle.timeout.connect(self.flush)
        self._again = QTimer(self, interval=_RETRY_MS)
        self._again.timeout.connect(self.retry)

    @property
    def path(self) -> Path | None:
        """Where it is, once it is begun."""
        return self._journal.path if self._journal is not None else None

    @property
    def on_disk(self) -> bool:
        """Whether every step of the review is in it."""
        return self._pending is None and not self._behind

    # -- one review after the other -----------------------------------------------------------

    def watch(self, kept: KeptReview) -> None:
        """Take up another review; the last one has come to its `end`."""
        self._kept = kept

    def go_on(self, path: Path | None, steps: int) -> None:
        """Go on with the review, which was put aside: in the journal it had if all of it is there.

        steps: as they were then.
        """
        kept = self._open
        self._detached = True
        if path is not None:
            with suppress(TwistError):
                recovered = recover(path, kept.clip)
                if same_review(kept.clip, recovered.review.state, kept.review.state):
                    self._resume(recovered)
                    return
        self.steps = steps
        self._begin(kept.review.state)

    def continue_with(self, recovered: Recovered, *, anew: bool = False) -> None:
        """Go on with a recovered review, in its own journal or (anew) in another."""
        self.give_up()  # nothing was done in the review that was open
        self._open.review = recovered.review
        if anew:
            self.steps = recovered.steps
            self._begin(recovered.review.state)
            return
        self._resume(recovered)
        self._first, self._detached = 0, False

    def close(self) -> None:
        """Let the file go: it is offered to whoever has the review now."""
        if self._journal is not None:
            self._journal.close()
            self._journal = None

    def give_up(self) -> None:
        """The steps are saved, or the person gives them up: the file goes."""
        self._pending = None
        self.steps = 0
        self._detached = False
        self._caught_up()
        if self._journal is not None:
            self._journal.discard()
            self._journal = None

    def end(self) -> None:
        """Let the review go; the file stays unless everything in it is saved."""
        self.flush()
        if self._journal is not None:
            self.retry()
        if self._kept is None or not self._kept.review.saved:
            self.close()
        self.give_up()
        self._kept = None

    @property
    def _open(self) -> KeptReview:
        assert self._kept is not None
        return self._kept

    # -- recording ----------------------------------------------------------------------------

    def record(self, command: Command, drag: int = 0) -> None:
        """Put a command on disk; a step of a drag waits for the drag's end."""
        if self._pending is not None and not command.continues(self._pending):
            self.flush()
        if drag:
            self._pending = command
            self._idle.start()
            if self._journal is None and self._may_write():
                self._begin_before_last()
        else:
            if self._journal is None and isinstance(command, Sign):
                self._detached = True  # no step of the history that a journal could begin before
            self._append(command_to_json(command))

    def record_step(self, entry: Mapping[str, Any]) -> None:
        """Put an undo or redo on disk; what is older than the journal, as the whole state."""
        self.flush()
        if (kept := self._kept) is None:
            return
        if self._journal is None or kept.review.position < self._first:
            self._detached = True
        self._append(state_entry(kept.clip, kept.review.state) if self._detached else entry)

    def flush(self) -> None:
        """Put a waiting drag on disk."""
        self._idle.stop()
        if self._pending is not None:
            pending, self._pending = self._pending, None
            self._append(command_to_json(pending))

    def retry(self) -> bool:
        """Try again to put on disk what it did not take; True if all is there."""
        if self._behind and self._kept is not None:
            journal = self._journal
            if journal is not None and journal.is_there():
                self._write(journal.write_waiting)
            else:
                self.close()
                self._begin(self._kept.review.state)
        return not self._behind

    def where(self) -> str:
        """Where the steps are that no session has, as the end of a sentence."""
        journal = self._journal
        if journal is not None and journal.is_there() and self.retry():
            return tr("in the journal {name}", name=journal.path.name)
        return tr("in this window only")

    # -- the file -----------------------------------------------------------------------------

    def _resume(self, recovered: Recovered) -> None:
        self.steps = recovered.steps
        try:
            self._journal = Journal.resume(recovered)
        except OSError:
            self._journal = None
            self._begin(recovered.review.state)

    def _append(self, entry: Mapping[str, Any]) -> None:
        if not self._may_write() or self._kept is None:
            return
        self.steps += 1
        journal = self._journal
        if journal is not None and journal.is_there():
            self._write(lambda: journal.append(entry))
            return
        if journal is not None:  # deleted, or its folder was
            self.close()
            if self._begin(self._kept.review.state):
                told = tr(
                    "{name} was deleted while it was open; it is now {path}.",
                    name=journal.path.name,
                    path=self.path,
                )
                self._told.emit(told, True)
        elif self._detached:  # an undo of what was saved
            self._begin(self._kept.review.state)
        elif (begun := self._begin_before_last()) is not None:
            self._write(lambda: begun.append(entry))

    def _begin_before_last(self) -> Journal | None:
        """Begin a journal with the review as it was before its last command, None if it cannot."""
        review = self._open.review
        if self._begin(review.state_before_last, back=1):
            self._first, self._detached = review.position - 1, False
        return self._journal

    def _begin(self, state: ReviewState, *, back: int = 0) -> bool:
        """Begin a journal with a state, so many steps back; False if no disk takes it."""
        clip, steps = self._open.clip, max(0, self.steps - back)

        def begin(place: Path) -> None:
            self._journal = Journal(free_name(place, JOURNAL_SUFFIX), clip, state, steps)
            self._detached = True

        return self._write(lambda: at_first(self._open.places, begin))

    def _write(self, work: Callable[[], object]) -> bool:
        try:
            work()
        except OSError as error:
            self._complain(error)
            return False
        self._caught_up()
        return True

    def _complain(self, error: OSError) -> None:
        self._behind = True
        self._again.start()
        waiting = self._journal.waiting if self._journal is not None else self.steps
        told = plural(
            "The journal cannot be written ({why}): the last step is in this window only.",
            "The journal cannot be written ({why}): the last {n} steps are in this window only.",
            waiting,
            why=of_core(str(error.strerror)),
        )
        self.failing.emit(told)

    def _caught_up(self) -> None:
        if self._behind:
            self._behind = False
            self._again.stop()
            self.caught_up.emit()
