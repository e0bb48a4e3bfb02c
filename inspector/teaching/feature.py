"""The teaching tab, as a feature of the window."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

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
from inspector.widgets.building import bring_to_front, scrolled


class Teaching(FeatureParts):
    """The teaching tab, and the frame that it explains."""

    def __init__(self, window: HostWindow) -> None:
        actions = window.actions_by_id
        self.taught = TaughtFrame(window.document, window)
        shown = [actions[name] for name in ("tour", "exercise", "record_dialog")]
        self.teaching = TeachingPanel(self.taught, window.viewport, window.timeline, shown)
        self.teaching.moved_far.connect(actions["focus_chain"].trigger)

    def connect(self, window: HostWindow) -> None:
        """Connect the tab to the window. Teaching is active while the tab is visible."""
        self._dock, self._window = window.docks["teaching"], window
        self._dock.visibilityChanged.connect(self._set_shown)

    def _set_shown(self, on: bool) -> None:
        """Activate teaching, or deactivate it if `on` is False.

        While teaching is active, the 3D view shows a single figure without the striped skin,
        because the gizmo is drawn on the wedges of the bones.
        """
        if on == self.taught.active:
            return
        for look in ("skin", "side_by_side"):
            wanted = not on and bool(self._window.settings.value(look))
            self._window.actions_by_id[look].setChecked(wanted)
        self.teaching.set_shown(on)

    def content(self) -> QWidget:
        """Return the content of the dock, whose minimum width depends on the typeset symbols."""
        area = scrolled(self.teaching)
        self.teaching.least_width.connect(area.setMinimumWidth)
        return area

    def show(self) -> None:
        """Bring the teaching tab to the front."""
        bring_to_front(self._dock)


# fmt: off
_ROWS: tuple[ActionRow[Teaching] | None, ...] = (
    ActionSpec("show_teaching", tr("Swing and twist"), ("Ctrl+L",),
               tr("Show the equations of swing and twist at the selected joint"),
               do=lambda p: p.show()),
    None,
)
# fmt: on

feature = Feature(
    "teaching",
    Teaching,
    rows=(MenuRows("Teach", _ROWS),),
    panels=(
        DockPanel("teaching", tr("Teaching"), Area.RightDockWidgetArea, Teaching.content, tab=True),
    ),
)
