"""What the actions of the review do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QInputDialog, QWidget

from inspector.panels.detail_card import DetailCard
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.session.document import Document
from inspector.session.why_here import peaks, reason_here, reason_near, told
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.signed_numbers import signed
from twistcore.analysis import ClipAnalysis
from twistcore.detection import Interval, Kind
from twistcore.review import Decide, Decision, Remove, ReviewState
from twistcore.review.model import flattened, following, resized
from twistcore.why_not import Reason, Why


@dataclass(eq=False)
class ReviewActions:
    """Verdicts, edges, hand-made intervals, what was missed, and the way from one to the next.

    card: where a reason may be read already; look: turns the camera to where the selected limb's
    roll shows best; sees: whether that limb is in the picture as it is.
    """

    document: Document
    intervals: IntervalsPanel
    bar: MessageBar
    card: DetailCard
    look: Callable[[], None]
    sees: Callable[[], bool]
    window: QWidget
    _faint: Interval | None = field(default=None, init=False)
    _answer: str = field(default="", init=False)

    def __post_init__(self) -> None:
        document = self.document
        document.answered.connect(self.answer)
        for moved in (document.frame_changed, document.chain_changed, document.opened):
            moved.connect(self._withdraw)
        find = QTimer(self.window, singleShot=True, interval=0)  # the playhead is there by then
        find.timeout.connect(self._find)
        document.interval_changed.connect(
            lambda: find.stop() if document.interval is None else find.start()
        )
        document.chains_changed.connect(find.start)

    def _find(self) -> None:
        """The camera stays, unless what was selected is out of the picture."""
        if not self.sees():
            self.look()

    def judge(self, decision: Decision) -> None:
        """Judge the selected intervals; the camera stays."""
        if self.document.data is not None:
            order = self.intervals.shown_ids()
            self.document.decide(decision, self.intervals.selected_ids(), order)

    def decide(self, decision: Decision) -> None:
        """Judge the selected intervals, and look at the next undecided."""
        self.judge(decision)
        self._look()

    def step_interval(self, direction: int) -> None:
        """Go to the next interval (+1) or the previous one (−1)."""
        self.document.step_interval(direction, order=self.intervals.shown_ids())
        self._look()

    def _look(self) -> None:
        if self.document.interval is not None:
            self.look()

    def accept_confident(self) -> None:
        """Ask for a confidence and accept all undecided intervals at or above it, in one step."""
        value, chosen = QInputDialog.getDouble(
            self.window, "Accept the sure ones", "Confidence of at least", 0.95, 0.0, 1.0, 2
        )
        if chosen:
            self.accept_at_least(value)

    def accept_at_least(self, confidence: float) -> None:
        """Accept all undecided intervals with at least this confidence, in one step."""
        document = self.document
        ids = document.review.state.unasked(confidence) if document.data else ()
        if ids:
            document.do(Decide(ids, Decision.ACCEPTED, document.reviewer, document.now()))
        else:
            text = f"No undecided interval has a confidence of {confidence:.2f} or more."
            self.bar.show_message(text, False)

    def move_edge(self, *, start: bool) -> None:
        """The selected interval starts at the playhead, or ends with its frame."""
        if (judged := self.document.interval) is None:
            return
        frame, interval = self.document.frame, judged.interval
        first, stop = (frame, interval.stop) if start else (interval.start, frame + 1)
        if stop <= first:
            self.bar.show_message("The playhead is on the wrong side of the interval.", False)
        else:
            self.document.edit(judged.id, resized(interval, first, stop))

    def make_level(self) -> None:
        """The selected interval gets one offset in all its frames."""
        if judged := self.document.interval:
            self.document.edit(judged.id, flattened(judged.interval))

    def make_following(self) -> None:
        """The selected interval gets an offset a frame, so that the twist runs straight through."""
        if (judged := self.document.interval) and self.document.data:
            angle = self.document.data.angle(judged.interval.chain)
            self.document.edit(judged.id, following(judged.interval, angle))

    def turn_end(self) -> None:
        """The end of the selected flip is kept if it was carried, or the reverse."""
        judged = self.document.interval
        if judged is None or judged.interval.kind != Kind.LIMB_FLIP:
            self.bar.show_message("Only a flip of a limb has an end, kept or turned along.", False)
        else:
            edited = replace(judged.interval, carried=not judged.interval.carried)
            self.document.edit(judged.id, edited)

    def insert_interval(self) -> None:
        """A hand-made interval: the suspicious moment gone to, or one around the playhead."""
        chain, frame, faint = self.document.chain, self.document.frame, self._faint
        there = faint and faint.chain == chain and faint.start <= frame < faint.stop
        self.document.insert_interval(frame, faint if there else None)

    def remove_interval(self) -> None:
        """Remove the selected interval if it was made by hand."""
        if judged := self.document.interval:
            self.document.do(Remove(judged.id))

    def next_faint(self) -> None:
        """Go to the next suspicious moment: what was missed is invisible.

        Between half of τ and τ it is a candidate; past τ a peak whose reason does not settle it.
        """
        document = self.document
        if (data := document.data) is None:
            self.bar.show_message("Nothing suspicious down to half of τ.", False)
            return
        past = list(peaks(document))
        faint = faint_intervals(data.analysis, document.review.state)
        found: list[Interval | Reason] = [*faint, *(r for r in past if r.suspicious)]
        if not found:
            self.bar.show_message(f"Nothing suspicious down to half of τ.{_settled(past)}", False)
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
        self.bar.show_message(f"{self._told(moment)} ({len(found)} such)", False)
        self.look()

    def _told(self, moment: Interval | Reason) -> str:
        if isinstance(moment, Reason):
            return told(self.document, moment)
        label = self.document.find_chain(moment.chain).label
        first = moment.start + self.document.first_frame
        return (
            f"{label}, {moment.frames} frames from {first}: "
            f"{signed(np.degrees(moment.delta), 2)}°, below τ. Insert makes it an interval."
        )

    def why_not(self) -> None:
        """Say why nothing is found at the playhead, or at the peak past τ next to it."""
        document, frame = self.document, self.document.frame
        if reason := reason_near(document, frame) or reason_here(document, frame):
            document.answered.emit(told(document, reason))

    def answer(self, text: str) -> None:
        """Say why nothing is found, where the card does not, until the playhead moves."""
        self._withdraw()
        if not self.card.says(text):
            self._answer = text
            self.bar.show_message(text, False)

    def _withdraw(self) -> None:
        if self._answer:
            self.bar.withdraw(self._answer)
            self._answer = ""

    def go_to_frame(self) -> None:
        """Ask for a frame."""
        if not self.document.frames:
            return
        first = self.document.first_frame
        now, last = self.document.frame + first, self.document.frames - 1 + first
        title, text = "Go to frame", f"Frame ({first} – {last})"
        frame, chosen = QInputDialog.getInt(self.window, title, text, now, first, last)
        if chosen:
            self.document.go_to(frame - first)


def _first_frame(moment: Interval | Reason) -> int:
    return moment.frame if isinstance(moment, Reason) else moment.start


def _settled(past: Sequence[Reason]) -> str:
    """What else is past τ, so that the curve and the list do not contradict each other."""
    if not past:
        return ""
    alone = sum(r.why == Why.ONE_JOINT for r in past)
    each = f"{alone} of one joint alone" if alone else ""
    rest = f"{len(past) - alone} of other errors or cuts" if len(past) > alone else ""
    one = len(past) == 1
    return (
        f" {len(past)} peak{'' if one else 's'} above τ {'has' if one else 'have'} a reason: "
        f"{' and '.join(filter(None, (each, rest)))}; Go → Why is nothing found here? says it."
    )


def faint_intervals(clip: ClipAnalysis, state: ReviewState) -> list[Interval]:
    """What the detector finds between half of τ and τ, where the review has nothing."""
    detector, out = clip.detector(state.method), []
    for chain in (c for c in clip.chains_and_limbs if c.name in state.tau):
        known = [(j.interval.start, j.interval.stop) for j in state.of_chain(chain.name)]
        candidates = detector.intervals(chain.name, 0.5 * state.tau[chain.name])
        out += [c for c in candidates if all(c.stop <= a or c.start >= b for a, b in known)]
    return out
