"""Write every step of the open review to a journal on disk, and retry if writing fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal, SignalInstance

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.leftovers import same_review
from inspector.session.session_files import (
    JOURNAL_SUFFIX,
    fallback_session_path,
    first_success,
    session_path,
)
from twistcore.errors import TwistError
from twistcore.files.atomic import first_unused_path
from twistcore.formats.clip import Clip
from twistcore.review import Command, Journal, Recovered, Review, ReviewState, Sign, replay_journal
from twistcore.review.journal import review_command_to_json, session_journal_entry

_IDLE_MS = 300  # pause in a drag after which its last step is written
_RETRY_MS = 5000  # time until a failed write is tried again


@dataclass(eq=False)
class KeptReview:
    """A review with its clip and its session file.

    Attributes
    ----------
    known
        The SHA-256 of each session file when this program last read or wrote it.
    """

    clip: Clip
    review: Review
    session_file: Path | None
    known: dict[Path, str]

    @property
    def places(self) -> tuple[Path, ...]:
        """Return the paths at which the session may be saved, the preferred one first.

        The journal and the lock are saved next to the session. If the preferred folder is
        read-only, the second path, in the user's home, is used.
        """
        wanted = self.session_file or session_path(self.clip.path)
        return tuple(dict.fromkeys((wanted, fallback_session_path(self.clip.path))))

    @property
    def all_places(self) -> tuple[Path, ...]:
        """Return the paths in `places` and the default session path next to the clip."""
        return tuple(dict.fromkeys((*self.places, session_path(self.clip.path))))


class ReviewJournal(QObject):
    """The journal of the open review.

    The file is created with the first command; merely opening a clip does not create a file. A drag
    with the mouse is written as one entry with its final values.
    """

    failing = Signal(str)  # steps could not be written; emitted again for every further step
    caught_up = Signal()  # all steps are on disk again, or were discarded

    def __init__(
        self, message: SignalInstance, may_write: Callable[[], bool], parent: QObject
    ) -> None:
        super().__init__(parent)
        self.steps = 0  # number of steps that are not in the session file
        self._message, self._may_write = message, may_write
        self._kept: KeptReview | None = None
        self._journal: Journal | None = None
        self._pending: Command | None = None
        self._first = 0  # position in the review's history where the journal begins
        self._detached = False  # the journal no longer corresponds to the review's history
        self._behind = False  # some steps are not on disk
        self._idle = QTimer(self, singleShot=True, interval=_IDLE_MS)
        self._idle.timeout.connect(self.flush)
        self._again = QTimer(self, interval=_RETRY_MS)
        self._again.timeout.connect(self.retry)

    @property
    def path(self) -> Path | None:
        """Return the path of the journal, or None before the first command."""
        return self._journal.path if self._journal is not None else None

    @property
    def on_disk(self) -> bool:
        """Return True if every step of the review has been written to disk."""
        return self._pending is None and not self._behind

    # -- one review after the other -----------------------------------------------------------

    def watch(self, kept: KeptReview) -> None:
        """Start recording a different review. Call `end` for the previous review first."""
        self._kept = kept

    def resume(self, path: Path | None, steps: int) -> None:
        """Continue a review that was put aside, in its previous journal if that is complete.

        `steps` is the number of steps in the journal when the review was put aside.
        """
        kept = self._open
        self._detached = True
        if path is not None:
            with suppress(TwistError):
                recovered = replay_journal(path, kept.clip)
                if same_review(kept.clip, recovered.review.state, kept.review.state):
                    self._resume(recovered)
                    return
        self.steps = steps
        self._begin(kept.review.state)

    def continue_with(self, recovered: Recovered, *, fresh: bool = False) -> None:
        """Continue a recovered review in its own journal or, if `fresh` is True, in a new one."""
        self.give_up()  # the open review had no steps
        self._open.review = recovered.review
        if fresh:
            self.steps = recovered.steps
            self._begin(recovered.review.state)
            return
        self._resume(recovered)
        self._first, self._detached = 0, False

    def close(self) -> None:
        """Close the file without deleting it.

        The next window that opens the clip offers to restore the review.
        """
        if self._journal is not None:
            self._journal.close()
            self._journal = None

    def give_up(self) -> None:
        """Delete the file, because its steps are saved or the user does not want them."""
        self._pending = None
        self.steps = 0
        self._detached = False
        self._caught_up()
        if self._journal is not None:
            self._journal.discard()
            self._journal = None

    def end(self) -> None:
        """Stop recording. Delete the file only if all of its steps are saved."""
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
        """Write a command to disk. If it belongs to a drag, write only the drag's last command."""
        if self._pending is not None and not command.continues(self._pending):
            self.flush()
        if drag:
            self._pending = command
            self._idle.start()
            if self._journal is None and self._may_write():
                self._begin_before_last()
        else:
            if self._journal is None and isinstance(command, Sign):
                self._detached = True  # the command is not a step of the history
            self._append(review_command_to_json(command))

    def record_step(self, entry: Mapping[str, Any]) -> None:
        """Write an undo or a redo to disk.

        If the undo restores a state before the first step of the journal, the whole state is
        written instead.
        """
        self.flush()
        if (kept := self._kept) is None:
            return
        if self._journal is None or kept.review.position < self._first:
            self._detached = True
        self._append(
            session_journal_entry(kept.clip, kept.review.state) if self._detached else entry
        )

    def flush(self) -> None:
        """Write the last step of a drag to disk if it has not been written yet."""
        self._idle.stop()
        if self._pending is not None:
            pending, self._pending = self._pending, None
            self._append(review_command_to_json(pending))

    def retry(self) -> bool:
        """Try again to write missing steps. Returns True if all steps are on disk."""
        if self._behind and self._kept is not None:
            journal = self._journal
            if journal is not None and journal.is_there():
                self._write(journal.write_waiting)
            else:
                self.close()
                self._begin(self._kept.review.state)
        return not self._behind

    def where(self) -> str:
        """Return a sentence that says where the unsaved steps are stored."""
        journal = self._journal
        if journal is not None and journal.is_there() and self.retry():
            return tr("Your decisions are kept in the journal {name}.", name=journal.path.name)
        return tr("Your decisions exist only in this window.")

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
        if journal is not None:  # the file or its folder was deleted
            self.close()
            if self._begin(self._kept.review.state):
                message = tr(
                    "The journal {name} was deleted while it was open. The new journal is {path}.",
                    name=journal.path.name,
                    path=self.path,
                )
                self._message.emit(message, True)
        elif self._detached:  # the undone step is saved in the session file
            self._begin(self._kept.review.state)
        elif (begun := self._begin_before_last()) is not None:
            self._write(lambda: begun.append(entry))

    def _begin_before_last(self) -> Journal | None:
        """Create a journal that begins with the state before the last command.

        Returns None on failure.
        """
        review = self._open.review
        if self._begin(review.state_before_last, back=1):
            self._first, self._detached = review.position - 1, False
        return self._journal

    def _begin(self, state: ReviewState, *, back: int = 0) -> bool:
        """Create a journal that begins with the state of the review `back` steps ago.

        Returns False if no folder is writable.
        """
        clip, steps = self._open.clip, max(0, self.steps - back)

        def begin(place: Path) -> None:
            self._journal = Journal(first_unused_path(place, JOURNAL_SUFFIX), clip, state, steps)
            self._detached = True

        return self._write(lambda: first_success(self._open.places, begin))

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
        message = plural(
            "The journal cannot be written ({why}). The last step exists only in this window.",
            "The journal cannot be written ({why}). The last {n} steps exist only in this window.",
            waiting,
            why=translate_core_sentence(str(error.strerror)),
        )
        self.failing.emit(message)

    def _caught_up(self) -> None:
        if self._behind:
            self._behind = False
            self._again.stop()
            self.caught_up.emit()
