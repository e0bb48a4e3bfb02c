"""The dialogs and the background work for exporting a lesson as a web page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from inspector.bundled import ASSETS, TOUR
from inspector.language import tr, translated_page_path
from inspector.lessons.lesson_file import LessonFile, read_lesson
from inspector.lessons.web_page import export_page
from inspector.widgets.background import OneTask
from inspector.widgets.file_dialog import ask_files, ask_save_path
from twistcore.errors import TwistError


class PageExport(QObject):
    """Exports a lesson as a web page.

    `show` is a function that shows a sentence to the user; its second argument is True for an
    error.
    """

    def __init__(self, window: QWidget, show: Callable[[str, bool], object]) -> None:
        super().__init__(window)
        self._window, self._show = window, show
        self._task = OneTask(self)

    def ask(self, lesson: LessonFile | None) -> None:
        """Ask for the path of the web page and, if `lesson` is None, for a lesson."""
        if lesson is not None:
            self._ask_where(lesson)
            return
        ask_files(
            self._window, tr("Export lesson as web page"), tr("Lessons (*.md)"),
            lambda paths: self._read(paths[0]),
            folder=translated_page_path(TOUR).parent,
        )  # fmt: skip

    def _read(self, path: Path) -> None:
        try:
            lesson = read_lesson(path)
        except TwistError as error:
            self._show(str(error), True)
            return
        self._ask_where(lesson)

    def _ask_where(self, lesson: LessonFile) -> None:
        own = not lesson.path.is_relative_to(ASSETS)  # do not write to the program's folder
        folder = lesson.path.parent if own else Path.home()
        ask_save_path(
            self._window, tr("Export lesson as web page to"), tr("Web pages (*.html)"),
            lambda path: self.write(lesson, path),
            wanted=folder / f"{lesson.path.stem}.html", suffix="html",
        )  # fmt: skip

    def write(self, lesson: LessonFile, path: Path) -> None:
        """Write the web page in the background, then show a message about the result."""

        def written(_: object) -> None:
            size = path.stat().st_size / 1e6
            text = tr(
                "The page {file} was written ({size:.1f} MB). Open it in any browser.",
                file=path,
                size=size,
            )
            self._show(text, False)

        def failed(error: Exception) -> None:
            self._show(tr("The page was not written. {why}", why=error), True)

        self._task.run(lambda _: export_page(lesson, path), written, failed)
