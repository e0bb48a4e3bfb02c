"""The review of intervals, as a feature of the window. Its actions are in the action table."""

from __future__ import annotations

from functools import partial

from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QWidget

from inspector.feature import Area, DockPanel, Feature, FeatureParts, HostWindow
from inspector.folder.feature import feature as folder
from inspector.language import tr
from inspector.panels.detail_card import DetailCard
from inspector.panels.history_panel import HistoryPanel
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.widgets.building import bring_to_front, scrolled, vbox
from inspector.window.look_through import LookThrough
from inspector.window.review_actions import ReviewActions

_ON_ROWS = (  # actions in the context menu of an interval
    "accept", "reject", "reject_for", "reset", "write_note", "zoom_to_interval", "loop_interval",
    "remove_interval",
)  # fmt: skip
_STATUS_MS = 6000  # time that a sentence stays in the status bar


class Reviewing(FeatureParts):
    """The list of intervals, the card of the selected interval, the history, and their actions."""

    def __init__(self, window: HostWindow) -> None:
        document = window.document
        self.intervals = IntervalsPanel(document, window.colours, window.settings)
        self.detail = DetailCard(document)
        self.history = HistoryPanel(document)

    def content(self) -> QWidget:
        """Return the content of the dock: the list of intervals above the card."""
        column = QWidget()
        vbox((self.intervals, 1), self.detail, owner=column, margins=(0, 0, 0, 0), spacing=0)
        return scrolled(column)

    def connect(self, window: HostWindow) -> None:
        """Build the actions of the review, and connect the list and the card to them."""
        actions, visible, queue = window.actions_by_id, window.timeline.visible, window.part(folder)
        native = QKeySequence.SequenceFormat.NativeText
        self.review_actions = ReviewActions(
            window.document, self.intervals, window.bar, self.detail,
            LookThrough(window.document, self.intervals, window.player, window.viewport), visible,
            window.player,
            window.settings, partial(bring_to_front, window.docks["intervals"]),
            lambda name: actions[name].shortcut().toString(native),
            lambda: len(queue.queue.clips) > 1, window.viewport.focus_chain,
            window.viewport.sees_chain,
            lambda text: window.statusBar().showMessage(text, _STATUS_MS), window,
        )  # fmt: skip
        self.intervals.activated.connect(visible.zoom_to_interval)
        self.intervals.row_selected.connect(self.review_actions.show_whole)
        self.intervals.unfold_with(actions["next_frame"], actions["previous_frame"])
        self.intervals.ids_changed.connect(self.detail.show_selected)
        self.intervals.context_menu([actions[name] for name in _ON_ROWS])
        self.detail.judged.connect(self.review_actions.judge)
        self.detail.end_turned.connect(self.review_actions.turn_end)


feature = Feature(
    "review",
    Reviewing,
    panels=(
        DockPanel(
            "intervals",
            tr("Intervals"),
            Area.RightDockWidgetArea,
            Reviewing.content,
            before="chains",
        ),
        DockPanel(
            "history", tr("History"), Area.RightDockWidgetArea, lambda p: p.history, tab=True
        ),
    ),
)
