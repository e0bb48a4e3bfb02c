"""A teacher's side of an exercise for a class: writing one, and scoring what was handed in."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from inspector.language import plural, tr
from inspector.lessons.classroom import scored, write_for_class
from inspector.lessons.interrupted_review import Aside
from inspector.widgets.background import OneTask
from inspector.widgets.file_dialog import ask_files, ask_where
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import encoded

_SEEDS = 2**31


class TeachersFiles(QObject):
    """Asks for files, and reads and writes them in the background.

    clips: samples, where the person has no clip open; kind: of exercise, when it is written;
    tell: a sentence for the person, and whether it is bad.
    """

    def __init__(
        self,
        aside: Aside,
        clips: tuple[Path, ...],
        kind: Callable[[], str],
        tell: Callable[[object, bool], object],
        window: QWidget,
    ) -> None:
        super().__init__(window)
        self._aside, self._clips, self._kind = aside, clips, kind
        self._tell, self._window = tell, window
        self._task = OneTask(self)

    def ask_write(self) -> None:
        """Ask where to write an exercise, and write it."""
        wanted = Path("exercise.json")
        title = tr("Write an exercise")
        ask_where(self._window, title, "*.json", self.write, wanted=wanted, suffix="json")

    def write(self, path: Path) -> None:
        """An exercise of the person's clip, else of a sample; no seed that others could try."""
        own, seed, kind = self._aside.own, secrets.randbelow(_SEEDS), self._kind()
        source = own.clip.path if own is not None else self._clips[seed % len(self._clips)]

        def written(files: tuple[Path, Path]) -> None:
            clip, key = files
            told = tr(
                "For your class: {exercise} and {clip}. For you alone: {key}.",
                exercise=path.name,
                clip=clip.name,
                key=key.name,
            )
            self._tell(told, False)

        self._task.run(lambda _: write_for_class(source, path, seed, kind), written, self._failed)

    def ask_score(self) -> None:
        """Ask for the key and what was handed in, and score it."""
        title = tr("The key, and all that was handed in")
        ask_files(self._window, title, "*.json", self.score, several=True)

    def score(self, files: Sequence[Path]) -> None:
        """Score what was handed in, and ask where to write the table."""

        def ask(table: str) -> None:
            ask_where(
                self._window, tr("Write the table"), "*.csv",
                lambda path: self.write_table(path, table),
                wanted=files[0].with_name("class.csv"), suffix="csv",
            )  # fmt: skip

        self._task.run(lambda _: scored(files), ask, self._failed)

    def write_table(self, path: Path, table: str) -> None:
        """Write what the class came to."""
        try:
            write_atomically(path, encoded(table))
        except (OSError, TwistError) as error:
            self._failed(error)
            return
        students = table.count("\n") - 1
        told = plural("{file}: {n} students.", "{file}: {n} students.", students, file=path.name)
        self._tell(told, False)

    def _failed(self, error: Exception) -> None:
        self._tell(error, True)
