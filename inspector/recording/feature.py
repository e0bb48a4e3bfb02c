"""Films and pictures of the views as a feature of the window."""

from __future__ import annotations

from inspector.feature import ActionRow, ActionSpec, Feature, FeatureParts, HostWindow, MenuRows
from inspector.language import tr
from inspector.recording.record_actions import RecordActions
from inspector.recording.recorder import Recorder, RecordingBar
from inspector.teaching.feature import feature as teaching


class Recording(FeatureParts):
    """The recorder, how far it is in the status bar, and what its action does."""

    def __init__(self, window: HostWindow) -> None:
        self.recorder = Recorder(window)

    def connect(self, window: HostWindow) -> None:
        """Show in the status bar how far a film is."""
        # The first of the permanent ones: before it is only the line of the frame.
        window.statusBar().insertPermanentWidget(1, RecordingBar(self.recorder))
        taught = window.part(teaching)
        self.record_actions = RecordActions(
            window.document, self.recorder, window.viewport, window.timeline, taught.taught,
            taught.teaching.typesetter, window.bar, window,
        )  # fmt: skip

    def close(self) -> None:
        """Give a film up that is being made."""
        self.recorder.cancel()


# fmt: off
_ROWS: tuple[ActionRow[Recording] | None, ...] = (
    ActionSpec("record_dialog", tr("Record…"), ("Ctrl+R",),
               tr("Film or picture of 3D view and curves"),
               needs="clip", do=lambda p: p.record_actions.record_dialog()),
)
# fmt: on

feature = Feature("recording", Recording, rows=(MenuRows("Teach", _ROWS),))
