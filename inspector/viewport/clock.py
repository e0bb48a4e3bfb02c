"""A clock-like drawing of a rotation as seen along its axis, with the angle in degrees.

One hand points in the direction before correction and the other in the direction after correction.
The user can drag the second hand to change the offset (see `dial.py`).
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
from inspector.viewport.bodies import apply_shortest_rotation
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.limb_turn import Turn
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array

# Width of the drawing, as a share of the image's width, and its limits in pixels
_SHARE, _BOUNDS = 0.27, (64, 134)
_STEPS = 40  # number of points on the arc
_FACE = 0.44  # radius of the clock's face, as a share of the widget's width
_SMALL = math.cos(math.radians(32.0))  # cosine of the largest angle that is drawn as a small one
# Layout of a small angle, as shares of the widget's width: the length of the hands, and the
# distances from the middle of the widget to the hub and to the text.
_LONG, _BACK, _ASIDE = 0.82, 0.38, 0.10
_HUB = 0.26  # radius of the limb's cross-section, in radii of the face
_ARC = 0.80  # radius of the arc, in lengths of the hands
_GAP = 3.0  # pixels between the text and the limb's cross-section or the border
_TIP = 0.07  # length of the arrowhead, as a share of the widget's width
_SAME = 0.01  # relative to the hands' length; a smaller change of a hand is not visible
_SWEPT = 70  # opacity of the sector between the hands, 0…255


@dataclass(frozen=True, eq=False)
class Hands:
    """The hands of the clock, which show a rotation as seen along its axis.

    Attributes
    ----------
    way
        Unit vectors from the hub to points along the arc, in the image, (n, 2). The first is the
        captured direction and the last the corrected direction. The y axis points down.
    degrees
        The angle to show as text, in degrees.
    """

    way: Array
    degrees: float

    @property
    def sense(self) -> float:
        """The change in the offset, in degrees, if the corrected hand moves 1° clockwise: ±1.0."""
        x, y = self.way[0], self.way[1]
        return math.copysign(1.0, self.degrees * float(x[0] * y[1] - x[1] * y[0]))

    @property
    def middle(self) -> Array:
        """The unit vector from the hub to the middle of the arc, (2,)."""
        found: Array = self.way[len(self.way) // 2]
        return found

    @property
    def small(self) -> bool:
        """True if the angle is small, so that longer hands are drawn."""
        return bool(self.way[0] @ self.way[-1] > _SMALL)

    def look_like(self, other: Hands) -> bool:
        """Return True if a drawing of `other` would look the same."""
        near = np.abs(self.way[[0, -1]] - other.way[[0, -1]]).max() < _SAME
        return bool(near and round(self.degrees) == round(other.degrees))


def clock_size(picture: tuple[int, int]) -> QSize:
    """Return the size of the drawing for an image of the given width and height, in pixels."""
    wide = round(min(max(_SHARE * picture[0], _BOUNDS[0]), _BOUNDS[1]))
    return QSize(wide, wide)


def clock_hands(turn: Turn, camera: OrbitCamera, degrees: float) -> Hands:
    """Return the hands that show a rotation as seen along its axis.

    The view along the axis is obtained by the shortest rotation of the camera, so directions in the
    drawing are similar to directions in the image.

    Parameters
    ----------
    turn
        The rotation to show.
    camera
        The camera of the image.
    degrees
        The angle to show as text, in degrees.
    """
    circle = turn.circle
    axis = circle.axis if circle.axis @ camera.direction >= 0.0 else -circle.axis
    right, up = (apply_shortest_rotation(side, camera.direction, axis) for side in camera.axes[:2])
    arms = circle.at(np.linspace(0.0, -turn.drawn, _STEPS)) - circle.centre
    way = np.stack([arms @ right, -(arms @ up)], axis=1)
    return Hands(way / np.linalg.norm(way, axis=1, keepdims=True), degrees)


class Clock(QWidget):
    """A small drawing of a rotation as seen along its axis, with a hand that the user can drag.

    Attributes
    ----------
    grasped
        Signal that is emitted when the user starts to drag the corrected hand.
    turned
        Signal that is emitted during a drag, with the change in the offset in degrees.
    hands
        The hands that are drawn, or None.
    """

    grasped = Signal()
    turned = Signal(float)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.hands: Hands | None = None
        # During a drag: the direction from the hub to the mouse in degrees, and Hands.sense
        self._grasp: tuple[float, float] | None = None
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        self.setToolTip(
            tr("Drag the hand of the dial to change the offset δ of the selected interval.")
        )
        self.offer(False)
        self.hide()

    @property
    def held(self) -> bool:
        """True while the user drags the hand."""
        return self._grasp is not None

    def offer(self, on: bool) -> None:
        """Set whether the user can drag the hand.

        If `on` is False, mouse events pass through to the view. A drag that has begun continues.
        """
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents, not (on or self.held))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start a drag if the left button is pressed."""
        if event.button() != Qt.MouseButton.LeftButton or self.hands is None:
            event.ignore()
            return
        self._grasp = self._degrees_at(event.position()), self.hands.sense
        self.setCursor(Qt.CursorShape.ClosedHandCursor)
        self.grasped.emit()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """During a drag, emit the change in the offset as the mouse moves around the hub."""
        if self._grasp is not None:
            (before, sense), now = self._grasp, self._degrees_at(event.position())
            self._grasp = now, sense
            self.turned.emit(sense * math.remainder(now - before, 360.0))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End the drag."""
        self._grasp = None
        self.setCursor(Qt.CursorShape.OpenHandCursor)

    def hideEvent(self, event: QHideEvent) -> None:
        """End the drag, because a hidden widget gets no event when the button is released."""
        self._grasp = None

    def _hub(self) -> QPointF:
        """Return the hub: the pixel around which the hands rotate."""
        middle = QRectF(self.rect()).center()
        if self.hands is None or not self.hands.small:
            return middle
        return middle - QPointF(*(_BACK * self.width() * self.hands.middle).tolist())

    def _degrees_at(self, position: QPointF) -> float:
        arm = position - self._hub()
        return math.degrees(math.atan2(arm.y(), arm.x()))  # clockwise, because y points down

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self._theme = theme
        self.update()

    def show_hands(self, hands: Hands, at: QRect) -> None:
        """Show the hands in the rectangle `at` of the view.

        During a drag, the drawing does not move.
        """
        known, self.hands = self.hands, hands
        if not self.held:  # during a drag, the drawing must stay under the mouse
            self.setGeometry(at)
        self.show()
        if known is None or not hands.look_like(known):
            self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the limb's cross-section, the hands, the arc between them, and the angle."""
        if self.hands is None:
            return
        theme, painter = self._theme, QPainter(self)
        painter.setPen(QColor(theme.line))
        painter.setBrush(QColor(theme.raised))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))  # round corners would take 2 ms
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
        """Write the angle opposite the arc or, if the angle is small, next to the hands."""
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
    """Return a point between `middle` (share 0) and `point` (share 1)."""
    return middle + (point - middle) * share
