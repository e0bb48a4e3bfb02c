"""Store the history of a review, with undo and redo."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from twistcore.analysis.clip_analysis import ClipAnalysis, Detection
from twistcore.detection import Interval
from twistcore.review.commands import Command, Insert
from twistcore.review.decisions import Decide, Sign
from twistcore.review.model import Decision, Judged, ReviewState, start_review
from twistcore.review.reasons import make_evidence_adder
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.work.frozen import dataclass


@dataclass(frozen=True, eq=False)
class _Step:
    command: Command
    before: ReviewState
    after: ReviewState


class Review:
    """A person's decisions on the detected intervals, with undo and redo.

    Parameters
    ----------
    found : Detection, ClipAnalysis or ReviewState
        The intervals to review, all undecided, or the state of an earlier review from a session.

    Raises
    ------
    TypeError
        If `found` has an unsupported type.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk_injected.bvh")
    >>> review = tc.Review(tc.detect(clip))
    >>> review.accept(at_least=0.9)
    8
    >>> review.undo()
    >>> review
    <Review, 0 steps: <ReviewState by consistency: 0 of 8 decided>>
    >>> review.redo()
    >>> len(tc.detect(tc.refine(clip, review)))
    0
    """

    def __init__(self, found: Detection | ClipAnalysis | ReviewState) -> None:
        state = _state_of(found)
        self.state = state
        self._done: list[_Step] = []
        self._undone: list[_Step] = []
        self._saved: ReviewState | None = state

    def __repr__(self) -> str:
        return f"<Review, {self.position} steps: {self.state!r}>"

    @classmethod
    def of(cls, found: Detection) -> Review:
        """Return a new review of a detection, in which all intervals are undecided."""
        return cls(_started(found))

    @property
    def accepted(self) -> tuple[Interval, ...]:
        """The accepted intervals that can be corrected. Lone jumps are excluded."""
        return self.state.chosen()

    def to_correct(self, motion: Motion) -> tuple[tuple[Chain, ...], tuple[Interval, ...]]:
        """Return the chains and limbs under review in a motion, and the accepted intervals.

        An accepted interval that cannot be corrected, such as a lone jump, is excluded.
        """
        return self.state.to_correct(motion)

    def accept(self, at_least: float | None = None, *, include_open: bool = False) -> int:
        """Accept all undecided intervals that qualify for automatic correction, in one step.

        Parameters
        ----------
        at_least : float, optional
            The lowest confidence, 0…1.
        include_open : bool
            True to accept open intervals as well.

        Returns
        -------
        int
            The number of accepted intervals.

        See Also
        --------
        twistcore.analysis.correction.twist_removal.automatic_corrections : The conditions.
        """
        ids = self.state.automatic_ids(at_least, include_open=include_open)
        if ids:
            self.do(Decide(ids, Decision.ACCEPTED))
        return len(ids)

    def do(self, command: Command) -> None:
        """Run a command as a new step, or as part of the previous step if both belong to one drag.

        During a drag, each command starts from the state before the drag, so only the final
        position matters. Dragging a τ line up and back, for example, does not change any interval.
        :class:`Sign` is not a step, because it changes all states.
        """
        if isinstance(command, Sign):
            self._change_all(command.signing(self.state))
            return
        same_drag = bool(self._done) and command.continues(self._done[-1].command)
        before = self._done[-1].before if same_drag else self.state
        after = command.apply(before)
        if same_drag:
            self._done.pop()
        self._done.append(_Step(command, before, after))
        self._undone.clear()
        self.state = after

    def undo(self) -> None:
        """Undo the last command, if there is one."""
        if self._done:
            step = self._done.pop()
            self._undone.append(step)
            self.state = step.before

    def redo(self) -> None:
        """Redo the last command that was undone, if there is one."""
        if self._undone:
            step = self._undone.pop()
            self._done.append(step)
            self.state = step.after

    @property
    def undo_text(self) -> str:
        """The name of the command that the next undo reverts, or ''."""
        return self._done[-1].command.text if self._done else ""

    @property
    def redo_text(self) -> str:
        """The name of the command that the next redo repeats, or ''."""
        return self._undone[-1].command.text if self._undone else ""

    @property
    def state_before_last(self) -> ReviewState:
        """The state before the last command, or the current state if there was no command."""
        return self._done[-1].before if self._done else self.state

    @property
    def state_after_next(self) -> ReviewState:
        """The state after the next redo, or the current state if there is nothing to redo."""
        return self._undone[-1].after if self._undone else self.state

    @property
    def history(self) -> tuple[str, ...]:
        """The names of all steps: the completed steps, followed by the undone steps.

        The number of completed steps is :attr:`position`.
        """
        return tuple(s.command.text for s in (*self._done, *reversed(self._undone)))

    @property
    def changed_intervals(self) -> tuple[Judged | None, ...]:
        """The interval that each step of :attr:`history` changes, as it is after the step.

        A removed interval is listed as it was before the step. The value is None for a step that
        changes several intervals or none.
        """
        return tuple(_changed_interval(s) for s in (*self._done, *reversed(self._undone)))

    @property
    def position(self) -> int:
        """The number of completed steps, which is the index of the next redo in :attr:`history`."""
        return len(self._done)

    @property
    def saved(self) -> bool:
        """True if nothing has changed since the session was last saved or opened."""
        return self.state is self._saved

    def take_reasons(self, found: Iterable[Interval]) -> None:
        """Copy the evidence of detected intervals to matching intervals in every stored state.

        `found` contains the detected intervals. Copying evidence is not a step of the history.
        """
        change = make_evidence_adder(found)
        self._saved = self._saved and change(self._saved)
        self._change_all(change)

    def _change_all(self, change: Callable[[ReviewState], ReviewState]) -> None:
        """Apply a function to every state in the history, without adding a step."""
        self.state = change(self.state)
        for steps in (self._done, self._undone):
            steps[:] = [_Step(s.command, change(s.before), change(s.after)) for s in steps]

    def mark_saved(self) -> None:
        """Mark the current state as saved."""
        self._saved = self.state

    def mark_unsaved(self) -> None:
        """Mark every state as unsaved, because the review was recovered from a journal."""
        self._saved = None


def _changed_interval(step: _Step) -> Judged | None:
    new = isinstance(step.command, Insert)
    ids = (step.before.next_id,) if new else step.command.interval_ids
    if len(ids) != 1:
        return None
    both = (*step.after.intervals, *step.before.intervals)
    return next((judged for judged in both if judged.id == ids[0]), None)


def _state_of(found: Detection | ClipAnalysis | ReviewState) -> ReviewState:
    """Return the initial state for reviewing `found`, or `found` itself if it is a state.

    Raises TypeError if `found` has an unsupported type.
    """
    if isinstance(found, ReviewState):
        return found
    if isinstance(found, ClipAnalysis):
        found = found.detect()
    if not isinstance(found, Detection):
        raise TypeError(
            "expected the result of detect or analyse, or the state of a review, found "
            f"{type(found).__name__} {found!r:.80}"
        )
    return _started(found)


def _started(found: Detection) -> ReviewState:
    names = [c.name for c in found.chains_and_limbs]
    return start_review(found.method, found.tau, found, names, found.analysis.rig)
