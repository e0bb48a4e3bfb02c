"""The actions for a folder of clips: save its table, and write its report."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from PySide6.QtCore import QCoreApplication, QProcess
from PySide6.QtWidgets import QMainWindow

from inspector.folder.clip_table import clip_table
from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import QueuedClip
from inspector.language import plural, tr, translate_core_sentence
from inspector.widgets.file_dialog import ask_save_path
from inspector.widgets.message_bar import MessageBar
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import encode_utf8
from twistcore.files.ordinary import path_exists
from twistcore.work.with_parent import parent_bound_module_command

_PATTERN = tr("Tables (*.csv);;All files (*)")


@dataclass(eq=False)
class FolderActions:
    """Writes the list of the folder's clips as a CSV table, and the report of a batch.

    Attributes
    ----------
    listed
        A function that returns the clips in the list.
    save
        A function that saves the open review.
    """

    queue: FolderQueue
    listed: Callable[[], Iterable[QueuedClip]]
    bar: MessageBar
    save: Callable[[], object]
    window: QMainWindow
    _report: QProcess | None = field(default=None, init=False)

    def save_clip_table(self) -> None:
        """Ask for a path, and write the listed clips to it as CSV."""
        if (folder := self.queue.folder) is None:
            self.bar.show_message(tr("Open a folder first."), False)
            return
        proposed = folder / f"{folder.name or 'clips'}.csv"
        title, then = tr("Save the table of clips"), self.save_clip_table_to
        ask_save_path(self.window, title, _PATTERN, then, wanted=proposed, suffix="csv")

    def save_clip_table_to(self, path: Path) -> None:
        """Write the table to `path`. If writing fails, an existing file stays unchanged."""
        clips = list(self.listed())
        if path_exists(path) and path.suffix.lower() != ".csv":
            message = tr(
                "{name} is not a CSV file. Choose a name that ends in .csv.", name=path.name
            )
            self.bar.show_message(message, True)
            return
        try:
            write_atomically(path, encode_utf8(clip_table(clips)))
        except OSError as error:
            why = translate_core_sentence(str(error.strerror))
            message = tr("{path} could not be written: {why}.", path=path, why=why)
            self.bar.show_message(message, True)
            return
        count = plural("{n} clip", "{n} clips", len(clips))
        rest = len(self.queue.clips) - len(clips)
        left = ""
        if rest:
            left = " " + plural(
                "{n} clip was left out, because it is not listed.",
                "{n} clips were left out, because they are not listed.",
                rest,
            )
        self.bar.show_message(f"{path.name}: {count}.{left}", False)

    def write_report(self) -> None:
        """Write the report of the open batch, including the decisions."""
        if (folder := self.queue.folder) is None or self.queue.batch is None:
            message = tr(
                "This report can only be written for a folder made by `twistcore batch`. Run "
                "`twistcore batch FOLDER -o OUTDIR --report`, then open OUTDIR."
            )
            self.bar.show_message(message, True)
            return
        if self._report is not None:
            self.bar.show_message(tr("The report is already being written."), False)
            return
        self.save()  # the report must include decisions that are not saved yet
        self.queue.batch.when_recorded(lambda: self._start_report(folder))
        message = tr("Writing the report for {folder} …", folder=folder.name)
        self.bar.show_message(message, False)

    def _start_report(self, folder: Path) -> None:
        # A separate process, because the report reads all clips and draws pictures.
        self._report = report = QProcess(self.window)
        if (application := QCoreApplication.instance()) is not None:
            application.aboutToQuit.connect(self._give_up)
        report.finished.connect(lambda code: self._report_finished(folder, code))
        report.errorOccurred.connect(lambda error: self._not_started(folder, error))
        target = folder / "report"
        program, *words = parent_bound_module_command(
            "twistcore", "report", str(folder), "-o", str(target)
        )
        report.start(program, words)

    def _give_up(self) -> None:
        """Stop the process that writes the report, because the program is closing.

        All pages written up to that point are complete.
        """
        report, self._report = self._report, None
        if report is not None:
            report.blockSignals(True)
            report.kill()
            report.waitForFinished(2_000)

    def _report_finished(self, folder: Path, code: int) -> None:
        report, self._report = self._report, None
        if report is None:
            return
        errors = bytes(report.readAllStandardError().data()).decode("utf-8", "replace").strip()
        # The process prints only after everything is written
        done = bool(report.readAllStandardOutput().data())
        report.deleteLater()
        if code in (0, 1) and done:
            message = tr("{path} was written.", path=folder / "report" / "index.html")
            if code:
                message += " " + tr("Some clips could not be drawn. The report lists these clips.")
            self.bar.show_message(message, False)
            # The message bar may show a question
            self.window.statusBar().showMessage(message, 10_000)
        else:
            silent = tr("the process ended without a message")
            last = translate_core_sentence(errors.splitlines()[-1]) if errors else silent
            self.bar.show_message(tr("The report could not be written: {why}", why=last), True)

    def _not_started(self, folder: Path, error: QProcess.ProcessError) -> None:
        if error == QProcess.ProcessError.FailedToStart and self._report is not None:
            self._report.deleteLater()
            self._report = None
            message = tr(
                "{folder}: the process that writes the report could not be started.",
                folder=folder.name,
            )
            self.bar.show_message(message, True)
