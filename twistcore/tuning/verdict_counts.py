"""Count reviewers' verdicts for each kind of error or each chain."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

from twistcore.review.kind_verdicts import KindVerdict
from twistcore.tuning.verdict_curve import VerdictScore
from twistcore.work.frozen import dataclass

Group = TypeVar("Group", bound=Hashable)


@dataclass(frozen=True)
class VerdictCount:
    """Verdict counts for a group of intervals.

    Attributes
    ----------
    score
        The number of errors, of errors that the program found, and of false alarms, from which
        precision and recall are computed.
    undecided
        The number of listed intervals that nobody has judged yet.
    """

    score: VerdictScore
    undecided: int

    @property
    def recall(self) -> float:
        """The share of errors that the program found.

        The result is NaN if no person has inserted an error, because it is then unknown whether
        anybody has looked for missed errors.
        """
        return self.score.recall[0] if self.score.errors > self.score.found else math.nan


def count_verdicts_by_group(
    verdicts: Iterable[KindVerdict], group_of: Callable[[KindVerdict], Group]
) -> dict[Group, VerdictCount]:
    """Count the verdicts in each group.

    Parameters
    ----------
    verdicts
        The verdicts.
    group_of
        A function that returns the group of a verdict, such as its kind.

    Returns
    -------
    dict
        The verdict counts, keyed by group, in the order in which the groups first occur.
    """
    groups: dict[Group, list[KindVerdict]] = {}
    for verdict in verdicts:
        groups.setdefault(group_of(verdict), []).append(verdict)
    return {group: _count(own) for group, own in groups.items()}


def _count(verdicts: Iterable[KindVerdict]) -> VerdictCount:
    found = missed = alarms = undecided = 0
    for verdict in verdicts:
        found += verdict.error is True and not verdict.by_hand
        missed += verdict.error is True and verdict.by_hand
        alarms += verdict.error is False
        undecided += verdict.error is None
    return VerdictCount(VerdictScore(found + missed, found, alarms, alarms), undecided)
