"""Docks, menus and layout, nothing else: what happens is in the document and the views."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QKeySequence,
    QResizeEvent,
    QShowEvent,
)
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QMenu, QWidget

from inspector.folder.folder_actions import FolderActions
from inspector.folder.queue import FolderQueue
from inspector.language import of_core, tr
from inspector.lessons.guide_card import GuideCard
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.interrupted_review import Aside
from inspector.lessons.lesson_actions import LessonActions
from inspector.panels.chains_panel import ChainsPanel
from inspector.panels.clips_panel import ClipsPanel
from inspector.panels.detail_card import DetailCard
from inspector.panels.history_panel import HistoryPanel
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.panels.position_line import FrameLine, PositionLine
from inspector.panels.reviewer_line import ReviewerLine
from inspector.panels.start_page import StartPage
from inspector.panels.transport import Transport
from inspector.quality.quality_panel import QualityPanel
from inspector.recording.record_actions import RecordActions
from inspector.recording.recorder import Recorder, RecordingBar
from inspector.session.document import Document
from inspector.session.exporter import Exporter
from inspector.session.player import Player
from inspector.session.settings import Settings
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.teaching_panel import TeachingPanel
from inspector.timeline.timeline import Timeline
from inspector.tuning.tuning_actions import TuningActions
from inspector.tuning.tuning_panel import TuningPanel
from inspector.video.video_actions import VideoActions
from inspector.video.video_panel import VideoPanel
from inspector.video.video_reader import SUFFIXES
from inspector.viewport.viewport import Viewport
from inspector.widgets import theme as themes
from inspector.widgets.background import Task
from inspector.widgets.building import Part, bring_to_front, scrolled, vbox
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.native_surface import own_surface
from inspector.widgets.review_keys import ReviewKeys
from inspector.window.action_table import MENUS, OF_A_CLIP, OF_CHAINS, OF_THE_FIGURE
from inspector.window.actions import build_actions, name_step
from inspector.window.chain_actions import ChainActions
from inspector.window.file_actions import FileActions
from inspector.window.parts import Parts
from inspector.window.presentation import Presentation
from inspector.window.program_actions import ProgramActions
from inspector.window.review_actions import ReviewActions
from inspector.window.settings_keeper import SettingsKeeper
from inspector.window.toolbar import ToolBar
from inspector.window.usual_layout import DOCKS, UsualLayout
from twistcore.detection import Interval, Kind
from twistcore.files.encoding import legible
from twistcore.review import Decision

_Area = Qt.DockWidgetArea


class MainWindow(Parts):
    """The program's window."""

    def __init__(self, settings: Settings, settings_file: Path | None) -> None:
        """`settings_file`: where to keep the settings; None: nowhere."""
        super().__init__()
        self.settings = settings
        self._unasked = False  # closing: what is not saved stays in the journal
        self.document = Document(self)
        self.exporter = Exporter(self.document, self)
        self.player = Player(self.document, self)
        self.queue = FolderQueue(parent=self)
        self.recorder = Recorder(self)
        self.setAcceptDrops(True)
        self.setWindowTitle("Twist Inspector")
        self.setDockOptions(self.dockOptions() | QMainWindow.DockOption.AllowNestedDocks)
        self.actions_by_id, self._menus = build_actions(MENUS, self, self.menuBar())
        self.program = ProgramActions(
            self.document, settings, MENUS, self.actions_by_id, self.apply_theme, self
        )
        self.program.take_settings()
        self.docks = {}
        self._build_views(self.program.wanted_theme())
        self._build_docks()
        self._build_bars()
        self._build_features()
        self._connect()
        self.program.colour()  # some views have no colours until they are told
        self._restore()
        self.keys = ReviewKeys(self, self._keyboard_home)
        complain = partial(self.bar.show_message, wrong=True)
        self._kept_settings = SettingsKeeper(settings, settings_file, self._looks, complain, self)
        # At once: after a crash the next start has to know which clip was open.
        self.document.opened.connect(self._kept_settings.write)

    # -- building -----------------------------------------------------------------------------

    def _build_views(self, theme: themes.Theme) -> None:
        document, actions = self.document, self.actions_by_id
        self.bar = MessageBar()
        self.viewport = Viewport(document, theme)
        self.transport = Transport(document, self.player, actions)
        self.reviewer_line = ReviewerLine(document, self.settings)
        figure = self.viewport, 1
        self.setCentralWidget(_column(self.bar, self.reviewer_line, figure, self.transport))
        own_surface(self.viewport)
        self.chains = ChainsPanel(document, theme, actions["joint_names"])
        self.intervals = IntervalsPanel(document, theme, self.settings)
        self.detail = DetailCard(document)
        self.timeline = Timeline(document, theme)
        self.video = VideoPanel(document, theme, self.settings, actions)
        self.clips = ClipsPanel(self.queue, document, theme)
        self.tuning = TuningPanel(document, theme, actions, self.settings)
        self.taught = TaughtFrame(document, self)
        shown = [actions[name] for name in ("tour", "exercise", "record_dialog")]
        self.teaching = TeachingPanel(self.taught, self.viewport, self.timeline, shown)
        self.guide = GuideCard(self.teaching.typesetter)
        self.quality = QualityPanel(document, theme, actions)
        self.viewport.accompany(self.quality.tracked)

    def _build_docks(self) -> None:
        right = _column((self.intervals, 1), self.detail)
        self._dock("curves", self.timeline, _Area.BottomDockWidgetArea)
        self._dock("video", self.video, _Area.BottomDockWidgetArea).hide()
        self._dock("clips", self.clips, _Area.LeftDockWidgetArea).hide()
        self._dock("chains", self.chains, _Area.LeftDockWidgetArea)
        intervals = self._dock("intervals", scrolled(right), _Area.RightDockWidgetArea)
        self._dock("history", HistoryPanel(self.document), _Area.RightDockWidgetArea)
        tuning = self._dock("tuning", scrolled(self.tuning), _Area.RightDockWidgetArea)
        taught = scrolled(self.teaching)
        self.teaching.least_width.connect(taught.setMinimumWidth)
        teaching = self._dock("teaching", taught, _Area.RightDockWidgetArea)
        self._dock("guide", self.guide, _Area.LeftDockWidgetArea).hide()
        quality = self._dock("quality", scrolled(self.quality), _Area.RightDockWidgetArea)
        for tab in (self.docks["history"], tuning, teaching, quality):
            self.tabifyDockWidget(intervals, tab)
        tuning.visibilityChanged.connect(self.tuning.set_seen)
        teaching.visibilityChanged.connect(self.teaching.set_shown)
        quality.visibilityChanged.connect(self.quality.set_seen)
        intervals.raise_()

    def _dock(self, name: str, content: QWidget, area: _Area) -> QDockWidget:
        dock = self.docks[name] = QDockWidget(DOCKS[name], self)
        dock.setObjectName(name)
        dock.setWidget(content)
        self.addDockWidget(area, dock)
        return dock

    def _build_bars(self) -> None:
        self.tools = ToolBar(self.actions_by_id)
        self.addToolBar(self.tools)
        view = self._menus["View"]
        view.addSeparator()
        for dock in self.docks.values():
            view.addAction(dock.toggleViewAction())
        self.recent_menu = QMenu(tr("Recent"), self)
        self._menus["File"].insertMenu(self.actions_by_id["save_session"], self.recent_menu)
        self.statusBar().addWidget(FrameLine(self.document), 1)
        self.position = PositionLine(self.document)
        self.decided = SteadyLabel()
        for widget in (RecordingBar(self.recorder), self.position, self.decided):
            self.statusBar().addPermanentWidget(widget)

    def _build_features(self) -> None:
        """What actions do, and the actions' way to it."""
        document, actions, docks, bar = self.document, self.actions_by_id, self.docks, self.bar
        self.presentation = Presentation(self, docks, self.viewport, self.timeline)
        program = GuidedProgram(
            document=document,
            taught=self.taught,
            viewport=self.viewport,
            settings=self.settings,
            guide=self.guide,
            aside=Aside(document),
            actions=actions,
            list_all=self.intervals.list_all,
            show_intervals=docks["intervals"].raise_,
            show_teaching=partial(bring_to_front, docks["teaching"]),
        )
        self.lesson_actions = LessonActions(program, docks["guide"], docks["chains"], self)
        self.files = FileActions(
            document=document,
            settings=self.settings,
            queue=self.queue,
            bar=bar,
            detail=self.detail,
            lessons=self.lesson_actions,
            tell_saved=self._review_changed,
            window=self,
            exporter=self.exporter,
            clips_dock=docks["clips"],
            recent_menu=self.recent_menu,
            cancel=actions["cancel_opening"],
            begin=lambda: self.review_actions.begin(),
        )
        look = actions["focus_chain"].trigger
        self.review_actions = ReviewActions(
            document, self.intervals, bar, self.detail, self.timeline.visible, self.player,
            self.settings, partial(bring_to_front, docks["intervals"]), self._key,
            lambda: len(self.queue.clips) > 1, look, self.viewport.sees_chain, self,
        )  # fmt: skip
        self.chain_actions = ChainActions(document, bar, docks["chains"], self)
        self.chains.table.addActions([actions[name] for name in OF_CHAINS])
        self.chains.table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.tuning_actions = TuningActions(
            document, self.queue, bar, self.tuning, docks["tuning"], self
        )
        self.record_actions = RecordActions(
            document, self.recorder, self.viewport, self.timeline, self.taught,
            self.teaching.typesetter, bar, self,
        )  # fmt: skip
        self.video_actions = VideoActions(document, self.video, docks["video"], self)
        save = self.files.save_quietly
        self.folder_actions = FolderActions(self.queue, self.clips.listed, bar, save, self)
        for spec in (spec for menu in MENUS.values() for spec in menu if spec is not None):
            spec.connect(actions[spec.id], self)
        complaint = "" if self.viewport.view is not None else self.viewport.overlays.notice.text()
        self.start_page = StartPage(self.viewport, actions, self.open_path, complaint)
        self._offer_what_can_be_done()

    def _connect(self) -> None:
        document, actions = self.document, self.actions_by_id
        document.message.connect(self.bar.show_message)
        document.question.connect(self.bar.ask)
        document.withdrawn.connect(self.bar.clear)
        document.message.connect(self.statusBar().clearMessage)
        document.opened.connect(self._review_changed)
        document.opened.connect(self._offer_what_can_be_done)
        document.intervals_changed.connect(self._review_changed)
        self.clips.chosen.connect(self.open_path)
        self.video.restored.connect(self.video_actions.show_dock)
        self.intervals.activated.connect(self.timeline.visible.zoom_to_interval)
        self.detail.judged.connect(self.review_actions.judge)
        self.detail.end_turned.connect(self.review_actions.turn_end)
        self.detail.quality_asked.connect(self._show_in_quality)
        self.teaching.moved_far.connect(actions["focus_chain"].trigger)
        self.presentation.escaped.connect(lambda: actions["presentation"].setChecked(False))
        self.timeline.toggles["other"].toggled.connect(actions["both_detectors"].setChecked)
        QApplication.styleHints().colorSchemeChanged.connect(self._scheme_changed)
        self._review_changed()

    def _restore(self) -> None:
        self.usual_layout = UsualLayout(self, self.docks, (self.intervals, self.detail))
        self.usual_layout.restore(self.settings.geometry, self.settings.layout)
        for chosen in (f"theme_{self.settings.theme}", f"order_{self.settings.order}"):
            self.actions_by_id[chosen].setChecked(True)
        self.actions_by_id["zoom_each"].setChecked(self.settings.zoom_to_interval)

    def _key(self, name: str) -> str:
        native = QKeySequence.SequenceFormat.NativeText
        return self.actions_by_id[name].shortcut().toString(native)

    def _keyboard_home(self) -> QWidget:
        table = self.intervals.table
        return self if table.visibleRegion().isEmpty() else table

    def _looks(self) -> tuple[str, str] | None:
        """Geometry and layout, as a person has them when nothing is presented."""
        if self.actions_by_id["presentation"].isChecked():
            return None
        return self.usual_layout.kept(self.settings.geometry)

    def _show_in_quality(self, interval: Interval) -> None:
        """Open the quality tab for a fault of the capture: its joints, and its first frame."""
        if not interval.start <= self.document.frame < interval.stop:
            self.document.go_to(interval.start)
        joints = (interval.evidence or {}).get("joints", (interval.joint,))
        bring_to_front(self.docks["quality"])
        self.quality.show_joints(joints, track=interval.kind == Kind.NOISE_BURST)

    # -- what is asked of it ------------------------------------------------------------------

    def open_path(self, path: Path) -> None:
        """Open a clip, a session or a folder."""
        self.files.open_path(path)

    def apply_theme(self, theme: themes.Theme) -> None:
        """Colour everything."""
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        themes.apply_theme(app, theme)
        views = (self.viewport, self.timeline, self.clips, self.chains, self.intervals, self.tools)
        more = (self.tuning, self.teaching, self.guide, self.video, self.quality, self.start_page)
        for view in (*views, *more):
            view.set_theme(theme)
        if (trackers := self.lesson_actions.five_trackers) is not None:
            trackers.set_theme(theme)

    def _scheme_changed(self) -> None:  # of the window: Qt disconnects it when it goes
        self.program.colour()

    def close_unasked(self) -> None:
        """Close without a question: decisions that are not saved wait in the journal."""
        self._unasked = True
        self.close()

    # -- what follows the document ------------------------------------------------------------

    def _offer_what_can_be_done(self) -> None:
        """Actions without anything to work on cannot be pressed; a page says how to begin."""
        is_open = self.document.data is not None
        for name in {*OF_A_CLIP, *OF_THE_FIGURE}:
            lacking = (name in OF_A_CLIP and not is_open) or (
                name in OF_THE_FIGURE and self.viewport.view is None
            )
            self.actions_by_id[name].setEnabled(not lacking)
        self.start_page.setVisible(not is_open)
        self.start_page.show_recent(self.settings.recent)

    def _review_changed(self) -> None:
        data = self.document.data
        review = self.document.review if data else None
        texts = (review.undo_text, review.redo_text) if review else ("", "")
        for name, text in zip(("undo", "redo"), texts, strict=True):
            title = {"undo": tr("Undo"), "redo": tr("Redo")}[name]
            name_step(self.actions_by_id[name], title, of_core(text))
        if review is not None:
            self.actions_by_id[f"use_{review.state.method}"].setChecked(True)
        title = "Twist Inspector"
        look = tr(" (look only)") if self.document.keeper.read_only else ""
        name = legible(data.clip.name).replace("[*]", "[*][*]") if data else ""  # twice is once
        self.setWindowTitle(f"{name}[*]{look} – {title}" if data else title)
        waits = review is not None and not review.saved and self.document.borrowed is None
        self.setWindowModified(waits)
        intervals = self.document.intervals
        decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
        told = tr("{done} of {total} decided", done=decided, total=len(intervals))
        if not intervals:
            told = tr("not examined") if data and data.analysis.not_examined else ""
        self.decided.setText(told)

    # -- Qt events ----------------------------------------------------------------------------

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Panels that nobody has sized keep their share of the window."""
        super().resizeEvent(event)
        self.usual_layout.follow()

    def showEvent(self, event: QShowEvent) -> None:
        """Panels that float come after the window: shown before, they would lie behind it."""
        super().showEvent(event)
        self.usual_layout.window_shown()

    def changeEvent(self, event: QEvent) -> None:
        """Coming to the front, look what other programs have done to the clip and its lock."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.ActivationChange and self.isActiveWindow():
            self.document.recovery.look_around()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """A file may be dropped."""
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the first file that was dropped; a video goes beside the present clip."""
        files = [u.toLocalFile() for u in event.mimeData().urls() if u.isLocalFile()]
        if files:
            event.acceptProposedAction()
            path = Path(files[0])
            video = path.suffix.lower() in SUFFIXES
            self.video_actions.show_video(path) if video else self.open_path(path)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Finish an export, ask about unsaved decisions, keep the layout, let the 3D view go."""
        self.files.closing = True
        if not self.exporter.finish() or not self.files.may_close(ask=not self._unasked):
            self.files.closing = False
            event.ignore()
            return
        for task in self.findChildren(Task):
            task.cancel()
        self.player.pause()
        self.recorder.cancel()
        if (trackers := self.lesson_actions.five_trackers) is not None:
            trackers.close()
        self.program.close_guide()
        self.actions_by_id["presentation"].setChecked(False)  # the layout to keep is the usual one
        self.document.close_clip()
        self.queue.close()
        self.tuning.set_seen(False)
        self.video.let_go()
        self.quality.close_clip()
        if trouble := self._kept_settings.end():  # the window is going: a terminal may be there
            print(legible(trouble), file=sys.stderr)
        self.viewport.close()
        super().closeEvent(event)


def _column(*parts: Part) -> QWidget:
    """Widgets under one another without gaps."""
    column = QWidget()
    vbox(*parts, owner=column, margins=(0, 0, 0, 0), spacing=0)
    return column
