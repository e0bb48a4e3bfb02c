"""Write exports in the background, one at a time."""

from __future__ import annotations

from PySide6.QtCore import QEventLoop, QObject, Signal

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.export_files import Export, ExportChoice, prepare_export, write_export_files
from inspector.session.session_files import replay_path
from inspector.widgets.background import Task
from twistcore.errors import TwistError
from twistcore.review.interrupted_export import mark_export_in_progress
from twistcore.work.progress import Tell


class Exporter(QObject):
    """Writes exports in the background and shows their progress and result.

    The user can continue the review in the meantime.
    """

    ended = Signal()
    written = Signal(object, str)  # a finished Export, and the sentence to show about it

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self._export: Export | None = None  # the export being written
        self._failed = False

    @property
    def running(self) -> bool:
        """Return True while an export is being written."""
        return self._export is not None

    def start(self, choice: ExportChoice) -> None:
        """Start an export of the current review with the options `choice`."""
        if self._export is not None:
            name = self._export.choice.path.name
            message = tr(
                "{name} is still being written. Wait until it is finished, then export again.",
                name=name,
            )
            self._document.message.emit(message, True)
            return
        try:
            export = prepare_export(self._document, choice)
        except TwistError as error:
            self._document.message.emit(str(error), True)
            return
        self._export, self._failed = export, False
        self._show_progress(0.0)
        task = Task(lambda tell: _write_marked(export, tell), self)
        task.progress.connect(self._show_progress)
        task.finished.connect(lambda text: self._done(export, text))
        task.failed.connect(lambda error: self._fail(export, error))
        task.start()

    def finish(self) -> bool:
        """Wait until the export is written. If writing fails, show the reason and return False."""
        if self._export is None:
            return True
        loop = QEventLoop()
        self.ended.connect(loop.quit)
        loop.exec(QEventLoop.ProcessEventsFlag.ExcludeUserInputEvents)
        return not self._failed

    def _show_progress(self, share: float) -> None:
        if self._export is not None:
            message = tr("Writing {name} …", name=self._export.choice.path.name)
            done = f" {100.0 * share:.0f} %" if share > 0.0 else ""
            self._document.message.emit(message + done, False)

    def _fail(self, export: Export, error: Exception) -> None:
        self._failed = True
        path, why = export.choice.path, translate_core_sentence(str(error))
        message = tr("{path} was not written: {why}", path=path, why=why)
        if isinstance(error, OSError):
            path, why = error.filename or path, translate_core_sentence(str(error.strerror))
            message = tr("{path} was not written ({why}).", path=path, why=why)
        self._end(export, message, wrong=True)

    def _done(self, export: Export, text: str) -> None:
        self._end(export, text, wrong=bool(export.changed))
        self.written.emit(export, text)

    def _end(self, export: Export, text: str, *, wrong: bool) -> None:
        self._document.exported.update(export.ours)  # after a failure, some files may be on disk
        self._export = None
        self._document.message.emit(text, wrong)
        self.ended.emit()


def _write_marked(export: Export, tell: Tell) -> str:
    with mark_export_in_progress(replay_path(export.choice.path), export.clip.path):
        return write_export_files(export, tell)
