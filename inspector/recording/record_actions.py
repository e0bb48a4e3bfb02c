"""The action that records films and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from inspector.language import tr, translate_core_sentence
from inspector.recording.choice import RecordChoice
from inspector.recording.record_dialog import LAST_FORMAT, RecordDialog
from inspector.recording.recorder import Recorder, save_picture
from inspector.recording.stage import Shown, Stage
from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.teaching.equation_table import teaching_tab_formulas
from inspector.teaching.taught_frame import TaughtFrame
from inspector.timeline.timeline import Timeline
from inspector.viewport.viewport import Viewport
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.typeset import Typesetter
from twistcore.files.ordinary import path_exists


@dataclass(eq=False)
class RecordActions:
    """Records films and pictures of the window's contents."""

    document: Document
    recorder: Recorder
    viewport: Viewport
    timeline: Timeline
    taught: TaughtFrame
    typesetter: Typesetter
    bar: MessageBar
    window: QWidget
    settings: Settings

    def __post_init__(self) -> None:
        self.recorder.finished.connect(self._recorded)
        self.recorder.failed.connect(self._not_recorded)

    def record_dialog(self) -> None:
        """Open the Record dialog. When the user accepts it, record with the chosen settings."""
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
        elif self.recorder.running:
            self.bar.show_message(
                tr("A video is being rendered. Wait until it is finished, or cancel it."), False
            )
        else:
            seen = self.timeline.visible.ends
            teaching = self.taught.active
            last = LAST_FORMAT.of(self.settings)
            dialog = RecordDialog(self.document, seen, self.window, teaching=teaching, suffix=last)
            dialog.accepted.connect(lambda: self._chosen(dialog.choice()))
            dialog.open()

    def _chosen(self, choice: RecordChoice) -> None:
        """Remember the format for the next recording, and record."""
        LAST_FORMAT.put(self.settings, choice.path.suffix.lower())
        self.record(choice)

    def record(self, choice: RecordChoice) -> None:
        """Make a film in the background, or save a picture immediately."""
        if path_exists(choice.path) and not choice.replace:
            message = tr(
                "{path} already exists. Choose another name, or tick 'Replace the existing file'.",
                path=choice.path,
            )
            self.bar.show_message(message, True)
            return
        if self.viewport.view is None and choice.contents.view:
            self.bar.show_message(
                tr("The 3D view cannot be recorded, because OpenGL is not available."), True
            )
            return
        taught = choice.contents.equations or choice.sweep is not None or self.taught.active
        typeset = self.typesetter.has(
            teaching_tab_formulas()
        )  # a lesson typesets only its own equations
        if taught and not typeset and not self.typesetter.trouble:
            self._typeset_first(choice)
            return
        shown = Shown(self.taught, self.viewport, self.timeline, self.typesetter)
        stage = Stage(shown, choice)
        if choice.film:
            self.recorder.start(stage, choice)
            return
        try:
            save_picture(stage, choice, self.document.frame)
            self._recorded(choice.path)
        except OSError as error:
            why = translate_core_sentence(error.strerror)
            message = tr("{path} could not be written: {why}.", path=choice.path, why=why)
            self.bar.show_message(message, True)
        finally:
            stage.close_views()

    def _typeset_first(self, choice: RecordChoice) -> None:
        """Typeset the equations before recording, because the teaching tab may not have done so."""
        self.bar.show_message(tr("The equations are being typeset …"), False)
        ready = self.typesetter.ready
        ready.connect(lambda: self.record(choice), Qt.ConnectionType.SingleShotConnection)
        self.typesetter.start(teaching_tab_formulas())

    def _recorded(self, path: Path) -> None:
        self.bar.show_message(tr("{name} was written.", name=path.name), False)

    def _not_recorded(self, why: str) -> None:
        if why:
            self.bar.show_message(why, True)
