"""The actions of the Teach menu."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QKeySequence, QShortcut
from PySide6.QtWidgets import QApplication, QDockWidget, QMenu

from inspector.bundled import EXERCISES, LESSONS, TOUR
from inspector.feature import HostWindow
from inspector.language import tr, translated_page_path
from inspector.lessons.guided_exercise import Exercise
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.lesson_file import LessonFile, read_lesson
from inspector.lessons.lesson_place import lesson_place_settings
from inspector.lessons.lesson_player import LessonPlayer
from inspector.lessons.page_export import PageExport
from inspector.lessons.scene_of_page import current_lesson_place
from inspector.teaching.five_trackers_dialog import FiveTrackers
from inspector.widgets.building import bring_to_front
from inspector.widgets.file_dialog import ask_files
from inspector.widgets.labels import escape_menu_text
from twistcore.errors import TwistError

_GUIDE_WIDTH = 330  # pixels


@dataclass(eq=False)
class LessonActions:
    """The actions that start lessons and exercises and open the window "Why quaternions".

    Attributes
    ----------
    dock
        The dock with the guide card, which shows the pages of lessons.
    """

    program: GuidedProgram
    dock: QDockWidget
    window: HostWindow

    def __post_init__(self) -> None:
        self.five_trackers: FiveTrackers | None = None
        self._title = ""
        self._lesson: LessonFile | None = None  # the lesson that was started last
        self._taught_before = False  # True if the teaching tab was in front before the lesson
        self._list_as_before: Callable[[], None] | None = None  # restores the user's filter
        self.player = LessonPlayer(self.program, self.window)
        self.hidden_errors = Exercise(self.program, EXERCISES, self.window)
        self.page_export = PageExport(self.window, self.program.document.message.emit)
        self.dock.toggleViewAction().setEnabled(False)
        self._add_menu()
        self._add_page_keys()
        self.player.began.connect(lambda: self._show_guide(self._title))
        self.player.ended.connect(self._close_guide)
        self.player.finished.connect(self._offer_next)
        for signal in (self.player.turned, self.dock.visibilityChanged):
            signal.connect(self._dim)
        self.hidden_errors.ended.connect(self._close_guide)
        self.program.guide.linked.connect(self.hidden_errors.go_to)

    def _dim(self) -> None:
        """Dim parts of the window for the current page, unless the guide card is closed."""
        self.player.dim(on=not self.dock.isHidden())

    def _add_menu(self) -> None:
        """Add a menu with the lessons that are shipped with the program.

        The menu is filled when it is opened for the first time.
        """
        self.lessons_menu = QMenu(tr("Lessons"), self.window)
        below = self.program.actions["open_lesson"]
        for menu in self.window.menuBar().findChildren(QMenu):
            if below in menu.actions():
                menu.insertMenu(below, self.lessons_menu)
        self.lessons_menu.aboutToShow.connect(self._fill_menu)

    def _add_page_keys(self) -> None:
        """Let Page Down and Page Up turn the pages of a lesson in a presentation."""
        for key, button in (
            (Qt.Key.Key_PageDown, self.player.forward),
            (Qt.Key.Key_PageUp, self.player.back),
        ):
            turn = QShortcut(QKeySequence(key), self.window, enabled=False)
            turn.setContext(Qt.ShortcutContext.ApplicationShortcut)  # also in a floating panel
            turn.activated.connect(button.click)
            self.program.actions["presentation"].toggled.connect(turn.setEnabled)

    def _fill_menu(self) -> None:
        if not self.lessons_menu.isEmpty():
            return
        for path in sorted(LESSONS.glob("*.md")):
            if path != TOUR:
                own = translated_page_path(path)
                action = QAction(read_lesson(own).title, self.lessons_menu)
                action.triggered.connect(lambda _=False, p=own: self.play(p))
                self.lessons_menu.addAction(action)

    @property
    def on(self) -> bool:
        """Return True while a lesson or an exercise is running and its page is visible."""
        return (self.player.running or self.hidden_errors.running) and not self.dock.isHidden()

    def tour(self) -> None:
        """Start the guided tour."""
        self.play(translated_page_path(TOUR))

    def open_lesson(self) -> None:
        """Ask for a lesson file, and start the lesson."""
        pattern = tr("Lessons (*.md)")
        ask_files(self.window, tr("Open lesson"), pattern, lambda paths: self.play(paths[0]))

    def play(self, path: Path) -> None:
        """Start a lesson. If the file cannot be read, only show the reason."""
        try:
            lesson = read_lesson(path)
        except TwistError as error:
            self.program.document.message.emit(str(error), True)
        else:
            self.hidden_errors.before_leaving(partial(self._play, lesson))

    def _play(self, lesson: LessonFile) -> None:
        self.leave_guide()
        self.window.statusBar().showMessage(f"{lesson.title} …")
        self._title, self._lesson = lesson.title, lesson
        self.player.begin(lesson, self._refuse)

    def _offer_next(self) -> None:
        """Offer the next lesson and the exercise, in a message that disappears after a while."""
        assert self._lesson is not None
        lessons = [TOUR, *(path for path in sorted(LESSONS.glob("*.md")) if path != TOUR)]
        names = [path.name for path in lessons]
        name = self._lesson.path.name
        text = tr("'{title}' is finished. What next?", title=self._lesson.title)
        answers: list[tuple[str, Callable[[], object]]] = [(tr("Exercise"), self.exercise)]
        following = names.index(name) + 1 if name in names else len(names)
        if following < len(lessons):
            own = translated_page_path(lessons[following])
            answers.insert(0, (read_lesson(own).title, partial(self.play, own)))
        self.window.bar.offer(text, tuple(answers))

    def _refuse(self, error: Exception) -> None:
        """End the lesson, and show why it could not be started."""
        self.window.statusBar().clearMessage()
        self.player.end()
        self.program.document.message.emit(str(error), True)

    def export_page(self) -> None:
        """Write the current lesson or, if none is running, a chosen lesson as a web page."""
        self.page_export.ask(self._lesson if self.player.running else None)

    def copy_place(self) -> None:
        """Copy the current frame, chain and view to the clipboard as settings of a lesson page."""
        place, message = current_lesson_place(self.program), self.program.document.message
        if place is None:
            message.emit(tr("Open a clip first."), False)
            return
        QApplication.clipboard().setText(f"{lesson_place_settings(place)}\n")
        message.emit(tr("Copied. Paste the settings into a page of your lesson file."), False)

    def exercise(self) -> None:
        """Start an exercise."""

        def begin() -> None:
            self.leave_guide()
            self._show_guide(tr("Exercise"))
            self.hidden_errors.begin()

        self.hidden_errors.before_leaving(begin)

    def why_quaternions(self) -> None:
        """Show the window in which five tracking filters follow a joint through ±180°."""
        if self.five_trackers is None:
            self.five_trackers = FiveTrackers(self.window.colours, self.window)
        bring_to_front(self.five_trackers)
        self.five_trackers.activateWindow()

    def leave_guide(self) -> None:
        """End the lesson or exercise without asking, and show the user's own clip again."""
        if self.player.running:
            self.player.end()
        if self.hidden_errors.running:
            self.hidden_errors.end()

    def _show_guide(self, title: str) -> None:
        self._list_as_before = self.program.list_all()  # a page may refer to any interval
        self._taught_before = self.program.taught.active
        self.dock.setWindowTitle(escape_menu_text(title))
        self.dock.toggleViewAction().setEnabled(True)
        bring_to_front(self.dock)
        self.window.statusBar().clearMessage()
        self.window.resizeDocks([self.dock], [_GUIDE_WIDTH], Qt.Orientation.Horizontal)

    def _close_guide(self) -> None:
        self.dock.hide()
        self.dock.toggleViewAction().setEnabled(False)
        if self._list_as_before is not None:
            self._list_as_before()
            self._list_as_before = None
            if self.program.taught.active and not self._taught_before:
                self.program.show_intervals()
        self.program.aside.put_back()
