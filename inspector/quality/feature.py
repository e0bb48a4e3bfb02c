"""Capture quality and joint tracking, as a feature of the window."""

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
from inspector.quality.tracked_clip import Tracked
from inspector.widgets.building import bring_to_front
from inspector.widgets.late_panel import LatePanel
from twistcore.detection import Interval, Kind


class Quality(FeatureParts):
    """The quality tab, and the display of tracked joints in the 3D view."""

    def __init__(self, window: HostWindow) -> None:
        document, colours, actions = window.document, window.colours, window.actions_by_id
        tracked = self.tracked = Tracked(document, window)
        self.quality_area = LatePanel(lambda: QualityPanel(document, colours, actions, tracked))
        window.viewport.accompany(tracked)
        self.jitter_note = JitterNote(document, window)

    @property
    def quality(self) -> QualityPanel:
        """The panel of the quality tab."""
        return self.quality_area.build()

    def connect(self, window: HostWindow) -> None:
        """Connect the tab to the window.

        Measures are computed only while the tab is visible. A button on the interval card opens the
        tab.
        """
        self._document, self._dock = window.document, window.docks["quality"]
        to_track = (tr("Quality → Track"), self._show_tracking)
        self.jitter_note.trembles.connect(lambda text: window.bar.append_offer(text, [to_track]))
        self._dock.visibilityChanged.connect(self.quality_area.set_seen)
        window.detail.quality_asked.connect(self._show_interval)
        self._actions = window.actions_by_id
        for signal in (
            self.tracked.changed,
            self._document.opened,
            self._document.intervals_changed,
        ):
            signal.connect(self._enable_actions)

    def show(self) -> None:
        """Bring the quality tab to the front."""
        bring_to_front(self._dock)

    def _enable_actions(self) -> None:
        data = self._document.data
        tracking = self._document.review.state.tracking if data is not None else None
        self._actions["cancel_tracking"].setEnabled(self.tracked.asked is not None)
        self._actions["stop_tracking"].setEnabled(tracking is not None)
        if not self.quality_area.built:  # the panel knows which joints are selected
            ready = data is not None and not self.tracked.running
            self._actions["track_joints"].setEnabled(ready)

    def _show_tracking(self) -> None:
        """Show the page for tracking joints."""
        self.show()
        self.quality.show_tracking()

    def _show_interval(self, interval: Interval) -> None:
        """Show the joints and the first frame of a capture fault in the quality tab.

        If the fault is a noise burst, also smooth it.
        """
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
        self.tracked.close()
        if self.quality_area.built:
            self.quality.stop()


# fmt: off
_ROWS: tuple[ActionRow[Quality] | None, ...] = (
    ActionSpec("show_quality", tr("Quality tab"), ("Ctrl+D",),
               tr("Show the jitter, jumps and speed of every joint, and any foot sliding"),
               do=lambda p: p.show()),
    None,
    ActionSpec("track_joints", tr("Track with QuaMo"), (),
               tr(
                   "Smooth the joints selected in the Quality tab; the twist correction is "
                   "applied first"),
               ready=False,
               do=lambda p: p.quality.track()),
    ActionSpec("cancel_tracking", tr("Cancel tracking"), (), tr("Cancel the tracking in progress"),
               ready=False,
               do=lambda p: p.tracked.cancel()),
    ActionSpec("stop_tracking", tr("Stop tracking"), (),
               tr("Remove the tracking from all joints; undo restores it"), ready=False,
               do=lambda p: p.tracked.stop()),
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
            lambda p: p.quality_area,
            tab=True,
        ),
    ),
)
