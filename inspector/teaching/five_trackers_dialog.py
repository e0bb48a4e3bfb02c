"""The window "Why quaternions", in which five tracking filters follow a joint through ±180°."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QGridLayout, QLabel, QSlider, QSpinBox, QWidget

from inspector.language import tr
from inspector.teaching.five_trackers import (
    FRAMES,
    euler_angles,
    fixed_axis_rotations,
    tracker_errors,
)
from inspector.widgets.axes import degrees_to_root_scale
from inspector.widgets.building import hbox, use_secondary_text_colour, vbox
from inspector.widgets.labels import Caption, SteadyLabel, coloured_rich_text
from inspector.widgets.signed_numbers import format_signed_number
from inspector.widgets.theme import Colours
from inspector.widgets.traces import Trace, TracePlot
from twistcore.skeleton.rotation import Array

_WORDS = {
    "Quaternion": tr(
        "The difference between pose and input is itself a rotation: the shorter of the two "
        "possible rotations, which has no seam at ±180°. Only the tracker's lag remains."
    ),
    "axis-angle, raw": tr(
        "At 180° the rotation vector flips to the opposite direction. The tracker turns all the "
        "way back, through poses that never occurred."
    ),
    "Euler XYZ, raw": tr(
        "180° becomes −180° between two frames. The tracker mistakes this numerical jump for "
        "motion."
    ),
    "Euler XYZ, wrapped": tr(
        "Wrapping the differences to ±180° removes the seam. But the three angles do not change "
        "evenly when the joint turns evenly: the faster the turn, the larger the error."
    ),
    "Quaternion, first-order": tr(
        "A linear step that is projected back onto the unit sphere is shorter than the "
        "rotation. The next frame makes up for this, so the error is hardly visible here."
    ),
}
_TITLES = {
    "Quaternion": tr("Quaternion"),
    "axis-angle, raw": tr("Axis-angle"),
    "Euler XYZ, raw": tr("Euler XYZ, raw"),
    "Euler XYZ, wrapped": tr("Euler XYZ, wrapped"),
    "Quaternion, first-order": tr("Quaternion, first-order"),
}
_EULER = (("X", "before"), ("Y", "accepted"), ("Z", "after"))
# Degrees; a larger change between frames is a jump from one end of the range to the other
_LEAP = 180.0


class FiveTrackers(QWidget):
    """The window with plots of five tracking filters for the chosen speed and frame."""

    def __init__(self, colours: Colours, parent: QWidget | None = None) -> None:
        super().__init__(parent, Qt.WindowType.Window)
        self.setWindowTitle(tr("Why quaternions"))
        self.frame = 0
        self._colours = colours
        self._build()
        colours.changed.connect(self.refresh)
        self.refresh()
        self.resize(1180, 620)

    def _build(self) -> None:
        self.words = Caption()
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(10, 150)  # hundredths of a turn per second
        self.slider.setValue(40)
        self.slider.setAccessibleName(tr("Speed of the joint"))
        self.slider.valueChanged.connect(self.refresh)
        self.speed = SteadyLabel()
        self.at = QSpinBox(minimum=0, maximum=FRAMES - 1, prefix=tr("frame "))
        self.at.setAccessibleName(tr("Frame"))
        self.at.valueChanged.connect(self.go_to)
        head = hbox(tr("Speed"), (self.slider, 1), self.speed, self.at)
        self.input_words = Caption()
        self.input = TracePlot(self._colours, "°")
        self.input.setMinimumHeight(140)
        self.input.setAccessibleName(tr("Euler angles of the input"))
        grid = QGridLayout()
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(2)
        self.titles: dict[str, Caption] = {}
        self.plots: dict[str, TracePlot] = {}
        for column, name in enumerate(_WORDS):
            title, plot = Caption(), TracePlot(self._colours, root=True)
            note = use_secondary_text_colour(
                QLabel(_WORDS[name], wordWrap=True, alignment=Qt.AlignmentFlag.AlignTop)
            )
            plot.setAccessibleName(
                tr("{tracker}: distance from the input over time", tracker=_TITLES[name])
            )
            plot.setMinimumHeight(150)
            plot.asked.connect(self.go_to)
            grid.addWidget(title, 0, column)
            grid.addWidget(plot, 1, column)
            grid.addWidget(note, 2, column)
            grid.setColumnStretch(column, 1)
            self.titles[name], self.plots[name] = title, plot
        grid.setRowStretch(1, 1)
        self.input.asked.connect(self.go_to)
        content = self.words, head, self.input_words, (self.input, 2), (grid, 3)
        vbox(*content, owner=self, margins=(12, 10, 12, 10), spacing=6)

    def refresh(self) -> None:
        """Compute the joint's rotation and the outputs of the filters, and show them."""
        q_hat = fixed_axis_rotations(0.01 * self.slider.value())
        self.found = tracker_errors(q_hat)
        self.angles = euler_angles(q_hat)
        x = np.arange(FRAMES, dtype=np.float64)
        lines = [Trace(x, _broken(self.angles[:, k]), role) for k, (_, role) in enumerate(_EULER)]
        self.input.show_lines(lines)
        self.input.show_range(FRAMES, -180.0, 180.0)
        top = max(float(distance.max()) for distance in self.found.values())
        for name, plot in self.plots.items():
            role = "after" if name.startswith("Quaternion") else "before"
            plot.show_lines([Trace(x, degrees_to_root_scale(self.found[name]), role)])
            plot.show_range(FRAMES, 0.0, float(degrees_to_root_scale(max(top, 10.0))))
        speed = tr("{turns:.2f} turns/s", turns=0.01 * self.slider.value())
        self.speed.setText(speed)
        self.words.set_text(
            tr(
                "One joint turns about one axis and is sampled at 25 Hz. Five trackers with the "
                "same gains (κP 600, κD 15) follow the joint. The plots show how far each tracker "
                "is from the input (on a √ scale)."
            )
        )
        self.go_to(self.frame)

    def go_to(self, frame: int) -> None:
        """Move the playhead of all plots."""
        self.frame = min(max(int(frame), 0), FRAMES - 1)
        with QSignalBlocker(self.at):
            self.at.setValue(self.frame)
        for plot in (self.input, *self.plots.values()):
            plot.show_frame(self.frame)
        angles = [
            f"{n} {format_signed_number(self.angles[self.frame, k], 0)}°"
            for k, (n, _) in enumerate(_EULER)
        ]
        inks = [getattr(self._colours.theme, role) for _, role in _EULER]
        keys = " &nbsp; ".join(
            coloured_rich_text(f"━ {t}", ink) for t, ink in zip(angles, inks, strict=True)
        )
        self.input_words.set_text(f"{tr('The input as XYZ Euler angles')} &nbsp; {keys}")
        self.input.setAccessibleDescription(", ".join(angles))
        for name, title in self.titles.items():
            distance = self.found[name]
            off = tr(
                "{angle:.1f}° away (largest distance: {most:.1f}°)",
                angle=distance[self.frame],
                most=distance.max(),
            )
            title.set_text(f"<b>{_TITLES[name]}</b><br>{off}")
            self.plots[name].setAccessibleDescription(off)


def _broken(angles: Array) -> Array:
    """Return the angles with NaN at every jump, where no line should be drawn."""
    out = angles.copy()
    out[1:][np.abs(np.diff(angles)) > _LEAP] = np.nan
    return out
