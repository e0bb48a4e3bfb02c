"""Docks, menus and layout, nothing else: what happens is in the document and the views."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtCore import QByteArray, Qt
from PySide6.QtGui import QAction, QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QFileDialog,
    QMainWindow,
    QMenu,
    QMessageBox,
    QTextBrowser,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from inspector import theme as themes
from inspector.actions import build_actions, shortcuts_markdown
from inspector.bundled import SAMPLE
from inspector.document import Document
from inspector.export import ExportChoice, ExportDialog
from inspector.exporter import Exporter
from inspector.folder import FolderQueue
from inspector.go_actions import GoActions
from inspector.keeping import SESSION_SUFFIX
from inspector.message_bar import MessageBar
from inspector.palette import CommandPalette
from inspector.panels import (
    ChainsPanel,
    ClipsPanel,
    DetailCard,
    HistoryPanel,
    IntervalsPanel,
    Transport,
)
from inspector.playback import Player
from inspector.plots import Timeline
from inspector.preferences import Preferences, apply_keys
from inspector.presentation import Presentation
from inspector.quality import QualityActions
from inspector.review_actions import ReviewActions
from inspector.settings import Settings, save_settings
from inspector.steady import SteadyLabel
from inspector.teaching.actions import TeachActions
from inspector.tuning import TuningActions, TuningPanel
from inspector.video.actions import VideoActions
from inspector.video.panel import VideoPanel
from inspector.video.reader import SUFFIXES
from inspector.view_actions import OF_THE_FIGURE, ViewActions
from inspector.viewport import Viewport
from twistcore import __version__
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
    VideoActions,
    QualityActions,
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
        self._wait_for_first = False
        self.theme = self._wanted_theme()
        self.setAcceptDrops(True)
        self.setWindowTitle("Twist Inspector")
        self.setDockOptions(self.dockOptions() | QMainWindow.DockOption.AllowNestedDocks)
        self.actions_by_id, self._menus = build_actions(self, self.menuBar())
        apply_keys(self.actions_by_id, settings)
        self._build()
        self._connect()
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
        self._build_quality(self.teaching_dock)
        rest.raise_()
        self.resizeDocks([left, rest], [_LEFT_WIDTH, _RIGHT_WIDTH], Qt.Orientation.Horizontal)
        for name in OF_THE_FIGURE:
            self.actions_by_id[name].setEnabled(self.viewport.view is not None)
        self.presenting = Presentation(self, self.viewport, self.timeline, _PRESENTED)
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
        document.locate.connect(self.locate_clip)
        document.opening.connect(self._opening)
        document.message.connect(lambda *_: self.statusBar().clearMessage())
        document.opened.connect(self._opened)
        document.intervals_changed.connect(self._review_changed)
        document.frame_changed.connect(self._show_position)
        document.chain_changed.connect(self._show_position)
        self.queue.changed.connect(self._queue_changed)
        self.clips.chosen.connect(self.open_path)
        self.video.restored.connect(self.show_video_dock)
        self.intervals.activated.connect(self.timeline.zoom_to_interval)
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

    # -- opening and saving -------------------------------------------------------------------

    def open_path(self, path: Path) -> None:
        """Open a clip or a session."""
        if not self._may_leave():
            return
        if path.is_dir():
            self.open_queue(path)
        elif path.name.endswith(".json"):
            self.document.open_session(path)
        else:
            self.document.open(path, self.queue.profile if path in self.queue.clips else None)

    def open_dialog(self) -> None:
        """Ask for a file and open it."""
        patterns = f"Motion and sessions (*.bvh *{SESSION_SUFFIX})"
        dialog = QFileDialog(self, "Open", "", f"{patterns};;All files (*)")
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.fileSelected.connect(lambda name: self.open_path(Path(name)))
        dialog.open()

    def open_folder(self) -> None:
        """Ask for a folder and queue its clips."""
        name = QFileDialog.getExistingDirectory(self, "Open folder")
        if name:
            self.open_path(Path(name))

    def open_queue(self, folder: Path) -> None:
        """Analyse the clips of a folder in the background; the first that is ready opens."""
        self.queue.open(folder)
        self.clips_dock.show()
        if not self.queue.clips:
            self.bar.show_message(f"{folder}: no BVH in this folder yet; it is watched.", False)
        self._wait_for_first = True

    def _queue_changed(self) -> None:
        if self._wait_for_first and (path := self.queue.next_after(None)):
            self._wait_for_first = False
            self.open_path(path)

    def next_clip(self) -> None:
        """Open the worst clip that is not decided."""
        data = self.document.data
        path = self.queue.next_after(data.clip.path if data else None)
        if path is None:
            self.bar.show_message("No other clip of the folder waits for a decision.", False)
        else:
            self.open_path(path)

    def open_sample(self) -> None:
        """Open the bundled walk with known errors."""
        self.open_path(SAMPLE)

    def save_session(self) -> bool:
        """Write the session beside the clip; True if it is on disk."""
        self.detail.commit()
        if trouble := self.document.keeper.save():
            self.bar.show_message(trouble, True)
            return False
        self._review_changed()
        if self.document.data is not None:
            self.queue.refresh(self.document.data.clip.path)
        if path := self.document.keeper.session_file:
            self.statusBar().showMessage(f"Saved {path.name}", 4000)
        return True

    def locate_clip(self, session: Path) -> None:
        """Ask where the clip of a session went, and open both."""
        name, _ = QFileDialog.getOpenFileName(self, "Locate the clip", str(session.parent), "*.bvh")
        if name:
            self.document.open_session(session, Path(name))

    def export_dialog(self) -> None:
        """Ask where to and export."""
        if self.document.data is None:
            self.bar.show_message("Open a clip first.", False)
            return
        dialog = ExportDialog(self.document, self)
        dialog.accepted.connect(lambda: self.export(dialog.choice()))
        dialog.open()

    def export(self, choice: ExportChoice) -> None:
        """Write what was chosen in the background; the message bar says what changed."""
        self.detail.commit()
        self.exporter.start(choice)

    def _opening(self, name: str) -> None:
        self.bar.hide()
        self.statusBar().showMessage(f"Opening {name} …")

    def _opened(self) -> None:
        data = self.document.data
        assert data is not None
        if not self.aside.open:
            self.settings.remember(data.clip.path)
        self._show_recent()
        motion = data.motion
        self.statusBar().showMessage(
            f"{data.clip.name}: {motion.frames} frames at {motion.fps:.4g} fps, "
            f"{len(motion.skeleton)} joints",
            8000,
        )
        self._review_changed()

    def _may_leave(self) -> bool:
        """True once unsaved decisions are saved or knowingly given up."""
        self.leave_guide()
        self.detail.commit()
        if self.document.data is None or self.document.review.saved:
            return True
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self,
            "Twist Inspector",
            f"{self.document.data.clip.name} has decisions that are not saved.",
            button.Save | button.Discard | button.Cancel,
            button.Save,
        )
        if answer == button.Save:
            return self.save_session()
        if answer == button.Discard:
            self.document.keeper.give_up()
        return answer == button.Discard

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
        self.setWindowTitle(f"{data.clip.name}[*] – {title}" if data else title)
        self.setWindowModified(review is not None and not review.saved)
        intervals = self.document.intervals
        decided = sum(j.decision != Decision.UNDECIDED for j in intervals)
        self.decided.setText(f"{decided} of {len(intervals)} decided" if intervals else "")
        self._show_position()

    def follow_root(self, on: bool) -> None:
        """Let the camera go along with the root."""
        self.viewport.set_follow(on)

    def view_iso(self) -> None:
        """Three-quarter view."""
        self.viewport.set_view("iso")

    def view_front(self) -> None:
        """From the front."""
        self.viewport.set_view("front")

    def view_side(self) -> None:
        """From the side."""
        self.viewport.set_view("side")

    def view_back(self) -> None:
        """From behind."""
        self.viewport.set_view("back")

    def view_top(self) -> None:
        """From above."""
        self.viewport.set_view("top")

    def zoom_to_interval(self) -> None:
        """Plots: the selected interval."""
        self.timeline.zoom_to_interval()

    def show_all(self) -> None:
        """Plots: the whole clip."""
        self.timeline.show_all()

    def both_detectors(self, on: bool) -> None:
        """The other detector's plot, or not."""
        self.timeline.toggles["other"].setChecked(on)

    def presentation(self, on: bool) -> None:
        """Large type, figure and curves; or the window as it was."""
        self.presenting.enter() if on else self.presenting.leave()

    def full_screen(self, on: bool) -> None:
        """Full screen or not."""
        self.showFullScreen() if on else self.showNormal()

    # -- looks and help -----------------------------------------------------------------------

    def theme_system(self, on: bool) -> None:
        """Colours as the system has them."""
        self._choose_theme("system", on)

    def theme_light(self, on: bool) -> None:
        """Light colours."""
        self._choose_theme("light", on)

    def theme_dark(self, on: bool) -> None:
        """Dark colours."""
        self._choose_theme("dark", on)

    def _choose_theme(self, name: str, on: bool) -> None:
        if on:
            self.settings.theme = name
            self.apply_theme(self._wanted_theme())

    def _scheme_changed(self) -> None:
        self.apply_theme(self._wanted_theme())

    def _wanted_theme(self) -> themes.Theme:
        fixed = {"light": themes.LIGHT, "dark": themes.DARK}
        return fixed.get(self.settings.theme) or themes.system_theme()

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

    def _take_settings(self) -> None:
        self.document.reviewer = self.settings.reviewer
        self.document.set_first_frame(self.settings.first_frame)

    def preferences(self) -> None:
        """Reviewer, how frames are counted, keys."""
        dialog = Preferences(self.settings, self)
        dialog.accepted.connect(lambda: self._preferred(dialog))
        dialog.open()

    def _preferred(self, dialog: Preferences) -> None:
        dialog.take(self.settings)
        self._take_settings()
        apply_keys(self.actions_by_id, self.settings)

    def command_palette(self) -> None:
        """Any action by a part of its name."""
        palette = CommandPalette(self.actions_by_id, self)
        palette.show()
        palette.line.setFocus()

    def show_shortcuts(self) -> None:
        """Keys and mouse in a window of their own."""
        page = QTextBrowser(self)
        page.setWindowFlag(Qt.WindowType.Tool)
        page.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        page.setWindowTitle("Keyboard and mouse")
        page.setMarkdown(shortcuts_markdown())
        page.resize(520, 640)
        page.show()

    def show_about(self) -> None:
        """Version, method and data."""
        QMessageBox.about(
            self,
            "Twist Inspector",
            f"<b>Twist Inspector {__version__}</b><p>Finds intervals in which a joint and its "
            "child twist against each other, after Choi, Jang and Kim, J. Sens. Sci. Technol. "
            "35(1), 2026.</p><p>Sample data obtained from mocap.cs.cmu.edu, created with funding "
            "from NSF EIA-0196217.</p>",
        )

    def _show_recent(self) -> None:
        self.recent_menu.clear()
        for name in self.settings.recent:
            # Made here, not by addAction(text): its answer may be taken for an object long deleted.
            action = QAction(name, self.recent_menu)
            action.triggered.connect(lambda _=False, n=name: self.open_path(Path(n)))
            self.recent_menu.addAction(action)
        self.recent_menu.setEnabled(bool(self.settings.recent))

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

    # -- Qt events ----------------------------------------------------------------------------

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
            self.show_video(path) if video else self.open_path(path)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Escape ends a presentation."""
        if event.key() == Qt.Key.Key_Escape and self.presenting.on:
            self.actions_by_id["presentation"].setChecked(False)
            return
        super().keyPressEvent(event)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Finish an export, ask about unsaved decisions, keep the layout, let the 3D view go."""
        if not self.exporter.finish() or not self._may_leave():
            event.ignore()
            return
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
            save_settings(self._settings_file, self.settings)
        self.viewport.close()
        super().closeEvent(event)
