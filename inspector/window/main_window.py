"""Docks, menus and layout, nothing else: what happens is in the document and the views."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PySide6.QtCore import QByteArray, QEvent, Qt
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QMainWindow,
    QMenu,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from inspector.panels.chains_panel import ChainsPanel
from inspector.panels.clips_panel import ClipsPanel
from inspector.panels.detail_card import DetailCard
from inspector.panels.history_panel import HistoryPanel
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.panels.transport import Transport
from inspector.quality.quality_actions import QualityActions
from inspector.recording.record_actions import RecordActions
from inspector.session.document import Document
from inspector.session.exporter import Exporter
from inspector.session.player import Player
from inspector.session.queue import FolderQueue
from inspector.session.settings import Settings, save_settings
from inspector.teaching.teaching_actions import TeachActions
from inspector.timeline.timeline import Timeline
from inspector.tuning.tuning_actions import TuningActions
from inspector.tuning.tuning_panel import TuningPanel
from inspector.video.video_actions import VideoActions
from inspector.video.video_panel import VideoPanel
from inspector.viewport.viewport import Viewport
from inspector.widgets import theme as themes
from inspector.widgets.background import Task
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.native_surface import own_surface
from inspector.window.actions import build_actions
from inspector.window.file_actions import FileActions
from inspector.window.go_actions import GoActions
from inspector.window.preferences import apply_keys
from inspector.window.presentation import Presentation
from inspector.window.program_actions import ProgramActions
from inspector.window.review_actions import ReviewActions
from inspector.window.view_actions import OF_THE_FIGURE, ViewActions
from twistcore.review import Decision

_STATE_VERSION = 2
_LEFT_WIDTH, _RIGHT_WIDTH = 335, 545
_PRESENTED = ("curves", "teaching")  # docks that stay in a presentation


class MainWindow(
    ViewActions,
    ReviewActions,
    GoActions,
    TuningActions,
    TeachActions,
    RecordActions,
    VideoActions,
    QualityActions,
    ProgramActions,
    FileActions,
):
    """The program's window."""

    def __init__(self, settings: Settings, settings_file: Path | None) -> None:
        """`settings_file`: where to keep the settings at the end; None: nowhere."""
        super().__init__()
        self.settings, self._settings_file = settings, settings_file
        self.document = Document(self)
        self.exporter = Exporter(self.document, self)
        self._take_settings()
        self.player = Player(self.document, self)
        self.queue = FolderQueue(parent=self)
        self.theme = self._wanted_theme()
        self.setAcceptDrops(True)
        self.setWindowTitle("Twist Inspector")
        self.setDockOptions(self.dockOptions() | QMainWindow.DockOption.AllowNestedDocks)
        self.actions_by_id, self._menus = build_actions(self, self.menuBar())
        apply_keys(self.actions_by_id, settings)
        self._build()
        self._connect()
        self.apply_theme(self.theme)  # some views have no colours until they are told
        self._restore()

    # -- building -----------------------------------------------------------------------------

    def _build(self) -> None:
        self.bar = MessageBar()
        self.viewport = Viewport(self.document, self.theme)
        self.transport = Transport(self.document, self.player, self.actions_by_id)
        centre = QWidget()
        layout = QVBoxLayout(centre)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.bar)
        layout.addWidget(self.viewport, 1)
        layout.addWidget(self.transport)
        self.setCentralWidget(centre)
        own_surface(self.viewport)
        self.chains = ChainsPanel(self.document, self.theme)
        self.intervals = IntervalsPanel(self.document, self.theme)
        self.detail = DetailCard(self.document)
        self.timeline = Timeline(self.document, self.theme)
        right = QWidget()
        column = QVBoxLayout(right)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.intervals, 1)
        column.addWidget(self.detail)
        self._dock("Curves", self.timeline, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.video = VideoPanel(self.document, self.theme, self.settings, self.actions_by_id)
        self.video_dock = self._dock("Video", self.video, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.video_dock.hide()
        self.clips = ClipsPanel(self.queue, self.document, self.theme)
        self.clips_dock = self._dock("Clips", self.clips, Qt.DockWidgetArea.LeftDockWidgetArea)
        self.clips_dock.hide()
        left = self._dock("Chains", self.chains, Qt.DockWidgetArea.LeftDockWidgetArea)
        rest = self._dock("Intervals", right, Qt.DockWidgetArea.RightDockWidgetArea)
        history = self._dock(
            "History", HistoryPanel(self.document), Qt.DockWidgetArea.RightDockWidgetArea
        )
        self.tuning = TuningPanel(self.document, self.theme, self.actions_by_id)
        area = Qt.DockWidgetArea.RightDockWidgetArea
        self.tuning_dock = self._dock("Tuning", self.tuning, area)
        self.tuning_dock.visibilityChanged.connect(self.tuning.set_seen)
        self.tabifyDockWidget(rest, history)
        self.tabifyDockWidget(rest, self.tuning_dock)
        self._build_teaching(rest, self.tuning_dock)
        self._build_recording()
        self._build_quality(self.teaching_dock)
        rest.raise_()
        self.resizeDocks([left, rest], [_LEFT_WIDTH, _RIGHT_WIDTH], Qt.Orientation.Horizontal)
        for name in OF_THE_FIGURE:
            self.actions_by_id[name].setEnabled(self.viewport.view is not None)
        self.presenting = Presentation(self, self.viewport, self.timeline, _PRESENTED)
        leave = self.actions_by_id["presentation"]
        self.presenting.escaped.connect(lambda: leave.setChecked(False))
        self.timeline.toggles["other"].toggled.connect(
            self.actions_by_id["both_detectors"].setChecked
        )
        tools = QToolBar("Tools")
        tools.setObjectName("tools")
        tools.setMovable(False)
        tools.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        for name in (
            "open_dialog", "export_dialog", "", "undo", "redo", "", "previous_interval",
            "next_interval", "accept", "reject", "reset", "", "cycle_show", "focus_chain",
        ):  # fmt: skip
            if name:
                tools.addAction(self.actions_by_id[name])
            else:
                tools.addSeparator()
        self.addToolBar(tools)
        view = self._menus["View"]
        view.addSeparator()
        for dock in self.findChildren(QDockWidget):
            view.addAction(dock.toggleViewAction())
        self.recent_menu = QMenu("Recent", self)
        self._menus["File"].insertMenu(self.actions_by_id["save_session"], self.recent_menu)
        self.position = SteadyLabel()
        self.decided = SteadyLabel()
        for label in (self.position, self.decided):
            self.statusBar().addPermanentWidget(label)

    def _dock(self, title: str, content: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(title.lower())
        dock.setWidget(content)
        self.addDockWidget(area, dock)
        return dock

    def _connect(self) -> None:
        document = self.document
        document.message.connect(self.bar.show_message)
        self.exporter.message.connect(self.bar.show_message)
        document.question.connect(self.bar.ask)
        document.withdrawn.connect(self.bar.clear)
        document.opener.locate.connect(self.locate_clip)
        document.recovery.save_elsewhere.connect(self.save_session_as)
        document.recovery.open_again.connect(self.open_path)
        document.opener.began.connect(self._opening)
        document.opener.share.connect(self._opening_share)
        document.opener.over.connect(self._opening_over)
        self.actions_by_id["cancel_opening"].setEnabled(False)
        document.message.connect(lambda *_: self.statusBar().clearMessage())
        document.opened.connect(self._opened)
        document.intervals_changed.connect(self._review_changed)
        document.frame_changed.connect(self._show_position)
        document.chain_changed.connect(self._show_position)
        self.queue.changed.connect(self._queue_changed)
        self.clips.chosen.connect(self.open_path)
        self.video.restored.connect(self.show_video_dock)
        self.intervals.activated.connect(self.timeline.visible.zoom_to_interval)
        self.detail.judged.connect(self._judge)
        QApplication.styleHints().colorSchemeChanged.connect(self._scheme_changed)
        self._review_changed()
        self._show_recent()

    def _restore(self) -> None:
        self.resize(1440, 900)
        self.resizeDocks(
            [d for d in self.findChildren(QDockWidget) if d.objectName() == "curves"],
            [330],
            Qt.Orientation.Vertical,
        )
        if self.settings.geometry:
            self.restoreGeometry(QByteArray.fromHex(self.settings.geometry.encode()))
        if self.settings.layout:
            state = QByteArray.fromHex(self.settings.layout.encode())
            self.restoreState(state, _STATE_VERSION)
        self.actions_by_id[f"theme_{self.settings.theme}"].setChecked(True)

    # -- what follows the document ------------------------------------------------------------

    def _review_changed(self) -> None:
        data = self.document.data
        review = self.document.review if data else None
        for name, text in (
            ("undo", review.undo_text if review else ""),
            ("redo", review.redo_text if review else ""),
        ):
            action = self.actions_by_id[name]
            title = name.capitalize()
            wanted = f"{title} {text[0].lower()}{text[1:]}" if text else title
            if (wanted, bool(text)) != (
                action.text(),
                action.isEnabled(),
            ):  # a changed action lays its tool bar out anew
                action.setEnabled(bool(text))
                action.setText(wanted)
                action.setIconText(title)
        if review is not None:
            method = self.actions_by_id[f"use_{review.state.method}"]
            method.blockSignals(True)
            method.setChecked(True)
            method.blockSignals(False)
        title = "Twist Inspector"
        look = " (look only)" if self.document.keeper.read_only else ""
        self.setWindowTitle(f"{data.clip.name}[*]{look} – {title}" if data else title)
        self.setWindowModified(review is not None and not review.saved)
        intervals = self.document.intervals
        decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
        self.decided.setText(f"{decided} of {len(intervals)} decided" if intervals else "")
        self._show_position()

    def _show_position(self) -> None:
        data = self.document.data
        if data is None or not self.document.chain:
            self.position.setText("")
            return
        frame = self.document.frame
        signals = data.signals[self.document.chain]
        off = np.degrees(self.document.offset(self.document.chain)[frame])
        label = self.document.find_chain(self.document.chain).label
        self.position.setText(
            f"{label}   θp {np.degrees(signals.theta_p[frame]):+7.1f}°   "
            f"m {np.degrees(signals.strength[frame]):6.2f}°   offset {off:+7.1f}°"
        )

    def apply_theme(self, theme: themes.Theme) -> None:
        """Colour everything."""
        self.theme = theme
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        themes.apply_theme(app, theme)
        views = (self.viewport, self.timeline, self.clips, self.chains, self.intervals)
        for view in (*views, self.tuning, self.teaching, self.guide, self.video, self.quality):
            view.set_theme(theme)
        if self.five_trackers is not None:
            self.five_trackers.set_theme(theme)

    def close_unasked(self) -> None:
        """Close without a question: decisions that are not saved wait in the journal."""
        self._unasked = True
        self.close()

    # -- Qt events ----------------------------------------------------------------------------

    def changeEvent(self, event: QEvent) -> None:
        """Coming to the front, look what other programs have done to the clip and its lock."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.ActivationChange and self.isActiveWindow():
            self.document.recovery.look_around()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Finish an export, ask about unsaved decisions, keep the layout, let the 3D view go."""
        if not self.exporter.finish() or not self._may_leave():
            event.ignore()
            return
        for task in self.findChildren(Task):
            task.cancel()
        self.player.pause()
        self.recorder.cancel()
        if self.five_trackers is not None:
            self.five_trackers.close()
        self.actions_by_id["presentation"].setChecked(False)  # the layout to keep is the usual one
        self.document.close_clip()
        self.queue.close()
        self.tuning.set_seen(False)
        self.video.let_go()
        self.quality.close_clip()
        self.settings.geometry = bytes(self.saveGeometry().toHex().data()).decode()
        self.settings.layout = bytes(self.saveState(_STATE_VERSION).toHex().data()).decode()
        if self._settings_file is not None:
            trouble = save_settings(self._settings_file, self.settings)
            if trouble:  # the window is going: a terminal may be there to read it
                print(trouble, file=sys.stderr)
        self.viewport.close()
        super().closeEvent(event)
