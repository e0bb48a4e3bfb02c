"""Record films in the background with a progress bar, and pictures immediately."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QLabel, QProgressBar, QPushButton, QWidget

from inspector.language import tr, translate_core_sentence
from inspector.recording.choice import RecordChoice, Shot, film_shots
from inspector.recording.figure_file import figure_file
from inspector.recording.film import FilmWriter
from inspector.recording.stage import Stage
from inspector.widgets.building import hbox
from twistcore.files.atomic import write_atomically

_POLL_MS = 5  # time between checks of whether ffmpeg has caught up


def save_picture(stage: Stage, choice: RecordChoice, frame: int) -> None:
    """Write a picture of a frame. If this fails, raise OSError and leave no file behind."""
    stage.show_shot(Shot(frame))
    path, pixels = choice.path, stage.size_in_pixels
    data = figure_file(stage.sheet(), path.suffix.lower(), path.stem, pixels, choice.paper.dpi)
    write_atomically(path, data)


class Recorder(QObject):
    """Records one film at a time, and draws one image in each iteration of the event loop."""

    progress = Signal(int, int)  # number of finished images, and of all images
    finished = Signal(object)  # with the path of the film
    failed = Signal(str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._stage: Stage | None = None
        self._writer: FilmWriter | None = None
        self._shots: list[Shot] = []
        self._at = 0
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._step)

    @property
    def running(self) -> bool:
        """Return True while a film is being made."""
        return self._writer is not None

    def start(self, stage: Stage, choice: RecordChoice) -> None:
        """Start recording a film of a stage, which is closed when the film is complete."""
        assert stage.document.data is not None
        self._stage = stage
        fps = stage.document.data.motion.fps
        self._shots = film_shots(choice, fps, stage.document.frame)
        self._at = 0
        size = (stage.width(), stage.height())
        try:
            self._writer = FilmWriter(choice.path, size, choice.fps)
        except OSError as error:
            self._end()
            why = translate_core_sentence(error.strerror)
            self.failed.emit(tr("{path} could not be written: {why}.", path=choice.path, why=why))
            return
        self.progress.emit(0, len(self._shots))
        self._timer.start(0)

    def cancel(self) -> None:
        """Stop recording, and delete the unfinished film."""
        if self._writer is not None:
            self._timer.stop()
            self._writer.cancel()
            self._end()
            self.failed.emit("")

    def _step(self) -> None:
        writer, stage = self._writer, self._stage
        assert writer is not None
        assert stage is not None
        if self._at == len(self._shots) or writer.trouble:
            self._wait(writer)
            return
        if writer.full:
            self._timer.setInterval(_POLL_MS)
            return
        self._timer.setInterval(0)
        stage.show_shot(self._shots[self._at])
        writer.offer(_rgb(stage.picture()))
        self._at += 1
        self.progress.emit(self._at, len(self._shots))
        if self._at == len(self._shots):
            writer.finish()
            self._timer.setInterval(_POLL_MS)

    def _wait(self, writer: FilmWriter) -> None:
        """Check whether ffmpeg has finished. If so, give the film its final name."""
        if writer.trouble and self._at < len(self._shots):
            self._at = len(self._shots)
            writer.finish()
        if not writer.ended:
            return
        self._timer.stop()
        try:
            writer.keep()
        except OSError as error:
            self._end()
            why = translate_core_sentence(error)
            self.failed.emit(tr("{path} could not be written: {why}.", path=writer.path, why=why))
        else:
            self._end()
            self.finished.emit(writer.path)

    def _end(self) -> None:
        if self._stage is not None:
            self._stage.close_views()
        self._stage = self._writer = None


class RecordingBar(QWidget):
    """The progress bar of a film, with a Cancel button. It is hidden unless a film is recorded."""

    def __init__(self, recorder: Recorder) -> None:
        super().__init__()
        self.label = QLabel(tr("Recording"))
        self.bar = QProgressBar(textVisible=False)
        self.bar.setFixedWidth(160)
        self.bar.setMaximumHeight(10)
        self.stop = QPushButton(tr("Cancel"))
        self.stop.clicked.connect(recorder.cancel)
        hbox(self.label, self.bar, self.stop, owner=self, margins=(8, 0, 8, 0))
        recorder.progress.connect(self._moved)
        recorder.finished.connect(self.hide)
        recorder.failed.connect(self.hide)
        self.hide()

    def _moved(self, done: int, total: int) -> None:
        self.bar.setRange(0, total)
        self.bar.setValue(done)
        self.label.setText(tr("Recording {done} / {total}", done=done, total=total))
        self.show()


def _rgb(image: QImage) -> bytes:
    """Return the RGB bytes of an image, without the padding that Qt adds to each row."""
    image = image.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].tobytes()
