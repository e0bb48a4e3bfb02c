"""The one observable: clip, review, cursor, selection. Views listen and hold no truth."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal

from inspector.session.clip_opener import ClipOpener
from inspector.session.keeper import Keeper, PutAside
from inspector.session.opening import Analysed, opening_notes
from inspector.session.recovery import Recovery
from twistcore.chain import Chain
from twistcore.detection import Analysis, Interval
from twistcore.detection.limb_flips import LimbFlips
from twistcore.refinement import Corrected
from twistcore.review import Command, Decide, Decision, Edit, Insert, Judged, Redetect, Review
from twistcore.review.journal import REDO, UNDO
from twistcore.review.model import resized
from twistcore.rotation import Array
from twistcore.tuning import Profile


class Show(StrEnum):
    """Which poses the 3D view shows."""

    BEFORE = "before"
    AFTER = "after"
    BOTH = "both"


class Document(QObject):
    """State of the program. Every change goes through a method here and ends in a signal."""

    opened = Signal()  # another clip, or none: everything is new
    leaving = Signal()  # the open clip is about to be replaced: what is half typed is kept now
    intervals_changed = Signal()  # the review's state: intervals, decisions or τ
    method_changed = Signal()  # another detector: other curves
    chain_changed = Signal()  # the selected chain
    interval_changed = Signal()  # the selected interval
    frame_changed = Signal(int)
    show_changed = Signal()
    hidden_changed = Signal()  # which chains are shown
    numbering_changed = Signal()  # frames are counted from another number
    message = Signal(str, bool)  # a sentence for the person; True if something went wrong
    question = Signal(str, object)  # a sentence with answers: ((text, slot), …)
    withdrawn = Signal()  # the last question is no longer one

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.data: Analysed | None = None  # what does not change while the clip is open
        self.method = ""  # the detector in use
        self.chain = ""
        self.interval_id: int | None = None
        self.frame = 0
        self.show = Show.BOTH
        self.exported: dict[Path, str] = {}  # SHA-256 of files as this program wrote them
        self.opener = ClipOpener(self.message, self.question, self)
        self.opener.analysed.connect(self.show_clip)
        self.keeper = Keeper(self.message, self)
        self.recovery = Recovery(self.keeper, self.do, self._use_review, self)
        self.recovery.question.connect(self.question)
        self.recovery.withdrawn.connect(self.withdrawn)
        self.reviewer = ""
        self.hidden: frozenset[str] = frozenset()  # chains a person does not want to see now
        self.first_frame = 0  # what a person calls the clip's first frame: 0 or 1
        self._review: Review | None = None
        self._corrected: Corrected | None = None
        self._drag = time.time_ns() // 1_000_000  # none that an earlier run has in its journal

    # -- one clip after the other ------------------------------------------------------------------

    def show_clip(self, data: Analysed, aside: PutAside | None = None) -> None:
        """Make an analysed clip the present one; aside: its review, if that was put aside."""
        self.opener.cancel()
        self.leaving.emit()
        self.recovery.end(data)
        self._hold(data, aside.kept.review if aside else data.review)
        self.frame = 0
        self.interval_id = None
        self.hidden = frozenset()
        if aside is not None:
            self.keeper.go_on(aside)
        else:
            self.keeper.begin(data)
        chains = [j.interval.chain for j in self.intervals] or [c.name for c in data.chains]
        self.chain = chains[0] if chains else ""
        self.opened.emit()
        if aside is None:
            for text, wrong in opening_notes(data, self.keeper.away, self.keeper.notes):
                self.message.emit(text, wrong)
        self.recovery.begin()

    def _hold(self, data: Analysed, review: Review) -> None:
        self.data, self._review, self.method = data, review, review.state.method
        self._corrected = Corrected(data.analysis)
        self._corrected.take(review.state.chosen(undecided=True))

    def snapshot(self, parent: QObject | None = None) -> Document:
        """A document with the same clip, review and selection, and nothing behind it on disk."""
        other = Document(parent)
        if self.data is not None:
            other._hold(self.data, Review(self.review.state))
            other.method = self.method
        other.chain, other.interval_id, other.frame = self.chain, self.interval_id, self.frame
        other.show, other.hidden, other.first_frame = self.show, self.hidden, self.first_frame
        return other

    def close_clip(self) -> None:
        """Let the clip's journal and lock go; the program is about to end."""
        self.opener.cancel()
        self.keeper.end()

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

    @property
    def interval(self) -> Judged | None:
        """The selected interval."""
        return next((j for j in self.intervals if j.id == self.interval_id), None)

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
        """Select an interval and its chain; with `jump` the playhead goes to its start."""
        judged = None if interval_id is None else self.review.state.find(interval_id)
        changed, self.interval_id = interval_id != self.interval_id, interval_id
        if judged is not None and judged.interval.chain != self.chain:
            self.chain = judged.interval.chain
            self.chain_changed.emit()
        if changed:
            self.interval_changed.emit()
        if judged is not None and jump:
            self.go_to(judged.interval.start)

    def step_interval(
        self, direction: int, *, undecided: bool = False, order: Sequence[int] = ()
    ) -> None:
        """Select the next (+1) or previous (−1) interval, round the end; order: see `decide`."""
        if self.data is None:
            return
        state = self.review.state
        found = state.neighbour(self.interval_id, direction, undecided=undecided, order=order)
        if found is not None:
            self.select_interval(found, jump=True)

    def set_first_frame(self, first: int) -> None:
        """Call the clip's first frame 0 or 1, as the person's other software does."""
        if first != self.first_frame:
            self.first_frame = first
            self.numbering_changed.emit()

    def set_hidden(self, chain: str, hidden: bool) -> None:
        """Leave a chain's intervals out of the table and the strip, or show them again."""
        self.hidden = self.hidden | {chain} if hidden else self.hidden - {chain}
        self.hidden_changed.emit()

    def set_show(self, show: Show) -> None:
        """Show before, after or both."""
        if show != self.show:
            self.show = show
            self.show_changed.emit()

    # -- the review ---------------------------------------------------------------------------

    def do(self, command: Command) -> bool:
        """Carry out a command of the review; False if that could not be."""
        if not self._may_change():
            return False
        try:
            self.review.do(command)
        except (KeyError, ValueError) as error:
            self.message.emit(f"{command.text}: {error}", True)
            return False
        self.keeper.journal.record(command, getattr(command, "drag", 0))
        self._review_changed()
        return True

    def _may_change(self) -> bool:
        if self.data is None:
            return False
        if self.opener.busy:
            self.message.emit("Another clip is being opened; nothing was changed.", False)
            return False
        if self.keeper.may_change():
            return True
        self.intervals_changed.emit()  # what a person typed or dragged is not so
        return False

    def undo(self) -> None:
        """Take the last command back."""
        if self.data and self.review.undo_text and self._may_change():
            self.review.undo()
            self.keeper.journal.record_step(UNDO)
            self._review_changed()

    def redo(self) -> None:
        """Do the last undone command again."""
        if self.data and self.review.redo_text and self._may_change():
            self.review.redo()
            self.keeper.journal.record_step(REDO)
            self._review_changed()

    def decide(
        self, decision: Decision, ids: Sequence[int] = (), order: Sequence[int] = ()
    ) -> None:
        """Judge intervals, or the selected one, then go on to the next undecided.

        order: ids as a person sees them listed; all by chain and start if none are given.
        """
        if self.data is None:
            return
        chosen = tuple(ids) or ((self.interval_id,) if self.interval_id is not None else ())
        if chosen and all(self.review.state.find(k).decision == decision for k in chosen):
            return
        if not chosen:
            self.message.emit("Select an interval first (N goes to the next).", False)
            return
        self.do(Decide(chosen, decision, self.reviewer, self.now()))
        if decision != Decision.UNDECIDED:
            self.step_interval(+1, undecided=True, order=order)

    @staticmethod
    def now() -> str:
        """The present time for a decision, ISO 8601."""
        return datetime.now(UTC).isoformat(timespec="seconds")

    def accept_undecided(self) -> bool:
        """Accept everything nobody has judged, in one step; False if that could not be."""
        ids = tuple(j.id for j in self.intervals if j.decision == Decision.UNDECIDED)
        return not ids or self.do(Decide(ids, Decision.ACCEPTED, self.reviewer, self.now()))

    def begin_drag(self) -> int:
        """A number for the commands of one drag, which are undone together."""
        self._drag += 1
        return self._drag

    def edit(self, interval_id: int, interval: Interval, drag: int = 0) -> None:
        """Give an interval other frames (kept inside the clip) or another offset."""
        start, stop = max(interval.start, 0), min(interval.stop, self.frames)
        old = self.review.state.find(interval_id).interval
        same = (start, stop) == (old.start, old.stop) and np.allclose(
            interval.offset[start - interval.start : stop - interval.start], old.offset, atol=1e-12
        )
        same = same and interval.carried == old.carried
        if start < stop and (drag or not same):
            self.do(Edit(interval_id, resized(interval, start, stop), drag))

    def insert_interval(self, frame: int, interval: Interval | None = None) -> None:
        """Add a hand-made interval and select it: the one given, or one proposed around a frame."""
        if self.data is None or not self.chain:
            return
        if interval is None:
            interval = self.data.proposed(self.chain, frame)
        number = self.review.state.next_id
        if self.do(Insert(interval)):
            self.select_interval(number)

    def set_tau(self, tau: float, chain: str = "", drag: int = 0) -> None:
        """Set τ, radians, of a chain (the selected one if none is named) and detect again."""
        if name := chain or self.chain:
            self.set_taus({name: tau}, drag)

    def set_taus(self, tau: Mapping[str, float], drag: int = 0) -> None:
        """Set τ, radians, of several chains and detect again: one step of the history."""
        if self.data and tau and self._follows_review():
            found = tuple(i for name, t in tau.items() for i in self.detector.intervals(name, t))
            self.do(Redetect(dict(tau), found, drag=drag))

    def use_profile(self, profile: Profile) -> None:
        """Detect with a profile's τ, and with its detector if it names one: one step."""
        if self.data is None or not self._may_change():
            return
        clip, method = self.data.analysis, profile.method
        own = profile.of(clip.chains_and_limbs)
        now = self.review.state.tau

        def detect() -> None:  # at the detector's own τ in chains that the profile lacks
            kept = {limb.name: now[limb.name] for limb in clip.limbs}  # no detector of chains' own
            found = clip.detect(method, tau_radians=kept | own)
            self.do(Redetect(dict(found.tau), found.intervals, method=method))

        if method in ("", self.review.state.method):
            self.set_taus(own)
        else:
            self.opener.ask(clip, method, detect)

    def use_method(self, method: str) -> None:
        """Detect with another detector, at its own τ; what a person decided stays."""
        if self.data is not None and method != self.review.state.method:
            self.use_profile(Profile({}, method))

    def _use_review(self, review: Review) -> None:
        self._review = review
        self._review_changed()

    def _review_changed(self) -> None:
        self.corrected.take(self.review.state.chosen(undecided=True))
        self._follows_review()
        if self.interval is None:
            self.select_interval(None)
        self.intervals_changed.emit()

    def _follows_review(self) -> bool:
        """Whether the detector in use is the one that the review names; if not, it will be.

        An undo may have gone back to another one: its curve belongs to its τ.
        """
        method = self.review.state.method
        if self.data is not None and self.method != method and not self.opener.busy:
            self.opener.ask(self.data.analysis, method, self._use_detector)
        return self.method == method

    def _use_detector(self) -> None:
        self.method = self.review.state.method
        self.method_changed.emit()
