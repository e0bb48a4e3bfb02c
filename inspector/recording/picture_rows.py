"""The rows of the Record dialog for a picture: size, resolution, font size and paper."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QLabel,
    QSpinBox,
)

from inspector.language import tr, tr_as
from inspector.recording.choice import SCREEN_DPI, Paper
from inspector.widgets.building import hbox

_INCH = 25.4  # millimetres per inch
_LONGEST = 12_000  # maximum number of pixels of a side; Qt's own limit is 32,767
_RESOLUTIONS = (96, 150, 300, 600)
_UNITS = {"mm": "mm", "pixels": tr("pixels")}


@dataclass(frozen=True)
class _Preset:
    """A suggested size of a picture, with a resolution and a font size.

    Attributes
    ----------
    width, height
        The size in `unit`. If the height is 0, it is adapted to the contents.
    unit
        'mm' or 'pixels'.
    dpi
        Pixels per inch.
    points
        The font size in points.
    """

    width: int
    height: int
    unit: str
    dpi: int
    points: float


_PRESETS = {
    tr("Column width, 90 mm"): _Preset(90, 0, "mm", 600, 7.0),
    tr("Page width, 180 mm"): _Preset(180, 0, "mm", 600, 8.0),
    tr("1280 × 720 pixels"): _Preset(1280, 720, "pixels", 96, 8.0),
    tr("1920 × 1080 pixels"): _Preset(1920, 1080, "pixels", 96, 12.0),
    tr("Custom size"): _Preset(120, 0, "mm", 600, 8.0),
}
_OWN = tr("Custom size")


class PictureRows(QObject):
    """Adds the rows for a picture to a form. `size` and `paper` are the user's choices."""

    changed = Signal()

    def __init__(self, form: QFormLayout) -> None:
        super().__init__(form)
        self._form, self._shown = form, False
        self.preset = QComboBox()
        for name, preset in _PRESETS.items():
            self.preset.addItem(name, preset)
        self.width, self.height = QSpinBox(), QSpinBox()
        self.height.setSpecialValueText(tr("as needed"))
        self.unit = QComboBox()
        for unit, name in _UNITS.items():
            self.unit.addItem(name, unit)
        self.width.setAccessibleName(tr("Width"))
        self.height.setAccessibleName(tr("Height"))
        self.unit.setAccessibleName(tr("Unit"))
        self._sides = hbox(self.width, "×", self.height, self.unit, None, spacing=6)
        self.dpi = QComboBox()
        for dpi in _RESOLUTIONS:
            self.dpi.addItem(f"{dpi} dpi", dpi)
        self.dpi.setAccessibleName(tr("Dots per inch"))
        self.points = QDoubleSpinBox(suffix=" pt", decimals=1, singleStep=0.5)
        self.points.setRange(4.0, 48.0)
        self.points.setToolTip(tr("Size of the smallest text on paper; lines scale accordingly"))
        self.points.setAccessibleName(tr("Font size"))
        self._at = QLabel(tr_as("resolution", "at"))
        self._fine = hbox(self.points, self._at, self.dpi, None, spacing=6)
        self.white = QCheckBox(tr("White background"))
        self.white.setChecked(True)
        form.addRow(tr("Size"), self.preset)
        form.addRow("", self._sides)
        form.addRow(tr("Font size"), self._fine)
        form.addRow("", self.white)
        self._propose()
        self.preset.currentIndexChanged.connect(self._propose)
        for box in (self.width, self.height, self.points):
            box.valueChanged.connect(self.changed)
        self.dpi.currentIndexChanged.connect(self._limit)
        self.unit.currentIndexChanged.connect(self._other_unit)

    def show(self, shown: bool) -> None:
        """Show the rows that apply to the current choices, or hide all rows if `shown` is False."""
        self._shown = shown
        preset = self.preset.currentData()
        own = self.preset.currentText() == _OWN
        for row in (self.preset, self._fine, self.white):
            self._form.setRowVisible(row, shown)
        self._form.setRowVisible(self._sides, shown and own)
        for part in (self._at, self.dpi):
            part.setVisible(shown and (own or preset.unit == "mm"))

    @property
    def size(self) -> tuple[int, int]:
        """The width and the height in pixels. If the height is 0, it is adapted to the contents."""
        sides = self.width.value(), self.height.value()
        if self._unit == "pixels":
            return sides
        wide, high = (round(side / _INCH * self.dpi.currentData()) for side in sides)
        return wide, high

    @property
    def paper(self) -> Paper:
        """The resolution, the font size and the colour of the paper."""
        return Paper(float(self.dpi.currentData()), self.points.value(), self.white.isChecked())

    def words(self) -> str:
        """Return a description of the picture's size, with a note if the size is at its limit."""
        most = self.width.maximum()
        if most not in (self.width.value(), self.height.value()):
            return self._size_in_words()
        limit = tr(
            "At {dpi}, each side can be at most {most} {unit}",
            dpi=self.dpi.currentText(),
            most=most,
            unit=self.unit.currentText(),
        )
        return f"{self._size_in_words()}. {limit}"

    def _size_in_words(self) -> str:
        wide, high = self.size
        pixels = (
            tr("{wide} × {high} pixels", wide=wide, high=high)
            if high
            else tr("{wide} pixels wide", wide=wide)
        )
        if self.dpi.currentData() == SCREEN_DPI:
            return pixels
        mm = [round(_INCH * side / self.dpi.currentData()) for side in (wide, high)]
        if high:
            return f"{mm[0]} × {mm[1]} mm ({pixels})"
        return tr("{mm} mm wide ({wide} pixels)", mm=mm[0], wide=wide)

    def _propose(self) -> None:
        """Fill in the values of the selected preset."""
        preset = self.preset.currentData()
        self.unit.setCurrentIndex(self.unit.findData(preset.unit))
        self.dpi.setCurrentIndex(self.dpi.findData(preset.dpi))
        self._limit()
        self.width.setValue(preset.width)
        self.height.setValue(preset.height)
        self.points.setValue(preset.points)
        self.white.setChecked(preset.unit == "mm")
        self.show(self._shown)
        self.changed.emit()

    def _other_unit(self) -> None:
        """Convert the size to the newly selected unit."""
        times = self.dpi.currentData() / _INCH
        if self._unit == "mm":
            times = 1.0 / times
        sides = self.width.value(), self.height.value()
        self._limit()
        for box, side in zip((self.width, self.height), sides, strict=True):
            box.setValue(round(side * times))
        self.changed.emit()

    def _limit(self) -> None:
        """Limit the width and the height to the maximum number of pixels."""
        pixels = self._unit == "pixels"
        most = _LONGEST if pixels else int(_LONGEST * _INCH / self.dpi.currentData())
        self.width.setRange(1, most)
        self.height.setRange(0, most)
        self.changed.emit()

    @property
    def _unit(self) -> str:
        return str(self.unit.currentData())
