"""The Record dialog, in which the user chooses film or picture, contents, speed and size."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QWidget

from inspector.language import tr, tr_as
from inspector.recording.choice import Contents, Paper, RecordChoice, film_shots
from inspector.recording.film import SUFFIXES
from inspector.recording.picture_rows import PictureRows
from inspector.recording.sweep_rows import SweepRows
from inspector.session.document import Document
from inspector.session.settings import FeatureSetting
from inspector.session.settings_checks import any_of
from inspector.viewport.frame_drawing import selected_chain
from inspector.widgets.building import hbox, use_secondary_text_colour
from inspector.widgets.write_dialog import WriteDialog
from twistcore.files.ordinary import path_exists
from twistcore.skeleton.limb import Limb

_FORMATS = {
    ".mp4": tr("Video, MP4"),
    ".gif": tr("Video, GIF"),
    ".png": tr("Image, PNG"),
    ".svg": tr("Image, SVG (vector graphics)"),
    ".pdf": tr("Image, PDF (vector graphics)"),
}
DEFAULT_FORMAT = ".mp4"
# The format that was recorded last.
LAST_FORMAT = FeatureSetting("record_format", DEFAULT_FORMAT, any_of(*_FORMATS))
_SIZES = ((1280, 720), (1920, 1080), (960, 540))
_SPEEDS = {
    tr("Real time"): 1.0,
    tr("Half speed"): 0.5,
    tr("1/4 speed"): 0.25,
    tr("1/10 speed"): 0.1,
}
_AROUND_S = 0.5
_SWEEP = tr("This frame, while a slider moves")
_NEEDS_CHAIN = tr("Whole limbs have no equations. Select a chain.")


class RecordDialog(WriteDialog):
    """A form with the settings of a recording."""

    def __init__(
        self,
        document: Document,
        seen: tuple[float, float],
        parent: QWidget,
        *,
        teaching: bool,
        suffix: str = DEFAULT_FORMAT,
    ) -> None:
        """Build the form.

        `seen` is the range of frames visible in the plots. `teaching` is True if the teaching tab
        is in front. `suffix` is the format that is selected at first.
        """
        assert document.data is not None
        proposed = document.proposed(f"_{document.chain or 'clip'}{suffix}")
        super().__init__(tr("Record"), proposed, parent)
        self._document = document
        chain = selected_chain(document)
        taught = chain is not None and not isinstance(chain, Limb)
        self.format = _box((text, suffix) for suffix, text in _FORMATS.items())
        self.format.setCurrentIndex(self.format.findData(suffix))
        self.range = _box(self._ranges(seen, taught=taught))
        self.speed = _box(_SPEEDS.items())
        self.size_box = _box((f"{width} × {height}", (width, height)) for width, height in _SIZES)
        self.view, self.curves = QCheckBox(tr("3D view")), QCheckBox(tr("Curves"))
        self.equations = QCheckBox(tr("Equations"))
        self.view.setChecked(True)
        self.curves.setChecked(True)
        self.equations.setChecked(taught and teaching)
        self.equations.setEnabled(taught)
        self.equations.setToolTip("" if taught else _NEEDS_CHAIN)
        self.length = use_secondary_text_colour(QLabel())
        self.form.addRow(tr("Format"), self.format)
        self.form.addRow(tr("Write to"), self.where)
        self.form.addRow("", self.replace)
        self.form.addRow(tr("Range"), self.range)
        self.form.addRow(tr("Speed"), self.speed)
        self.sweep = SweepRows(self.form)
        contents = hbox(self.view, self.curves, self.equations, None, spacing=14)
        self.form.addRow(tr_as("film", "Show"), contents)
        self.form.addRow(tr("Size"), self.size_box)
        self.picture = PictureRows(self.form)
        self.form.addRow("", self.length)
        self.end_form()
        self.format.currentIndexChanged.connect(self._reformat)
        for box in (self.range, self.speed):
            box.currentIndexChanged.connect(self._describe)
        for part in (self.sweep, self.picture):
            part.changed.connect(self._describe)
        for check in (self.view, self.curves, self.equations):
            check.toggled.connect(self._describe)
        self.path.textChanged.connect(self._describe)
        self._describe()

    def choice(self) -> RecordChoice:
        """Return the settings that the user has chosen."""
        span = self.range.currentData()
        path = Path(self.path.text()).expanduser()
        suffix = str(self.format.currentData())
        if path.suffix.lower() != suffix:
            path = path.with_name(path.name + suffix)
        film = suffix in SUFFIXES
        first, stop = span or (0, 1)
        return RecordChoice(
            path,
            first,
            stop,
            self.speed.currentData(),
            tuple(self.size_box.currentData()) if film else self.picture.size,
            self._contents(),
            self.replace.isChecked(),
            Paper() if film else self.picture.paper,
            self.sweep.sweep if film and span is None else None,
        )

    def _contents(self) -> Contents:
        checks = (self.view, self.curves, self.equations)
        return Contents(*(check.isChecked() for check in checks))

    def _ranges(
        self, seen: tuple[float, float], *, taught: bool
    ) -> list[tuple[str, tuple[int, int] | None]]:
        """Return the entries of the list of frames to film, as (text, frames).

        The frames are a range [first, stop), or None for a moving slider.
        """
        document = self._document
        assert document.data is not None
        frames = document.frames
        out: list[tuple[str, tuple[int, int] | None]] = []
        if (judged := document.interval) is not None:
            around = round(_AROUND_S * document.data.motion.fps)
            low, high = judged.interval.start - around, judged.interval.stop + around
            out.append((tr("The selected interval ± 0.5 s"), (max(0, low), min(frames, high))))
        first, stop = max(0, round(seen[0] + 0.5)), min(frames, round(seen[1] + 0.5))
        if stop - first < frames and stop > first:
            out.append((tr("The visible range"), (first, stop)))
        out.append((tr("The whole clip"), (0, frames)))
        if taught:
            out.append((_SWEEP, None))
        return out

    def _reformat(self) -> None:
        path = Path(self.path.text())
        if path.suffix.lower() in _FORMATS:
            self.path.setText(str(path.with_suffix(str(self.format.currentData()))))
        self._describe()

    def _describe(self) -> None:
        """Show the rows for the current choices, and describe the resulting film or picture."""
        choice = self.choice()
        film, sweep = choice.film, choice.sweep is not None
        for row, shown in (
            (self.range, film),
            (self.speed, film and not sweep),
            (self.size_box, film),
            (self.replace, path_exists(choice.path)),
        ):
            self.form.setRowVisible(row, shown)
        self.sweep.show(sweep)
        self.picture.show(not film)
        self.do_it.setEnabled(choice.contents.anything)
        self.length.setText(self._words(choice))

    def _words(self, choice: RecordChoice) -> str:
        document = self._document
        if not choice.contents.anything:
            return tr("Tick at least one of 3D view, curves and equations.")
        if document.data is None:
            return ""
        if not choice.film:
            frame, size = document.frame + document.first_frame, self.picture.words()
            return tr("Frame {frame}: {size}.", frame=frame, size=size)
        count = len(film_shots(choice, document.data.motion.fps, document.frame))
        return tr(
            "{n} images, {seconds:.1f} s. The camera does not move.",
            n=count,
            seconds=count / choice.fps,
        )

    def pattern(self) -> str:
        """Return the file dialog's name pattern for the chosen format."""
        suffix = str(self.format.currentData())
        return f"{_FORMATS[suffix].split(' (')[0]} (*{suffix})"


def _box(choices: Iterable[tuple[str, object]]) -> QComboBox:
    """Return a combo box of choices, given as pairs (text, value)."""
    box = QComboBox()
    for text, value in choices:
        box.addItem(text, value)
    return box
