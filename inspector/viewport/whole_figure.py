"""A small drawing of the whole figure, shown when the image shows only a part of the figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from inspector.viewport.bone_colours import Role
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Pose
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array, rotate

# Width of the drawing, as a share of the image's width, and its limits in pixels
_SHARE, _BOUNDS = 0.24, (64, 120)
_TALL = 1.3  # height of the drawing divided by its width
_AIR = 1.3  # size of the drawing relative to the figure
_NOSE = 1.9  # distance from the middle of the head to the tip of the nose, in half widths
_APART = 26.0  # pixels; if two joints are closer, only one of them has a letter
_GAP = 10.0  # pixels from a joint to the letter of its side
# Directions from a joint in which its letter may be placed; y points down
_WAYS = np.array([[1, 0], [-1, 0], [0.8, 0.6], [-0.8, 0.6], [0.8, -0.6], [-0.8, -0.6]])
_ALONG = np.linspace(0.0, 1.0, 6)[:, None]  # positions along a bone


@dataclass(frozen=True, eq=False)
class Miniature:
    """The geometry of a small drawing of the figure, in pixels.

    Attributes
    ----------
    bones
        The two ends of each bone, (n, 2, 2).
    roles
        The role of each bone, from bone_colours.Role, (n,).
    heads
        The centre of each head and the tip of its nose, (heads, 2, 2).
    radius
        The radius of each head, (heads,).
    facing
        A mask of the heads that face the viewer, (heads,).
    letters
        The pixel at which to draw the letter of each side, (2,), keyed by side.
    """

    bones: Array
    roles: NDArray[np.int64]
    heads: Array
    radius: Array
    facing: NDArray[np.bool_]
    letters: Mapping[str, Array]


def miniature_size(picture: tuple[int, int]) -> QSize:
    """Return the size of the drawing for an image of the given width and height, in pixels."""
    wide = round(min(max(_SHARE * picture[0], _BOUNDS[0]), _BOUNDS[1]))
    return QSize(wide, round(_TALL * wide))


def miniature(
    scene: Scene,
    pose: Pose,
    ends: Array,
    own: NDArray[np.bool_],
    sides: Mapping[str, int],
    camera: OrbitCamera,
    size: QSize,
) -> Miniature:
    """Return a drawing of the whole figure, seen from the direction of the camera.

    Parameters
    ----------
    scene
        The scene of the open clip.
    pose
        The pose to draw.
    ends
        The ends of all bones in world space, (bones, 2, 3).
    own
        A mask of the bones to draw, which are the bones of one person, (bones,).
    sides
        The joint that gets the letter of each side, keyed by side. The last entry is the joint of
        the selected limb.
    camera
        The camera of the image.
    size
        The size of the drawing.
    """
    wide, high = size.toTuple()
    shown = ends[own]
    whole = camera.framing(shown.reshape(-1, 3), wide / high, margin=_AIR)
    owners = {scene.bones[k].parent for k in np.flatnonzero(own)}
    fronts = [f.bone for f in scene.fronts if f.face and f.bone.parent in owners]
    parents, widths = [b.parent for b in fronts], np.array([b.width for b in fronts])
    vectors = np.array([(b.tip, b.normal) for b in fronts]).reshape(-1, 2, 3)
    tip, ahead = rotate(pose.rotations[parents][:, None], vectors).swapaxes(0, 1)
    heads = pose.positions[parents] + tip
    rim = heads + widths[:, None] * whole.axes[0]
    nose = heads + _NOSE * widths[:, None] * ahead
    at = pose.positions[list(sides.values())].reshape(-1, 3)
    points, _ = whole.project(np.vstack([shown.reshape(-1, 3), heads, rim, nose, at]), wide, high)
    cuts = np.cumsum([2 * len(shown), len(heads), len(heads), len(heads)])
    bones, centre, rims, noses, places = np.split(points, cuts)
    if len(places) > 1 and np.linalg.norm(places[0] - places[-1]) < _APART:
        sides, places = dict([*sides.items()][-1:]), places[-1:]  # the selected limb
    ends_of = bones.reshape(-1, 2, 2)
    drawn = ends_of[:, :1] + _ALONG * (ends_of[:, 1:] - ends_of[:, :1])
    full = np.vstack([drawn.reshape(-1, 2), centre, places])
    return Miniature(
        bones.reshape(-1, 2, 2),
        pose.roles[own],
        np.stack([centre, noses], axis=1),
        1.2 * np.linalg.norm(rims - centre, axis=1),
        ahead @ whole.direction > 0.0,
        {side: _free_place(at, full) for side, at in zip(sides, places, strict=True)},
    )


def _free_place(at: Array, full: Array) -> Array:
    """Return a pixel for a letter, (2,), that is near a joint and far from the drawn figure.

    Parameters
    ----------
    at
        The pixel of the joint, (2,).
    full
        Pixels on the figure, (n, 2).
    """
    near = at + _GAP * _WAYS
    apart = np.linalg.norm(near[:, None] - full, axis=-1).min(axis=1)
    best: Array = near[int(np.argmax(apart))]
    return best


class WholeFigure(QWidget):
    """A widget with a small drawing of the whole figure."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._miniature: Miniature | None = None
        self._words: Mapping[str, str] = {}
        self.hide()

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self._theme = theme
        self.update()

    def show_miniature(self, drawn: Miniature, at: QRect, words: Mapping[str, str]) -> None:
        """Show a drawing of the figure.

        Parameters
        ----------
        drawn
            The geometry of the drawing.
        at
            The rectangle of the widget in the view.
        words
            The letter of each side, keyed by side.
        """
        self._miniature, self._words = drawn, words
        self.setGeometry(at)
        self.show()
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the figure, with its selected and wrong bones in colour, and the side letters."""
        if self._miniature is None:
            return
        drawn, theme, painter = self._miniature, self._theme, QPainter(self)
        painter.setPen(QColor(theme.line))
        painter.setBrush(QColor(theme.raised))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))  # round corners would take 2 ms
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        inks = {Role.CHOSEN: theme.accent, Role.BEFORE: theme.before, Role.AFTER: theme.after}
        for role in Role:
            pen = QPen(QColor(inks.get(role, theme.soft)), 4.0 if role in inks else 2.0)
            pen.setCapStyle(Qt.PenCapStyle.RoundCap)
            painter.setPen(pen)
            painter.drawLines(
                [QLineF(*a, *b) for a, b in drawn.bones[drawn.roles == role].tolist()]
            )
        for head, radius, facing in zip(drawn.heads, drawn.radius, drawn.facing, strict=True):
            centre, nose = (QPointF(*point) for point in head.tolist())
            face = QColor(theme.surface if facing else theme.soft)
            middle = centre + (nose - centre) * 0.4  # between the eyes
            aside = QPointF(0.45 * radius, 0.0)
            painter.setPen(QPen(QColor(theme.soft), 2.5))
            painter.setBrush(face)
            if facing:
                painter.drawEllipse(centre, radius, 1.25 * radius)
                painter.drawPoints([middle - aside, middle + aside])
            else:
                painter.drawLine(centre, nose)
                painter.drawEllipse(centre, radius, 1.25 * radius)
        painter.setPen(QColor(theme.text))
        for side, at in drawn.letters.items():
            box = QRectF(0.0, 0.0, 20.0, 20.0)
            box.moveCenter(QPointF(*at.tolist()))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self._words.get(side, ""))
