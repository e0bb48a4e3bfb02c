"""What the actions of the review do: methods of the main window, by the actions' ids."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QInputDialog, QMainWindow

from inspector.panels.intervals_panel import IntervalsPanel
from inspector.session.document import Document
from inspector.session.redetection import faint_intervals
from inspector.timeline.timeline import Timeline
from inspector.widgets.message_bar import MessageBar
from twistcore.detection import Interval
from twistcore.review import Decide, Decision, Insert, Judged, Remove
from twistcore.review.model import flattened, following, resized
from twistcore.review.proposal import proposed_interval


class ReviewActions(QMainWindow):
    """Verdicts, edges, hand-made intervals, what was missed."""

    document: Document
    intervals: IntervalsPanel
    timeline: Timeline
    bar: MessageBar
    _faint: Interval | None = None

    def _judge(self, decision: Decision) -> None:
        if self.document.data is not None:
            order = self.intervals.shown_ids()
            self.document.decide(decision, self.intervals.selected_ids(), order)

    def accept(self) -> None:
        """Accept the selected intervals."""
        self._judge(Decision.ACCEPTED)

    def reject(self) -> None:
        """Reject the selected intervals."""
        self._judge(Decision.REJECTED)

    def reset(self) -> None:
        """Take the verdict back."""
        self._judge(Decision.UNDECIDED)

    def accept_confident(self) -> None:
        """Ask for a confidence and accept all undecided intervals at or above it, in one step."""
        value, chosen = QInputDialog.getDouble(
            self, "Accept the sure ones", "Confidence of at least", 0.95, 0.0, 1.0, 2
        )
        if chosen:
            self.accept_at_least(value)

    def accept_at_least(self, confidence: float) -> None:
        """Accept all undecided intervals with at least this confidence, in one step."""
        ids = self.document.review.state.unasked(confidence) if self.document.data else ()
        if not ids:
            self.bar.show_message(
                f"No undecided interval has a confidence of {confidence:.2f} or more.", False
            )
            return
        self.document.do(
            Decide(ids, Decision.ACCEPTED, self.document.reviewer, self.document.now())
        )

    def undo(self) -> None:
        """Take the last command back."""
        self.document.undo()

    def redo(self) -> None:
        """Do it again."""
        self.document.redo()

    def start_here(self) -> None:
        """The selected interval starts at the playhead."""
        if judged := self.document.interval:
            self._resize(judged, self.document.frame, judged.interval.stop)

    def stop_here(self) -> None:
        """The selected interval ends with the playhead's frame."""
        if judged := self.document.interval:
            self._resize(judged, judged.interval.start, self.document.frame + 1)

    def _resize(self, judged: Judged, start: int, stop: int) -> None:
        if stop <= start:
            self.bar.show_message("The playhead is on the wrong side of the interval.", False)
        else:
            self.document.edit(judged.id, resized(judged.interval, start, stop))

    def make_level(self) -> None:
        """The selected interval gets one offset in all its frames."""
        if judged := self.document.interval:
            self.document.edit(judged.id, flattened(judged.interval))

    def make_following(self) -> None:
        """The selected interval gets an offset a frame, so that the twist runs straight through."""
        if (judged := self.document.interval) and self.document.data:
            theta = self.document.data.signals[judged.interval.chain].theta_p
            self.document.edit(judged.id, following(judged.interval, theta))

    def insert_interval(self) -> None:
        """A hand-made interval: the suspicious moment gone to, or one around the playhead."""
        document = self.document
        if document.data is None or not document.chain:
            return
        faint = self._faint
        if faint and faint.chain == document.chain and faint.start <= document.frame < faint.stop:
            interval = faint
        else:
            signals = document.data.signals[document.chain]
            fps = document.data.motion.fps
            interval = proposed_interval(document.chain, signals, document.frame, fps)
        document.do(Insert(interval))
        document.select_interval(document.review.state.next_id - 1)

    def remove_interval(self) -> None:
        """Remove the selected interval if it was made by hand."""
        if judged := self.document.interval:
            self.document.do(Remove(judged.id))

    def next_faint(self) -> None:
        """Go to the next candidate between half of τ and τ: what was missed is invisible."""
        data = self.document.data
        found = faint_intervals(data.analysis, self.document.review.state) if data else []
        if data is None or not found:
            self.bar.show_message("Nothing suspicious down to half of τ.", False)
            return
        order = [c.name for c in data.chains]
        found = sorted(found, key=lambda i: (i.start, order.index(i.chain)))
        self._faint = next((i for i in found if i.start > self.document.frame), found[0])
        faint = self._faint
        self.document.select_interval(None)
        self.document.select_chain(faint.chain)
        self.document.go_to(faint.start)
        label = self.document.find_chain(faint.chain).label
        first = faint.start + self.document.first_frame
        self.bar.show_message(
            f"{label}, {faint.frames} frames from {first}: {np.degrees(faint.delta):+.2f}°, "
            f"below τ. Insert makes it an interval. ({len(found)} such)",
            False,
        )

    def use_consistency(self, on: bool) -> None:
        """Detect with our detector."""
        if on:
            self.document.use_method("consistency")

    def use_paper(self, on: bool) -> None:
        """Detect with the paper's detector."""
        if on:
            self.document.use_method("paper")
