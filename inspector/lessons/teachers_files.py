"""Write class exercises, and score the students' answers."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from inspector.language import plural, tr
from inspector.lessons.classroom import score_answers, write_for_class
from inspector.lessons.interrupted_review import Aside
from inspector.widgets.background import OneTask
from inspector.widgets.file_dialog import ask_files, ask_save_path
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import encode_utf8

_SEEDS = 2**31


class TeachersFiles(QObject):
    """Asks for the files of a class exercise, and reads and writes them in the background.

    Parameters
    ----------
    aside
        The object that sets the user's own clip aside during an exercise.
    clips
        The sample clips, one of which is used if no clip is open.
    kind
        A function that returns the kind of exercise to write.
    show
        A function that shows a sentence to the user; its second argument is True for an error.
    """

    def __init__(
        self,
        aside: Aside,
        clips: tuple[Path, ...],
        kind: Callable[[], str],
        show: Callable[[object, bool], object],
        window: QWidget,
    ) -> None:
        super().__init__(window)
        self._aside, self._clips, self._kind = aside, clips, kind
        self._show, self._window = show, window
        self._task = OneTask(self)

    def ask_write(self) -> None:
        """Ask for a path, and write an exercise to it."""
        wanted = Path("exercise.json")
        title = tr("Write an exercise")
        ask_save_path(self._window, title, "*.json", self.write, wanted=wanted, suffix="json")

    def write(self, path: Path) -> None:
        """Write an exercise made from the open clip or from a sample, with a random seed."""
        own, seed, kind = self._aside.own, secrets.randbelow(_SEEDS), self._kind()
        source = own.clip.path if own is not None else self._clips[seed % len(self._clips)]

        def written(files: tuple[Path, Path]) -> None:
            clip, key = files
            text = tr(
                "Give {exercise} and {clip} to your class. Keep the key {key} to yourself.",
                exercise=path.name,
                clip=clip.name,
                key=key.name,
            )
            self._show(text, False)

        self._task.run(lambda _: write_for_class(source, path, seed, kind), written, self._failed)

    def ask_score(self) -> None:
        """Ask for the files of the answer key and the students' answers, and score the answers."""
        title = tr("Select the answer key and all answers")
        ask_files(self._window, title, "*.json", self.score, several=True)

    def score(self, files: Sequence[Path]) -> None:
        """Score the students' answers, then ask for a path and write the score table to it.

        `files` are the paths of the answer key and of the answers, in any order.
        """

        def ask(table: str) -> None:
            ask_save_path(
                self._window, tr("Save the table of scores"), "*.csv",
                lambda path: self.write_table(path, table),
                wanted=files[0].with_name("class.csv"), suffix="csv",
            )  # fmt: skip

        self._task.run(lambda _: score_answers(files), ask, self._failed)

    def write_table(self, path: Path, table: str) -> None:
        """Write the table of scores, a CSV text, to a file."""
        try:
            write_atomically(path, encode_utf8(table))
        except (OSError, TwistError) as error:
            self._failed(error)
            return
        students = table.count("\n") - 1
        text = plural(
            "The score of {n} student was written to {file}.",
            "The scores of {n} students were written to {file}.",
            students,
            file=path.name,
        )
        self._show(text, False)

    def _failed(self, error: Exception) -> None:
        self._show(error, True)
