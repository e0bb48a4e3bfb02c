"""Mouse and wheel over the 3D view, as camera moves and clicks.

VTK's own styles are kept out: they render twice a move, tip the figure over, and listen to keys
that quit or change the scene.
"""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

_CLICK = 4.0  # pixels the mouse may move between press and release
_TURN = 0.0075  # radians a pixel
_STEP = 1.15  # zoom a wheel notch


class Navigation(QObject):
    """Filters the events of a widget: drag, Shift+drag or middle drag, wheel, click, hover."""

    orbited = Signal(float, float)  # azimuth and elevation to add, radians
    panned = Signal(float, float)  # pixels right and up
    zoomed = Signal(float)  # factor, above 1 comes nearer
    clicked = Signal(QPointF)
    hovered = Signal(QPointF)

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        self._from: QPointF | None = None
        self._last = QPointF()
        self._dragged = False
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take what is meant for the camera; VTK sees no input at all."""
        kind = event.type()
        if kind in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease):
            event.ignore()  # on to the window, which knows the keys
            return True
        if kind in (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick):
            self._press(event)
        elif kind == QEvent.Type.MouseMove:
            self._move(event)
        elif kind == QEvent.Type.MouseButtonRelease:
            self._release(event)
        elif kind == QEvent.Type.Wheel:
            self._wheel(event)
        else:
            return kind in (QEvent.Type.Enter, QEvent.Type.Leave, QEvent.Type.Gesture)
        event.accept()
        return True

    def _press(self, event: QMouseEvent) -> None:
        self._from = self._last = event.position()
        self._dragged = False

    def _move(self, event: QMouseEvent) -> None:
        here = event.position()
        if self._from is None or event.buttons() == Qt.MouseButton.NoButton:
            self.hovered.emit(here)
            return
        if not self._dragged and (here - self._from).manhattanLength() < _CLICK:
            return
        self._dragged = True
        step = here - self._last
        self._last = here
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        if shift or event.buttons() & Qt.MouseButton.MiddleButton:
            self.panned.emit(step.x(), -step.y())
        elif event.buttons() & Qt.MouseButton.RightButton:
            self.zoomed.emit(_STEP ** (-step.y() / 20.0))
        else:
            self.orbited.emit(-_TURN * step.x(), _TURN * step.y())

    def _release(self, event: QMouseEvent) -> None:
        left = event.button() == Qt.MouseButton.LeftButton
        if self._from is not None and not self._dragged and left:
            self.clicked.emit(event.position())
        self._from = None

    def _wheel(self, event: QWheelEvent) -> None:
        notches = event.angleDelta().y() / 120.0
        if notches:
            self.zoomed.emit(_STEP**notches)
