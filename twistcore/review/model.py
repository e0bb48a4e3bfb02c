"""Represent the state of a review by immutable objects, so that undo can restore an earlier one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import field, replace
from enum import StrEnum
from operator import attrgetter
from types import MappingProxyType
from typing import Any

import numpy as np

from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import Interval
from twistcore.quamo.tracking_settings import Tracking
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.work.frozen import dataclass

SEEN = "seen"  # verdict shown for an accepted interval that cannot be corrected
Span = tuple[int, int]  # frames [start, stop)
APPLIED = "applied automatically"  # verdict shown for automatic corrections


class Decision(StrEnum):
    """A person's decision on an interval.

    Parameters
    ----------
    value : {'undecided', 'accepted', 'rejected'}
        The string that represents the decision in session files.

    Examples
    --------
    >>> import twistcore as tc
    >>> review = tc.Review(tc.detect(tc.read_clip("assets/walk_injected.bvh")))
    >>> {judged.decision for judged in review.state.intervals} == {tc.Decision.UNDECIDED}
    True
    """

    UNDECIDED = "undecided"
    ACCEPTED = "accepted"
    REJECTED = "rejected"


@dataclass(frozen=True, eq=False)
class Judged:
    """An interval under review.

    Parameters
    ----------
    id
        A number that identifies the interval during the whole review.
    interval
        The interval, with the reviewer's edits.
    decision
        The reviewer's decision.
    by_hand
        True if a person inserted the interval.
    edited
        True if a person has changed the frames or the offset.
    supported
        True if the detector still finds the interval at the current τ.
    reviewer, decided_at
        The reviewer's name and the time (ISO 8601).
    note, reason
        The reviewer's note, and the reason for a rejection.
    in_bulk
        True if accepted together with other confident intervals, without viewing each one.
    """

    id: int
    interval: Interval
    decision: Decision = Decision.UNDECIDED
    by_hand: bool = False
    edited: bool = False
    supported: bool = True
    reviewer: str = ""
    decided_at: str = ""
    note: str = ""
    reason: str = ""
    in_bulk: bool = False

    @property
    def corrects(self) -> bool:
        """True if the interval is accepted and can be corrected, so that an export corrects it."""
        return self.decision == Decision.ACCEPTED and self.interval.correctable

    @property
    def counts(self) -> bool:
        """True if summaries count the interval as a correctable error.

        An error of a single joint is included only after a person has accepted it.
        """
        return self.interval.repairable or self.corrects

    @property
    def reported(self) -> Interval:
        """The interval as it is listed in reports.

        An error of a single joint has an offset only after a person has accepted it.
        """
        if self.counts or not self.interval.kind.info.repairer:
            return self.interval
        return replace(self.interval, offset=np.zeros(self.interval.frames))

    @property
    def verdict(self) -> str:
        """The decision as text to display.

        An accepted interval that cannot be corrected, such as a lone jump, is 'seen'. An accepted
        twist error without a reviewer's name and time is an automatic correction.
        """
        if self.decision == Decision.ACCEPTED and not self.interval.correctable:
            return SEEN
        by_person = self.reviewer or self.decided_at or not self.interval.repairable
        if self.decision != Decision.ACCEPTED or by_person:
            return self.decision.value
        return APPLIED

    @property
    def kept(self) -> bool:
        """True if a person has inserted, edited, annotated or decided on the interval.

        A new detection then keeps the interval.
        """
        return (
            self.by_hand
            or self.edited
            or bool(self.note or self.reason)
            or self.decision != Decision.UNDECIDED
        )


@dataclass(frozen=True, eq=False)
class ReviewState:
    """The state of a review.

    Parameters
    ----------
    method
        Name of the detector.
    tau
        τ in radians, keyed by the name of the chain or limb.
    intervals
        The intervals, sorted by chain and start.
    next_id
        The id of the next new interval.
    chain_order
        The index of each chain in the order of the chains, keyed by name.
    tracking
        The settings for tracking after the twist correction, or None.
    rig
        The user's changes to the chains and limbs of the skeleton.
    left_out
        Spans of frames [start, stop) that are excluded from tuning.
    """

    method: str
    tau: Mapping[str, float]
    intervals: tuple[Judged, ...] = ()
    next_id: int = 1
    chain_order: Mapping[str, int] = field(default_factory=lambda: MappingProxyType({}))
    tracking: Tracking | None = None
    rig: Rig = AS_FOUND
    left_out: tuple[Span, ...] = ()

    def __repr__(self) -> str:
        decided = sum(j.decision != Decision.UNDECIDED for j in self.intervals)
        return f"<ReviewState by {self.method}: {decided} of {len(self.intervals)} decided>"

    def find(self, interval_id: int) -> Judged:
        """Return the interval with this id. Raises KeyError if there is none."""
        for judged in self.intervals:
            if judged.id == interval_id:
                return judged
        raise KeyError(interval_id)

    def to_correct(self, motion: Motion) -> tuple[tuple[Chain, ...], tuple[Interval, ...]]:
        """Return the chains and limbs under review in a motion, and the accepted intervals.

        An accepted interval that cannot be corrected, such as a lone jump, is excluded.
        """
        return self.rig.chains(motion), self.chosen()

    def of_chain(self, chain: str) -> tuple[Judged, ...]:
        """Return the intervals of one chain, sorted by start."""
        return tuple(j for j in self.intervals if j.interval.chain == chain)

    def same_frames(self, interval: Interval) -> Judged | None:
        """Return an interval with the same frames that may be the same error, or None.

        Rejected intervals are ignored.
        """
        for judged in self.of_chain(interval.chain):
            own = judged.interval
            frames = (own.start, own.stop) == (interval.start, interval.stop)
            if judged.decision != Decision.REJECTED and frames and own.may_be_same(interval):
                return judged
        return None

    def chosen(self, *, undecided: bool = False) -> tuple[Interval, ...]:
        """Return the accepted intervals that can be corrected.

        Set `undecided` to True to include undecided intervals. Lone jumps are excluded, because
        they cannot be corrected.
        """
        wanted = {Decision.ACCEPTED} | ({Decision.UNDECIDED} if undecided else set())
        return tuple(
            j.interval for j in self.intervals if j.decision in wanted and j.interval.correctable
        )

    def automatic_ids(
        self,
        at_least: float | None = None,
        *,
        include_open: bool = False,
        confidence: Callable[[Interval], float | None] = attrgetter("confidence"),
    ) -> tuple[int, ...]:
        """Return the ids of the undecided intervals that qualify for automatic correction.

        Parameters
        ----------
        at_least
            The lowest confidence, 0…1, or None for the default.
        include_open
            True to include open intervals.
        confidence
            A function that returns the confidence of an interval, or None if it has none. By
            default, this is the detector's confidence.
        """
        undecided = {j.interval: j.id for j in self.intervals if j.decision == Decision.UNDECIDED}
        passing = automatic_corrections(
            undecided, at_least, include_open=include_open, confidence=confidence
        )
        return tuple(undecided[i] for i in passing)

    def neighbour(
        self,
        interval_id: int | None,
        direction: int,
        *,
        undecided: bool = False,
        order: Sequence[int] = (),
    ) -> int | None:
        """Return the id of the next (+1) or previous (−1) interval, or None if there is none.

        The search wraps around at the first and at the last interval.

        Parameters
        ----------
        interval_id
            The current interval, or None to start with the first or last interval.
        direction
            1 or −1.
        undecided
            True to skip decided intervals.
        order
            The ids in the order of the displayed list. By default, intervals are sorted by chain
            and start.
        """
        by_id = {j.id: j for j in self.intervals}
        ids = [
            k
            for k in (order or by_id)
            if k in by_id
            and (not undecided or by_id[k].decision == Decision.UNDECIDED or k == interval_id)
        ]
        if not ids:
            return None
        if interval_id in ids:
            return ids[(ids.index(interval_id) + direction) % len(ids)]
        return ids[0 if direction > 0 else -1]

    def with_intervals(
        self, intervals: Iterable[Judged], next_id: int | None = None
    ) -> ReviewState:
        """Return a copy of the state with the given intervals, sorted by chain and start."""
        order = self.chain_order
        ordered = sorted(
            intervals,
            key=lambda j: (order.get(j.interval.chain, len(order)), j.interval.start, j.id),
        )
        return replace(
            self, intervals=tuple(ordered), next_id=self.next_id if next_id is None else next_id
        )

    def with_changes(self, ids: Collection[int], **changes: Any) -> ReviewState:
        """Return a copy of the state with these fields of some intervals changed.

        Raises KeyError if an id does not exist.
        """
        for interval_id in ids:
            self.find(interval_id)
        wanted = set(ids)
        changed = tuple(replace(j, **changes) if j.id in wanted else j for j in self.intervals)
        if "interval" in changes:
            return self.with_intervals(changed)
        return replace(self, intervals=changed)  # without sorting, which speeds up long journals


def start_review(
    method: str,
    tau: Mapping[str, float],
    found: Iterable[Interval],
    chains: Iterable[str],
    rig: Rig = AS_FOUND,
) -> ReviewState:
    """Return the state of a new review, in which all intervals are undecided.

    Parameters
    ----------
    method
        Name of the detector.
    tau
        τ in radians, keyed by the name of the chain or limb.
    found
        The detected intervals.
    chains
        Names of the chains and limbs in their order.
    rig
        The user's changes to the chains and limbs.
    """
    judged = [Judged(k, interval.for_review) for k, interval in enumerate(found, start=1)]
    state = ReviewState(
        method, MappingProxyType(dict(tau)), chain_order=chain_index_by_name(chains), rig=rig
    )
    return state.with_intervals(judged, next_id=len(judged) + 1)


def chain_index_by_name(chains: Iterable[str]) -> Mapping[str, int]:
    """Return the index of each chain in the given order, keyed by name."""
    return MappingProxyType({name: k for k, name in enumerate(chains)})


def with_earlier_decisions(
    earlier: Sequence[Judged], state: ReviewState, *, same_clip: bool = False
) -> ReviewState:
    """Apply the decisions of an earlier review to this one, matching intervals by their overlap.

    The rules are:

    - An interval that nobody has changed in this review gets the decision, reviewer, note and
      reason of the earlier interval in the same chain that shares the most frames with it. If the
      earlier interval was edited, its frames and offset are copied, too.
    - An interval that a person has changed in this review does not change.
    - Earlier intervals made by hand are added.
    - If `same_clip` is True, earlier decided intervals that overlap no interval of this review are
      added, marked as unsupported by the detector. In a different take, the error may not exist.
    """
    left = [j for j in earlier if j.kept and j.interval.chain in state.tau]
    by_hand = {_frames(j) for j in state.intervals if j.by_hand}
    out = []
    met: set[int] = set()
    for judged in state.intervals:
        near = [(n, old) for old in left if (n := _common(judged.interval, old.interval)) > 0]
        free = [(n, old) for n, old in near if old.id not in met and not old.by_hand]
        if judged.kept or not free:
            met.update(old.id for _, old in near if judged.kept)
            out.append(judged)
            continue
        _, best = max(free, key=lambda shared: shared[0])
        met.add(best.id)
        interval = best.interval if best.edited else judged.interval
        out.append(replace(best, id=judged.id, interval=interval, supported=judged.supported))
    alone = [
        old
        for old in left
        if (_frames(old) not in by_hand if old.by_hand else same_clip and old.id not in met)
    ]
    out += [replace(old, id=k, supported=old.by_hand) for k, old in enumerate(alone, state.next_id)]
    return state.with_intervals(out, state.next_id + len(alone))


def _common(one: Interval, other: Interval) -> int:
    """Return the number of frames shared by two intervals that may be the same error.

    The result is 0 or negative if the intervals share no frames or cannot be the same error.
    """
    if not one.may_be_same(other):
        return 0
    return min(one.stop, other.stop) - max(one.start, other.start)


def _frames(judged: Judged) -> tuple[str, int, int]:
    return judged.interval.chain, judged.interval.start, judged.interval.stop


def overlapping_ids(intervals: Sequence[Judged]) -> frozenset[int]:
    """Return the ids of intervals that overlap another interval of the same chain.

    Rejected intervals and intervals that cannot be corrected automatically are ignored.
    """
    out: set[int] = set()
    reach: Judged | None = None  # the previous interval that ends last
    wanted = (j for j in intervals if j.decision != Decision.REJECTED and j.interval.repairable)
    for judged in sorted(wanted, key=_frames):
        if reach is None or reach.interval.chain != judged.interval.chain:
            reach = judged
            continue
        if judged.interval.start < reach.interval.stop:
            out.update((judged.id, reach.id))
        if judged.interval.stop > reach.interval.stop:
            reach = judged
    return frozenset(out)
