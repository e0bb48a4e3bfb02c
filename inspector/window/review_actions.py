"""The actions for reviewing intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QInputDialog, QWidget

from inspector.language import plural, tr, translate_core_sentence
from inspector.panels.accept_confident_dialog import AcceptConfidentDialog
from inspector.panels.detail_card import DetailCard
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.panels.reason_palette import ReasonPalette
from inspector.session.document import BLIND, Document
from inspector.session.examined import one_line_summary, reason_unexamined, unexamined_sentences
from inspector.session.player import Player
from inspector.session.settings import Settings
from inspector.session.why_here import (
    reason_here,
    reason_near,
    reason_sentence,
    reasons_at_unexplained_peaks,
)
from inspector.timeline.visible_range import VisibleRange
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.signed_numbers import format_signed_number
from inspector.window.look_through import LookThrough
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.why_not import Reason, Why
from twistcore.detection import Interval
from twistcore.detection.interval_offsets import (
    resized_interval,
    with_offset_making_twist_linear,
    with_offset_replaced_by_median,
)
from twistcore.review import Decision, Judged, Remove, ReviewState


@dataclass(eq=False)
class ReviewActions:
    """The actions that decide on, edit, insert and remove intervals, and move between them.

    Attributes
    ----------
    card
        The card with details of the selected interval. If no interval is selected, the card
        explains why nothing was found at the current frame.
    show_card
        A function that brings the card to the front.
    look_through
        Shows the errors of groups before a decision applies to all of them.
    look
        A function that rotates the camera so that the roll of the selected limb is clearly visible.
    sees
        A function that returns True if the selected limb is visible.
    show_status
        A function that shows a sentence in the status bar.
    key
        A function that returns the shortcut of an action as text.
    more_clips
        A function that returns True if a folder of clips is open.
    """

    document: Document
    intervals: IntervalsPanel
    bar: MessageBar
    card: DetailCard
    look_through: LookThrough
    visible: VisibleRange
    player: Player
    settings: Settings
    show_card: Callable[[], None]
    key: Callable[[str], str]
    more_clips: Callable[[], bool]
    look: Callable[[], None]
    sees: Callable[[], bool]
    show_status: Callable[[str], None]
    window: QWidget
    _faint: Interval | None = field(default=None, init=False)
    _answer: str = field(default="", init=False)
    _announced: str = field(default="", init=False)
    # The decision and reason for which the errors of groups were last shown
    _wanted: tuple[Decision, str] | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        document = self.document
        document.set_order(self.settings.order)
        document.answered.connect(self.answer)
        for moved in (document.frame_changed, document.chain_changed, document.opened):
            moved.connect(self._withdraw)
        look_through = self.look_through
        look_through.began.connect(self._announce_look)
        look_through.showing.connect(self._show_progress)
        look_through.stopped.connect(self._stop_looking)
        look_through.done.connect(self._end_looking)
        # Wait until the playhead has moved. Rotate the camera only if the limb is not visible.
        find = QTimer(self.window, singleShot=True, interval=0)
        find.timeout.connect(lambda: None if self.sees() else self.look())
        document.interval_changed.connect(
            lambda: find.stop() if document.interval is None else find.start()
        )
        document.chains_changed.connect(find.start)
        document.opened.connect(lambda: setattr(self, "_faint", None))

    # -- decisions, and moving between intervals -------------------------------------------------

    def judge(self, decision: Decision) -> None:
        """Set the decision for the selected intervals, and select the next undecided interval.

        Unlike `decide`, this method does not move the camera.
        """
        if not self._is_looking(decision):
            ids = self.intervals.selected_ids()
            self._when_seen(decision, ids, partial(self._judge, decision, ids))

    def decide(self, decision: Decision, reason: str = "") -> None:
        """Set the decision for the selected intervals, and go to the next undecided interval.

        If the selected interval is outside the visible range of the plots, only scroll the plots to
        it, so the user sees it before deciding. `reason` is the reason for a rejection, or '' to
        keep the reasons.
        """
        ids = self.intervals.selected_ids()

        def decide() -> bool:
            before = self.document.interval_id
            done = self._judge(decision, ids, reason)
            if decision != Decision.UNDECIDED:
                self._arrive(zoom=self.document.interval_id != before)
            return done

        if not self._is_looking(decision, reason) and not self._out_of_view():
            self._when_seen(decision, ids, decide, reason)

    def _is_looking(self, decision: Decision, reason: str = "") -> bool:
        """Return True if the errors of groups are being shown before a decision.

        A different decision stops this.
        """
        if not self.look_through.running:
            return False
        # a look is running, so ignore the key
        if self._wanted != (decision, reason):
            self.look_through.stop()
        return True

    def _when_seen(
        self, decision: Decision, ids: Sequence[int], decide: Callable[[], bool], reason: str = ""
    ) -> None:
        """Call `decide` after all errors of the selected groups have been shown.

        Rows of single intervals are not shown first, because the user selected each of them.
        """
        grouped = self.intervals.ids_in_selected_groups()
        if decision == Decision.UNDECIDED or not grouped:
            decide()
            return
        self.card.commit()  # or its note would be a change of the review during the look
        self._wanted = decision, reason
        there = (judged for judged in map(self.document.found, ids) if judged is not None)
        changed = [j for j in there if self.document.is_changed_by(j, decision, reason)]
        self.look_through.begin(changed, grouped, self.settings.look_ms, decide)

    def _judge(self, decision: Decision, ids: Sequence[int], reason: str = "") -> bool:
        if self.document.data is None:
            return False
        with self.intervals.visit_order() as order:
            done = self.document.decide(decision, ids, order, reason)
        if decision != Decision.UNDECIDED and self.document.interval is not None:
            self._report_end()
        return done

    def _announce_look(self, count: int, unseen: int) -> None:
        """Show a message that some errors of groups are shown before the decision."""
        if count == unseen:
            text = plural(
                "You have not seen {n} grouped error. It is shown before the decision. "
                "Press Esc to stop.",
                "You have not seen {n} grouped errors. They are shown before the decision. "
                "Press Esc to stop.",
                count,
            )
        else:
            text = tr(
                "You have not seen {total} grouped errors. The worst {n} are shown before "
                "the decision. Press Esc to stop.",
                n=count,
                total=unseen,
            )
        self._announced = text
        self.bar.show_message(self._announced, False)

    def _show_progress(self, number: int, count: int) -> None:
        self.show_status(tr("Error {k} of {n}", k=number, n=count))
        self.show_whole()

    def _stop_looking(self, unreported: bool) -> None:
        self.show_status("")
        self.bar.withdraw(self._announced)
        if unreported:
            self.bar.show_message(
                tr("Nothing was decided, because not all grouped errors were shown."), False
            )

    def _end_looking(self, seen: int, total: int) -> None:
        self.bar.withdraw(self._announced)
        text = tr(
            "The decision applies to {total} errors. You have seen {n} of them.",
            n=seen,
            total=total,
        )
        self.show_status(text if seen < total else "")

    def undo(self) -> None:
        """Undo the last step, show its name, and go to the interval that it changed.

        While the errors of a group are shown before a decision, only stop this.
        """
        if self.document.data is not None and not self.look_through.stop():
            step = translate_core_sentence(self.document.review.undo_text)
            self._retrace(self.document.undo, tr("Undone: {step}", step=step))

    def redo(self) -> None:
        """Redo the last undone step, show its name, and go to the interval that it changed.

        While the errors of a group are shown before a decision, only stop this.
        """
        if self.document.data is not None and not self.look_through.stop():
            step = translate_core_sentence(self.document.review.redo_text)
            self._retrace(self.document.redo, tr("Redone: {step}", step=step))

    def _retrace(self, act: Callable[[], None], words: str) -> None:
        document = self.document
        before = document.review.state
        act()
        after = document.review.state
        if after is before:
            return
        self.show_status(words)
        if (before.method, before.tau) != (after.method, after.tau):
            return  # many intervals have changed, so there is none to go to
        old = {j.id: j for j in before.intervals}
        changed = [j.id for j in after.intervals if old.get(j.id) is not j]
        if not changed:
            return
        if document.interval_id not in changed:
            with self.intervals.visit_order() if len(changed) > 1 else nullcontext(()) as order:
                first = next((k for k in order if k in changed), changed[0])
                document.select_interval(first, jump=True)
            self._arrive(zoom=True)
        elif (judged := document.interval) and not self._is_in_view(judged):
            document.go_to(judged.interval.seen_at)
            self._arrive(zoom=True)

    def _is_in_view(self, judged: Judged) -> bool:
        first, last = self.visible.ends
        return judged.interval.start <= last and judged.interval.stop >= first

    def show_whole(self) -> None:
        """Zoom the plots to the selected interval if a part of it is not visible."""
        judged, (first, last) = self.document.interval, self.visible.ends
        whole = judged is None or (judged.interval.start >= first and judged.interval.stop <= last)
        if not whole and self.settings.zoom_to_interval:
            self.visible.zoom_to_interval()

    def _out_of_view(self) -> bool:
        judged = self.document.interval
        if judged is None or self.player.playing or self.intervals.has_several_selected:
            return False
        if self._is_in_view(judged):
            return False
        self.document.go_to(judged.interval.seen_at)
        self._arrive(zoom=True)
        self.bar.show_message(
            tr("Here is the selected interval again. Look at it, then decide."), False
        )
        return True

    def step_interval(self, direction: int) -> None:
        """Go to the next undecided interval (+1) or to the previous one (−1).

        If no interval in that direction is undecided, go to the neighbouring interval.
        """
        if self._report_unexamined():
            return
        with self.intervals.visit_order() as order:
            if direction < 0 and not self._undecided_before(order):
                self.document.step_interval(direction, order=order)
            elif not self.document.step_interval(direction, undecided=True, order=order):
                judged = self.document.interval
                if judged is None or judged.decision != Decision.UNDECIDED:
                    self._report_end()
                    self.document.step_interval(direction, order=order)
                else:
                    self.bar.show_message(tr("This is the last undecided interval."), False)
        self._arrive(zoom=True)

    def _report_unexamined(self) -> bool:
        """If the clip could not be examined, show a message and return True."""
        blind = "" if self.document.intervals else reason_unexamined(self.document.data)
        if blind:
            self.bar.show_message(blind, False)
        return bool(blind)

    def begin(self) -> None:
        """Go to the first undecided interval, unless the user has moved or selected something."""
        fresh = self.document.interval is None and self.document.frame == 0
        with self.intervals.visit_order() as order:
            if fresh and self.document.step_interval(+1, undecided=True, order=order):
                self._arrive(zoom=True)

    def go_to_worst(self) -> Judged | None:
        """Go to the worst undecided interval and return it. Return None if all are decided."""
        document = self.document
        undecided = [j for j in document.intervals if j.decision == Decision.UNDECIDED]
        if not undecided:
            return None
        worst = max(undecided, key=document.severity)
        document.select_interval(worst.id, jump=True)
        self._arrive(zoom=True)
        return worst

    def _undecided_before(self, order: Sequence[int]) -> bool:
        now = self.document.interval_id
        before = set(order[: order.index(now)] if now in order else order)
        undecided = (j.id for j in self.document.intervals if j.decision == Decision.UNDECIDED)
        return any(k in before for k in undecided)

    def step_any(self, direction: int) -> None:
        """Go to the next (+1) or previous (−1) interval, whether it is decided or not."""
        with self.intervals.visit_order() as order:
            self.document.step_interval(direction, order=order)
        self._arrive(zoom=True)

    def _arrive(self, *, zoom: bool) -> None:
        if self.document.interval is None:
            return
        self.look()
        if zoom and self.settings.zoom_to_interval:
            self.visible.zoom_to_interval()

    def _report_end(self) -> None:
        """If every listed interval is decided, show a message about what to do next."""
        intervals, listed = self.document.intervals, set(self.intervals.shown_ids())
        left = [j.id for j in intervals if j.decision == Decision.UNDECIDED]
        if not intervals or listed.intersection(left):
            return
        if left:
            text = plural(
                "All listed intervals are decided. {n} undecided interval is hidden by the filter "
                "or by an unticked chain.",
                "All listed intervals are decided. {n} undecided intervals are hidden by the "
                "filter or by unticked chains.",
                len(left),
            )
        else:
            text = plural(
                "The interval is decided. Press {key} to export the clip.",
                "All {n} intervals are decided. Press {key} to export the clip.",
                len(intervals),
                key=self.key("export_dialog"),
            )
            if self.more_clips():
                text += " " + tr(
                    "{key} exports without a dialog and opens the next clip.",
                    key=self.key("export_at_once"),
                )
        rest = one_line_summary(unexamined_sentences(self.document.data))
        self.bar.show_message(f"{text} {rest}".strip(), False)

    def group_errors(self, on: bool) -> None:
        """Turn the grouping of related errors in the interval list on or off. Save the choice."""
        self.settings.group_errors = on
        self.intervals.group_errors(on)

    def set_order(self, order: str) -> None:
        """Set and save the order in which intervals are visited: 'worst', 'time' or 'chain'."""
        self.settings.order = order
        self.document.set_order(order)
        self.intervals.order_by(order)

    def accept_confident(self) -> None:
        """Open the dialog in which the user accepts all intervals with a high confidence."""
        if self.document.data is not None:
            AcceptConfidentDialog(self.document, self.accept_at_least, self.window).show()

    def accept_at_least(self, confidence: float) -> None:
        """Accept all undecided intervals with at least this confidence, in one undo step."""
        document = self.document
        if document.data is not None and document.automatic_ids(confidence):
            document.accept_undecided(confidence)
            self._report_end()
        else:
            text = tr(
                "No undecided interval has a confidence of {least:.2f} or more.", least=confidence
            )
            self.bar.show_message(text, False)

    def reject_for(self) -> None:
        """Show the list of reasons, and reject the selected interval with the chosen reason."""
        if (judged := self.document.interval) is None:
            self._ask_to_select()
        elif not self._out_of_view():
            own = [j.reason for j in self.document.intervals if j.reason]
            self.look_through.stop()
            palette = ReasonPalette(own, tr("Why reject this interval?"), self.window)
            palette.chosen.connect(lambda reason, k=judged.id: self._reject_for(k, reason))
            self.document.opened.connect(palette.close)
            palette.show()
            palette.line.setFocus()

    def _reject_for(self, interval_id: int, reason: str) -> None:
        self.card.commit()
        judged = self.document.interval
        if judged is not None and judged.id == interval_id:
            self.decide(Decision.REJECTED, reason)

    def focus_field(self, what: str) -> None:
        """Move the keyboard focus to a field on the card of the selected interval.

        `what` is 'note', 'delta', 'start' or 'stop'.
        """
        if self.document.interval is None:
            self._ask_to_select()
            return
        self.show_card()
        if not self.card.focus_field(what):
            self.bar.show_message(tr("This number cannot be edited for this kind of error."), False)

    def play_edge(self, *, other: bool = False) -> None:
        """Play the frames around the beginning or end of the selected interval.

        The edge nearer to the playhead is played or, if `other` is True, the farther one.
        """
        if not self.player.play_edge(other=other):
            self._ask_to_select()

    def _ask_to_select(self) -> None:
        text = tr(
            "Select an interval first: press {key} to go to the next one.",
            key=self.key("next_interval"),
        )
        self.bar.show_message(text, False)

    # -- edges, and intervals made by hand ------------------------------------------------------

    def move_edge(self, *, start: bool) -> None:
        """Move an edge of the selected interval to the playhead.

        The frame at the playhead becomes the first frame or, if `start` is False, the last one.
        """
        if (judged := self.document.interval) is None:
            return
        frame, interval = self.document.frame, judged.interval
        first, stop = (frame, interval.stop) if start else (interval.start, frame + 1)
        if stop <= first:
            text = (
                tr("The interval must start before its end.")
                if start
                else tr("The interval must end after its start.")
            )
            self.bar.show_message(text, False)
        else:
            self.document.edit(judged.id, resized_interval(interval, first, stop))

    def make_level(self) -> None:
        """Use the same offset in all frames of the selected interval."""
        if judged := self.document.interval:
            self.document.edit(judged.id, with_offset_replaced_by_median(judged.interval))

    def make_following(self) -> None:
        """Use a separate offset in each frame, so that the corrected twist is linear in time."""
        judged = self.document.interval
        if judged and judged.interval.kind.info.repairer:
            self.bar.show_message(
                tr("This kind of error has the same offset in all its frames."), False
            )
        elif judged and self.document.data:
            angle = self.document.data.angle(judged.interval.chain)
            self.document.edit(judged.id, with_offset_making_twist_linear(judged.interval, angle))

    def turn_end(self) -> None:
        """Switch whether the selected interval's correction also rotates the joints below.

        For a flip, these joints are the hand or foot; for a stretch, all joints below the rotated
        joint. If the correction does not rotate them, they keep their captured rotation.
        """
        judged = self.document.interval
        if judged is None or not judged.interval.kind.info.below:
            text = tr(
                "Select a limb flip or a stretch. Only for these can the joints below keep their "
                "rotation or turn with the limb."
            )
            self.bar.show_message(text, False)
        else:
            edited = replace(judged.interval, carried=not judged.interval.carried)
            self.document.edit(judged.id, edited)

    def insert_interval(self) -> None:
        """Insert an interval at the playhead.

        If `next_faint` has found a candidate at the playhead, the interval has the frames and the
        offset of this candidate.
        """
        chain, frame, faint = self.document.chain, self.document.frame, self._faint
        there = faint and faint.chain == chain and faint.start <= frame < faint.stop
        self.document.insert_interval(frame, faint if there else None)

    def remove_interval(self) -> None:
        """Remove the selected interval if it was made by hand."""
        if judged := self.document.interval:
            self.document.do(Remove(judged.id))

    # -- missed errors --------------------------------------------------------------------------

    def next_faint(self) -> None:
        """Go to the next suspicious moment, at which the detector may have missed an error.

        Such a moment is a candidate interval with a strength between τ/2 and τ, or an unexplained
        peak of the strength above τ.
        """
        document = self.document
        if (data := document.data) is None:
            self.bar.show_message(tr("No suspicious moments were found down to half of τ."), False)
            return
        if data.blind:
            self.bar.show_message(BLIND, False)
            return
        if self._report_unexamined():
            return
        past = list(reasons_at_unexplained_peaks(document))
        faint = weak_candidates(data.analysis, document.review.state)
        found: list[Interval | Reason] = [*faint, *(r for r in past if r.suspicious)]
        if not found:
            text = tr("No suspicious moments were found down to half of τ.") + _count_explained(
                past
            )
            self.bar.show_message(text, False)
            return
        order = [c.name for c in data.chains_and_limbs]
        found.sort(key=lambda m: (_first_frame(m), order.index(m.chain)))
        here = document.frame, order.index(document.chain) if document.chain in order else -1
        moment = next(
            (m for m in found if (_first_frame(m), order.index(m.chain)) > here), found[0]
        )
        self._faint = moment if isinstance(moment, Interval) else None
        document.select_interval(None)
        document.select_chain(moment.chain)
        document.go_to(_first_frame(moment))
        count = plural(
            "({n} suspicious moment in all)", "({n} suspicious moments in all)", len(found)
        )
        self.bar.show_message(f"{self._describe(moment)} {count}", False)
        self.look()

    def _describe(self, moment: Interval | Reason) -> str:
        if isinstance(moment, Reason):
            return reason_sentence(self.document, moment)
        label = translate_core_sentence(self.document.find_chain(moment.chain).label)
        first = moment.start + self.document.first_frame
        return tr(
            "{chain}: {delta}° over {frames} frames from frame {first}, below τ. Press Insert to "
            "make these frames an interval.",
            chain=label,
            frames=moment.frames,
            first=first,
            delta=format_signed_number(np.degrees(moment.delta), 2),
        )

    def why_not(self) -> None:
        """Explain why the detector found nothing at the playhead or at a nearby peak above τ."""
        document, frame = self.document, self.document.frame
        if document.data is not None and document.data.blind:
            document.answered.emit(BLIND)
        elif not self.document.intervals and (blind := reason_unexamined(document.data)):
            document.answered.emit(blind)
        elif reason := reason_near(document, frame) or reason_here(document, frame):
            document.answered.emit(reason_sentence(document, reason))

    def answer(self, text: str) -> None:
        """Show an explanation as a message, unless the card already shows it.

        The message disappears when the playhead moves.
        """
        self._withdraw()
        if not self.card.says(text):
            self._answer = text
            self.bar.show_message(text, False)

    def _withdraw(self) -> None:
        if self._answer:
            self.bar.withdraw(self._answer)
            self._answer = ""

    def go_to_frame(self) -> None:
        """Ask for the number of a frame, and move the playhead to that frame."""
        if not self.document.frames:
            return
        first = self.document.first_frame
        now, last = self.document.frame + first, self.document.frames - 1 + first
        title = tr("Go to frame")
        text = tr("Frame ({first} – {last})", first=first, last=last)
        frame, chosen = QInputDialog.getInt(self.window, title, text, now, first, last)
        if chosen:
            self.document.go_to(frame - first)


def _first_frame(moment: Interval | Reason) -> int:
    return moment.frame if isinstance(moment, Reason) else moment.start


def _count_explained(past: Sequence[Reason]) -> str:
    """Return a sentence with the number of explained peaks above τ, or '' if there are none."""
    if not past:
        return ""
    alone = sum(r.why == Why.ONE_JOINT for r in past)
    each = plural("at {n} peak, only one joint turns", "at {n} peaks, only one joint turns", alone)
    rest = plural(
        "{n} belongs to another error or to a cut",
        "{n} belong to other errors or to cuts",
        len(past) - alone,
    )
    if 0 < alone < len(past):
        reasons = tr("{some}, and {others}", some=each, others=rest)
    else:
        reasons = each if alone else rest
    return plural(
        " {n} peak above τ is explained: {reasons}. For details choose Go → Why is nothing found "
        "here?",
        " {n} peaks above τ are explained: {reasons}. For details choose Go → Why is nothing "
        "found here?",
        len(past),
        reasons=reasons,
    )


def weak_candidates(clip: ClipAnalysis, state: ReviewState) -> list[Interval]:
    """Return the intervals that the review's detector finds with half of τ, but not with τ.

    Intervals that overlap an interval of the review are excluded.
    """
    if clip.usable(state.method) != state.method:
        return []
    detector, out = clip.detector(state.method), []
    for chain in (c for c in clip.chains_and_limbs if c.name in state.tau):
        known = [(j.interval.start, j.interval.stop) for j in state.of_chain(chain.name)]
        candidates = detector.intervals(chain.name, 0.5 * state.tau[chain.name])
        out += [c for c in candidates if all(c.stop <= a or c.start >= b for a, b in known)]
    return out
