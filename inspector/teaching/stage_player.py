"""The animation of the parent's rotation: first the swing of the bone, then its twist."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QSignalBlocker, QSize, Qt, QTimer
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QLabel, QMenu, QSizePolicy, QSlider, QWidget

from inspector.language import tr
from inspector.teaching.taught_frame import TaughtFrame
from inspector.widgets.building import hbox, tool_button

_GAP = 2  # pixels
_STEPS = 100  # steps of the slider for one stage
_END = 2.0  # the last stage: the whole rotation
_TICK_MS = 30
_SECONDS = 1.6  # seconds that a stage takes at the speed 1×
_REST = 0.6  # seconds at the end before the animation repeats
_SPEEDS = {"¼×": 0.25, "½×": 0.5, "1×": 1.0, "2×": 2.0}
_PLAY, _PAUSE = "▶", "⏸"
_TIP = tr(
    "P’s rotation step by step. In the first half, the swing takes a to w. In the second half, "
    "the twist rolls the bone and carries the children along. The last step shows the complete "
    "pose."
)


class StagePlayer(QWidget):
    """The controls of the animation: play button, slider, speed and loop button."""

    def __init__(self, taught: TaughtFrame) -> None:
        super().__init__()
        self._taught = taught
        self._at: float | None = None  # the stage that this player has set; None for the whole pose
        self.play = tool_button(_PLAY, tr("Play the swing first, then the twist"))
        self.play.setAccessibleName(self.play.toolTip())
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, round(_END * _STEPS))
        self.slider.setPageStep(_STEPS // 4)
        self.slider.setToolTip(_TIP)
        self.slider.setAccessibleName(tr("Swing, then twist"))
        self.slider.setMinimumWidth(50)
        self.speed = tool_button("1×", tr("Speed"))
        menu = QMenu(self.speed)
        self.speeds: dict[str, QAction] = {}
        for text in _SPEEDS:
            self.speeds[text] = menu.addAction(text)
            self.speeds[text].triggered.connect(lambda _=False, t=text: self.speed.setText(t))
        self.speed.setMenu(menu)
        self.speed.setPopupMode(self.speed.ToolButtonPopupMode.InstantPopup)
        self.loop = tool_button("↻", tr("Loop"))
        self.loop.setAccessibleName(self.loop.toolTip())
        self.loop.setCheckable(True)
        for button in (self.play, self.speed, self.loop):
            button.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self._words = QLabel(tr("a→swing→twist"))
        hbox(
            self._words, self.play, (self.slider, 1), self.speed, self.loop,
            owner=self, margins=(0, 0, 0, 0), spacing=_GAP,
        )  # fmt: skip
        self._timer = QTimer(self, interval=_TICK_MS)
        self._timer.timeout.connect(self._tick)
        self._clock = QElapsedTimer()
        self._rest = 0.0
        self.play.clicked.connect(self._toggle)
        self.slider.valueChanged.connect(self._dragged)
        taught.changed.connect(self._follow)
        self._follow()

    def minimumSizeHint(self) -> QSize:
        """Return the minimum size without the label, which is hidden if there is little room."""
        least, words = super().minimumSizeHint(), self._words
        gone = words.sizeHint().width() + _GAP if not words.isHidden() else 0
        return QSize(least.width() - gone, least.height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show the label only if there is enough room for it."""
        super().resizeEvent(event)
        wanted = self.minimumSizeHint().width() + self._words.sizeHint().width() + _GAP
        self._words.setVisible(self.width() >= wanted)

    @property
    def playing(self) -> bool:
        """True while the animation is running."""
        return self._timer.isActive()

    def _toggle(self) -> None:
        if self.playing:
            self.stop()
            return
        self._set(0.0 if self._taught.stage is None else self._taught.stage)
        self._rest = 0.0
        self._clock.start()
        self._timer.start()
        self.play.setText(_PAUSE)

    def stop(self) -> None:
        """Stop the animation at the current stage."""
        self._timer.stop()
        self.play.setText(_PLAY)

    def _tick(self) -> None:
        passed = 1e-3 * self._clock.restart()
        at = self._taught.stage
        if at is None:  # the animation shows the whole pose for a moment before it repeats
            self._rest -= passed
            if self._rest <= 0.0:
                self._set(0.0)
            return
        at += passed * _SPEEDS[self.speed.text()] / _SECONDS
        if at < _END:
            self._set(at)
            return
        self._rest = _REST
        if not self.loop.isChecked():
            self.stop()
        self._set(None)

    def _dragged(self, place: int) -> None:
        self.stop()
        self._set(place / _STEPS if place < self.slider.maximum() else None)

    def _set(self, stage: float | None) -> None:
        self._at = stage
        self._taught.set_stage(stage)

    def _follow(self) -> None:
        """Show the stage of the teaching tab on the slider.

        If the tab is hidden or something else has set the stage, stop the animation.
        """
        stage = self._taught.stage
        if stage != self._at or not self._taught.active:
            self._at = stage
            self.stop()
        place = self.slider.maximum() if stage is None else round(stage * _STEPS)
        if place != self.slider.value():
            with QSignalBlocker(self.slider):
                self.slider.setValue(place)
