"""Compare two reviews of the same clip, and merge them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Any

from twistcore.detection.interval_offsets import same_offsets
from twistcore.errors import ClipMismatchError
from twistcore.review.model import APPLIED, Decision, Judged, ReviewState
from twistcore.review.overlaps import overlapping_interval_pairs
from twistcore.review.session import judged_to_json
from twistcore.work.frozen import dataclass


class PairDifference(StrEnum):
    """A kind of difference between two reviewers' decisions on an interval."""

    VERDICT = "opposite decisions"
    CORRECTION = "different corrections"  # neither reviewer has rejected the interval
    DECIDED = "decided by one only"
    INSERTED = "inserted by only one reviewer"
    DETECTED = "detected in one only"  # by a reviewer who has decided on it


@dataclass(frozen=True)
class PairedIntervals:
    """An interval that appears in one or both of two reviews of the same clip.

    Parameters
    ----------
    mine
        The interval in the first review, or None if only the second review has it.
    theirs
        The interval in the second review, or None if only the first review has it.
    """

    mine: Judged | None
    theirs: Judged | None

    @property
    def either(self) -> Judged:
        """The interval in the first review, or in the second if the first does not have it."""
        one = self.mine or self.theirs
        assert one is not None
        return one

    @property
    def decided_by_both(self) -> bool:
        """True if both reviewers have decided on the interval."""
        return decided_by_person(self.mine) and decided_by_person(self.theirs)

    @property
    def difference(self) -> PairDifference | None:
        """The kind of difference between the two reviews, or None if there is none."""
        mine, theirs = self.mine, self.theirs
        if mine is None or theirs is None:
            if self.either.by_hand:
                return PairDifference.INSERTED
            return PairDifference.DETECTED if decided_by_person(self.either) else None
        both = self.decided_by_both
        if both and mine.decision != theirs.decision:
            return PairDifference.VERDICT
        if decided_by_person(mine) != decided_by_person(theirs):
            return PairDifference.DECIDED
        decided_or_edited = both or mine.edited or theirs.edited
        rejected = mine.decision == Decision.REJECTED
        if decided_or_edited and not rejected and not same_offsets(mine.interval, theirs.interval):
            return PairDifference.CORRECTION
        return None

    def taken(self, new_id: int) -> Judged | None:
        """Return the interval with the second reviewer's decision and offset.

        The result is None if the second reviewer has not decided. `new_id` is the id of the result
        if only the second review has the interval.
        """
        mine, theirs = self.mine, self.theirs
        if theirs is None or not decided_by_person(theirs):
            return None
        if mine is None:
            return replace(theirs, id=new_id, supported=theirs.by_hand)
        same = same_offsets(mine.interval, theirs.interval)  # only `mine` may have evidence
        return replace(
            theirs,
            id=mine.id,
            interval=mine.interval if same else theirs.interval,
            by_hand=mine.by_hand,
            supported=mine.supported,
            note=mine.note or theirs.note,
        )


@dataclass(frozen=True, eq=False)
class Agreement:
    """The paired intervals of two reviews of a clip, and measures of the reviewers' agreement."""

    pairs: tuple[PairedIntervals, ...]

    @property
    def differences(self) -> tuple[PairedIntervals, ...]:
        """The pairs that differ between the two reviews."""
        return tuple(pair for pair in self.pairs if pair.difference is not None)

    @property
    def decisions(self) -> tuple[tuple[Decision, Decision], ...]:
        """The two reviewers' decisions on each interval on which both have decided."""
        return tuple(
            (pair.mine.decision, pair.theirs.decision)
            for pair in self.pairs
            if pair.mine is not None and pair.theirs is not None and pair.decided_by_both
        )

    @property
    def alike(self) -> int:
        """The number of intervals on which both reviewers have made the same decision."""
        return sum(mine == theirs for mine, theirs in self.decisions)

    @property
    def percent(self) -> float | None:
        """The percentage of equal decisions, among the intervals decided by both reviewers.

        The value is None if there is no such interval.
        """
        return 100.0 * self.alike / len(self.decisions) if self.decisions else None

    @property
    def kappa(self) -> float | None:
        """Cohen's kappa of the decisions, or None if it is undefined."""
        return cohen_kappa(*zip(*self.decisions, strict=True)) if self.decisions else None

    @property
    def why_no_kappa(self) -> str:
        """The reason why kappa is undefined, or '' if it is defined."""
        if self.kappa is not None:
            return ""
        if not self.decisions:
            return "no interval was decided by both reviewers"
        return f"both reviewers {self.decisions[0][0]} every interval"

    @property
    def summary(self) -> str:
        """A text with the number and percentage of equal decisions, and kappa."""
        if self.percent is None:
            return self.why_no_kappa
        score = f"undefined ({self.why_no_kappa})" if self.kappa is None else f"{self.kappa:.2f}"
        count = (
            f"decided by both reviewers: {len(self.decisions)}, with the same decision: "
            f"{self.alike}"
        )
        return f"{count} ({self.percent:.0f} %), Cohen's kappa: {score}"


def decided_by_person(judged: Judged | None) -> bool:
    """Return True if a person has decided on the interval. Automatic corrections do not count."""
    return (
        judged is not None and judged.decision != Decision.UNDECIDED and judged.verdict != APPLIED
    )


def reviewers_of(judged: Iterable[Judged]) -> tuple[str, ...]:
    """Return the names of the reviewers who have decided on intervals, in alphabetical order."""
    decided = (j for j in judged if j.decision != Decision.UNDECIDED)
    return tuple(sorted({j.reviewer for j in decided if j.reviewer}))


def cohen_kappa(first: Sequence[str], second: Sequence[str]) -> float | None:
    """Return Cohen's kappa [Cohen 1960] of the decisions of two judges on the same items.

    Kappa is 1 if the judges always agree, and 0 if they agree as often as by chance. The result is
    None if there are no decisions, or if both judges have made the same decision on every item.
    """
    if not first:
        return None
    count = len(first)
    same = sum(a == b for a, b in zip(first, second, strict=True)) / count
    of_first, of_second = Counter(first), Counter(second)
    chance = sum(of_first[v] * of_second[v] for v in of_first) / count**2
    return (same - chance) / (1.0 - chance) if chance < 1.0 else None


def pair_intervals(mine: Sequence[Judged], theirs: Sequence[Judged]) -> tuple[PairedIntervals, ...]:
    """In two reviews of a clip, pair the intervals that may describe the same error.

    Two intervals can form a pair if they have the same chain and kind, and if they overlap. Pairs
    with the largest overlap are formed first. The result lists the intervals of the first review in
    their order, followed by the intervals that only the second review has.
    """
    partner: dict[int, int] = {}
    taken: set[int] = set()
    for _, k, n in sorted(
        overlapping_interval_pairs([j.interval for j in mine], [j.interval for j in theirs])
    ):
        if k not in partner and n not in taken:
            partner[k] = n
            taken.add(n)
    pairs = [
        PairedIntervals(j, theirs[partner[k]] if k in partner else None) for k, j in enumerate(mine)
    ]
    alone = (j for n, j in enumerate(theirs) if n not in taken)
    return (*pairs, *(PairedIntervals(None, j) for j in alone))


def decisions_only_by_second(pairs: Sequence[PairedIntervals], new_id: int) -> tuple[Judged, ...]:
    """Return the second reviewer's decisions on intervals that the first has left undecided.

    An interval keeps its id in the first review. Intervals that only the second review has get new
    ids, starting with `new_id`. Two kinds of intervals are excluded: intervals that the first
    reviewer has decided on, edited, annotated or inserted, and intervals that overlap one of these,
    because both corrections would be applied.
    """
    kept = [p.mine.interval for p in pairs if p.mine is not None and p.mine.kept]
    theirs = [p.theirs for p in pairs if p.theirs is not None]
    clashing = {
        theirs[n]
        for _, _, n in overlapping_interval_pairs(kept, [judged.interval for judged in theirs])
    }
    out: list[Judged] = []
    for pair in pairs:
        free = pair.theirs not in clashing and not (pair.mine is not None and pair.mine.kept)
        if free and (taken := pair.taken(new_id)) is not None:
            out.append(taken)
            new_id += pair.mine is None
    return tuple(out)


def check_same_clip(sha256: str, other: str) -> None:
    """Raise ClipMismatchError unless the clips of two reviews have the same SHA-256."""
    if sha256 != other:
        raise ClipMismatchError("the two reviews are of different clips (SHA-256 differs)")


def merged_review(found: Agreement, state: ReviewState) -> ReviewState:
    """Return a review that contains the decisions on which both reviewers agree.

    `found` contains the paired intervals of both reviews. Intervals without an agreement are
    undecided, and their notes contain both decisions. τ, chains and tracking are copied from
    `state`, the first review. Raises ClipMismatchError if the first review lacks a chain of the
    second.
    """
    out: list[Judged] = []
    new_id = state.next_id
    for pair in found.pairs:
        if pair.mine is None and pair.difference is None:
            continue
        if pair.either.interval.chain not in state.tau:
            raise ClipMismatchError("the two reviews have different chains")
        out.append(_merged_pair(pair, new_id))
        new_id += pair.mine is None
    return state.with_intervals(out, new_id)


def _merged_pair(pair: PairedIntervals, new_id: int) -> Judged:
    mine, theirs = pair.mine, pair.theirs
    if mine is None or theirs is None or pair.difference or mine.decision != theirs.decision:
        one, opinions = pair.either, filter(None, map(_opinion, (mine, theirs)))
        return replace(
            one,
            id=new_id if mine is None else one.id,
            supported=one.supported and (mine is not None or one.by_hand),
            decision=Decision.UNDECIDED,
            reviewer="",
            decided_at="",
            reason="",
            in_bulk=False,
            note="; ".join(opinions) if pair.difference else one.note,
        )
    names = dict.fromkeys(filter(None, (mine.reviewer, theirs.reviewer)))
    return replace(
        mine,
        reviewer=", ".join(names),
        decided_at=max(mine.decided_at, theirs.decided_at),
        reason=mine.reason or theirs.reason,
        note="; ".join(dict.fromkeys(filter(None, (mine.note, theirs.note)))),
        in_bulk=mine.in_bulk and theirs.in_bulk,
    )


def _opinion(judged: Judged | None) -> str:
    """Return a reviewer's decision, correction and note in words, or '' if there is none."""
    if judged is None or not judged.kept:
        return ""
    place = f"{judged.interval.start}–{judged.interval.stop} {judged.interval.angle_text(1)}"
    why = "".join(f", {text}" for text in (judged.reason, judged.note) if text)
    return f"{judged.reviewer or 'no name'}: {judged.decision} {place}{why}"


def agreement_to_json(found: Agreement) -> dict[str, Any]:
    """Return the agreement and the differences of two reviews as JSON data.

    The keys "a" and "b" contain the interval in the first and in the second review, written as in
    sessions.
    """
    return {
        "decided_by_both": len(found.decisions),
        "alike": found.alike,
        "percent": found.percent,
        "kappa": found.kappa,
        "kappa_undefined": found.why_no_kappa or None,
        "differences": [
            {
                "difference": pair.difference,
                "chain": pair.either.interval.chain,
                "a": pair.mine and judged_to_json(pair.mine, kinds=True),
                "b": pair.theirs and judged_to_json(pair.theirs, kinds=True),
            }
            for pair in found.differences
        ],
    }
