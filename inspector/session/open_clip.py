"""The open clip, the playhead and the selection, without methods that change a review."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
from PySide6.QtCore import QObject, Signal

from inspector.session.opening import Analysed
from twistcore.analysis.clip_severity import severity_of_intervals
from twistcore.analysis.correction.corrected import Corrected
from twistcore.analysis.error_groups import drop_weaker_correction_alternatives
from twistcore.detection import Analysis, Interval, Kind
from twistcore.detection.limb_flips import LimbFlips
from twistcore.review import Decision, Judged, Review
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array
from twistcore.tuning.learned_confidence import LearnedConfidence


class Show(StrEnum):
    """The poses to show in the 3D view: before the correction, after it, or both."""

    BEFORE = "before"
    AFTER = "after"
    BOTH = "both"


@dataclass(frozen=True)
class Borrowed:
    """Facts about a clip that a lesson or an exercise has opened in a temporary folder.

    Attributes
    ----------
    write_to
        The folder for files made from the clip.
    why
        A sentence with the reason why its review is not saved.
    signed
        True if decisions carry the reviewer's name, as in a class exercise.
    over
        True if the lesson has ended and the clip is open only for viewing.
    """

    write_to: Path
    why: str
    signed: bool = False
    over: bool = False


class OpenClip(QObject):
    """A clip, its review, the playhead and the selection."""

    chain_changed = Signal()  # another chain is selected
    interval_changed = Signal()  # another interval is selected
    frame_changed = Signal(int)
    show_changed = Signal()
    hidden_changed = Signal()  # the set of hidden chains
    person_changed = Signal()  # the intervals of another person are listed
    numbering_changed = Signal()  # frames are counted from 0 or from 1
    order_changed = Signal()
    tracked_changed = Signal()  # another tracked motion is shown, or none
    confidence_changed = Signal()  # learned confidences are switched on or off

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.data: Analysed | None = None  # does not change while the clip is open
        self.method = ""  # the detector in use
        self.tracked: Motion | None = None  # the corrected clip after tracking, if it is shown
        self.chain = ""
        self.interval_id: int | None = None
        self.frame = 0
        self.show = Show.BOTH
        self.hidden: frozenset[str] = frozenset()  # chains that the person has hidden
        self.person = ""  # the person whose chains are listed, '' for everyone
        self.order = "chain"  # the order in which intervals are visited: "worst", "chain" or "time"
        self.learned: LearnedConfidence | None = None  # shown instead of the detector's confidence
        self.first_frame = 0  # the number of the first frame, 0 or 1
        self.borrowed: Borrowed | None = None
        self._review: Review | None = None
        self._corrected: Corrected | None = None
        # Intervals mostly stay the same while τ is dragged, and computing a severity takes 0.1 ms.
        self._severities = WeakKeyDictionary[Interval, float]()

    # -- what views read ----------------------------------------------------------------------

    @property
    def review(self) -> Review:
        """The review of the open clip."""
        assert self._review is not None
        return self._review

    @property
    def detector(self) -> Analysis:
        """Return the analysis of the open clip by the current detector, including limb flips."""
        assert self.data is not None
        return self.data.analysis.detector(self.method)

    @property
    def intervals(self) -> tuple[Judged, ...]:
        """Return all intervals of the open clip, sorted by chain and start; () if none is open."""
        return self.review.state.intervals if self.data else ()

    def displayed(self, judged: Judged) -> Judged:
        """Return an interval with the confidence that the views display.

        If learned confidences are switched on, this is the learned one. An edited interval has no
        confidence, because the detector computed it for the values before the edit.
        """
        sure = None if judged.edited else self.sureness(judged.interval)
        if sure == judged.interval.confidence:
            return judged
        return replace(judged, interval=replace(judged.interval, confidence=sure))

    def sureness(self, interval: Interval) -> float | None:
        """Return the displayed confidence of an interval, 0…1, or None if it has none."""
        counter_twist = interval.kind == Kind.COUNTER_TWIST
        own = interval.confidence
        return self.learned(own) if self.learned is not None and counter_twist else own

    def severity(self, judged: Judged) -> float:
        """Return the clip's severity, in degrees, if this interval were its only error."""
        interval = judged.interval
        if interval not in self._severities:
            assert self.data is not None
            motion, chain = self.data.motion, self.find_chain(interval.chain)
            severity = severity_of_intervals([(interval, chain)], motion.frames, motion.fps)
            self._severities[interval] = severity
        return self._severities[interval]

    def use_learned(self, learned: LearnedConfidence | None) -> None:
        """Show learned confidences or, if `learned` is None, the detector's confidences."""
        if learned != self.learned:
            self.learned = learned
            self.confidence_changed.emit()

    @property
    def interval(self) -> Judged | None:
        """The selected interval, or None."""
        return self.found(self.interval_id)

    def found(self, interval_id: int | None) -> Judged | None:
        """Return the interval with this id, or None if the open clip has no such interval."""
        return next((j for j in self.intervals if j.id == interval_id), None)

    @property
    def frames(self) -> int:
        """The number of frames of the open clip, or 0 if no clip is open."""
        return self.data.motion.frames if self.data else 0

    def find_chain(self, name: str) -> Chain:
        """Return the chain or limb of the open clip with this name.

        Raises KeyError if there is none.
        """
        for chain in self.data.chains_and_limbs if self.data else ():
            if chain.name == name:
                return chain
        raise KeyError(name)

    @property
    def limb(self) -> LimbFlips | None:
        """The flips of the selected limb, or None if a chain is selected."""
        return self.data.limb(self.chain) if self.data else None

    def offset(self, chain: str) -> Array:
        """Return the sum of a chain's offsets in each frame, in radians, (frames,).

        Rejected intervals are excluded.
        """
        return self._corrected.offset(chain) if self._corrected else np.zeros(0)

    @property
    def corrected(self) -> Corrected:
        """Return the clip with all intervals corrected, except rejected ones.

        Undecided intervals are included, to show the effect of accepting them.
        """
        assert self._corrected is not None
        return self._corrected

    def _previewed(self) -> tuple[Interval, ...]:
        """Return the intervals to preview as corrected: all except the rejected ones.

        Of several alternative corrections of the same frames, only the accepted, the selected or
        the most confident one is returned.
        """
        assert self.data is not None
        state, chains = self.review.state, self.data.chains_and_limbs
        first = [
            j.interval
            for j in state.intervals
            if j.decision == Decision.ACCEPTED or j.id == self.interval_id
        ]
        skeleton = self.data.motion.skeleton
        return drop_weaker_correction_alternatives(
            state.chosen(undecided=True), chains, skeleton, chosen=first
        )

    @property
    def suggested_chains(self) -> frozenset[str]:
        """Return the names of chains with an undecided correction at the current frame.

        Chains that also have an accepted, selected or hand-made interval at this frame are
        excluded.
        """
        here = [
            judged
            for judged in self.intervals
            if judged.interval.start <= self.frame < judged.interval.stop
            and judged.interval.repairable
        ]
        meant = {
            judged.interval.chain
            for judged in here
            if judged.decision == Decision.ACCEPTED
            or judged.id == self.interval_id
            or judged.by_hand
        }
        undecided = (j for j in here if j.decision == Decision.UNDECIDED)
        return frozenset(j.interval.chain for j in undecided) - meant

    def pose(self, frame: int, *, after: bool) -> tuple[Array, Array]:
        """Return the global rotations (joints, 4) and positions (joints, 3) of a frame.

        If `after` is True, return the pose in the corrected clip.
        """
        assert self.data is not None
        if after:
            return self.corrected.pose(frame)
        return self.data.rotations[frame], self.data.positions[frame]

    # -- cursor and selection -----------------------------------------------------------------

    def go_to(self, frame: int) -> None:
        """Move the playhead to a frame, limited to the frames of the clip."""
        frame = max(0, min(int(frame), self.frames - 1))
        if self.data and frame != self.frame:
            self.frame = frame
            self.frame_changed.emit(frame)

    def select_chain(self, name: str) -> None:
        """Select a chain. If the selected interval belongs to another chain, deselect it."""
        if name == self.chain:
            return
        self.find_chain(name)
        self.chain = name
        self.chain_changed.emit()
        if (selected := self.interval) and not self.is_of_chain(selected.interval):
            self.select_interval(None)

    def select_interval(self, interval_id: int | None, *, jump: bool = False) -> None:
        """Select an interval and its chain. None deselects the interval.

        An error of the whole body belongs to every chain of its person, so the chain stays
        selected. If `jump` is True, also move the playhead to the interval. An id that no longer
        exists is ignored.
        """
        judged = self.found(interval_id)
        if judged is None and interval_id is not None:
            return
        changed, self.interval_id = interval_id != self.interval_id, interval_id
        if judged is not None and not self.is_of_chain(judged.interval):
            self.chain = judged.interval.chain
            self.chain_changed.emit()
        if changed:
            self.interval_changed.emit()
        if judged is not None and jump:
            self.go_to(judged.interval.seen_at)

    def step_interval(
        self, direction: int, *, undecided: bool = False, order: Sequence[int] = ()
    ) -> bool:
        """Select the next (+1) or previous (−1) interval, and wrap around at the end of the list.

        If no interval is selected, start at the playhead or, if the list is sorted by severity, at
        the beginning or end of the list. Returns False if there is no other interval.

        Parameters
        ----------
        undecided
            True to skip intervals with a decision.
        order
            The ids of the intervals in the order of the list.
        """
        if self.data is None:
            return False
        state, now = self.review.state, self.interval_id
        if now is None and not (order and self.order == "worst"):
            found = self._from_playhead(direction, undecided, set(order))
        else:
            found = state.neighbour(now, direction, undecided=undecided, order=order)
        if found is None or found == now:
            return False
        self.select_interval(found, jump=True)
        return True

    def _from_playhead(self, direction: int, undecided: bool, listed: set[int]) -> int | None:
        """Return the id of the next (+1) or previous (−1) interval, starting from the playhead.

        Intervals are ordered by time or by chain. In the order by chain, errors of the whole body
        precede the chains, as in the table. The search wraps around at the end.
        """
        state, by_time = self.review.state, self.order == "time"
        row = {name: k for k, name in enumerate(state.tau)}
        chosen = [
            j
            for j in state.intervals
            if (not listed or j.id in listed)
            and (not undecided or j.decision == Decision.UNDECIDED)
        ]

        own = row.get(self.chain, -1)

        def place(judged: Judged, frame: int) -> tuple[int, int]:
            of_body = judged.interval.kind.info.whole_body
            chain = row.get(judged.interval.chain, len(row))
            if by_time:
                return frame, own if of_body else chain
            return -1 if of_body else chain, frame

        chosen.sort(key=lambda j: place(j, j.interval.start), reverse=direction < 0)
        here = (self.frame, own) if by_time else (own, self.frame)
        of_chains = (j for j in chosen if not j.interval.kind.info.whole_body)
        if (
            direction > 0
            and not by_time
            and all(place(j, j.interval.start) >= here for j in of_chains)
        ):
            here = (-1, self.frame)  # the playhead is at the beginning of the list
        ahead = (
            j.id
            for j in chosen
            if (
                (place(j, j.interval.stop - 1) >= here)
                if direction > 0
                else (place(j, j.interval.start) < here)
            )
        )
        return next(ahead, chosen[0].id if chosen else None)

    def set_order(self, order: str) -> None:
        """Set the order in which intervals are visited: 'worst', 'time' or 'chain'."""
        if order != self.order:
            self.order = order
            self.order_changed.emit()

    def set_first_frame(self, first: int) -> None:
        """Set the number of the clip's first frame, 0 or 1."""
        if first != self.first_frame:
            self.first_frame = first
            self.numbering_changed.emit()

    def set_hidden(self, chain: str, hidden: bool) -> None:
        """Hide a chain's intervals in the table and the overview, or show them."""
        self.hidden = self.hidden | {chain} if hidden else self.hidden - {chain}
        self.hidden_changed.emit()

    def hides(self, interval: Interval) -> bool:
        """Return True if an interval is hidden with its chain.

        An error of the whole body is hidden only with all chains of its person.
        """
        if not (self.hidden and interval.kind.info.whole_body):
            return interval.chain in self.hidden
        assert self.data is not None
        person, chains = self.find_chain(interval.chain).person, self.data.chains_and_limbs
        return all(chain.name in self.hidden for chain in chains if chain.person == person)

    def is_of_chain(self, interval: Interval) -> bool:
        """Return True if an interval is an error of the selected chain.

        An error of the whole body is an error of every chain of its person.
        """
        if not (self.chain and interval.kind.info.whole_body):
            return interval.chain == self.chain
        own, selected = (self.find_chain(name) for name in (interval.chain, self.chain))
        return own.person == selected.person

    def show_person(self, person: str) -> None:
        """List only one person's intervals and select one of that person's chains.

        '' lists the intervals of everyone.
        """
        self.person = person
        self.hidden = self._others()
        self.hidden_changed.emit()
        own = [c.name for c in self.listed_chains]
        if own and self.chain not in own:
            found = (j.interval.chain for j in self.intervals if j.interval.chain in own)
            self.select_chain(next(found, own[0]))
        self.person_changed.emit()

    @property
    def listed_chains(self) -> tuple[Chain, ...]:
        """Return the chains and limbs of the listed person, or of everyone if all are listed."""
        chains, others = self.data.chains_and_limbs if self.data else (), self._others()
        return tuple(chain for chain in chains if chain.name not in others)

    def _others(self) -> frozenset[str]:
        """Return the names of all chains of people who are not listed."""
        chains = self.data.chains_and_limbs if self.data and self.person else ()
        return frozenset(c.name for c in chains if c.person != self.person)

    def show_tracked(self, motion: Motion | None) -> None:
        """Show the tracked (filtered) motion next to the corrected clip; None hides it."""
        if motion is not self.tracked:
            self.tracked = motion
            self.tracked_changed.emit()

    def set_show(self, show: Show) -> None:
        """Set the poses to show in the 3D view: before, after or both."""
        if show != self.show:
            self.show = show
            self.show_changed.emit()
