"""Define the commands that decide on intervals, give a reason or add a reviewer's name."""

from __future__ import annotations

from collections.abc import Callable

from twistcore.review.commands import Command
from twistcore.review.model import Decision, ReviewState
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class Decide(Command):
    """Set a reviewer's decision on one or more intervals.

    Parameters
    ----------
    ids
        The ids of the intervals.
    decision
        The decision.
    reviewer, decided_at
        The reviewer's name and the time (ISO 8601).
    in_bulk
        True if all confident intervals were decided together, without viewing each one.
    reason
        The reason for a rejection, or '' to keep the reasons.
    """

    ids: tuple[int, ...]
    decision: Decision
    reviewer: str = ""
    decided_at: str = ""
    in_bulk: bool = False
    reason: str = ""

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        n = len(self.ids)
        one, many = {
            Decision.ACCEPTED: ("Accept interval", f"Accept {n} intervals"),
            Decision.REJECTED: ("Reject interval", f"Reject {n} intervals"),
            Decision.UNDECIDED: ("Reset interval", f"Reset {n} intervals"),
        }[self.decision]
        return one if n == 1 else many

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The ids of the decided intervals."""
        return self.ids

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the decision on the intervals, and with the reason if there is one.

        If the decision is reset to undecided, the reviewer's name and the time are removed, too.
        """
        undecided = self.decision == Decision.UNDECIDED
        by, at = ("", "") if undecided else (self.reviewer, self.decided_at)
        bulk = self.in_bulk and not undecided
        verdict = {"decision": self.decision, "reviewer": by, "decided_at": at, "in_bulk": bulk}
        if self.reason:
            verdict["reason"] = self.reason
        return state.with_changes(self.ids, **verdict)


@dataclass(frozen=True)
class Sign(Command):
    """Add a reviewer's name to decisions that were made without a name.

    Signing is not a step in the undo history, because :class:`Review` adds the name to every stored
    state. The next undo therefore reverts the last decision, and the other decisions remain signed.
    """

    ids: tuple[int, ...]
    reviewer: str

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        return (
            "Add name to decision"
            if len(self.ids) == 1
            else f"Add name to {len(self.ids)} decisions"
        )

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the reviewer's name added to its unsigned decisions."""
        return self.signing(state)(state)

    def signing(self, now: ReviewState) -> Callable[[ReviewState], ReviewState]:
        """Return a function that signs the decisions in a state that are unsigned in `now`.

        The function returns a state in which these decisions have the reviewer's name. If it is
        called again with the same state, it returns the same object. A state without such decisions
        is returned unchanged. Raises KeyError if `now` lacks one of the intervals.
        """
        nobody = {
            (judged.id, judged.decided_at)
            for judged in map(now.find, self.ids)
            if judged.decision != Decision.UNDECIDED and not judged.reviewer
        }
        states: dict[ReviewState, ReviewState] = {}

        def sign(state: ReviewState) -> ReviewState:
            if state not in states:
                ids = tuple(
                    j.id
                    for j in state.intervals
                    if (j.id, j.decided_at) in nobody
                    and j.decision != Decision.UNDECIDED
                    and not j.reviewer
                )
                signed = state.with_changes(ids, reviewer=self.reviewer) if ids else state
                states[state] = signed
            return states[state]

        return sign
