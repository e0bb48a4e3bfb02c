"""The rows of the Record dialog for a moving slider: the slider, its range and its duration."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QDoubleSpinBox, QFormLayout

from inspector.language import tr, tr_as
from inspector.recording.sweep import SWEPT, Sweep
from inspector.widgets.building import hbox
from inspector.widgets.signed_numbers import SignedBox


class SweepRows(QObject):
    """Adds the rows for a moving slider to a form. `sweep` is the user's choice."""

    changed = Signal()

    def __init__(self, form: QFormLayout) -> None:
        super().__init__(form)
        self._form = form
        self.slider = QComboBox()
        for name, swept in SWEPT.items():
            self.slider.addItem(swept.words, name)
        self.first, self.last = SignedBox(), SignedBox()
        self.seconds = QDoubleSpinBox(suffix=" s", decimals=1, singleStep=0.5)
        self.seconds.setRange(0.5, 60.0)
        self.seconds.setValue(4.0)
        self.and_back = QCheckBox(tr("and back"))
        self.and_back.setChecked(True)
        self.first.setAccessibleName(tr("From"))
        self.last.setAccessibleName(tr("To"))
        self.seconds.setAccessibleName(tr("Seconds for each direction"))
        start, end, within = tr_as("slider", "from"), tr_as("slider", "to"), tr_as("slider", "in")
        ends = start, self.first, end, self.last, within, self.seconds
        self._ends = hbox(*ends, self.and_back, None, spacing=6)
        form.addRow(tr("Slider"), self.slider)
        form.addRow("", self._ends)
        self._propose()
        self.slider.currentIndexChanged.connect(self._propose)
        for box in (self.first, self.last, self.seconds):
            box.valueChanged.connect(self.changed)
        self.and_back.toggled.connect(self.changed)

    def show(self, shown: bool) -> None:
        """Show the rows, or hide them if `shown` is False."""
        self._form.setRowVisible(self.slider, shown)
        self._form.setRowVisible(self._ends, shown)

    @property
    def sweep(self) -> Sweep:
        """The chosen slider, with the range and the duration of its movement."""
        return Sweep(
            self.slider.currentData(),
            self.first.value(),
            self.last.value(),
            self.seconds.value(),
            self.and_back.isChecked(),
        )

    def _propose(self) -> None:
        """Fill in the range of the selected slider, excluding negative values."""
        swept = SWEPT[self.slider.currentData()]
        for box in (self.first, self.last):
            box.setDecimals(swept.decimals)
            box.setRange(swept.low, swept.high)
            box.setSuffix(f" {swept.unit}" if swept.unit == "%" else swept.unit)
        self.first.setValue(max(swept.low, 0.0))
        self.last.setValue(swept.high)
        self.changed.emit()
