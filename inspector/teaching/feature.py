"""The teaching tab, as a feature of the window."""

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
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.teaching_panel import TeachingPanel
from inspector.widgets.building import bring_to_front
from inspector.widgets.late_panel import LatePanel
from inspector.widgets.typeset import Typesetter


class Teaching(FeatureParts):
    """The teaching tab, and the frame that it explains."""

    def __init__(self, window: HostWindow) -> None:
        self._window = window
        self.taught = TaughtFrame(window.document, window)
        self.typesetter = Typesetter(window)
        self.teaching_area = LatePanel(self._build)

    def _build(self) -> TeachingPanel:
        window, actions = self._window, self._window.actions_by_id
        shown = [actions[name] for name in ("tour", "exercise", "record_dialog")]
        panel = TeachingPanel(self.taught, window.viewport, window.timeline, shown, self.typesetter)
        panel.moved_far.connect(actions["focus_chain"].trigger)
        # The minimum width depends on the typeset symbols.
        panel.least_width.connect(self.teaching_area.setMinimumWidth)
        return panel

    @property
    def teaching(self) -> TeachingPanel:
        """The panel of the teaching tab."""
        return self.teaching_area.build()

    def connect(self, window: HostWindow) -> None:
        """Connect the tab to the window. The tab is active while it is visible."""
        self._dock = window.docks["teaching"]
        self._dock.visibilityChanged.connect(self._set_seen)
        self.typesetter.ready.connect(self._report)

    def _report(self) -> None:
        """Show a message if a formula of the tab or of a lesson could not be typeset."""
        if why := self.typesetter.trouble or self.typesetter.left_out:
            self._window.document.message.emit(why, True)

    def _set_seen(self, on: bool) -> None:
        """Activate the teaching tab when it becomes visible, or deactivate it if `on` is False.

        While the tab is active, the 3D view shows a single figure without the striped skin, because
        the gizmo is drawn on the wedges of the bones.
        """
        if on == self.taught.active:
            return
        for look in ("skin", "side_by_side"):
            wanted = not on and bool(self._window.settings.value(look))
            self._window.actions_by_id[look].setChecked(wanted)
        self.teaching_area.set_seen(on)

    def show(self) -> None:
        """Bring the teaching tab to the front."""
        bring_to_front(self._dock)


# fmt: off
_ROWS: tuple[ActionRow[Teaching] | None, ...] = (
    ActionSpec("show_teaching", tr("Swing and twist"), ("Ctrl+L",),
               tr("Show the equations of swing and twist for the selected joint"),
               do=lambda p: p.show()),
    None,
)
# fmt: on

feature = Feature(
    "teaching",
    Teaching,
    rows=(MenuRows("Teach", _ROWS),),
    panels=(
        DockPanel(
            "teaching",
            tr("Teaching"),
            Area.RightDockWidgetArea,
            lambda p: p.teaching_area,
            tab=True,
            tall=True,
        ),
    ),
)
