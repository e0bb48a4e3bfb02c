"""The document that all views observe: the clip, its review, the playhead and the selection."""

from __future__ import annotations

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from PySide6.QtCore import QObject, Signal, SignalInstance

from inspector.language import tr, translate_core_sentence
from inspector.session.clip_opener import ClipOpener
from inspector.session.failing_detector import redetect_or_give_up, unusable_detector_message
from inspector.session.keeper import Keeper, PutAside
from inspector.session.open_clip import Borrowed, OpenClip
from inspector.session.opening import Analysed, opening_notes
from inspector.session.recovery import Recovery
from inspector.session.rigs import Rigs
from twistcore.analysis.correction.corrected import Corrected
from twistcore.detection import Interval, Kind
from twistcore.detection.interval_offsets import resized_interval, same_offsets
from twistcore.errors import TwistError
from twistcore.files.ordinary import path_exists
from twistcore.formats.reading import companion_file_prefix
from twistcore.review import (
    ChangeChains,
    Command,
    Decide,
    Decision,
    Edit,
    Insert,
    Judged,
    Redetect,
    Review,
    Settle,
    Sign,
)
from twistcore.review.journal import REDO, UNDO
from twistcore.skeleton.rig import Rig
from twistcore.tuning import Profile

BLIND = tr("In an exercise, the detector is off and τ is fixed: you are the detector.")


class Document(OpenClip):
    """The state of the program: the open clip, its review, the playhead and the selection.

    Every method that changes the state emits a signal.
    """

    opened = Signal()  # the clip was opened or closed, so everything must be updated
    leaving = Signal()  # the clip is about to be replaced, so store text that is being typed
    intervals_changed = Signal()  # the review's state: intervals, decisions or τ
    method_changed = Signal()  # another detector is in use, so the curves have changed
    chains_changed = Signal()  # the set of chains has changed
    message = Signal(str, bool)  # a sentence to show; True if something went wrong
    answered = Signal(str)  # an answer about the current frame, shown until the playhead moves
    question = Signal(str, object)  # a question with its answers, ((text, slot), …)
    unsigned = Signal()  # a decision was made without a reviewer's name
    withdrawn = Signal()  # the last question is obsolete

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.exported: dict[Path, str] = {}  # SHA-256 of files that this program wrote
        self.opener = ClipOpener(self.message, self.question, self)
        self.opener.analysed.connect(self.show_clip)
        self.keeper = Keeper(self.message, self)
        self.rigs = Rigs(self.opener)
        when_ready = self.rigs.when_ready
        self.recovery = Recovery(self.keeper, self.do, self._use_review, when_ready, self)
        self.recovery.question.connect(self.question)
        self.recovery.withdrawn.connect(self.withdrawn)
        self.reviewer = ""
        # Decisions made in this run without a reviewer's name, as (interval id, time).
        self._unsigned: set[tuple[int, str]] = set()
        self._drag = secrets.randbits(52)  # unlike any number in an earlier journal
        self.interval_changed.connect(self._preview_selected)

    # -- opening clips -----------------------------------------------------------------------------

    def show_clip(
        self, data: Analysed, aside: PutAside | None = None, *, borrowed: Borrowed | None = None
    ) -> None:
        """Show an analysed clip.

        Parameters
        ----------
        data
            The clip with its analysis and review.
        aside
            An earlier review of this clip to continue, as returned by `Keeper.put_aside`; None to
            use the review in `data`.
        borrowed
            Facts about a clip that a lesson or an exercise has opened; None for the user's own
            clip.
        """
        self.opener.cancel()
        self.leaving.emit()
        self.recovery.end(data)
        self._hold(data, aside.kept.review if aside else data.review)
        self.borrowed = borrowed
        self.learned = None  # another clip may have another rig
        self.frame = 0
        self.interval_id = None
        self.hidden, self.person = frozenset(), ""
        self._unsigned.clear()
        if aside is not None:
            self.keeper.resume(aside)
        else:
            self.keeper.begin(data)
        chains = [j.interval.chain for j in self.intervals] or [c.name for c in data.chains]
        self.chain = chains[0] if chains else ""
        self.opened.emit()
        if aside is None:
            for text, wrong in opening_notes(data, self.keeper.away, self.keeper.notes):
                self.message.emit(text, wrong)
        self.recovery.begin()

    @property
    def folder(self) -> Path:
        """Return the default folder for files made from the clip."""
        if self.borrowed is not None:
            return self.borrowed.write_to
        return self.data.clip.path.parent if self.data is not None else Path()

    def proposed(self, ending: str, *, own: bool = False) -> Path:
        """Return a path to propose for a file made from the clip.

        For a clip of a lesson or an exercise, no file exists at this path yet.

        Parameters
        ----------
        ending
            The end of the file name.
        own
            If True, return a path that a clip of the same name in a different format does not
            share.
        """
        clip = self.data.clip.path if self.data is not None else Path("clip")
        stem = companion_file_prefix(clip) if own else clip.stem
        path, k = self.folder / f"{stem}{ending}", 2
        while self.borrowed is not None and path_exists(path):
            path, k = self.folder / f"{stem}_{k}{ending}", k + 1
        return path

    def _hold(self, data: Analysed, review: Review) -> None:
        self.data, self._review = data, review
        self.method = data.analysis.usable(review.state.method)
        self.rigs.begin(data)
        self._corrected = Corrected(data.analysis)
        self._corrected.take(self._previewed())

    def snapshot(self, parent: QObject | None = None) -> Document:
        """Return a copy with the same clip, review and selection.

        The copy never writes a session or a journal.
        """
        other = Document(parent)
        if self.data is not None:
            other._hold(self.data, Review(self.review.state))
            other.method = self.method
        other.chain, other.interval_id, other.frame = self.chain, self.interval_id, self.frame
        other.show, other.hidden, other.first_frame = self.show, self.hidden, self.first_frame
        other.person = self.person
        return other

    def close_clip(self) -> None:
        """Stop reviewing the clip: close the journal and release the lock on the review."""
        self.opener.cancel()
        self.keeper.end()

    # -- the review ---------------------------------------------------------------------------

    def do(self, command: Command) -> bool:
        """Apply a command to the review and write it to the journal. Return False on failure."""
        if not self._may_change():
            return False
        try:
            self.review.do(command)
        except (KeyError, ValueError) as error:
            self.message.emit(
                f"{translate_core_sentence(command.text)}: {translate_core_sentence(str(error))}",
                True,
            )
            return False
        self.keeper.journal.record(command, getattr(command, "drag", 0))
        self._review_changed()
        return True

    def _may_change(self) -> bool:
        if self.data is None:
            return False
        if self.opener.busy:
            message = tr("Nothing was changed, because another clip is being opened.")
            self.message.emit(message, False)
            return False
        if self.borrowed is not None and self.borrowed.over:
            self.message.emit(self.borrowed.why, False)
        elif self.keeper.may_change():
            return True
        self.intervals_changed.emit()  # views must discard unfinished typing and dragging
        return False

    def undo(self) -> None:
        """Undo the last command."""
        if self.data and self.review.undo_text and self._may_change():
            self.rigs.when_ready(self.review.state_before_last, self._undo)

    def _undo(self) -> None:
        self.review.undo()
        self.keeper.journal.record_step(UNDO)
        self._review_changed()
        self.sign(self.reviewer)  # for decisions undone when the name was entered

    def redo(self) -> None:
        """Redo the last undone command."""
        if self.data and self.review.redo_text and self._may_change():
            self.rigs.when_ready(self.review.state_after_next, self._redo)

    def _redo(self) -> None:
        self.review.redo()
        self.keeper.journal.record_step(REDO)
        self._review_changed()
        self.sign(self.reviewer)  # for decisions undone when the name was entered

    def decide(
        self,
        decision: Decision,
        ids: Sequence[int] = (),
        order: Sequence[int] = (),
        reason: str = "",
    ) -> bool:
        """Apply a decision to intervals and select the next undecided interval.

        Only intervals that `is_changed_by` names are changed: another reviewer's same decision
        keeps the name of that reviewer. Returns False on failure.

        Parameters
        ----------
        decision
            The decision.
        ids
            The ids of the intervals to decide on; the selected interval by default.
        order
            The ids of all intervals in the order of the list; sorted by chain and start by default.
        reason
            The reason for a rejection, or '' to keep the reasons. A rejection and its reason are
            one step.

        Raises
        ------
        ValueError
            If there is a reason, but the decision is not a rejection.
        """
        if reason and decision != Decision.REJECTED:
            raise ValueError("a reason is only for a rejection")
        if self.data is None:
            return False
        chosen = tuple(ids) or ((self.interval_id,) if self.interval_id is not None else ())
        # Exclude ids that belonged to the previous clip
        there = [j for j in map(self.found, chosen) if j is not None]
        if not there:
            self.message.emit(tr("Select an interval first. Press N to go to the next one."), False)
            return False
        changed = tuple(j.id for j in there if self.is_changed_by(j, decision, reason))
        if changed and not self._decide(changed, decision, reason=reason):
            return False
        if decision != Decision.UNDECIDED:
            self.step_interval(+1, undecided=True, order=order)
        return True

    @staticmethod
    def is_changed_by(judged: Judged, decision: Decision, reason: str = "") -> bool:
        """Return True if an interval lacks a person's own decision or its reason.

        An interval that was decided in bulk, or whose correction was applied automatically, has no
        decision of a person yet.
        """
        same = judged.decision == decision and reason in ("", judged.reason)
        by_person = decision == Decision.UNDECIDED or judged.decided_at or judged.reviewer
        return not same or judged.in_bulk or not by_person

    def _decide(
        self,
        ids: tuple[int, ...],
        decision: Decision,
        *,
        in_bulk: bool = False,
        reason: str = "",
    ) -> bool:
        at = self.now()
        command = Decide(ids, decision, self.reviewer, at, in_bulk, reason)
        return self.do(command) if decision == Decision.UNDECIDED else self._do_signed(command, at)

    def settle(self, judged: Judged) -> bool:
        """Store an interval and its decision in the review, signed with the reviewer's name.

        The interval may already be in the review. An interval from another review must have an id
        that is not in use yet. Returns False on failure.
        """
        at = self.now()
        mine = replace(judged, reviewer=self.reviewer, decided_at=at, in_bulk=False)
        return self._do_signed(Settle((mine,)), at)

    def _do_signed(self, command: Command, at: str) -> bool:
        """Apply a command that decides on intervals, and return True if that succeeded.

        If the reviewer's name is needed but not known, emit `unsigned`.
        """
        done = self.do(command)
        nobodys = self.borrowed is not None and not self.borrowed.signed
        if done and not (self.reviewer or nobodys):
            self._unsigned.update((k, at) for k in command.interval_ids)
            self.unsigned.emit()
        return done

    def sign(self, reviewer: str) -> None:
        """Set the reviewer's name.

        The name is also added to unsigned decisions made since the clip was opened.
        """
        self.reviewer = reviewer
        mine = (j for j in self.intervals if (j.id, j.decided_at) in self._unsigned)
        ids = tuple(j.id for j in mine if not j.reviewer)
        if reviewer and ids:
            self.do(Sign(ids, reviewer))

    @staticmethod
    def now() -> str:
        """Return the current UTC time in ISO 8601 format."""
        return datetime.now(UTC).isoformat(timespec="seconds")

    def automatic_ids(
        self, at_least: float | None = None, *, include_open: bool = False
    ) -> tuple[int, ...]:
        """Return the ids of undecided intervals with a displayed confidence of at least `at_least`.

        Without `at_least`, return the intervals that the program may correct automatically. Edited
        intervals are excluded because they have no confidence. Open intervals, with an uncertain
        side or joint, are returned only if `include_open` is True.
        """
        edited = {judged.id for judged in self.intervals if judged.edited}
        if at_least is None:
            found = self.review.state.automatic_ids(include_open=include_open)
        else:
            found = self.review.state.automatic_ids(
                at_least, include_open=include_open, confidence=self.sureness
            )
        return tuple(k for k in found if k not in edited)

    def accept_undecided(self, at_least: float | None = None) -> bool:
        """Accept undecided intervals of high confidence in one step. Returns False on failure.

        If `at_least` is given, it is the minimum confidence that the reviewer has chosen, and the
        decisions are recorded as the reviewer's. If not, the detector's limit for automatic
        corrections is used, and the decisions are recorded as automatic.
        """
        ids = self.automatic_ids(at_least)
        if at_least is None:
            return not ids or self.do(Decide(ids, Decision.ACCEPTED))
        return not ids or self._decide(ids, Decision.ACCEPTED, in_bulk=True)

    def begin_drag(self) -> int:
        """Return a new number that identifies a mouse drag.

        All commands with the same drag number are undone in one step.
        """
        self._drag += 1
        return self._drag

    def edit(self, interval_id: int, interval: Interval, drag: int = 0) -> None:
        """Change the frames or the offset of an interval, limited to the frames of the clip.

        `drag` is a number from `begin_drag` if the change is part of a drag.
        """
        start, stop = max(interval.start, 0), min(interval.stop, self.frames)
        if (there := self.found(interval_id)) is None or start >= stop:
            return  # the interval belongs to the previous clip or was undone
        new = resized_interval(interval, start, stop)
        if drag or not same_offsets(new, there.interval):
            self.do(Edit(interval_id, new, drag))

    def insert_interval(self, frame: int, interval: Interval | None = None) -> None:
        """Add an interval by hand and select it.

        Without `interval`, the program proposes an interval at the frame. If a lone jump or a joint
        jump is selected at the frame, the proposal begins or ends at the jump. If no correction
        fits the jump, only a message is shown. If an interval of the same kind already has the same
        frames, it is selected and nothing is added, because the two offsets would add up.
        """
        if self.data is None or not self.chain:
            return
        if interval is None:
            interval = self._proposed(frame)
        if interval is None:
            return
        if (there := self.review.state.same_frames(interval)) is not None:
            first, last = (t + self.first_frame for t in (interval.start, interval.stop))
            message = tr(
                "There is already an interval at frames {first}–{last}. It is now selected.",
                first=first,
                last=last,
            )
            if last == first + 1:
                message = tr(
                    "There is already an interval at frame {first}. It is now selected.",
                    first=first,
                )
            self.select_interval(there.id)
            self.message.emit(message, False)
            return
        number = self.review.state.next_id
        if self.do(Insert(interval)):
            self.select_interval(number)

    def _proposed(self, frame: int) -> Interval | None:
        """Return an interval proposed at a frame.

        If no correction fits the selected jump, show a message and return None.
        """
        assert self.data is not None
        selected = self.interval.interval if self.interval else None
        if selected is None or selected.kind not in (Kind.LONE_JUMP, Kind.JOINT_JUMP):
            return self.data.proposed(self.chain, frame)
        if not selected.start <= frame < selected.stop:
            return self.data.proposed(self.chain, frame)
        every = (j.interval for j in self.intervals)
        proposed = self.data.proposed_at(selected, every, self.method)
        if proposed is None:
            message = tr(
                "No correction fits this jump: {joint} neither turns back soon nor stays rotated "
                "about its own bone. Correct the jump in your animation software.",
                joint=selected.joint,
            )
            self.message.emit(message, False)
        return proposed

    def set_tau(self, tau: float, chain: str = "", drag: int = 0) -> None:
        """Set a chain's threshold τ in radians, and detect again.

        By default, the threshold of the selected chain is set.
        """
        if name := chain or self.chain:
            self.set_taus({name: tau}, drag)

    def set_taus(self, tau: Mapping[str, float], drag: int = 0) -> None:
        """Set the thresholds τ (radians) of several chains, keyed by chain name, and detect again.

        The change is one step that can be undone.
        """
        if not (self.data and tau and self._may_detect()):
            return
        if why := unusable_detector_message(self.data.analysis, self.review.state.method):
            self.message.emit(why, False)
        elif self._follows_review():
            try:
                found = tuple(i for n, t in tau.items() for i in self.detector.intervals(n, t))
            except TwistError as error:  # a detector by another author may fail
                self.message.emit(translate_core_sentence(error), True)
            else:
                what = ""
                if len(tau) == 1:
                    label = translate_core_sentence(self.find_chain(next(iter(tau))).label)
                    what = tr("Set τ of {chain}", chain=label)
                self.do(Redetect(dict(tau), found, drag=drag, what=what))

    def change_chains(self, rig: Rig, what: str, message: str = "") -> None:
        """Analyse the clip with a different set of chains and use those chains, in one undo step.

        Parameters
        ----------
        rig
            The rig that defines the chains.
        what
            The name of the step in the undo history.
        message
            A sentence to show after the switch.
        """

        def change(command: ChangeChains) -> None:
            if self.do(command) and message:
                self.message.emit(message, False)

        if self.data and rig != self.review.state.rig and self._may_change():
            self.rigs.change(self.review.state, rig, what, change)

    def use_profile(self, profile: Profile) -> None:
        """Detect again with a profile's τ and, if the profile has one, its detector.

        The change is one step that can be undone.
        """
        if self.data is None or not self._may_change() or not self._may_detect():
            return
        clip, method = self.data.analysis, profile.method
        own = profile.of(clip.chains_and_limbs)
        now = self.review.state.tau

        def detect() -> None:  # chains without a τ in the profile get the detector's automatic τ
            kept = {
                limb.name: now[limb.name] for limb in clip.limbs
            }  # limbs have their own detector
            found = clip.detect(method, tau_radians=kept | own)
            self.do(Redetect(dict(found.tau), found.intervals, method=method))

        if method in ("", self.review.state.method):
            self.set_taus(own)
        else:
            self.opener.ask(clip, method, detect)

    def use_method(self, method: str) -> None:
        """Switch to a different detector and its automatic τ. All decisions stay the same."""
        if self.data is not None and method != self.review.state.method:
            self.use_profile(Profile({}, method))

    def _may_detect(self) -> bool:
        """Return True if detection is allowed.

        In an exercise, show a message and return False, because detection would reveal the hidden
        errors.
        """
        if self.data is not None and self.data.blind:
            self.message.emit(BLIND, False)
            return False
        return True

    def _use_review(self, review: Review) -> None:
        if (analysis := self.rigs.known(review.state.rig)) is not None:
            review.take_reasons(redetect_or_give_up(analysis, review.state))
        self._review = review
        self._review_changed()

    def _review_changed(self) -> None:
        others = self._take_chains()
        self.corrected.take(self._previewed())
        for signal in others:
            signal.emit()
        self._follows_review()
        if self.interval is None:
            self.select_interval(None)
        self.intervals_changed.emit()

    def _preview_selected(self) -> None:
        """Preview the correction of the selected interval rather than an alternative to it."""
        if self.data is not None and self.corrected.take(self._previewed()):
            self.intervals_changed.emit()

    def _take_chains(self) -> Sequence[SignalInstance]:
        """If the review's chains differ from the current chains, use the analysis with its chains.

        Returns the signals that must be emitted after the change.
        """
        state, data = self.review.state, self.data
        if data is None or data.analysis.rig == state.rig:
            return ()
        self.data = replace(data, analysis=self.rigs.take(state.rig))
        self._corrected = Corrected(self.data.analysis)
        self.method = self.data.analysis.usable(state.method)
        names, before = ([c.name for c in d.chains_and_limbs] for d in (self.data, data))
        self.hidden = self.hidden & frozenset(names) | self._others()
        new = [name for name in names if name not in before]
        if len(new) == 1 or self.chain not in names:
            self.chain = (*new, *names, "")[0]
        return self.chains_changed, self.chain_changed

    def _follows_review(self) -> bool:
        """Return True if the review's detector is in use. If not, start analysing the clip with it.

        The review's detector changes, for example, if an undo restores an earlier choice.
        """
        if self.data is not None:
            method = self.data.analysis.usable(self.review.state.method)
            if self.method != method and not self.opener.busy:
                self.opener.ask(self.data.analysis, method, self._use_detector)
        return self.method == self.review.state.method

    def _use_detector(self) -> None:
        if self.data is not None:
            self.method = self.data.analysis.usable(self.review.state.method)
        self.method_changed.emit()
