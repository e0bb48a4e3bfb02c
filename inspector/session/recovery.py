"""Ask the user about a clip's earlier review, its lock, its journals and changes to its file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from inspector.language import plural, tr, tr_as
from inspector.session.keeper import Keeper
from inspector.session.leftovers import Leftover, count_missing
from inspector.session.opening import Analysed, Stamp, clip_changed_sentence, stamp_of
from inspector.session.session_files import modified_ns, session_path
from inspector.widgets.background import OneTask
from twistcore.files.marks import cached_sha256, is_slow_to_hash
from twistcore.files.ordinary import path_exists
from twistcore.review import CarryOver, Command, Judged, LeaveOut, Review, ReviewState
from twistcore.review.interrupted_export import interrupted_exports
from twistcore.review.left_out import joined_spans


class Recovery(QObject):
    """Asks questions about the open clip and acts on the answers.

    Unanswered questions are asked again when the program is started next time.
    """

    question = Signal(str, object)  # a question with its answers, ((text, slot), …)
    withdrawn = Signal()  # the last question is obsolete
    save_elsewhere = Signal()  # ask for another path for the session
    open_again = Signal(object)  # with the path of a clip or session that must be read again

    def __init__(
        self,
        keeper: Keeper,
        do: Callable[[Command], bool],
        use: Callable[[Review], None],
        when_ready: Callable[[ReviewState, Callable[[], object]], None],
        parent: QObject,
    ) -> None:
        """Prepare to ask questions. No clip is open yet.

        Parameters
        ----------
        do
            Applies a command and returns True on success.
        use
            Makes a review the open review.
        when_ready
            Analyses the clip with the chains of a review, then calls a function.
        """
        super().__init__(parent)
        self._keeper, self._do, self._use, self._when_ready = keeper, do, use, when_ready
        self._data: Analysed | None = None  # the open clip
        self._stamp: Stamp | None = None  # stamp of the clip's file at the last check
        self._changed = ""  # a sentence about a change of the clip's file
        self._asks_about_disk = False
        self._look = OneTask(self)  # hashes the file of a large clip after a change
        keeper.journal.failing.connect(self._ask_about_disk)
        keeper.journal.caught_up.connect(self._disk_has_room)
        keeper.locked.connect(self._ask_about_lock)

    def begin(self) -> None:
        """Ask the questions about a newly opened clip."""
        self._stamp, self._changed = self._open().stamp, ""
        if exports := interrupted_exports(self._open().clip.path):
            message = tr(
                "An export was interrupted: the exported clip may be newer than {session} and "
                "the report. Export the clip again.",
                session=exports[0],
            )
            self._keeper.message.emit(message, True)
        if self._keeper.read_only:
            self._ask_about_lock()
        else:
            self._ask_next()

    def end(self, data: Analysed) -> None:
        """Withdraw all questions about the previous clip. `data` is the clip to be opened next."""
        self._data = data
        self._look.cancel()
        self._asks_about_disk = False
        self.withdrawn.emit()

    def check_lock_and_clip(self) -> None:
        """Check whether another window has taken the lock or another program changed the clip.

        Call this method when the window is activated.
        """
        if self._data is not None:
            if not self._keeper.read_only:
                self._keeper.may_change()
            path = self._data.clip.path
            if self._look.running:
                return
            if stamp_of(path) != self._stamp and is_slow_to_hash(path):
                self._look.run(lambda _: cached_sha256(path), self._looked, self._looked)
            else:
                self.check_clip()

    def _looked(self, _: object) -> None:
        self.check_clip()

    def check_clip(self) -> str:
        """Return a sentence stating that the clip has changed on disk, or '' if it has not.

        After each change, also ask the user once whether to open the clip again.
        """
        data = self._data
        if data is None or data.stamp is None:
            return ""
        stamp = stamp_of(data.clip.path)
        if stamp != self._stamp:
            self._stamp = stamp
            self._changed = clip_changed_sentence(data.clip, data.stamp, stamp)
            keep = (tr("Keep the open version"), lambda: None)
            again = (tr("Open the new version"), lambda: self.open_again.emit(self._source()))
            if self._changed:
                self.question.emit(self._changed, (again, keep) if stamp else (keep,))
        return self._changed

    def _ask_next(self) -> None:
        """Ask about the latest journal of an earlier run.

        If there is none, ask about the review of an earlier version of the clip.
        """
        data = self._open()
        if self._keeper.leftovers:
            self._offer(self._keeper.leftovers[0])
        elif data.earlier:
            carry = CarryOver(_fitting(data.earlier, data.motion.frames))
            self.question.emit(
                tr("{clip} has changed since its session was saved.", clip=data.clip.name),
                ((tr("Carry over decisions"), lambda: self._do(carry)),),
            )

    def _offer(self, leftover: Leftover) -> None:
        steps = leftover.recovered.steps
        kept = plural("{n} step was kept", "{n} steps were kept", steps)
        # The format of day, month, hour and minute for `strftime`.
        when = datetime.fromtimestamp(modified_ns(leftover.path) / 1e9).strftime(tr("%d %B, %H:%M"))
        if not leftover.same_clip:
            message = tr(
                "A review of another version of {clip} was not saved ({when}). {kept}.",
                clip=self._open().clip.name,
                when=when,
                kept=kept,
            )
            answer = tr("Carry over decisions")
        elif self._touched:
            message = tr(
                "Another review of this clip was not saved ({when}). {kept}.",
                when=when,
                kept=kept,
            )
            answer = tr("Add decisions")
        else:
            message = tr(
                "The last review of this clip was not saved ({when}). {kept}.",
                when=when,
                kept=kept,
            )
            answer = tr_as("the review", "Restore")
        discard = tr_as("the review", "Discard"), lambda: self.discard(leftover)
        self.question.emit(message, ((answer, lambda: self.restore(leftover)), discard))

    @property
    def _touched(self) -> bool:
        """Return True if the open review has been changed or restored since it was opened."""
        review = self._keeper.review
        return bool(review.position) or not review.saved

    def _open(self) -> Analysed:
        assert self._data is not None
        return self._data

    def restore(self, leftover: Leftover) -> None:
        """Restore the review from a journal of an earlier run, and continue it.

        If the journal belongs to another version of the clip, or if the open review has already
        been changed, add the journal's decisions to the open review instead.
        """
        if leftover not in self._keeper.leftovers:
            return
        if self._touched or not leftover.same_clip:
            if self._add(leftover):
                self._ask_next()
        else:
            self._when_ready(leftover.recovered.review.state, lambda: self._continue(leftover))

    def _continue(self, leftover: Leftover) -> None:
        if leftover in self._keeper.leftovers:
            self._keeper.continue_with(leftover)
            self._use(leftover.recovered.review)
            self._ask_next()

    def _add(self, leftover: Leftover) -> bool:
        """Add a journal's decisions to the open review. Returns True if they are safely on disk."""
        left, here = leftover.recovered.review.state, self._keeper.review.state
        fitting = _fitting(left.intervals, self._open().motion.frames)
        steps: list[Command] = [CarryOver(fitting, leftover.same_clip)]
        both = joined_spans([*here.left_out, *left.left_out])
        if leftover.same_clip and both != here.left_out:
            steps.append(LeaveOut(both))
        if not (all(self._do(step) for step in steps) and self._keeper.journal.on_disk):
            return False  # keep the journal until its decisions are on disk elsewhere
        lost, of = count_missing(leftover, self._keeper.review.state)
        if not lost:
            self._keeper.forget(leftover)
        elif name := self._keeper.keep(leftover):
            message = tr(
                "{taken} of {total} decisions were added. The others stay in {name}, because "
                "this review lacks the intervals or has different decisions on them.",
                taken=of - lost,
                total=of,
                name=name,
            )
            self._keeper.message.emit(message, True)
        return True

    def discard(self, leftover: Leftover) -> None:
        """Delete a journal of an earlier run."""
        if leftover in self._keeper.leftovers:
            self._keeper.forget(leftover)
            self._ask_next()

    def _ask_about_lock(self) -> None:
        lock, name = self._keeper.lock, self._open().clip.name
        if lock is not None and lock.is_free():
            text = tr("{name} is no longer open in the other window.", name=name)
            take = tr("Review here")
        else:
            holder = lock and lock.holder
            text = tr("{name} is open in another window ({holder}).", name=name, holder=holder)
            text += " " + tr("You can look at the review here, but you cannot change it.")
            take = tr("Take over")
        self.question.emit(text, ((take, self._take_over), (tr("View only"), lambda: None)))

    def _take_over(self) -> None:
        if trouble := self._keeper.take_over():
            self._keeper.message.emit(trouble, True)
        else:  # open what the other window has saved, and offer to restore the rest
            self.open_again.emit(self._source())

    def _source(self) -> Path:
        """Return the file to open again: the clip, or its session if that has an unusual path."""
        path, session = self._open().clip.path, self._keeper.session_file
        own = session is None or session == session_path(path) or not path_exists(session)
        return path if own or session is None else session

    def _ask_about_disk(self, text: str) -> None:
        self._asks_about_disk = True
        # If this fails, the question appears again
        again = (tr("Try again"), self._keeper.journal.retry)
        self.question.emit(text, (again, (tr("Save elsewhere…"), self.save_elsewhere.emit)))

    def _disk_has_room(self) -> None:
        if self._asks_about_disk:
            self._asks_about_disk = False
            self.withdrawn.emit()
            self._keeper.message.emit(tr("All steps have now been saved to disk."), False)
            self._ask_next()


def _fitting(earlier: Sequence[Judged], frames: int) -> tuple[Judged, ...]:
    """Return the intervals of an earlier review that fit within a clip of `frames` frames."""
    return tuple(judged for judged in earlier if judged.interval.stop <= frames)
