"""What the actions of teaching do: methods of the main window, by the actions' ids."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

from inspector.bundled import EXERCISES, SAMPLE
from inspector.recording.record_dialog import RecordDialog
from inspector.recording.recorder import RecordChoice, Recorder, RecordingBar, save_picture
from inspector.recording.stage import Stage
from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.teaching.five_trackers_dialog import FiveTrackers
from inspector.teaching.guide_card import GuideCard
from inspector.teaching.guided_exercise import Exercise
from inspector.teaching.interrupted_review import Aside
from inspector.teaching.lesson import Lesson
from inspector.teaching.teaching_panel import TeachingPanel
from inspector.teaching.tour import Tour
from inspector.timeline.timeline import Timeline
from inspector.viewport.viewport import Viewport
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.theme import Theme

_GUIDE_WIDTH = 345  # pixels


class TeachActions(QMainWindow):
    """The teaching tab, the tour, the exercise, recording."""

    document: Document
    viewport: Viewport
    timeline: Timeline
    actions_by_id: Mapping[str, QAction]
    settings: Settings
    theme: Theme
    bar: MessageBar
    five_trackers: FiveTrackers | None = None

    def _dock(self, title: str, content: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        raise NotImplementedError

    def _build_teaching(self, intervals: QDockWidget, beside: QDockWidget) -> None:
        """The tab, behind another one, and the guide's card, hidden until it leads."""
        self.intervals_dock = intervals
        self.lesson = Lesson(self.document, self)
        shown = [self.actions_by_id[name] for name in ("tour", "exercise", "record_dialog")]
        self.teaching = TeachingPanel(self.lesson, self.viewport, self.timeline, shown)
        self.teaching_dock = self._dock(
            "Teaching", self.teaching, Qt.DockWidgetArea.RightDockWidgetArea
        )
        self.tabifyDockWidget(beside, self.teaching_dock)
        self.aside = Aside(self.document)
        self.guide = GuideCard()
        self.guide_dock = self._dock("Guide", self.guide, Qt.DockWidgetArea.LeftDockWidgetArea)
        self.guide_dock.hide()
        self.guided_tour = Tour(self, SAMPLE)
        self.hidden_errors = Exercise(self, EXERCISES)
        self.guided_tour.ended.connect(self._led)
        self.hidden_errors.ended.connect(self._led)
        self.guide.linked.connect(self.hidden_errors.go_to)
        self.recorder = Recorder(self)
        self.recorder.finished.connect(self._recorded)
        self.recorder.failed.connect(self._not_recorded)
        self.statusBar().addPermanentWidget(RecordingBar(self.recorder))
        self.teaching_dock.visibilityChanged.connect(self.teaching.set_shown)
        self.teaching.moved_far.connect(lambda: self.viewport.focus_chain(self.settings.turn_ms))

    def show_teaching(self) -> None:
        """Bring the teaching tab to the front."""
        self.teaching_dock.show()
        self.teaching_dock.raise_()

    def tour(self) -> None:
        """Begin the guided tour."""
        self.leave_guide()
        self._lead("Tour")
        self.guided_tour.begin()

    def exercise(self) -> None:
        """Begin an exercise."""
        self.leave_guide()
        self._lead("Exercise")
        self.hidden_errors.begin()

    def why_quaternions(self) -> None:
        """One joint through ±180° with five trackers, in a window of its own."""
        if self.five_trackers is None:
            self.five_trackers = FiveTrackers(self.theme, self)
        self.five_trackers.set_theme(self.theme)
        self.five_trackers.show()
        self.five_trackers.raise_()
        self.five_trackers.activateWindow()

    def leave_guide(self) -> None:
        """End tour and exercise; the person's own clip comes back as it was."""
        if self.guided_tour.running:
            self.guided_tour.end()
        if self.hidden_errors.running:
            self.hidden_errors.end()

    def record_dialog(self) -> None:
        """Ask what to record, and record it."""
        if self.document.data is None:
            self.bar.show_message("Open a clip first.", False)
        elif self.recorder.running:
            self.bar.show_message("A film is being made; wait for it or cancel it.", False)
        else:
            dialog = RecordDialog(self.document, self.timeline.visible.ends, self)
            dialog.accepted.connect(lambda: self.record(dialog.choice()))
            dialog.open()

    def record(self, choice: RecordChoice) -> None:
        """Make a film in the background of what goes on, or a picture at once."""
        if choice.path.exists() and not choice.replace:
            self.bar.show_message(f"{choice.path}: there is such a file already.", True)
            return
        if self.viewport.view is None:
            self.bar.show_message("Without the 3D view there is nothing to record.", True)
            return
        stage = Stage(
            self.lesson,
            self.viewport,
            self.teaching.typesetter,
            self.theme,
            QSize(*choice.size),
            curves=choice.curves,
        )
        if choice.film:
            self.recorder.start(stage, choice)
            return
        try:
            save_picture(stage, choice, self.document.frame)
            self.bar.show_message(f"{choice.path.name} written.", False)
        except OSError as error:
            self.bar.show_message(f"{choice.path}: not written ({error.strerror}).", True)
        finally:
            stage.strike()

    def _recorded(self, path: Path) -> None:
        self.bar.show_message(f"{path.name} written.", False)

    def _not_recorded(self, why: str) -> None:
        if why:
            self.bar.show_message(why, True)

    def _lead(self, title: str) -> None:
        self.guide_dock.setWindowTitle(title)
        self.guide_dock.show()
        self.guide_dock.raise_()
        chains = self.findChild(QDockWidget, "chains")
        if chains is not None:
            self.resizeDocks([chains, self.guide_dock], [1, 3], Qt.Orientation.Vertical)
        self.resizeDocks([self.guide_dock], [_GUIDE_WIDTH], Qt.Orientation.Horizontal)

    def _led(self) -> None:
        self.guide_dock.hide()
        self.aside.put_back()
