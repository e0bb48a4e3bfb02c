"""Define the commands of a review as immutable objects that transform one state into the next."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from types import MappingProxyType

from twistcore.detection import DETECTORS, Interval
from twistcore.quamo.tracking_settings import Tracking
from twistcore.review.model import Judged, ReviewState, chain_index_by_name, with_earlier_decisions
from twistcore.review.overlaps import overlapping_interval_pairs
from twistcore.skeleton.rig import Rig
from twistcore.work.frozen import dataclass


class Command(ABC):
    """A change to the state of a review.

    If `apply` raises an exception, the review is unchanged.
    """

    @property
    @abstractmethod
    def text(self) -> str:
        """The command's name in the undo menu."""

    @abstractmethod
    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The ids of the intervals that the command changes, or () if it does not list them."""
        return ()

    def continues(self, earlier: Command) -> bool:
        """Return True if this command continues the drag of `earlier`, so one undo reverts both."""
        del earlier
        return False


@dataclass(frozen=True, eq=False)
class Edit(Command):
    """Change the frames or the offset of an interval.

    Parameters
    ----------
    id
        The id of the interval.
    interval
        The new interval.
    drag
        A number that all edits in one mouse drag share, or 0 for an edit without a drag.
    """

    id: int
    interval: Interval
    drag: int = 0

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        return f"Edit interval {self.id}"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The id of the edited interval."""
        return (self.id,)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the new interval, marked as edited.

        Raises ValueError if the interval is empty, belongs to a different chain, or cannot be
        edited.
        """
        old = state.find(self.id)
        if self.interval.start < 0 or self.interval.stop <= self.interval.start:
            raise ValueError("an interval must have at least one frame")
        if self.interval.chain != old.interval.chain:
            raise ValueError("an edit cannot move an interval to another chain")
        if not old.interval.kind.correctable:
            raise ValueError(
                "detections of this kind are not corrected; press Insert to create an interval"
            )
        return state.with_changes((self.id,), interval=self.interval.as_written, edited=True)

    def continues(self, earlier: Command) -> bool:
        """Return True if `earlier` edits the same interval in the same drag."""
        return (
            isinstance(earlier, Edit)
            and self.drag != 0
            and (earlier.id, earlier.drag) == (self.id, self.drag)
        )


@dataclass(frozen=True)
class Annotate(Command):
    """Set the note on an interval, and the reason for rejecting it."""

    id: int
    note: str
    reason: str = ""

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        return f"Note on interval {self.id}"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The id of the interval with the note."""
        return (self.id,)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the note and the reason."""
        return state.with_changes((self.id,), note=self.note, reason=self.reason)


@dataclass(frozen=True, eq=False)
class Insert(Command):
    """Add an interval that the user has created by hand."""

    interval: Interval

    text = "New interval"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the new interval, which is undecided."""
        new = Judged(state.next_id, self.interval.as_written, by_hand=True)
        return state.with_intervals((*state.intervals, new), next_id=state.next_id + 1)


@dataclass(frozen=True)
class Remove(Command):
    """Remove an interval created by hand. Detected intervals can be rejected, but not removed."""

    id: int

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        return f"Remove interval {self.id}"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The id of the removed interval."""
        return (self.id,)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state without the interval. Raises ValueError for a detected interval."""
        if not state.find(self.id).by_hand:
            raise ValueError("only hand-made intervals can be removed")
        return state.with_intervals(j for j in state.intervals if j.id != self.id)


@dataclass(frozen=True, eq=False)
class Redetect(Command):
    """Set a new threshold τ, and replace intervals by the ones detected with it.

    The rules are:

    - An interval that was edited, or on which a person has decided, is kept. A detected interval
      is dropped if it matches a kept one (IoU of at least 0.5) or if at least 80 % of it lies
      inside a kept one. A kept interval without such a detected interval is marked as unsupported.
    - Every other interval is replaced by a detected one that overlaps it, with the largest overlaps
      first, or removed if there is none.
    - The remaining detected intervals are added.

    Parameters
    ----------
    tau
        The new τ in radians, keyed by chain name.
    found
        The intervals detected in these chains.
    method
        The new detector, or '' to keep the detector.
    drag
        A number that all commands in one drag of a τ line share, or 0 without a drag.
    what
        The command's name in the undo menu, '' for the usual name.
    """

    tau: Mapping[str, float]
    found: tuple[Interval, ...]
    method: str = ""
    drag: int = 0
    what: str = ""

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        if self.what:
            return self.what
        if self.method:
            return DETECTORS.info(self.method).menu_text
        if len(self.tau) == 1:
            return f"Set τ of {next(iter(self.tau))}"
        return f"Set τ of {len(self.tau)} chains"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the new τ and the detected intervals."""
        tau = MappingProxyType({**state.tau, **self.tau})
        known = replace(state, tau=tau, method=self.method or state.method)
        return _redetected(known, self.tau, self.found)

    def continues(self, earlier: Command) -> bool:
        """Return True if `earlier` belongs to the same drag of the same τ line."""
        return (
            isinstance(earlier, Redetect)
            and self.drag != 0
            and earlier.drag == self.drag
            and set(earlier.tau) == set(self.tau)
        )


@dataclass(frozen=True, eq=False)
class ChangeChains(Command):
    """Change the chains and limbs, and remove the intervals of removed chains.

    Parameters
    ----------
    rig
        The new chains.
    tau
        The τ of every chain in radians, keyed by chain name, in the order of the chains.
    again
        Names of the chains in which intervals were detected again: new chains, and chains whose
        neighbours changed.
    found
        The detected intervals of these chains, merged by the rules of :class:`Redetect`.
    what
        The command's name in the undo menu, '' for the usual name.
    moved
        The person's new first chain, keyed by the earlier one. Decided errors of the whole body,
        which are listed under the first chain, move there.
    """

    rig: Rig
    tau: Mapping[str, float]
    again: tuple[str, ...]
    found: tuple[Interval, ...]
    what: str = ""
    moved: Mapping[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        return self.what or "Change the chains"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the new chains. Raises ValueError if a chain has no τ."""
        if missing := [name for name in self.again if name not in self.tau]:
            raise ValueError(f"there is no chain {missing[0]!r}")
        tau = MappingProxyType(dict(self.tau))
        stay = {name for name in tau if state.rig.own(name) == self.rig.own(name)}
        kept = []
        for judged in state.intervals:
            interval = judged.interval
            first = self.moved.get(interval.chain, "")
            if first in tau and judged.kept and interval.kind.info.whole_body:
                kept.append(replace(judged, interval=replace(interval, chain=first)))
            elif interval.chain in stay:
                kept.append(judged)
        state = replace(state, rig=self.rig, tau=tau, chain_order=chain_index_by_name(tau))
        return _redetected(state.with_intervals(kept), self.again, self.found)


@dataclass(frozen=True, eq=False)
class CarryOver(Command):
    """Apply the decisions of an earlier review to this review.

    Parameters
    ----------
    earlier
        The intervals of the earlier review.
    same_clip
        True if the earlier review is of the same clip, False if it is of a different take.
    """

    earlier: tuple[Judged, ...]
    same_clip: bool = False

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        return "Add decisions" if self.same_clip else "Carry over decisions"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the earlier decisions (see ``with_earlier_decisions``)."""
        return with_earlier_decisions(self.earlier, state, same_clip=self.same_clip)


@dataclass(frozen=True, eq=False)
class Settle(Command):
    """Replace intervals and their decisions, to settle differences between two reviews of a clip.

    Each given interval replaces the interval with the same id, or is added if there is none.
    """

    earlier: tuple[Judged, ...]

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        n = len(self.earlier)
        return "Settle difference" if n == 1 else f"Settle {n} differences"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The ids of the settled intervals."""
        return tuple(judged.id for judged in self.earlier)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the settled intervals. Raises ValueError for an unknown chain."""
        for judged in self.earlier:
            if judged.interval.chain not in state.tau:
                raise ValueError(f"there is no chain {judged.interval.chain!r}")
        new = {judged.id: judged for judged in self.earlier}
        kept = (j for j in state.intervals if j.id not in new)
        return state.with_intervals(
            (*kept, *new.values()), max((state.next_id, *(k + 1 for k in new)))
        )


@dataclass(frozen=True)
class Track(Command):
    """Set the joints that QuaMo tracks after the twist correction, or None to stop tracking."""

    tracking: Tracking | None

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        if self.tracking is None:
            return "Stop tracking"
        return f"Track {self.tracking.what}"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with the tracking settings. Raises ValueError if they are empty."""
        if self.tracking is not None and not self.tracking.what:
            raise ValueError("expected a joint to track")
        return replace(state, tracking=self.tracking)


def _redetected(
    state: ReviewState, chains: Iterable[str], found: Iterable[Interval]
) -> ReviewState:
    """Merge detected intervals into some chains of a state, by the rules of `Redetect`."""
    chains, found = tuple(chains), tuple(found)
    out = [j for j in state.intervals if j.interval.chain not in chains]
    next_id = state.next_id
    for chain in chains:
        own = [i.for_review for i in found if i.chain == chain]
        merged, next_id = _merged(state.of_chain(chain), own, next_id)
        out += merged
    return state.with_intervals(out, next_id=next_id)


def _merged(
    earlier: tuple[Judged, ...], found: list[Interval], next_id: int
) -> tuple[list[Judged], int]:
    partner: dict[int, int] = {}
    taken: set[int] = set()
    supported: set[int] = set()
    pairs = sorted(overlapping_interval_pairs([judged.interval for judged in earlier], found))
    for minus_common, k, n in pairs:
        if earlier[k].kept and _replaces(earlier[k].interval, found[n], -minus_common):
            supported.add(k)
            taken.add(n)
    for _, k, n in pairs:
        if not earlier[k].kept and k not in partner and n not in taken:
            partner[k] = n
            taken.add(n)
    out = []
    for k, judged in enumerate(earlier):
        if judged.kept or k in partner:
            interval = judged.interval if judged.kept else found[partner[k]]
            holds = not judged.kept or judged.by_hand or k in supported
            # Keep the objects of unchanged intervals, so that they need not be redrawn.
            same = interval is judged.interval and holds == judged.supported
            out.append(judged if same else replace(judged, interval=interval, supported=holds))
    new = [interval for n, interval in enumerate(found) if n not in taken]
    out += [Judged(new_id, interval) for new_id, interval in enumerate(new, next_id)]
    return out, next_id + len(new)


def _replaces(kept: Interval, found: Interval, common: int) -> bool:
    union = kept.frames + found.frames - common
    return common >= 0.5 * union or common >= 0.8 * found.frames
