"""Control the camera with the mouse and the wheel over the 3D view.

VTK's own interaction styles are not used, because they render twice per movement, tip the figure
over, and have keys that quit or change the scene.
"""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

_CLICK = 4.0  # maximum movement of a click in pixels
_TURN = 0.0075  # radians per pixel
_STEP = 1.15  # zoom factor per notch of the wheel


class Navigation(QObject):
    """An event filter that moves the camera and reports mouse clicks and movements."""

    steered = Signal(object)  # with a function that takes and returns an OrbitCamera
    clicked = Signal(QPointF)
    hovered = Signal(QPointF)

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        self._from: QPointF | None = None
        self._last = QPointF()
        self._dragged = False
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle mouse and wheel events, and withhold all input events from VTK."""
        kind = event.type()
        if kind in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease):
            event.ignore()  # passes the key to the window
            return True
        if isinstance(event, QWheelEvent):
            self._zoom(event.angleDelta().y() / 120.0)
        elif not isinstance(event, QMouseEvent):
            return kind in (QEvent.Type.Enter, QEvent.Type.Leave, QEvent.Type.Gesture)
        elif kind == QEvent.Type.MouseMove:
            self._move(event)
        elif kind == QEvent.Type.MouseButtonRelease:
            self._release(event)
        else:
            self._from = self._last = event.position()
            self._dragged = False
        event.accept()
        return True

    def _move(self, event: QMouseEvent) -> None:
        here = event.position()
        if self._from is None or event.buttons() == Qt.MouseButton.NoButton:
            self.hovered.emit(here)
            return
        if not self._dragged and (here - self._from).manhattanLength() < _CLICK:
            return
        self._dragged = True
        right, down = (here - self._last).toTuple()
        self._last = here
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        if shift or event.buttons() & Qt.MouseButton.MiddleButton:
            view = self.parent()
            assert isinstance(view, QWidget)
            high = view.height()
            self.steered.emit(lambda camera: camera.panned(right, -down, high))
        elif event.buttons() & Qt.MouseButton.RightButton:
            self._zoom(-down / 20.0)
        else:
            self.steered.emit(lambda camera: camera.orbited(-_TURN * right, _TURN * down))

    def _release(self, event: QMouseEvent) -> None:
        left = event.button() == Qt.MouseButton.LeftButton
        if self._from is not None and not self._dragged and left:
            self.clicked.emit(event.position())
        self._from = None

    def _zoom(self, notches: float) -> None:
        if notches:
            self.steered.emit(lambda camera: camera.zoomed(_STEP**notches))
