"""A clock-like drawing of a turn along its axis: hands before and after, and the degrees.

The hand after the correction can be dragged to change the offset (see `dial.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFont,
    QHideEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
)
from PySide6.QtWidgets import QWidget

from inspector.language import tr
from inspector.viewport.bodies import carried_normal
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.limb_turn import Turn
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array

_SHARE, _BOUNDS = 0.27, (64, 134)  # share of an image's width; pixels
_STEPS = 40  # of the arc
_FACE = 0.44  # radius of the face, in widths of the widget
_SMALL = math.cos(math.radians(32.0))  # cosine of the largest small turn
# Of a small turn: the length of the hands, and how far from the middle they and the degrees are.
_LONG, _BACK, _ASIDE = 0.82, 0.38, 0.10
_HUB = 0.26  # radius of the limb, in radii of the face
_ARC = 0.80  # radius of the arc
_GAP = 3.0  # pixels from the limb to the degrees
_TIP = 0.07  # length of the arrow's tip, in widths
_SAME = 0.01  # of the radius, less than a pixel
_SWEPT = 70  # alpha of the turned sector


@dataclass(frozen=True, eq=False)
class Hands:
    """The hands of the clock: a turn seen along its axis.

    - way: unit vectors from the captured to the corrected direction, (n, 2), y down
    - degrees: the angle to write
    """

    way: Array
    degrees: float

    @property
    def sense(self) -> float:
        """The degrees that a turn of the last hand by one degree, clockwise in the image, adds."""
        x, y = self.way[0], self.way[1]
        return math.copysign(1.0, self.degrees * float(x[0] * y[1] - x[1] * y[0]))

    @property
    def middle(self) -> Array:
        """The unit vector (2,) to the middle of the arc."""
        found: Array = self.way[len(self.way) // 2]
        return found

    @property
    def small(self) -> bool:
        """True for a small turn, which is drawn with longer hands."""
        return bool(self.way[0] @ self.way[-1] > _SMALL)

    def look_like(self, other: Hands) -> bool:
        """True if the two drawings would look the same."""
        near = np.abs(self.way[[0, -1]] - other.way[[0, -1]]).max() < _SAME
        return bool(near and round(self.degrees) == round(other.degrees))


def clock_size(picture: tuple[int, int]) -> QSize:
    """Return the size of the drawing for an image of this width and height, in pixels."""
    wide = round(min(max(_SHARE * picture[0], _BOUNDS[0]), _BOUNDS[1]))
    return QSize(wide, wide)


def hands_of(turn: Turn, camera: OrbitCamera, degrees: float) -> Hands:
    """Return the hands as seen by the camera after tipping it onto the axis of the turn.

    It is tipped the shortest way, so that directions in the image stay similar.
    """
    circle = turn.circle
    axis = circle.axis if circle.axis @ camera.direction >= 0.0 else -circle.axis
    right, up = (carried_normal(side, camera.direction, axis) for side in camera.axes[:2])
    arms = circle.at(np.linspace(0.0, -turn.drawn, _STEPS)) - circle.centre
    way = np.stack([arms @ right, -(arms @ up)], axis=1)
    return Hands(way / np.linalg.norm(way, axis=1, keepdims=True), degrees)


class Clock(QWidget):
    """The small drawing of a turn along its axis. A drag with the mouse turns the last hand.

    The signal `turned` is emitted with the change of the offset in degrees.
    """

    grasped = Signal()
    turned = Signal(float)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.hands: Hands | None = None
        self._grasp: tuple[float, float] | None = None  # degrees of the mouse, and the sense
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        self.setToolTip(tr("Drag the hand to change the offset δ of the selected interval."))
        self.offer(False)
        self.hide()

    @property
    def held(self) -> bool:
        """True while the user drags the hand."""
        return self._grasp is not None

    def offer(self, on: bool) -> None:
        """Let the user drag the hand (`on`), or let the mouse pass through."""
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents, not (on or self.held))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a drag with the left button."""
        if event.button() != Qt.MouseButton.LeftButton or self.hands is None:
            event.ignore()
            return
        self._grasp = self._degrees_at(event.position()), self.hands.sense
        self.setCursor(Qt.CursorShape.ClosedHandCursor)
        self.grasped.emit()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn the hand with the mouse about the centre."""
        if self._grasp is not None:
            (before, sense), now = self._grasp, self._degrees_at(event.position())
            self._grasp = now, sense
            self.turned.emit(sense * math.remainder(now - before, 360.0))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End the drag."""
        self._grasp = None
        self.setCursor(Qt.CursorShape.OpenHandCursor)

    def hideEvent(self, event: QHideEvent) -> None:
        """End the drag, because a hidden widget gets no release of the mouse."""
        self._grasp = None

    def _hub(self) -> QPointF:
        """Return the point about which the hands turn."""
        middle = QRectF(self.rect()).center()
        if self.hands is None or not self.hands.small:
            return middle
        return middle - QPointF(*(_BACK * self.width() * self.hands.middle).tolist())

    def _degrees_at(self, position: QPointF) -> float:
        arm = position - self._hub()
        return math.degrees(math.atan2(arm.y(), arm.x()))  # clockwise, since y points down

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self._theme = theme
        self.update()

    def show_hands(self, hands: Hands, at: QRect) -> None:
        """Show the hands in a rectangle of the view."""
        known, self.hands = self.hands, hands
        if not self.held:  # it must not move away under the mouse
            self.setGeometry(at)
        self.show()
        if known is None or not hands.look_like(known):
            self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the limb's cross-section, the hands, the arc between them, and its degrees."""
        if self.hands is None:
            return
        theme, painter = self._theme, QPainter(self)
        painter.setPen(QColor(theme.line))
        painter.setBrush(QColor(theme.raised))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))  # round corners take 2 ms
        middle = self._hub()
        radius = (_LONG if self.hands.small else _FACE) * self.width()
        way = [middle + QPointF(*(radius * arm).tolist()) for arm in self.hands.way]
        before, after = QColor(theme.before), QColor(theme.after)
        swept = QColor(before)
        swept.setAlpha(_SWEPT)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(swept)
        painter.drawPolygon(QPolygonF([middle, *(_nearer(p, middle, _ARC) for p in way)]))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for end, ink in ((way[0], before), (way[-1], after)):
            pen = QPen(ink, 0.045 * self.width())
            pen.setCapStyle(Qt.PenCapStyle.RoundCap)
            painter.setPen(pen)
            painter.drawLine(middle, end)
        self._draw_arc(painter, [_nearer(p, middle, _ARC) for p in way], after)
        painter.setPen(QPen(QColor(theme.soft), 1.5))
        painter.setBrush(QColor(theme.bone))
        hub = _HUB * _FACE * self.width()
        painter.drawEllipse(middle, hub, hub)
        self._draw_degrees(painter, middle, hub)

    def _draw_arc(self, painter: QPainter, way: list[QPointF], ink: QColor) -> None:
        painter.setPen(QPen(ink, 2.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawPolyline(QPolygonF(way))
        last, long = QLineF(way[-1], way[-2]), QLineF(way[0], way[-1]).length()
        size = min(_TIP * self.width(), 0.5 * long)
        for turn in (-35.0, 35.0):
            edge = QLineF(last)
            edge.setLength(size)
            edge.setAngle(last.angle() + turn)
            painter.drawLine(edge)

    def _draw_degrees(self, painter: QPainter, middle: QPointF, hub: float) -> None:
        """Write the degrees on the side away from the arc or, for a small turn, next to it."""
        assert self.hands is not None
        away = self.hands.middle
        text, font = f"{abs(self.hands.degrees):.0f}°", QFont(self.font())
        font.setBold(True)
        font.setPixelSize(max(12, round(0.15 * self.width())))
        painter.setFont(font)
        painter.setPen(QColor(self._theme.before))
        box = QRectF(painter.fontMetrics().boundingRect(text))
        if self.hands.small:
            middle, away = QRectF(self.rect()).center(), np.array([-away[1], away[0]])
            hub = _ASIDE * self.width()
        reach = hub + _GAP + 0.5 * float(np.abs(away) @ box.size().toTuple())
        box.moveCenter(middle - QPointF(*(reach * away).tolist()))
        room = QRectF(self.rect()).adjusted(_GAP, _GAP, -_GAP, -_GAP)
        box.moveLeft(min(max(box.left(), room.left()), room.right() - box.width()))
        box.moveTop(min(max(box.top(), room.top()), room.bottom() - box.height()))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def _nearer(point: QPointF, middle: QPointF, share: float) -> QPointF:
    """Return the point at a share of the way from the middle to another point."""
    return middle + (point - middle) * share
