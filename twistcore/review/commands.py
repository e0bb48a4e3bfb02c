"""The commands of a review as immutable objects. Each command turns one state into the next."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from twistcore.detection import Interval
from twistcore.review.model import (
    Decision,
    Judged,
    ReviewState,
    Tracking,
    as_written,
    carried_over,
    chain_places,
)
from twistcore.review.overlaps import overlaps
from twistcore.skeleton.rig import Rig
from twistcore.work.frozen import dataclass


class Command(ABC):
    """A change of a review, with a name for the undo menu.

    If `apply` raises an exception, the review is unchanged.
    """

    @property
    @abstractmethod
    def text(self) -> str:
        """Name of the command in the undo menu."""

    @abstractmethod
    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The ids of the intervals that the command names, or an empty tuple."""
        return ()

    def continues(self, earlier: Command) -> bool:
        """True if this command is the next step of the same drag, so that one undo reverts both."""
        del earlier
        return False


@dataclass(frozen=True)
class Decide(Command):
    """Set the verdict on intervals.

    `in_bulk` is True if all confident intervals were decided together, without viewing each one.
    """

    ids: tuple[int, ...]
    decision: Decision
    reviewer: str = ""
    decided_at: str = ""
    in_bulk: bool = False

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        n = len(self.ids)
        one, many = {
            Decision.ACCEPTED: ("Accept interval", f"Accept {n} intervals"),
            Decision.REJECTED: ("Reject interval", f"Reject {n} intervals"),
            Decision.UNDECIDED: ("Reset interval", f"Reset {n} intervals"),
        }[self.decision]
        return one if n == 1 else many

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The ids of the intervals."""
        return self.ids

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        undecided = self.decision == Decision.UNDECIDED
        by, at = ("", "") if undecided else (self.reviewer, self.decided_at)
        bulk = self.in_bulk and not undecided
        verdict = {"decision": self.decision, "reviewer": by, "decided_at": at, "in_bulk": bulk}
        return _replace(state, self.ids, **verdict)


@dataclass(frozen=True)
class Sign(Command):
    """Add a reviewer's name to decisions that were made without one.

    Adding a name is not a step of the history: `Review` adds it to the same decisions in every
    state. So an undo reverts the last decision, and the other decisions stay signed.
    """

    ids: tuple[int, ...]
    reviewer: str

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        return "Sign decision" if len(self.ids) == 1 else f"Sign {len(self.ids)} decisions"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        return self.signing(state)(state)

    def signing(self, now: ReviewState) -> Callable[[ReviewState], ReviewState]:
        """Return a function that adds the name, in any state, to decisions without one in `now`.

        Repeated calls with the same state return the same new state. A state without such a
        decision is returned unchanged. Raises KeyError if `now` does not have one of the intervals.
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
                signed = _replace(state, ids, reviewer=self.reviewer) if ids else state
                states[state] = signed
            return states[state]

        return sign


@dataclass(frozen=True, eq=False)
class Edit(Command):
    """Change the frames or the offset of an interval.

    Edits with equal `drag` numbers belong to one drag of the mouse.
    """

    id: int
    interval: Interval
    drag: int = 0

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        return f"Edit interval {self.id}"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The id of the interval."""
        return (self.id,)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        old = state.find(self.id)
        if self.interval.start < 0 or self.interval.stop <= self.interval.start:
            raise ValueError("an interval must have at least one frame")
        if self.interval.chain != old.interval.chain:
            raise ValueError("an edit cannot move an interval to another chain")
        if not old.interval.kind.correctable:
            raise ValueError(
                "detections of this kind are not corrected; press Insert to create an interval"
            )
        return _replace(state, (self.id,), interval=as_written(self.interval), edited=True)

    def continues(self, earlier: Command) -> bool:
        """True if this edit belongs to the same drag of the same interval."""
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
        """Name of the command in the undo menu."""
        return f"Note on interval {self.id}"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The id of the interval."""
        return (self.id,)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        return _replace(state, (self.id,), note=self.note, reason=self.reason)


@dataclass(frozen=True, eq=False)
class Insert(Command):
    """Add an interval that the user made by hand."""

    interval: Interval

    text = "New interval"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        new = Judged(state.next_id, as_written(self.interval), by_hand=True)
        return state.with_intervals((*state.intervals, new), next_id=state.next_id + 1)


@dataclass(frozen=True)
class Remove(Command):
    """Remove an interval made by hand. A detected interval can only be rejected."""

    id: int

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        return f"Remove interval {self.id}"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The id of the interval."""
        return (self.id,)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        if not state.find(self.id).by_hand:
            raise ValueError("only hand-made intervals can be removed")
        return state.with_intervals(j for j in state.intervals if j.id != self.id)


@dataclass(frozen=True, eq=False)
class Redetect(Command):
    """Set a new τ (radians, keyed by chain name) and the intervals detected with it.

    An interval on which a person has decided, or which was edited, is kept. It replaces every
    detected interval that is the same (IoU of at least 0.5) or lies inside it (at least 80 %). If
    there is no such interval, it is marked as unsupported. Every other interval is replaced by a
    detected one that overlaps it, with the largest overlaps first, or removed. The remaining
    detected intervals are added.
    """

    tau: Mapping[str, float]
    found: tuple[Interval, ...]
    method: str = ""
    drag: int = 0

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        if self.method:
            return f"Detect with {self.method}"
        if len(self.tau) == 1:
            return f"Set τ of {next(iter(self.tau))}"
        return f"Set τ of {len(self.tau)} chains"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        tau = MappingProxyType({**state.tau, **self.tau})
        known = replace(state, tau=tau, method=self.method or state.method)
        return _redetected(known, self.tau, self.found)

    def continues(self, earlier: Command) -> bool:
        """True if this command belongs to the same drag of the same τ line."""
        return (
            isinstance(earlier, Redetect)
            and self.drag != 0
            and earlier.drag == self.drag
            and set(earlier.tau) == set(self.tau)
        )


@dataclass(frozen=True, eq=False)
class ChangeChains(Command):
    """Change the chains and limbs, and remove the intervals of removed chains.

    - rig: the new chains
    - tau: τ of all chains in their order, radians
    - found: intervals detected in the chains that `again` lists (new chains, and chains whose
      neighbours changed), merged by the rules of `Redetect`
    """

    rig: Rig
    tau: Mapping[str, float]
    again: tuple[str, ...]
    found: tuple[Interval, ...]
    what: str = ""

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        return self.what or "Change the chains"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        if missing := [name for name in self.again if name not in self.tau]:
            raise ValueError(f"there is no chain {missing[0]!r}")
        tau = MappingProxyType(dict(self.tau))
        kept = [
            j
            for j in state.intervals
            if (name := j.interval.chain) in tau and state.rig.own(name) == self.rig.own(name)
        ]
        state = replace(state, rig=self.rig, tau=tau, chain_order=chain_places(tau))
        return _redetected(state.with_intervals(kept), self.again, self.found)


@dataclass(frozen=True, eq=False)
class CarryOver(Command):
    """Apply the decisions of an earlier review to this review.

    `same_clip` is True if the earlier review is of the same clip, and False if it is of another
    take.
    """

    earlier: tuple[Judged, ...]
    same_clip: bool = False

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        return "Add decisions" if self.same_clip else "Carry decisions over"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        return carried_over(self.earlier, state, same_clip=self.same_clip)


@dataclass(frozen=True, eq=False)
class Settle(Command):
    """Settle differences between two reviews of the clip: set intervals with their decisions.

    An interval of `earlier` replaces the one with the same id, or is added if there is none.
    """

    earlier: tuple[Judged, ...]

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        n = len(self.earlier)
        return "Settle difference" if n == 1 else f"Settle {n} differences"

    @property
    def interval_ids(self) -> tuple[int, ...]:
        """The ids of the intervals."""
        return tuple(judged.id for judged in self.earlier)

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
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
    """Track joints with QuaMo after the twist correction. None turns tracking off."""

    tracking: Tracking | None

    @property
    def text(self) -> str:
        """Name of the command in the undo menu."""
        if self.tracking is None:
            return "Stop tracking"
        return f"Track {self.tracking.what}"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state after the command."""
        if self.tracking is not None and not self.tracking.what:
            raise ValueError("expected a joint to track")
        return replace(state, tracking=self.tracking)


def _redetected(
    state: ReviewState, chains: Iterable[str], found: Iterable[Interval]
) -> ReviewState:
    """Replace the intervals of these chains with the detected ones."""
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
    pairs = sorted(overlaps([judged.interval for judged in earlier], found))
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
            # Unchanged intervals stay the same objects, so they do not need to be redrawn.
            same = interval is judged.interval and holds == judged.supported
            out.append(judged if same else replace(judged, interval=interval, supported=holds))
    new = [interval for n, interval in enumerate(found) if n not in taken]
    out += [Judged(new_id, interval) for new_id, interval in enumerate(new, next_id)]
    return out, next_id + len(new)


def _replaces(kept: Interval, found: Interval, common: int) -> bool:
    union = kept.frames + found.frames - common
    return common >= 0.5 * union or common >= 0.8 * found.frames


def _replace(state: ReviewState, ids: tuple[int, ...], **changes: Any) -> ReviewState:
    for interval_id in ids:
        state.find(interval_id)
    wanted = set(ids)
    changed = tuple(replace(j, **changes) if j.id in wanted else j for j in state.intervals)
    if "interval" in changes:
        return state.with_intervals(changed)
    return replace(state, intervals=changed)  # already in order, which speeds up long journals
