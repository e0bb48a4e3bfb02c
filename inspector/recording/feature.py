"""The recording of films and pictures, as a feature of the window."""

from __future__ import annotations

from inspector.feature import ActionRow, ActionSpec, Feature, FeatureParts, HostWindow, MenuRows
from inspector.language import tr
from inspector.recording.record_actions import RecordActions
from inspector.recording.recorder import Recorder, RecordingBar
from inspector.teaching.feature import feature as teaching


class Recording(FeatureParts):
    """The recorder for films and pictures, with its progress bar and its action."""

    def __init__(self, window: HostWindow) -> None:
        self.recorder = Recorder(window)

    def connect(self, window: HostWindow) -> None:
        """Add the recording's progress bar to the status bar, and create the actions."""
        # The first permanent widget; only the frame line is left of it.
        window.statusBar().insertPermanentWidget(1, RecordingBar(self.recorder))
        taught = window.part(teaching)
        self.record_actions = RecordActions(
            window.document, self.recorder, window.viewport, window.timeline, taught.taught,
            taught.typesetter, window.bar, window, window.settings,
        )  # fmt: skip

    def close(self) -> None:
        """Cancel the film that is being made."""
        self.recorder.cancel()


# fmt: off
_ROWS: tuple[ActionRow[Recording] | None, ...] = (
    ActionSpec("record_dialog", tr("Record…"), ("Ctrl+R",),
               tr("Record a video or an image of the 3D view and the curves"),
               needs="clip", do=lambda p: p.record_actions.record_dialog()),
)
# fmt: on

feature = Feature("recording", Recording, rows=(MenuRows("Teach", _ROWS),))
