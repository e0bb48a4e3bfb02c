"""The state of a review: immutable, so that an undo is the state before."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, replace
from enum import StrEnum
from operator import attrgetter
from types import MappingProxyType

import numpy as np

from twistcore.analysis.correction import applied_unasked
from twistcore.detection import Interval
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

SEEN = "seen"  # what a lone jump is told to be where it is accepted
Span = tuple[int, int]  # frames, half-open
APPLIED = "applied automatically"  # what is told to be accepted by nobody in particular


class Decision(StrEnum):
    """A person's verdict on an interval.

    Parameters
    ----------
    value : {'undecided', 'accepted', 'rejected'}
        The word that session files have.

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


@dataclass(frozen=True)
class Tracking:
    """Which joints are tracked with QuaMo after the twist refinement, and how.

    joints: names, by the skeleton's order, none where only the place is tracked; learned: gains of
    the shipped networks instead of κP (1/s²), κD (1/s) and κA; weights: the first 16 digits of the
    SHA-256 of the networks' file, '' with gains of hands; causal: False for both ways; place: the
    figure's place too. As these two are here, so were all sessions that do not name them.
    """

    joints: tuple[str, ...]
    kp: float = 600.0
    kd: float = 15.0
    ka: float = 0.0
    learned: bool = False
    weights: str = ""
    causal: bool = True
    place: bool = False

    @property
    def what(self) -> str:
        """What is tracked, in two or three words."""
        joints = self.joints[0] if len(self.joints) == 1 else f"{len(self.joints)} joints"
        return " and ".join((joints,) * bool(self.joints) + ("the place",) * self.place)


@dataclass(frozen=True, eq=False)
class Judged:
    """An interval under review.

    id: stays the same for the life of the review; by_hand: made by a person; edited: its frames
    or offset were; supported: the detector still finds it at the present τ; reviewer, decided_at
    (ISO 8601), note, reason (of a rejection): as entered; in_bulk: accepted with all that were as
    sure, none of which was looked at.
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
    def verdict(self) -> str:
        """The decision as it is told.

        A lone jump that is accepted is 'seen', not corrected; what is accepted with no name and no
        time was looked at by nobody.
        """
        if self.decision != Decision.ACCEPTED:
            return self.decision.value
        if not self.interval.repairable:
            return SEEN
        return self.decision.value if self.reviewer or self.decided_at else APPLIED

    @property
    def kept(self) -> bool:
        """A person has put work into it: re-detection must not take it away."""
        return (
            self.by_hand
            or self.edited
            or bool(self.note or self.reason)
            or self.decision != Decision.UNDECIDED
        )


@dataclass(frozen=True, eq=False)
class ReviewState:
    """method: detector; tau: radians by chain or limb; intervals by chain order and start.

    tracking: what is tracked once the twist errors are out; None: nothing, as ever unless asked;
    rig: which chains and limbs there are, and so whose names these are; left_out: of tuning.
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
        """The interval of an id; KeyError where there is none."""
        for judged in self.intervals:
            if judged.id == interval_id:
                return judged
        raise KeyError(interval_id)

    def to_correct(self, motion: Motion) -> tuple[tuple[Chain, ...], tuple[Interval, ...]]:
        """The chains and limbs of the review's rig in a motion, and the accepted intervals."""
        return self.rig.chains(motion), self.chosen()

    def of_chain(self, chain: str) -> tuple[Judged, ...]:
        """Intervals of one chain by start."""
        return tuple(j for j in self.intervals if j.interval.chain == chain)

    def same_frames(self, interval: Interval) -> Judged | None:
        """What is not rejected and has its chain, kind and frames; None where nothing has."""
        wanted = interval.kind, interval.start, interval.stop
        for judged in self.of_chain(interval.chain):
            own = judged.interval
            if judged.decision != Decision.REJECTED and (own.kind, own.start, own.stop) == wanted:
                return judged
        return None

    def chosen(self, *, undecided: bool = False) -> tuple[Interval, ...]:
        """What is taken out: accepted intervals; with `undecided`, those nobody has rejected.

        No lone jumps: an accepted one was seen, and of it nothing is taken out.
        """
        wanted = {Decision.ACCEPTED} | ({Decision.UNDECIDED} if undecided else set())
        return tuple(
            j.interval for j in self.intervals if j.decision in wanted and j.interval.repairable
        )

    def unasked(
        self,
        at_least: float | None = None,
        *,
        include_open: bool = False,
        confidence: Callable[[Interval], float | None] = attrgetter("confidence"),
    ) -> tuple[int, ...]:
        """Ids of undecided intervals that :func:`applied_unasked` lets pass."""
        undecided = {j.interval: j.id for j in self.intervals if j.decision == Decision.UNDECIDED}
        passing = applied_unasked(
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
        """The id of the next (+1) or previous (−1) interval, round the end; None without any.

        undecided: others are passed over; order: ids as they are listed, by chain and start if
        none are given.
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
        """The same review with other intervals, put in order."""
        order = self.chain_order
        ordered = sorted(
            intervals,
            key=lambda j: (order.get(j.interval.chain, len(order)), j.interval.start, j.id),
        )
        return replace(
            self, intervals=tuple(ordered), next_id=self.next_id if next_id is None else next_id
        )


def start_review(
    method: str,
    tau: Mapping[str, float],
    found: Iterable[Interval],
    chains: Iterable[str],
    rig: Rig = AS_FOUND,
) -> ReviewState:
    """A review in which nothing is decided yet."""
    judged = [Judged(k, as_written(interval)) for k, interval in enumerate(found, start=1)]
    state = ReviewState(
        method, MappingProxyType(dict(tau)), chain_order=chain_places(chains), rig=rig
    )
    return state.with_intervals(judged, next_id=len(judged) + 1)


def chain_places(chains: Iterable[str]) -> Mapping[str, int]:
    """Places by the names of chains."""
    return MappingProxyType({name: k for k, name in enumerate(chains)})


def as_written(interval: Interval) -> Interval:
    """The interval with its offset as a session file holds it: degrees with nine decimals, no −0.0.

    So the program and `twistcore apply` correct by the very same numbers.
    """
    return interval.as_written


def resized(interval: Interval, start: int, stop: int) -> Interval:
    """The interval over [start, stop): kept offsets stay, new frames get the nearest one."""
    at = np.clip(np.arange(start, stop), interval.start, interval.stop - 1) - interval.start
    return interval.with_offset(start, interval.offset[at])


def same_offsets(one: Interval, other: Interval) -> bool:
    """Whether two intervals of a chain take the same out of the same frames, but for rounding."""
    frames = (one.start, one.stop, one.carried) == (other.start, other.stop, other.carried)
    return frames and np.allclose(one.offset, other.offset, atol=1e-12)


def levelled(interval: Interval, delta: float) -> Interval:
    """The interval moved by whole to a new median offset `delta`, radians.

    One whose ends are soft gets `delta` as its largest offset: its course is stretched, so that its
    ends stay soft.
    """
    if interval.soft_ended:
        return interval.with_offset(interval.start, interval.offset * (delta / interval.largest))
    return interval.with_offset(interval.start, wrap(interval.offset + (delta - interval.delta)))


def flattened(interval: Interval) -> Interval:
    """The interval with its median offset in all frames: a level shift."""
    return interval.with_offset(interval.start, np.full(interval.frames, interval.delta))


def following(interval: Interval, theta_p: Array) -> Interval:
    """The interval with an offset a frame, so that P's corrected twist runs straight across it.

    theta_p: twist of P, radians, (frames,). For errors that drift or jitter inside.
    """
    if interval.frames >= len(theta_p):
        return interval
    return interval.with_offset(interval.start, off_line(theta_p, interval.start, interval.stop))


def off_line(theta: Array, start: int, stop: int) -> Array:
    """Twist in [start, stop) above a straight line between its neighbours, radians in (−π, π].

    At an end of the clip, which has one neighbour, the line is level; where all of the clip is
    meant it is at the last frame.
    """
    outside = [t for t in (start - 1, stop) if 0 <= t < len(theta)] or [len(theta) - 1]
    before, behind = float(theta[outside[0]]), float(theta[outside[-1]])
    share = (np.arange(stop - start) + 1) / (stop - start + 1)
    return wrap(theta[start:stop] - (before + wrap(behind - before) * share))


def carried_over(
    earlier: Sequence[Judged], state: ReviewState, *, same_clip: bool = False
) -> ReviewState:
    """The work of an earlier review on the intervals of this one, matched by overlap.

    An interval that nobody has touched takes verdict, reviewer, note, reason and, if they were
    edited, frames and offset of the earlier one of its chain that shares most frames with it;
    one that a person has touched here stays. Hand-made ones come along. same_clip: so does, without
    the detector's support, every other that was kept and overlaps none here; in another take the
    error it was about may be gone.
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
    """How many frames two intervals share, 0 or less for none; of two chains or kinds, none."""
    if (one.chain, one.kind) != (other.chain, other.kind):
        return 0
    return min(one.stop, other.stop) - max(one.start, other.start)


def _frames(judged: Judged) -> tuple[str, int, int]:
    return judged.interval.chain, judged.interval.start, judged.interval.stop


def overlapping_ids(intervals: Sequence[Judged]) -> frozenset[int]:
    """Ids of the intervals not rejected that share frames with another of their chain: they add."""
    out: set[int] = set()
    reach: Judged | None = None  # of those before, the one that reaches furthest
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


def constant(chain: str, start: int, stop: int, delta: float) -> Interval:
    """An interval with one offset, radians, in all its frames."""
    offset: Array = np.full(stop - start, delta)
    return Interval(chain, start, stop, offset)
