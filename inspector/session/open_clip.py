"""What is open, and where in it a person is; nothing here changes a review."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal

from inspector.session.opening import Analysed
from twistcore.analysis.correction import Corrected
from twistcore.detection import Analysis, Interval, Kind
from twistcore.detection.limb_flips import LimbFlips
from twistcore.review import Decision, Judged, Review
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.rotation import Array
from twistcore.tuning.learned_confidence import LearnedConfidence


class Show(StrEnum):
    """Which poses the 3D view shows."""

    BEFORE = "before"
    AFTER = "after"
    BOTH = "both"


@dataclass(frozen=True)
class Borrowed:
    """Of a clip that a lesson or an exercise has opened, whose own folder goes with it.

    write_to: where files made of it belong; why: a sentence that says why its review is kept
    nowhere; signed: whether its decisions are somebody's all the same, as a class's are; over: it
    is open only for want of another clip, and nothing in it is to be decided any more.
    """

    write_to: Path
    why: str
    signed: bool = False
    over: bool = False


class OpenClip(QObject):
    """A clip, its review as it is, the playhead and what is selected."""

    chain_changed = Signal()  # the selected chain
    interval_changed = Signal()  # the selected interval
    frame_changed = Signal(int)
    show_changed = Signal()
    hidden_changed = Signal()  # which chains are shown
    person_changed = Signal()  # whose chains are listed, of several people
    numbering_changed = Signal()  # frames are counted from another number
    confidence_changed = Signal()  # learned confidences are shown, or the detector's own again

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.data: Analysed | None = None  # what does not change while the clip is open
        self.method = ""  # the detector in use
        self.chain = ""
        self.interval_id: int | None = None
        self.frame = 0
        self.show = Show.BOTH
        self.hidden: frozenset[str] = frozenset()  # chains a person does not want to see now
        self.person = ""  # of several people the one whose chains are listed; '': everyone
        self.order = "chain"  # in which a person goes through intervals, or "time"
        self.learned: LearnedConfidence | None = None  # in place of the detector's confidence
        self.first_frame = 0  # what a person calls the clip's first frame: 0 or 1
        self.borrowed: Borrowed | None = None
        self._review: Review | None = None
        self._corrected: Corrected | None = None

    # -- what views read ----------------------------------------------------------------------

    @property
    def review(self) -> Review:
        """The review of the open clip."""
        assert self._review is not None
        return self._review

    @property
    def detector(self) -> Analysis:
        """What the detector in use knows of the open clip, and that of flips of its limbs."""
        assert self.data is not None
        return self.data.analysis.detector(self.method)

    @property
    def intervals(self) -> tuple[Judged, ...]:
        """All intervals of the open clip, by chain and start; empty without a clip."""
        return self.review.state.intervals if self.data else ()

    def told(self, judged: Judged) -> Judged:
        """An interval as a person is told of it: with the learned confidence where that is used."""
        sure = self.sureness(judged.interval)
        if sure == judged.interval.confidence:
            return judged
        return replace(judged, interval=replace(judged.interval, confidence=sure))

    def sureness(self, interval: Interval) -> float | None:
        """The confidence that a person is told of, 0…1; None where there is none."""
        counter_twist = interval.kind == Kind.COUNTER_TWIST
        own = interval.confidence
        return self.learned(own) if self.learned is not None and counter_twist else own

    def use_learned(self, learned: LearnedConfidence | None) -> None:
        """Show learned confidences instead of the detector's own, or these again."""
        if learned != self.learned:
            self.learned = learned
            self.confidence_changed.emit()

    @property
    def interval(self) -> Judged | None:
        """The selected interval."""
        return self.found(self.interval_id)

    def found(self, interval_id: int | None) -> Judged | None:
        """The interval of an id; None where the clip that is open by now has none."""
        return next((j for j in self.intervals if j.id == interval_id), None)

    @property
    def frames(self) -> int:
        """Number of frames; 0 without a clip."""
        return self.data.motion.frames if self.data else 0

    def find_chain(self, name: str) -> Chain:
        """A chain or limb of the open clip by name; KeyError where there is none."""
        for chain in self.data.chains_and_limbs if self.data else ():
            if chain.name == name:
                return chain
        raise KeyError(name)

    @property
    def limb(self) -> LimbFlips | None:
        """What is known of the selected limb; None where a chain is selected."""
        return self.data.limb(self.chain) if self.data else None

    def offset(self, chain: str) -> Array:
        """Twist error of a chain's parent by all intervals not rejected, radians, (frames,)."""
        return self._corrected.offset(chain) if self._corrected else np.zeros(0)

    @property
    def corrected(self) -> Corrected:
        """The clip with every interval corrected that is not rejected.

        So that an undecided one can be judged by what accepting it would do.
        """
        assert self._corrected is not None
        return self._corrected

    def pose(self, frame: int, *, after: bool) -> tuple[Array, Array]:
        """Global rotations (joints, 4) and positions (joints, 3) of a frame; after: `corrected`."""
        assert self.data is not None
        if after:
            return self.corrected.pose(frame)
        return self.data.rotations[frame], self.data.positions[frame]

    # -- cursor and selection -----------------------------------------------------------------

    def go_to(self, frame: int) -> None:
        """Move the playhead; frames outside the clip become its first or last."""
        frame = max(0, min(int(frame), self.frames - 1))
        if self.data and frame != self.frame:
            self.frame = frame
            self.frame_changed.emit(frame)

    def select_chain(self, name: str) -> None:
        """Select a chain; a selected interval of another chain is let go."""
        if name == self.chain:
            return
        self.find_chain(name)
        self.chain = name
        self.chain_changed.emit()
        if (selected := self.interval) and selected.interval.chain != name:
            self.select_interval(None)

    def select_interval(self, interval_id: int | None, *, jump: bool = False) -> None:
        """Select an interval and its chain; with `jump` the playhead goes where it is seen.

        One that there is not, of the last clip or undone meanwhile, is left alone.
        """
        judged = self.found(interval_id)
        if judged is None and interval_id is not None:
            return
        changed, self.interval_id = interval_id != self.interval_id, interval_id
        if judged is not None and judged.interval.chain != self.chain:
            self.chain = judged.interval.chain
            self.chain_changed.emit()
        if changed:
            self.interval_changed.emit()
        if judged is not None and jump:
            self.go_to(judged.interval.seen_at)

    def step_interval(
        self, direction: int, *, undecided: bool = False, order: Sequence[int] = ()
    ) -> bool:
        """Select the next (+1) or previous (−1) interval, round the end; order: see `decide`.

        Where none is selected, the next from the playhead. False where there is no other.
        """
        if self.data is None:
            return False
        state, now = self.review.state, self.interval_id
        if now is None:
            found = self._from_playhead(direction, undecided, set(order))
        else:
            found = state.neighbour(now, direction, undecided=undecided, order=order)
        if found is None or found == now:
            return False
        self.select_interval(found, jump=True)
        return True

    def _from_playhead(self, direction: int, undecided: bool, listed: set[int]) -> int | None:
        """The next interval from the playhead on or before it, by time or chain; round the end."""
        state, by_time = self.review.state, self.order == "time"
        row = {name: k for k, name in enumerate(state.tau)}
        chosen = [
            j
            for j in state.intervals
            if (not listed or j.id in listed)
            and (not undecided or j.decision == Decision.UNDECIDED)
        ]

        def place(judged: Judged, frame: int) -> tuple[int, int]:
            chain = row.get(judged.interval.chain, len(row))
            return (frame, chain) if by_time else (chain, frame)

        chosen.sort(key=lambda j: place(j, j.interval.start), reverse=direction < 0)
        own = row.get(self.chain, -1)
        here = (self.frame, own) if by_time else (own, self.frame)
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

    def set_first_frame(self, first: int) -> None:
        """Call the clip's first frame 0 or 1, as the person's other software does."""
        if first != self.first_frame:
            self.first_frame = first
            self.numbering_changed.emit()

    def set_hidden(self, chain: str, hidden: bool) -> None:
        """Leave a chain's intervals out of the table and the strip, or show them again."""
        self.hidden = self.hidden | {chain} if hidden else self.hidden - {chain}
        self.hidden_changed.emit()

    def show_person(self, person: str) -> None:
        """Show the intervals of one person only, of everyone for ''; select a chain of theirs."""
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
        """The chains and limbs of the person whose are listed, or of everyone."""
        chains, others = self.data.chains_and_limbs if self.data else (), self._others()
        return tuple(chain for chain in chains if chain.name not in others)

    def _others(self) -> frozenset[str]:
        """Chains of other people than the one whose are listed."""
        chains = self.data.chains_and_limbs if self.data and self.person else ()
        return frozenset(c.name for c in chains if c.person != self.person)

    def set_show(self, show: Show) -> None:
        """Show before, after or both."""
        if show != self.show:
            self.show = show
            self.show_changed.emit()
