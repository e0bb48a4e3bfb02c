"""Collect the verdicts of a review on intervals of all kinds of errors.

The threshold τ is learned only from verdicts on counter-twists. The verdicts on all kinds show how
reliable the detection of each kind is.
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
    chain
        The name of the chain or limb of the interval.
    kind
        The kind of the interval.
    error
        True if a person accepted the interval as an error, False if a person rejected it, and None
        if it is undecided.
    by_hand
        True if a person inserted the interval, which means that the program missed the error.
    """

    chain: str
    kind: Kind
    error: bool | None
    by_hand: bool


def verdicts_with_kinds(state: ReviewState) -> tuple[KindVerdict, ...]:
    """Return a verdict for each interval of a review.

    Automatic corrections, and intervals that a person accepted in bulk, are undecided, because no
    person has looked at them one by one. Intervals that a person inserted but did not accept are
    omitted.
    """
    verdicts = []
    for judged in state.intervals:
        by_person = decided_by_person(judged) and not judged.in_bulk
        error = judged.decision == Decision.ACCEPTED if by_person else None
        if error or not judged.by_hand:
            interval = judged.interval
            verdicts.append(KindVerdict(interval.chain, interval.kind, error, judged.by_hand))
    return tuple(verdicts)
