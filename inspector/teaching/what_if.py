"""The sliders with which the user edits the displayed frame, and a sentence about the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QButtonGroup, QGridLayout, QLabel, QPushButton, QSlider, QWidget

from inspector.language import tr
from inspector.teaching.stage_player import StagePlayer
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.what_if_words import what_if_comment
from inspector.widgets.building import RIGHT, hbox, vbox
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.signed_numbers import format_number, format_signed_number
from inspector.widgets.theme import Colours, Theme, figures_font


@dataclass(frozen=True)
class _Knob:
    """The description of a slider.

    Attributes
    ----------
    text
        The label.
    low, high
        The range in `unit`.
    tip
        The tool tip.
    unit
        '°' or ' %'.
    steps
        The steps per unit.
    """

    text: str
    low: int
    high: int
    tip: str
    unit: str = "°"
    steps: int = 10

    def value(self, place: int) -> float:
        """Return the value at a slider position: radians for an angle, or 0…1 for per cent."""
        at = place / self.steps
        return at / 100.0 if self.unit == " %" else float(np.radians(at))

    def shown(self, value: float) -> float:
        """Convert a value from radians or from a share, 0…1, to the unit of the slider."""
        return 100.0 * value if self.unit == " %" else float(np.degrees(value))


_LEAST = 36  # minimum width of a slider in pixels
_KNOBS = {
    "twist": _Knob(tr("Twist parent"), -180, 180, tr("Turn the parent about its bone")),
    "swing": _Knob(
        tr("Swing α"), 0, 180, tr("The angle between a and w. At 180° the twist is undefined.")
    ),
    "bend": _Knob(tr("Bend"), 0, 180, tr("The angle between v and a. At 0° the limb is straight.")),
    "nudge": _Knob(
        tr("Nudge"),
        -3,
        3,
        tr(
            "Tilt P→C and C→G sideways by up to 3°. Near a singularity, this changes the angles a "
            "lot."
        ),
    ),
    "applied": _Knob(
        tr("Apply"),
        0,
        100,
        tr(
            "Remove part of the offset (Eq. 14–15): the selected interval’s offset in frames that "
            "are not altered, and the paper’s running sum offset(t) in all other frames."
        ),
        " %",
        1,
    ),
}


def _shown(knob: _Knob, value: float) -> str:
    number = format_signed_number if knob.low < 0 else format_number
    return f"{number(knob.shown(value), len(str(knob.steps)) - 1)}{knob.unit}"


class SpokenSlider(QSlider):
    """A slider that lets screen readers read its value together with the unit."""

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self._value = ""

    def set_spoken(self, value: str) -> None:
        """Set the text that a screen reader reads while the slider has the focus."""
        self._value = value
        if self.hasFocus():
            self.setAccessibleDescription(value)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Let a screen reader read the value when the slider gets the focus."""
        self.setAccessibleDescription(self._value)
        super().focusInEvent(event)


class WhatIfBox(QWidget):
    """A box with sliders, animation controls, buttons and a sentence about the edited frame."""

    def __init__(self, taught: TaughtFrame, colours: Colours) -> None:
        super().__init__()
        self._taught, self._colours = taught, colours
        self._role = ""
        self.sliders: dict[str, SpokenSlider] = {}
        self.numbers: dict[str, QLabel] = {}
        grid = QGridLayout()
        grid.setHorizontalSpacing(6)
        grid.setVerticalSpacing(2)
        for k, (name, knob) in enumerate(_KNOBS.items()):
            slider = SpokenSlider()
            slider.setRange(knob.low * knob.steps, knob.high * knob.steps)
            slider.setPageStep(5 * knob.steps if knob.high > 10 else knob.steps)
            slider.setToolTip(knob.tip)
            slider.setAccessibleName(knob.text)
            slider.setMinimumWidth(_LEAST)
            slider.valueChanged.connect(lambda v, n=name, k=knob: taught.alter(**{n: k.value(v)}))
            number = SteadyLabel(alignment=RIGHT)
            number.setFont(figures_font())
            widest = knob.low if knob.low < 0 else knob.high
            number.keep_room(_shown(knob, knob.value(widest * knob.steps)))
            row, column = k // 2, 4 * (k % 2)
            grid.addWidget(QLabel(knob.text), row, column)
            grid.addWidget(slider, row, column + 1)
            grid.addWidget(number, row, column + 2)
            grid.setColumnStretch(column + 1, 1)
            self.sliders[name], self.numbers[name] = slider, number
        self.player = StagePlayer(taught)
        grid.addWidget(self.player, 2, 4, 1, 3)
        grid.setColumnMinimumWidth(3, 8)
        self.follow = QPushButton(tr("Child follows"))
        self.counter = QPushButton(tr("Child counter-twists"))
        self.follow.setToolTip(
            tr("The parent's twist carries the child along, as in a real movement")
        )
        self.counter.setToolTip(
            tr("The child counter-rotates by the same angle, as in an axial twist error")
        )
        group = QButtonGroup(self)
        for button in (self.follow, self.counter):
            button.setCheckable(True)
            group.addButton(button)
        self.follow.setChecked(True)
        self.counter.toggled.connect(lambda on: taught.alter(counter=on))
        self.reset = QPushButton(tr("Reset"))
        self.reset.setToolTip(tr("Show the frame as captured"))
        self.reset.clicked.connect(taught.reset)
        self.words = QLabel(wordWrap=True, alignment=Qt.AlignmentFlag.AlignTop)
        self.words.setMinimumHeight(2 * self.words.fontMetrics().lineSpacing() + 2)
        buttons = hbox(self.follow, self.counter, None, self.reset, spacing=4)
        vbox(grid, buttons, self.words, owner=self, margins=(8, 4, 8, 5), spacing=3)
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        self._role = ""
        chosen = (
            f"background: {theme.accent}; color: {theme.on_accent}; border-color: {theme.accent}"
        )
        for button in (self.follow, self.counter):
            button.setStyleSheet(
                f"QPushButton {{ border: 1px solid {theme.line}; border-radius: 4px;"
                f" padding: 3px 6px; background: {theme.raised} }}"
                f" QPushButton:checked {{ {chosen} }}"
                f" QPushButton:focus {{ border-color: {theme.accent} }}"
            )

    def refresh(self) -> None:
        """Update the sliders, the numbers and the sentence."""
        numbers = self._taught.numbers if self._taught.active else None
        self.setEnabled(numbers is not None)
        if numbers is None:
            if self._taught.active:
                self._clear()
            return
        what_if, before = self._taught.what_if, numbers.correction.before
        values = {
            "twist": what_if.twist,
            "swing": before.alpha,
            "bend": before.bend if what_if.bend is None else what_if.bend,
            "nudge": what_if.nudge,
            "applied": what_if.applied,
        }
        if what_if.swing is not None:
            values["swing"] = what_if.swing
        for name, value in values.items():
            slider, knob = self.sliders[name], _KNOBS[name]
            place = round(knob.shown(value) * knob.steps)
            if place != slider.value():
                with QSignalBlocker(slider):
                    slider.setValue(place)
            self.numbers[name].setText(_shown(knob, value))
            slider.set_spoken(_shown(knob, value))
        for button, on in ((self.counter, what_if.counter), (self.follow, not what_if.counter)):
            if button.isChecked() != on:
                with QSignalBlocker(button):
                    button.setChecked(on)
        self.reset.setEnabled(what_if.changes or self._taught.stage is not None)
        text, role = what_if_comment(numbers, what_if, self._taught.stage)
        if text != self.words.text() or role != self._role:
            self._role = role
            self.words.setText(text)
            self.words.setStyleSheet(f"color: {getattr(self._colours.theme, role)}")

    def _clear(self) -> None:
        """Show no values and no sentence, because no chain is selected."""
        for name, slider in self.sliders.items():
            with QSignalBlocker(slider):
                slider.setValue(0)
            self.numbers[name].setText("")
            slider.set_spoken("")
        self.words.setText("")
