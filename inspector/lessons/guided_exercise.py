"""The exercise: the user reviews a sample clip with hidden errors and gets a score."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QComboBox, QLabel, QMenu, QPushButton, QSpinBox, QToolButton, QWidget

from inspector.language import plural, tr, tr_as, translate_core_sentence
from inspector.lessons.classroom import open_for_review, open_for_student, with_hidden_errors
from inspector.lessons.exercise_texts import exercise_page, score_text
from inspector.lessons.guide_card import leave_button
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.scene_of_page import ViewBefore
from inspector.lessons.teachers_files import TeachersFiles
from inspector.session.opening import Analysed
from inspector.widgets.background import OneTask
from inspector.widgets.building import tool_button
from inspector.widgets.file_dialog import ask_files, ask_save_path
from twistcore.detection import Interval
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision
from twistcore.study.class_exercise import ClassExercise, StudentAnswer, write_student_answer
from twistcore.study.exercise import ExerciseScore, score_review_of_hidden_errors
from twistcore.study.exercise_clip import write_student_exercise_clip
from twistcore.synthesis import InjectedError

KINDS = {"judge": tr("Judge"), "find": tr("Find")}
_NOTHING_KEPT = tr(
    "An exercise does not save anything. When it ends, your own clip comes back unchanged."
)
_HAND_IN = tr(
    "An exercise does not save anything by itself. Press 'Hand in…' to write your verdicts to "
    "a file."
)


def make_exercise(
    clip: Path, folder: Path, seed: int, kind: str
) -> tuple[Analysed, tuple[InjectedError, ...]]:
    """Write a copy of a clip with hidden errors. Return the opened copy and its errors.

    This function is thread-safe.

    Parameters
    ----------
    clip
        The BVH file to copy.
    folder
        The folder for the copy.
    seed
        The seed of the random errors.
    kind
        The kind of exercise, a key of KINDS.
    """
    source = read_bvh(clip)
    dirty, errors, listed = with_hidden_errors(source, seed, kind.lower())
    path = folder / f"exercise_{seed}.bvh"
    write_student_exercise_clip(source, dirty, path)
    return open_for_review(path, listed), errors


class Exercise(QObject):
    """Guides the user through an exercise: start, review, and score or hand-in."""

    ended = Signal()

    def __init__(self, program: GuidedProgram, clips: tuple[Path, ...], window: QWidget) -> None:
        """Create the exercise. `clips` are sample clips, one of which is chosen by the seed."""
        super().__init__(window)
        self._program, self._clips = program, clips
        self.running = False
        self._errors: tuple[InjectedError, ...] = ()
        self._task = OneTask(self)
        self._class: ClassExercise | None = None  # the open exercise of a class
        # Start time of a class exercise, and seed of any other exercise
        self._since, self._seed = 0.0, 1
        self._view_before: ViewBefore | None = None  # the view before the exercise
        # the verdicts when they were last handed in, or at the start
        self._kept: list[tuple[Interval, Decision]] = []
        self.result: ExerciseScore | None = None
        self.kind, self.seed = QComboBox(), QSpinBox()
        for kind, text in KINDS.items():
            self.kind.addItem(text, kind)
        self.kind.setToolTip(tr("Judge a list of intervals, or find the errors yourself"))
        self.kind.setAccessibleName(tr("Kind of exercise"))
        self.seed.setRange(1, 9999)
        self.seed.setToolTip(tr("The same seed always hides the same errors"))
        self.seed_label = QLabel(tr_as("exercise", "Seed"))
        self.seed.setAccessibleName(tr("Seed"))
        self.start = QPushButton(tr_as("button", "Start"))
        self.score_button = QPushButton(tr_as("button", "Score"))
        self.hand_in_button = QPushButton(tr("Hand in…"))
        self.hand_in_button.setToolTip(tr("Write your verdicts to a file for your teacher"))
        self.hand_in_button.clicked.connect(lambda: self.ask_hand_in(lambda: None))
        self.teacher = TeachersFiles(
            program.aside, clips, lambda: str(self.kind.currentData()), self._show, window
        )
        tip = tr("Write an exercise for a class, do one, or score the answers")
        self.for_class = tool_button(f"{tr('Class')} ▾", tip)
        self.for_class.setStyleSheet("QToolButton::menu-indicator { image: none; }")
        self.for_class.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._add_menu()
        tip = tr("End the exercise. Your own clip comes back unchanged.")
        self.leave = leave_button(tip)
        self.start.clicked.connect(lambda: self.before_leaving(self._start))
        self.score_button.clicked.connect(self.show_score)
        self.leave.clicked.connect(lambda: self.before_leaving(self.end))
        program.document.intervals_changed.connect(self._judged)

    def begin(self) -> None:
        """Show the page of the exercise with its controls, without opening a clip."""
        self.running = True
        self.result = None
        self._errors, self._class = (), None
        self._offer(self.score_button)
        self._program.guide.show_page(*exercise_page())
        self.start.setEnabled(True)  # disabled while a clip is made, unlike the End button
        self.start.setText(tr_as("button", "Start"))
        self.score_button.setEnabled(False)

    def _offer(self, last: QPushButton) -> None:
        """Show the controls and two buttons: the Start button, then the button `last`."""
        controls = [self.kind, self.seed_label, self.seed, self.for_class]
        self._program.guide.set_buttons([self.start, last], controls, self.leave)

    def end(self) -> None:
        """End the exercise, and return to the user's own clip."""
        self._task.cancel()
        self.running, self._class = False, None
        if self._view_before is not None:
            self._view_before.restore()
            self._view_before = None
        self.ended.emit()

    def _start(self) -> None:
        folder, seed = self._program.aside.folder(), self.seed.value()
        self._seed = seed
        clip, kind = self._clips[seed % len(self._clips)], str(self.kind.currentData())
        self.start.setEnabled(False)
        make = partial(make_exercise, clip, folder, seed, kind)
        self._task.run(lambda _: make(), self._ready, self._show)

    def _ready(self, made: tuple[Analysed, tuple[InjectedError, ...]]) -> None:
        data, self._errors = made
        self._class, self.result = None, None
        self._offer(self.score_button)
        self.start.setEnabled(True)
        self.start.setText(tr("Start again"))
        self.score_button.setEnabled(True)
        self._program.guide.show_page(*exercise_page())
        self._program.aside.show(data, _NOTHING_KEPT)
        self._show_skin()
        self._judged()

    def _show_skin(self) -> None:
        """Show the list of intervals and the striped skin until the exercise ends."""
        if self._view_before is None:
            self._view_before = ViewBefore(self._program)
        self._program.actions["skin"].setChecked(True)
        self._program.show_intervals()

    def _judged(self) -> None:
        begun = self._class is not None or bool(self._errors)
        if self.running and begun and self.result is None:
            intervals = self._program.document.intervals
            judged = sum(j.decision != Decision.UNDECIDED for j in intervals)
            button = tr_as("button", "Score") if self._class is None else tr("Hand in")
            task = tr(
                "Insert an interval at each error. Press *{button}* when you are done.",
                button=button,
            )
            if intervals:
                task = tr(
                    "{judged} of {total} intervals judged. Press *{button}* when you are done.",
                    judged=judged,
                    total=len(intervals),
                    button=button,
                )
            self._program.guide.set_task(task)

    def show_score(self) -> None:
        """Show the score, with links to missed errors and wrong verdicts."""
        guide, document = self._program.guide, self._program.document
        self.result = result = score_review_of_hidden_errors(self._errors, document.intervals)
        guide.show_text(score_text(result, document.first_frame, self._label))
        total, wrong = len(self._errors), result.false_verdicts
        found = {"found": len(result.hits), "total": total}
        words = plural(
            "{found} of {total} errors found, {n} false verdict",
            "{found} of {total} errors found, {n} false verdicts",
            wrong,
            **found,
        )
        right = len(result.hits) / max(total + len(result.false_accepted), 1)
        guide.set_result(words, right)
        self.seed.setValue(self._seed % self.seed.maximum() + 1)
        self.start.setText(tr("Next exercise"))

    def _label(self, chain: str) -> str:
        try:
            return translate_core_sentence(self._program.document.find_chain(chain).label)
        except KeyError:  # the user has removed the chain
            return chain

    # -- a class ------------------------------------------------------------------------------

    def _add_menu(self) -> None:
        menu = QMenu(self.for_class)
        for text, ask in (
            (tr("Write a class exercise…"), self.teacher.ask_write),
            (tr("Do a class exercise…"), self._ask_open),
            (tr("Score the class answers…"), self.teacher.ask_score),
        ):
            action = QAction(text, menu)
            action.triggered.connect(ask)
            menu.addAction(action)
        self.for_class.setMenu(menu)

    @property
    def _window(self) -> QWidget:
        return self.for_class.window()

    def _show(self, text: object, wrong: bool = True) -> None:
        self.start.setEnabled(not self._task.running)
        self._program.document.message.emit(str(text), wrong)

    def _ask_open(self) -> None:
        title = tr("Open a class exercise")
        ask_files(self._window, title, "*.json", lambda paths: self.do_one(paths[0]))

    def do_one(self, path: Path) -> None:
        """Open a class exercise with a copy of its clip.

        The exercise ends without a score, because only the teacher has the answer key.
        """
        self.before_leaving(partial(self._open, path))

    def _open(self, path: Path) -> None:
        folder = self._program.aside.folder()
        self.start.setEnabled(False)
        self._task.run(lambda _: open_for_student(path, folder), self._opened, self._show)

    def _opened(self, made: tuple[Analysed, ClassExercise]) -> None:
        data, self._class = made
        self._errors, self.result, self._since = (), None, time.monotonic()
        self.start.setEnabled(True)
        self._offer(self.hand_in_button)
        self._program.guide.show_page(*exercise_page())
        self._program.aside.show(data, _HAND_IN, signed=True)
        self._kept = self._verdicts()
        self._show_skin()
        self._judged()

    def _verdicts(self) -> list[tuple[Interval, Decision]]:
        return [(judged.interval, judged.decision) for judged in self._program.document.intervals]

    @property
    def not_handed_in(self) -> str:
        """A warning if a class exercise has verdicts that are not handed in, or ''."""
        borrowed = self._program.document.borrowed
        if self._class is None or not (borrowed is not None and borrowed.signed):
            return ""
        if self._verdicts() == self._kept:
            return ""
        return tr("You have not handed in your verdicts on {clip}.", clip=self._class.clip)

    def before_leaving(self, then: Callable[[], object]) -> None:
        """Call `then` as soon as the class exercise may be closed.

        This is the case if the verdicts are handed in, or if the user declines to hand them in.
        """
        asked = self._class

        def answer(do: Callable[[], object]) -> None:
            if self._class is asked:  # another exercise may have been opened in the meantime
                do()

        if text := self.not_handed_in:
            first = tr("Hand in…"), partial(answer, partial(self.ask_hand_in, then))
            without = tr("Leave without handing in"), partial(answer, then)
            answers = first, without, (tr("Cancel"), lambda: None)
            self._program.document.question.emit(text, answers)
        else:
            then()

    def ask_hand_in(self, then: Callable[[], object]) -> None:
        """Ask for a path, write the verdicts to it and, on success, call `then`."""
        name = self._program.settings.reviewer.strip() or tr("answers")
        wanted = Path(f"{name.replace('/', '-')}.json")

        def write(path: Path) -> None:
            if self.hand_in(path):
                then()

        ask_save_path(self._window, tr("Hand in"), "*.json", write, wanted=wanted, suffix="json")

    def hand_in(self, path: Path) -> bool:
        """Write all intervals with their verdicts, the user's name and the time needed.

        Returns True on success.
        """
        if self._class is None:
            return False
        document = self._program.document
        name = self._program.settings.reviewer.strip() or path.stem
        seconds = time.monotonic() - self._since
        own = self._class.clip, self._class.sha256
        try:
            write_student_answer(
                path, StudentAnswer(name, seconds, *own, tuple(document.intervals))
            )
        except (OSError, TwistError) as error:
            self._show(error)
            return False
        self._kept = self._verdicts()
        text = tr(
            "Your verdicts were written to {file} under the name {name}.", file=path.name, name=name
        )
        self._show(text, wrong=False)
        self._program.guide.set_done(True)
        return True

    def go_to(self, address: str) -> None:
        """Follow a link in the score: select the chain in the link, and go to its frame."""
        chain, _, frame = address.removeprefix("at:").rpartition("/")
        if self.running and chain:
            document = self._program.document
            document.select_chain(chain)
            document.go_to(int(frame))
            self._program.viewport.focus_chain()
