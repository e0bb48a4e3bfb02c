"""What to record: a film or a picture, of which frames, how fast, how large."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QWidget

from inspector.recording.recorder import FPS, RecordChoice, film_frames
from inspector.session.document import Document
from inspector.widgets.building import soft
from inspector.widgets.write_dialog import WriteDialog

_FORMATS = {
    ".mp4": "Film, MP4",
    ".gif": "Film, GIF",
    ".png": "Picture, PNG",
    ".svg": "Picture, SVG (curves as lines)",
}
_SIZES = ((1280, 720), (1920, 1080), (960, 540))
_SPEEDS = {"Real time": 1.0, "Half speed": 0.5, "A quarter": 0.25, "A tenth": 0.1}
_AROUND_S = 0.5


class RecordDialog(WriteDialog):
    """A form; its `choice` is what is to be recorded."""

    def __init__(self, document: Document, seen: tuple[float, float], parent: QWidget) -> None:
        """`seen`: the frames that the plots show now."""
        assert document.data is not None
        clip = document.data.clip.path
        wanted = clip.with_name(f"{clip.stem}_{document.chain or 'clip'}.mp4")
        super().__init__("Record", wanted, parent)
        self._document = document
        self.format = _box((text, suffix) for suffix, text in _FORMATS.items())
        self.range = _box(self._ranges(seen))
        self.speed = _box(_SPEEDS.items())
        self.size_box = _box((f"{width} × {height}", (width, height)) for width, height in _SIZES)
        self.curves = QCheckBox("With the curves below the 3D view")
        self.curves.setChecked(True)
        self.length = soft(QLabel())
        self.form.addRow("Format", self.format)
        self.form.addRow("Write to", self.where)
        self.form.addRow("", self.replace)
        for name, box in (("Frames", self.range), ("Speed", self.speed), ("Size", self.size_box)):
            self.form.addRow(name, box)
        self.form.addRow("", self.curves)
        self.form.addRow("", self.length)
        self.end_form()
        self.format.currentIndexChanged.connect(self._reformat)
        for box in (self.range, self.speed):
            box.currentIndexChanged.connect(self._describe)
        self.path.textChanged.connect(self._describe)
        self._describe()

    def choice(self) -> RecordChoice:
        """What the form says."""
        first, stop = self.range.currentData()
        path = Path(self.path.text()).expanduser()
        suffix = str(self.format.currentData())
        if path.suffix.lower() != suffix:
            path = path.with_name(path.name + suffix)
        return RecordChoice(
            path,
            first,
            stop,
            self.speed.currentData(),
            tuple(self.size_box.currentData()),
            self.curves.isChecked(),
            self.replace.isChecked(),
        )

    def _ranges(self, seen: tuple[float, float]) -> list[tuple[str, tuple[int, int]]]:
        document = self._document
        assert document.data is not None
        frames, out = document.frames, []
        if (judged := document.interval) is not None:
            around = round(_AROUND_S * document.data.motion.fps)
            low, high = judged.interval.start - around, judged.interval.stop + around
            out.append(("The selected interval ± 0.5 s", (max(0, low), min(frames, high))))
        first, stop = max(0, round(seen[0] + 0.5)), min(frames, round(seen[1] + 0.5))
        if stop - first < frames and stop > first:
            out.append(("What the plots show", (first, stop)))
        out.append(("The whole clip", (0, frames)))
        return out

    def _reformat(self) -> None:
        path = Path(self.path.text())
        if path.suffix.lower() in _FORMATS:
            self.path.setText(str(path.with_suffix(str(self.format.currentData()))))
        self._describe()

    def _describe(self) -> None:
        choice = self.choice()
        film = choice.film
        for box in (self.range, self.speed):
            box.setEnabled(film)
        self.replace.setVisible(choice.path.exists())
        if not film or self._document.data is None:
            number = self._document.frame + self._document.first_frame
            self.length.setText(f"Frame {number}, as the window shows it.")
            return
        count = len(film_frames(choice, self._document.data.motion.fps))
        seconds = count / FPS[choice.path.suffix.lower()]
        self.length.setText(f"{count} pictures, {seconds:.1f} s; the camera stays as it is now.")

    def pattern(self) -> str:
        """Files of the chosen format."""
        suffix = str(self.format.currentData())
        return f"{_FORMATS[suffix]} (*{suffix})"


def _box(choices: Iterable[tuple[str, object]]) -> QComboBox:
    """One of the choices, each a text and what it stands for."""
    box = QComboBox()
    for text, value in choices:
        box.addItem(text, value)
    return box
