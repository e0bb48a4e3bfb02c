"""A second review of the open clip, and its differences from the user's review."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from twistcore.review import Judged, ReviewState, Session
from twistcore.review.agreement import (
    Agreement,
    PairedIntervals,
    decided_by_person,
    decisions_only_by_second,
    pair_intervals,
    reviewers_of,
)


@dataclass(frozen=True)
class DifferenceRow:
    """A difference between the user's review and the second review.

    Attributes
    ----------
    pair
        The intervals of both reviewers.
    settled
        True if the user has decided again or if the decisions have become equal.
    """

    pair: PairedIntervals
    settled: bool

    @property
    def key(self) -> int:
        """A number that identifies the difference and stays the same when it is settled."""
        return self.pair.theirs.id if self.pair.theirs else -self.pair.either.id


class SecondReview:
    """A comparison of the user's review with a second review, which comes from a session file.

    Attributes
    ----------
    agreement
        The agreement between the reviewers before any difference was settled.
    mine, theirs
        The names of the reviewers in the user's review and in the second review.
    """

    def __init__(self, session: Session, intervals: Sequence[Judged]) -> None:
        self._theirs = session.state.intervals
        self.agreement = Agreement(pair_intervals(intervals, self._theirs))
        both = reviewers_of(intervals), reviewers_of(self._theirs)
        self.mine, self.theirs = map(", ".join, both)
        self._began = {j.id: (j.decision, j.decided_at) for j in intervals}
        self._listed: set[int] = set()  # keys of all pairs that have differed

    def rows(self, state: ReviewState) -> list[DifferenceRow]:
        """Return the differences from the user's review in `state`, sorted by chain and start.

        Settled differences are included.
        """
        pairs = pair_intervals(state.intervals, self._theirs)
        rows = [DifferenceRow(pair, self._is_settled(pair)) for pair in pairs]
        self._listed.update(row.key for row in rows if row.pair.difference is not None)
        return sorted((r for r in rows if r.key in self._listed), key=partial(_place, state))

    def _is_settled(self, pair: PairedIntervals) -> bool:
        mine = pair.mine
        if mine is None or not decided_by_person(mine):
            return pair.difference is None
        again = (mine.decision, mine.decided_at) != self._began.get(mine.id)
        return again or pair.difference is None

    def left_to_them(self, state: ReviewState) -> tuple[Judged, ...]:
        """Return the second reviewer's decisions on intervals that are undecided in `state`."""
        return decisions_only_by_second(
            pair_intervals(state.intervals, self._theirs), state.next_id
        )


def _place(state: ReviewState, row: DifferenceRow) -> tuple[int, int]:
    interval = row.pair.either.interval
    return state.chain_order.get(interval.chain, len(state.chain_order)), interval.start
