"""What the actions of teaching do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow

from inspector.bundled import EXERCISES, FLIPPED, SAMPLE
from inspector.lessons.guided_exercise import Exercise
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.tour import Tour
from inspector.teaching.five_trackers_dialog import FiveTrackers
from inspector.widgets.building import bring_to_front

_GUIDE_WIDTH = 345  # pixels


@dataclass(eq=False)
class LessonActions:
    """The tour, the exercise and the five trackers.

    dock: the guide's, shown while it leads, below the one `above`.
    """

    program: GuidedProgram
    dock: QDockWidget
    above: QDockWidget
    window: QMainWindow

    def __post_init__(self) -> None:
        self.five_trackers: FiveTrackers | None = None
        self._list_as_before: Callable[[], None] | None = None  # by the person's own filter
        self.guided_tour = Tour(self.program, SAMPLE, FLIPPED, self.window)
        self.hidden_errors = Exercise(self.program, EXERCISES, self.window)
        self.guided_tour.ended.connect(self._led)
        self.hidden_errors.ended.connect(self._led)
        self.program.guide.linked.connect(self.hidden_errors.go_to)

    def tour(self) -> None:
        """Begin the guided tour."""
        self._lead("Tour")
        self.guided_tour.begin()

    def exercise(self) -> None:
        """Begin an exercise."""
        self._lead("Exercise")
        self.hidden_errors.begin()

    def why_quaternions(self) -> None:
        """One joint through ±180° with five trackers, in a window of its own."""
        theme = self.program.viewport.theme
        if self.five_trackers is None:
            self.five_trackers = FiveTrackers(theme, self.window)
        self.five_trackers.set_theme(theme)
        bring_to_front(self.five_trackers)
        self.five_trackers.activateWindow()

    def leave_guide(self) -> None:
        """End tour and exercise; the person's own clip comes back as it was."""
        if self.guided_tour.running:
            self.guided_tour.end()
        if self.hidden_errors.running:
            self.hidden_errors.end()

    def _lead(self, title: str) -> None:
        self.leave_guide()
        self._list_as_before = self.program.list_all()  # what a page speaks of is listed
        self.dock.setWindowTitle(title)
        bring_to_front(self.dock)
        self.window.resizeDocks([self.above, self.dock], [1, 3], Qt.Orientation.Vertical)
        self.window.resizeDocks([self.dock], [_GUIDE_WIDTH], Qt.Orientation.Horizontal)

    def _led(self) -> None:
        self.dock.hide()
        if self._list_as_before is not None:
            self._list_as_before()
            self._list_as_before = None
        self.program.aside.put_back()
