"""The playback controls below the 3D view."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QSignalBlocker, QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QComboBox, QLabel, QSlider, QSpinBox, QWidget

from inspector.language import tr, tr_as
from inspector.session.document import Document
from inspector.session.open_clip import Show
from inspector.session.player import SPEEDS, Player
from inspector.widgets.building import hbox, tool_button, vbox

_MARGIN = 8  # pixels at the left and right end
_LEAST_SLIDER = 200  # pixels; with less space, the slider is in a separate row
_PLAY, _PAUSE = tr_as("button", "Play"), tr_as("button", "Pause")
_SHOWN = {
    Show.BEFORE: tr_as("in the 3D view", "Before"),
    Show.AFTER: tr_as("in the 3D view", "After"),
    Show.BOTH: tr_as("in the 3D view", "Both"),
}


class Transport(QWidget):
    """The playback controls: buttons, slider, frame number, time and speed.

    A list selects the figure that the 3D view shows: before correction, after correction, or both.
    """

    def __init__(self, document: Document, player: Player, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self._document, self._player = document, player
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.slider.setAccessibleName(tr("Playhead"))
        buttons = []
        for name, sign in (("previous_frame", "◀"), ("toggle_play", _PLAY), ("next_frame", "▶")):
            button = tool_button(sign, actions[name].toolTip())
            button.setAccessibleName(actions[name].text())
            button.clicked.connect(actions[name].trigger)
            buttons.append(button)
        self._buttons = buttons
        self._play = buttons[1]
        words = map(self._play.fontMetrics().horizontalAdvance, (_PLAY, _PAUSE))
        self._play.setFixedWidth(max(words) + 20)
        self.frame = QSpinBox()
        self.frame.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.frame.setMinimumWidth(self.fontMetrics().horizontalAdvance("0000000") + 36)
        self.frame.setToolTip(tr("Frame (Ctrl+J)"))
        self.frame.setAccessibleName(tr("Frame"))
        self.time = QLabel()
        self._time_width = self.fontMetrics().horizontalAdvance("000.000 / 000.00 s") + 8
        self.time.setMinimumWidth(self._time_width)
        self.speed = QComboBox()
        self.speed.addItems([f"{s:g}×" for s in SPEEDS])
        self.speed.setToolTip(tr("Speed (J slower, K real time, L faster)"))
        self.speed.setAccessibleName(tr("Speed"))
        self.show_box = QComboBox()
        self.show_box.addItems([_SHOWN[s] for s in Show])
        self.show_box.setToolTip(tr("What the 3D view shows (B)"))
        self.show_box.setAccessibleName(tr("What the 3D view shows"))
        for box in (self.speed, self.show_box):
            box.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._row = hbox(*buttons, self.frame, self.time, None, self.speed, self.show_box)
        self._rows = vbox(
            self.slider, self._row, owner=self, margins=(_MARGIN, 2, _MARGIN, 2), spacing=2
        )
        self._in_row = False  # True if the slider is in the row of the buttons
        self._place_slider(in_row=True)  # most windows are wide enough
        self.slider.valueChanged.connect(document.go_to)
        self.frame.valueChanged.connect(lambda f: document.go_to(f - document.first_frame))
        document.numbering_changed.connect(self._opened)
        self.speed.activated.connect(lambda k: player.set_speed(SPEEDS[k]))
        self.show_box.activated.connect(lambda k: document.set_show(list(Show)[k]))
        document.opened.connect(self._opened)
        document.frame_changed.connect(self._frame_changed)
        document.show_changed.connect(self._show_changed)
        player.changed.connect(self._player_changed)
        self._opened()
        self._show_changed()
        self._player_changed()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Adapt the controls to the width of the window.

        If the window is narrow, hide the time, which the curves also show. If it is very narrow,
        move the slider to a separate row as well.
        """
        super().resizeEvent(event)
        room = self.width() - self._least_width()
        fits = room >= _LEAST_SLIDER
        if fits != self._in_row:
            self._place_slider(in_row=fits)
        self.time.setVisible(room >= _LEAST_SLIDER + self._time_width)

    def minimumSizeHint(self) -> QSize:
        """Return the minimum size, with the time hidden and the slider in a separate row."""
        return QSize(self._least_width(), super().minimumSizeHint().height())

    def _least_width(self) -> int:
        """Return the width, in pixels, of all widgets except the time and the slider."""
        fixed = *self._buttons, self.frame, self.speed, self.show_box
        gaps = 2 * _MARGIN + self._row.spacing() * (len(fixed) + 1)
        return gaps + sum(max(p.minimumSizeHint().width(), p.minimumWidth()) for p in fixed)

    def _place_slider(self, *, in_row: bool) -> None:
        self._in_row = in_row
        (self._rows if in_row else self._row).removeWidget(self.slider)
        if in_row:
            self._row.insertWidget(self._row.indexOf(self.speed), self.slider, 1)
        else:
            self._rows.insertWidget(0, self.slider)
        gap = self._row.indexOf(self.time) + 1
        self._row.setStretch(gap, int(not in_row))

    def _counted(self) -> tuple[tuple[QSlider | QSpinBox, int], ...]:
        """Return the widgets that show the frame, each with its value at the clip's first frame."""
        return (self.slider, 0), (self.frame, self._document.first_frame)

    def _opened(self) -> None:
        last = max(self._document.frames - 1, 0)
        for widget, first in self._counted():
            with QSignalBlocker(widget):
                widget.setRange(first, last + first)
            widget.setEnabled(last > 0)
        for button in self._buttons:
            button.setEnabled(last > 0)
        self._frame_changed(self._document.frame)

    def _frame_changed(self, frame: int) -> None:
        for widget, first in self._counted():
            with QSignalBlocker(widget):
                widget.setValue(frame + first)
        if data := self._document.data:
            seconds = frame * data.motion.frame_time
            total = data.motion.frames * data.motion.frame_time
            self.time.setText(f"{seconds:.3f} / {total:.2f} s")
        else:
            self.time.setText("")

    def _show_changed(self) -> None:
        self.show_box.setCurrentIndex(list(Show).index(self._document.show))

    def _player_changed(self) -> None:
        self._play.setText(_PAUSE if self._player.playing else _PLAY)
        speed = abs(self._player.speed)
        self.speed.setCurrentIndex(min(range(len(SPEEDS)), key=lambda k: abs(SPEEDS[k] - speed)))
