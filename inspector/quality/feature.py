"""The quality of the capture, and tracking, as a feature of the window."""

from __future__ import annotations

from inspector.feature import (
    ActionRow,
    ActionSpec,
    Area,
    DockPanel,
    Feature,
    FeatureParts,
    HostWindow,
    MenuRows,
)
from inspector.language import tr
from inspector.quality.jitter_note import JitterNote
from inspector.quality.quality_panel import QualityPanel
from inspector.widgets.building import bring_to_front, scrolled
from twistcore.detection import Interval, Kind


class Quality(FeatureParts):
    """The quality tab. The 3D view also shows the tracked joints."""

    def __init__(self, window: HostWindow) -> None:
        colours, actions = window.colours, window.actions_by_id
        self.quality = QualityPanel(window.document, colours, actions)
        window.viewport.accompany(self.quality.tracked)
        self.jitter_note = JitterNote(window.document, self.quality)

    def connect(self, window: HostWindow) -> None:
        """Compute measures while the tab is visible, and react to the interval card."""
        self._document, self._dock = window.document, window.docks["quality"]
        to_track = (tr("Quality → Track"), self._show_tracking)
        self.jitter_note.trembles.connect(lambda text: window.bar.append_offer(text, [to_track]))
        self._dock.visibilityChanged.connect(self.quality.set_seen)
        window.detail.quality_asked.connect(self._show_interval)

    def show(self) -> None:
        """Bring the quality tab to the front."""
        bring_to_front(self._dock)

    def _show_tracking(self) -> None:
        """Show the page for tracking joints."""
        self.show()
        self.quality.show_tracking()

    def _show_interval(self, interval: Interval) -> None:
        """Show the joints and the first frame of a capture fault. Smooth a noise burst."""
        if not interval.start <= self._document.frame < interval.stop:
            self._document.go_to(interval.start)
        joints = (interval.evidence or {}).get("joints", (interval.joint,))
        self.show()
        burst = interval.kind == Kind.NOISE_BURST
        self.quality.show_joints(joints, track=burst)
        if burst:
            self.quality.track_burst(interval)

    def close(self) -> None:
        """Stop all computations."""
        self.jitter_note.stop()
        self.quality.close_clip()


# fmt: off
_ROWS: tuple[ActionRow[Quality] | None, ...] = (
    ActionSpec("show_quality", tr("Quality tab"), ("Ctrl+D",),
               tr("Show jitter, jumps, speed and foot slide of every joint"),
               do=lambda p: p.show()),
    None,
    ActionSpec("track_joints", tr("Track with QuaMo"), (),
               tr("Smooth the joints selected in the quality tab, after the twist correction"),
               do=lambda p: p.quality.track()),
    ActionSpec("cancel_tracking", tr("Cancel tracking"), (), tr("Cancel the running tracking"),
               do=lambda p: p.quality.tracked.cancel()),
    ActionSpec("stop_tracking", tr("Stop tracking"), (),
               tr("Remove the tracking from all joints; undo restores it"),
               do=lambda p: p.quality.tracked.stop()),
)
# fmt: on

feature = Feature(
    "quality",
    Quality,
    rows=(MenuRows("Quality", _ROWS),),
    panels=(
        DockPanel(
            "quality",
            tr("Quality"),
            Area.RightDockWidgetArea,
            lambda p: scrolled(p.quality),
            tab=True,
        ),
    ),
)
