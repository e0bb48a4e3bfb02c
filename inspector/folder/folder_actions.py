"""What the actions of a folder of clips do: its table and its report, written."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from PySide6.QtCore import QCoreApplication, QProcess
from PySide6.QtWidgets import QMainWindow

from inspector.folder.clip_table import clip_table
from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import QueuedClip
from inspector.language import of_core, plural, tr
from inspector.widgets.file_dialog import ask_where
from inspector.widgets.message_bar import MessageBar
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import encoded
from twistcore.files.ordinary import is_there
from twistcore.work.with_parent import python_bound

_PATTERN = tr("Tables (*.csv);;All files (*)")


@dataclass(eq=False)
class FolderActions:
    """The folder's clips: their table as CSV, and a batch's report.

    listed: the rows as they are listed; save: keeps the review.
    """

    queue: FolderQueue
    listed: Callable[[], Iterable[QueuedClip]]
    bar: MessageBar
    save: Callable[[], object]
    window: QMainWindow
    _report: QProcess | None = field(default=None, init=False)

    def save_clip_table(self) -> None:
        """Ask where to and write the clips that are listed, in their order, as CSV."""
        if (folder := self.queue.folder) is None:
            self.bar.show_message(tr("Open a folder first."), False)
            return
        wanted = folder / f"{folder.name or 'clips'}.csv"
        title, then = tr("Save the table of clips"), self.save_clip_table_to
        ask_where(self.window, title, _PATTERN, then, wanted=wanted, suffix="csv")

    def save_clip_table_to(self, path: Path) -> None:
        """Write the table; all of the file or nothing."""
        clips = list(self.listed())
        if is_there(path) and path.suffix.lower() != ".csv":
            told = tr("{name}: expected a CSV file to write.", name=path.name)
            self.bar.show_message(told, True)
            return
        try:
            write_atomically(path, encoded(clip_table(clips)))
        except OSError as error:
            why = of_core(str(error.strerror))
            told = tr("{path}: cannot be written ({why}).", path=path, why=why)
            self.bar.show_message(told, True)
            return
        count = plural("{n} clip", "{n} clips", len(clips))
        rest = len(self.queue.clips) - len(clips)
        left = tr("; {n} not listed here are not in it", n=rest) if rest else ""
        self.bar.show_message(f"{path.name}: {count}{left}.", False)

    def write_report(self) -> None:
        """Write the report of the batch folder that is open, decisions included."""
        if (folder := self.queue.folder) is None or self.queue.batch is None:
            told = tr("Open a folder that `twistcore batch` wrote first.")
            self.bar.show_message(told, False)
            return
        if self._report is not None:
            self.bar.show_message(tr("The report is being written already."), False)
            return
        self.save()  # what is decided and not saved yet belongs to it
        self.queue.batch.when_noted(lambda: self._start_report(folder))
        told = tr("{folder}: the report is being written …", folder=folder.name)
        self.bar.show_message(told, False)

    def _start_report(self, folder: Path) -> None:
        # A process: it reads every clip again and draws, while the window stays free.
        self._report = report = QProcess(self.window)
        if (application := QCoreApplication.instance()) is not None:
            application.aboutToQuit.connect(self._give_up)
        report.finished.connect(lambda code: self._reported(folder, code))
        report.errorOccurred.connect(lambda error: self._not_started(folder, error))
        target = folder / "report"
        program, *words = python_bound("twistcore", "report", str(folder), "-o", str(target))
        report.start(program, words)

    def _give_up(self) -> None:
        """The program ends: so does the process, whose pages are each whole or not there."""
        report, self._report = self._report, None
        if report is not None:
            report.blockSignals(True)
            report.kill()
            report.waitForFinished(2_000)

    def _reported(self, folder: Path, code: int) -> None:
        report, self._report = self._report, None
        if report is None:
            return
        said = bytes(report.readAllStandardError().data()).decode("utf-8", "replace").strip()
        done = bool(report.readAllStandardOutput().data())  # nothing is said before all is written
        report.deleteLater()
        if code in (0, 1) and done:
            told = tr("{path} was written.", path=folder / "report" / "index.html")
            if code:
                told += " " + tr("Some clips could not be drawn; the page lists them.")
            self.bar.show_message(told, False)
            self.window.statusBar().showMessage(told, 10_000)  # the bar may be asking something
        else:
            silent = tr("the process ended without a word")
            last = of_core(said.splitlines()[-1]) if said else silent
            self.bar.show_message(tr("No report: {why}", why=last), True)

    def _not_started(self, folder: Path, error: QProcess.ProcessError) -> None:
        if error == QProcess.ProcessError.FailedToStart and self._report is not None:
            self._report.deleteLater()
            self._report = None
            told = tr("{folder}: the report's process could not be started.", folder=folder.name)
            self.bar.show_message(told, True)
