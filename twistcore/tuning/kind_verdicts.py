"""The verdicts of a review on intervals of all kinds.

τ is learned only from counter-twists; these verdicts show how reliable each kind is.
"""

from __future__ import annotations

from typing import NamedTuple

from twistcore.detection import Kind
from twistcore.review import Decision, ReviewState
from twistcore.review.agreement import decided_by_person


class KindVerdict(NamedTuple):
    """A person's verdict on an interval of any kind.

    Attributes
    ----------
    chain, kind
        The chain or limb of the interval, and its kind.
    error
        True if the interval was accepted, False if it was rejected, None if it is undecided.
    by_hand
        True if a person inserted the interval, so that the program had missed the error.
    """

    chain: str
    kind: Kind
    error: bool | None
    by_hand: bool


def kind_verdicts(state: ReviewState) -> tuple[KindVerdict, ...]:
    """Return a verdict for each interval of a review.

    Automatic corrections, and intervals that were accepted in bulk, are undecided. Intervals that a
    person inserted and rejected are left out.
    """
    verdicts = []
    for judged in state.intervals:
        by_person = decided_by_person(judged) and not judged.in_bulk
        error = judged.decision == Decision.ACCEPTED if by_person else None
        if error or not judged.by_hand:
            interval = judged.interval
            verdicts.append(KindVerdict(interval.chain, interval.kind, error, judged.by_hand))
    return tuple(verdicts)
