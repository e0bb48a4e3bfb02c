"""Sliders that alter the shown frame, and words on what happens at the two singularities."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QButtonGroup, QGridLayout, QLabel, QPushButton, QSlider, QWidget

from inspector.teaching.taught_frame import TaughtFrame
from inspector.widgets.building import RIGHT, hbox, vbox
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.signed_numbers import plain, signed
from inspector.widgets.theme import Theme, figures_font
from twistcore.decomposition import Decomposition, WhatIf

_STEPS = 10  # of a slider, a degree
_NEAR_SWING = 0.10  # reliability of θp below which the words warn: a swing beyond 168°
_NEAR_STRAIGHT = 0.17  # of the azimuth: a limb straighter than 10°
_SLIDERS = {  # name: what stands before it, range in degrees, what it is for
    "twist": ("Twist parent", -180, 180, "Turns the parent about its bone"),
    "swing": ("Swing α", 0, 180, "The angle between a and w; at 180° the twist is undefined"),
    "bend": ("Bend", 0, 180, "The angle between v and a; at 0° the limb is straight"),
    "nudge": ("Nudge", -3, 3, "Tips both bones sideways by up to 3°: little, but at a singularity"),
}
_HINT = "The frame as captured. Move a slider: what if …? Nothing of it reaches the review."


class WhatIfBox(QWidget):
    """Four sliders, what the child does, reset, and a sentence."""

    def __init__(self, taught: TaughtFrame) -> None:
        super().__init__()
        self._taught = taught
        self._theme: Theme | None = None
        self._role = ""
        self.sliders: dict[str, QSlider] = {}
        self.numbers: dict[str, QLabel] = {}
        grid = QGridLayout()
        grid.setHorizontalSpacing(6)
        grid.setVerticalSpacing(2)
        for k, (name, (text, low, high, tip)) in enumerate(_SLIDERS.items()):
            slider = QSlider(Qt.Orientation.Horizontal)
            slider.setRange(low * _STEPS, high * _STEPS)
            slider.setPageStep(5 * _STEPS if high > 10 else _STEPS)
            slider.setToolTip(tip)
            slider.setAccessibleName(text)
            slider.setMinimumWidth(60)
            slider.valueChanged.connect(
                lambda v, n=name: taught.alter(**{n: float(np.radians(v / _STEPS))})
            )
            number = SteadyLabel(alignment=RIGHT)
            number.setFont(figures_font())
            number.setText("−180.0°")
            row, column = k // 2, 4 * (k % 2)
            grid.addWidget(QLabel(text), row, column)
            grid.addWidget(slider, row, column + 1)
            grid.addWidget(number, row, column + 2)
            grid.setColumnStretch(column + 1, 1)
            self.sliders[name], self.numbers[name] = slider, number
        grid.setColumnMinimumWidth(3, 8)
        self.follow = QPushButton("Child goes along")
        self.counter = QPushButton("Child counter-twists")
        self.follow.setToolTip("The parent's twist carries the child: a real movement")
        self.counter.setToolTip("The child turns back by as much: an axial twist error")
        group = QButtonGroup(self)
        for button in (self.follow, self.counter):
            button.setCheckable(True)
            group.addButton(button)
        self.follow.setChecked(True)
        self.counter.toggled.connect(lambda on: taught.alter(counter=on))
        self.reset = QPushButton("Reset")
        self.reset.setToolTip("The frame as captured")
        self.reset.clicked.connect(taught.reset)
        self.words = QLabel(_HINT, wordWrap=True, alignment=Qt.AlignmentFlag.AlignTop)
        self.words.setMinimumHeight(2 * self.words.fontMetrics().lineSpacing() + 2)
        buttons = hbox(self.follow, self.counter, None, self.reset, spacing=4)
        vbox(grid, buttons, self.words, owner=self, margins=(10, 6, 10, 8), spacing=5)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._theme, self._role = theme, ""
        chosen = (
            f"background: {theme.accent}; color: {theme.on_accent}; border-color: {theme.accent}"
        )
        for button in (self.follow, self.counter):
            button.setStyleSheet(
                f"QPushButton {{ border: 1px solid {theme.line}; border-radius: 4px;"
                f" padding: 3px 10px; background: {theme.raised} }}"
                f" QPushButton:checked {{ {chosen} }}"
                f" QPushButton:focus {{ border-color: {theme.accent} }}"
            )

    def show_state(self, quantities: Decomposition | None) -> None:
        """Sliders where the taught frame is; an untouched one goes along with the clip."""
        self.setEnabled(quantities is not None)
        if quantities is None:
            return
        what_if = self._taught.what_if
        angles = {
            "twist": what_if.twist,
            "swing": quantities.alpha if what_if.swing is None else what_if.swing,
            "bend": quantities.bend if what_if.bend is None else what_if.bend,
            "nudge": what_if.nudge,
        }
        for name, angle in angles.items():
            slider, degrees = self.sliders[name], float(np.degrees(angle))
            if round(degrees * _STEPS) != slider.value():
                with QSignalBlocker(slider):
                    slider.setValue(round(degrees * _STEPS))
            told = signed if name in ("twist", "nudge") else plain
            self.numbers[name].setText(f"{told(degrees)}°")
        for button, on in ((self.counter, what_if.counter), (self.follow, not what_if.counter)):
            if button.isChecked() != on:
                with QSignalBlocker(button):
                    button.setChecked(on)
        self.reset.setEnabled(what_if.changes)
        text, role = words(quantities, what_if, self._taught.tau)
        if text != self.words.text() or role != self._role:
            self._role = role
            self.words.setText(text)
            if self._theme is not None:
                self.words.setStyleSheet(f"color: {getattr(self._theme, role)}")


def words(d: Decomposition, what_if: WhatIf, tau: float) -> tuple[str, str]:
    """What is to be seen, in a sentence or two, and the theme's colour for it."""
    turned, straight = d.swing_reliability < _NEAR_SWING, d.azimuth_reliability < _NEAR_STRAIGHT
    if turned and straight:
        return (
            "Both singularities. w points against a, so θp is arbitrary; v lies along the bone, so "
            "θc is too. Nudge: both jump, and hardly anything moves.",
            "warning",
        )
    if turned:
        return (
            f"Singularity of θp: w points against a ({d.swing_reliability:.0%} reliable). Every "
            "twist gives nearly the same pose. Nudge, and θp jumps.",
            "warning",
        )
    if straight:
        return (
            f"Singularity of θc: the limb is straight ({d.azimuth_reliability:.0%} reliable). v⊥ "
            "has hardly a direction. Nudge, and Δθc jumps.",
            "warning",
        )
    if d.strength >= tau > 0.0:
        return (
            "Parent and child twist against each other: Δθp·Δθc < 0, and m exceeds "
            f"τ = {np.degrees(tau):.1f}°. The grandchild stays where it was: a twist error.",
            "tau",
        )
    if what_if.changes and abs(what_if.twist) > 0.0 and not what_if.counter:
        return (
            "A pure twist: θp changes; w, n and α stay. The child goes along, so Δθc does not "
            "answer it: a real movement, no error.",
            "soft",
        )
    return (_HINT, "soft") if not what_if.changes else ("No twist error: m is below τ.", "soft")
