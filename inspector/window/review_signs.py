"""Show the state of the review in the window title, the Edit menu and the status bar."""

from __future__ import annotations

from inspector.feature import HostWindow
from inspector.language import tr, translate_core_sentence
from inspector.panels.position_line import FrameLine, PositionLine
from inspector.widgets.labels import SteadyLabel
from inspector.window.actions import set_undo_step_name
from inspector.window.detector_rows import tick_detector_entry
from twistcore.files.encoding import escape_control_characters
from twistcore.review import Decision


class ReviewSigns:
    """Shows the state of the review in the window title, the Edit menu and the status bar."""

    def __init__(self, window: HostWindow) -> None:
        self._window = window
        self.position, self.decided = PositionLine(window.document), SteadyLabel()
        window.statusBar().addWidget(FrameLine(window.document), 1)
        for widget in (self.position, self.decided):
            window.statusBar().addPermanentWidget(widget)

    def show(self) -> None:
        """Show the current state of the review."""
        document, actions = self._window.document, self._window.actions_by_id
        review = document.review if document.data else None
        texts = (review.undo_text, review.redo_text) if review else ("", "")
        for name, text in zip(("undo", "redo"), texts, strict=True):
            title = {"undo": tr("Undo"), "redo": tr("Redo")}[name]
            set_undo_step_name(actions[name], title, translate_core_sentence(text))
        if review is not None:
            tick_detector_entry(actions, review.state.method)
        self._show_title()
        waits = review is not None and not review.saved and document.borrowed is None
        self._window.setWindowModified(waits)
        self._show_decided()

    def _show_title(self) -> None:
        document, title = self._window.document, "Twist Inspector"
        data = document.data
        look = tr(" (read-only)") if document.keeper.read_only else ""
        # Qt replaces [*] with a mark for changes; if doubled, it is shown unchanged
        name = escape_control_characters(data.clip.name).replace("[*]", "[*][*]") if data else ""
        self._window.setWindowTitle(f"{name}[*]{look} – {title}" if data else title)

    def _show_decided(self) -> None:
        document = self._window.document
        intervals = document.intervals
        done = sum(judged.decision != Decision.UNDECIDED for judged in intervals)
        text = tr("{done} of {total} decided", done=done, total=len(intervals))
        if not intervals:
            unseen = document.data and document.data.analysis.not_examined
            text = tr("not examined") if unseen else ""
        self.decided.setText(text)
