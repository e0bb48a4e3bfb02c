"""Count people's verdicts by kind of error or by chain."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

from twistcore.tuning.kind_verdicts import KindVerdict
from twistcore.tuning.verdict_curve import VerdictScore
from twistcore.work.frozen import dataclass

Group = TypeVar("Group", bound=Hashable)


@dataclass(frozen=True)
class VerdictCount:
    """The verdicts of a group.

    Attributes
    ----------
    score
        The numbers of errors and false alarms, with precision and recall.
    undecided
        The number of listed intervals without a verdict of a person.
    """

    score: VerdictScore
    undecided: int


def count_by(
    verdicts: Iterable[KindVerdict], group_of: Callable[[KindVerdict], Group]
) -> dict[Group, VerdictCount]:
    """Count verdicts, keyed by the group of each verdict, in the order of the first verdicts."""
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
