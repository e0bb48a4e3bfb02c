"""The handles of the gizmo: their positions on the screen, and the effect of dragging them.

The handles are the tip of w, the bone's direction after the swing, and the dial of the twist θp.
All functions depend only on the camera and on positions in world coordinates. Pixels are counted
from the top left corner of the image.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inspector.teaching.gizmo_shapes import DIAL_AT, DIAL_SIZE, HAND_LONG, W_LONG, fan
from inspector.viewport.camera import OrbitCamera
from twistcore.analysis.decomposition import Decomposition
from twistcore.skeleton.directions import perpendicular
from twistcore.skeleton.rotation import Array, conjugate, multiply, normalise, rotate, wrap

W, DIAL = "w", "theta_p"  # the handles, named by their symbols
# Pixels from the tip of w or from the dial's edge within which the mouse grabs the handle
REACH = 14.0
# If the cosine between the view and the dial's axis is smaller, the dial is seen edge-on
_FLAT = 0.2
_DEAD = 0.15  # share of the dial's radius; closer to the centre, the mouse has no direction

Size = tuple[int, int]  # width and height of an image in pixels


@dataclass(frozen=True, eq=False)
class Handles:
    """The handles of a gizmo, in world coordinates.

    Attributes
    ----------
    above
        The global rotation of the joint above the parent, (4,).
    root
        The position of the parent, (3,).
    tip
        The tip of the arrow w, (3,).
    centre, radius
        The centre, (3,), and the radius of the dial.
    axis
        The unit vector w, (3,).
    hand
        The direction of the dial's hand, a unit vector (3,).
    """

    above: Array
    root: Array
    tip: Array
    centre: Array
    radius: float
    axis: Array
    hand: Array

    @property
    def ring(self) -> Array:
        """Points on the edge of the dial in world coordinates, (n, 3)."""
        return self.centre + self.radius * fan(self.hand, self.axis, 2.0 * np.pi)

    @property
    def hand_tip(self) -> Array:
        """The end of the dial's hand in world coordinates, (3,)."""
        return self.centre + HAND_LONG * self.radius * self.hand

    def own(self, way: Array) -> Array:
        """Convert a vector, (3,), from world coordinates to those of the joint above the parent."""
        return rotate(conjugate(self.above), way)


def place_gizmo_handles(d: Decomposition, q_parent: Array, parent: Array, unit: float) -> Handles:
    """Return the handles of a gizmo that `gizmo_shapes.sketch_gizmo` draws from the same values.

    Parameters
    ----------
    d
        The quantities of the frame.
    q_parent
        The global rotation of the parent, (4,).
    parent
        The position of the parent, (3,).
    unit
        The bone length that sets the size of the gizmo.
    """
    axis = rotate(q_parent, d.a)
    return Handles(
        above=multiply(q_parent, conjugate(d.q)),
        root=parent,
        tip=parent + W_LONG * unit * axis,
        centre=parent + DIAL_AT * unit * axis,
        radius=DIAL_SIZE * unit,
        axis=axis,
        hand=rotate(q_parent, perpendicular(d.a)),
    )


def handle_at(held: Handles, camera: OrbitCamera, size: Size, at: Array) -> str:
    """Return the name of the handle at a pixel, (2,), or '' if there is none."""
    tip, _ = camera.project(held.tip, *size)
    if np.linalg.norm(tip - at) <= REACH:
        return W
    ring, _ = camera.project(held.ring, *size)
    hand, _ = camera.project(np.stack([held.centre, held.hand_tip]), *size)
    away = min(_distance(at, line) for line in (ring, hand))
    return DIAL if away <= REACH else ""


class SwingDrag:
    """A drag of the tip of w with the mouse. The tip moves on a sphere around the parent.

    If the mouse leaves the outline of the sphere, the tip continues on the back of the sphere.
    """

    def __init__(self, held: Handles, camera: OrbitCamera, size: Size, at: Array) -> None:
        self._slip = at - camera.project(held.tip, *size)[0]
        ray = camera.ray(at - self._slip, *size)
        # The tip is on the far side of the sphere
        self._far = float((held.tip - held.root) @ ray) > 0.0

    def way(self, held: Handles, camera: OrbitCamera, size: Size, at: Array) -> Array:
        """Return the new direction of w, a unit vector (3,) in world coordinates.

        `at` is the pixel of the mouse, (2,).
        """
        ray = camera.ray(at - self._slip, *size)
        root = held.root - camera.position
        aside = float(root @ ray) * ray - root  # from the parent to the closest point of the ray
        radius = float(np.linalg.norm(held.tip - held.root))
        away = max(float(np.linalg.norm(aside)), 1e-12)
        share, side = away / radius, 1.0 if self._far else -1.0
        if share > 1.0:
            share, side = float(max(2.0 - share, 0.0)), -side
        out = np.sqrt(1.0 - share * share) * side * ray
        return normalise(out + share / away * aside)


class TwistDrag:
    """A drag of the dial. Its hand follows the mouse around the centre, for any number of turns.

    If the dial is seen edge-on, it rolls under the mouse instead.
    """

    def __init__(self, held: Handles, camera: OrbitCamera, size: Size, at: Array) -> None:
        self.turned = 0.0  # radians since the drag began, not wrapped
        self._start = perpendicular(held.axis)
        ray = camera.ray(camera.project(held.centre, *size)[0], *size)
        self._rolls = abs(float(ray @ held.axis)) < _FLAT
        self._last = self._angle(held, camera, size, at)

    def turn(self, held: Handles, camera: OrbitCamera, size: Size, at: Array) -> float:
        """Return the angle, in radians, by which the dial has rotated since the drag began.

        `at` is the pixel of the mouse, (2,).
        """
        now = self._angle(held, camera, size, at)
        if now is not None:
            if self._last is not None:
                step = now - self._last
                self.turned += step if self._rolls else float(wrap(step))
            self._last = now
        return self.turned

    def _angle(self, held: Handles, camera: OrbitCamera, size: Size, at: Array) -> float | None:
        """Return the angle of the mouse about the dial's axis in radians, or None if undefined."""
        if self._rolls:
            return self._rolled(held, camera, size, at)
        ray, axis = camera.ray(at, *size), held.axis
        along = float(ray @ axis)
        if abs(along) < 1e-3:
            return None
        far = float((held.centre - camera.position) @ axis) / along
        spoke = camera.position + far * ray - held.centre
        if far <= 0.0 or float(np.linalg.norm(spoke)) < _DEAD * held.radius:
            return None
        first = normalise(self._start - float(self._start @ axis) * axis)
        return float(np.arctan2(spoke @ np.cross(axis, first), spoke @ first))

    def _rolled(self, held: Handles, camera: OrbitCamera, size: Size, at: Array) -> float:
        """Return the angle, in radians, by which an edge-on dial has rolled under the mouse."""
        centre, _ = camera.project(held.centre, *size)
        ray = camera.ray(centre, *size)
        along = normalise(np.cross(held.axis, -ray))
        edge, _ = camera.project(held.centre + held.radius * along, *size)
        way = edge - centre
        return float((at - centre) @ way) / max(float(way @ way), 1e-9)


def _distance(at: Array, line: Array) -> float:
    """Return the distance, in pixels, of a point, (2,), from a polyline with n points, (n, 2)."""
    start, along = line[:-1], np.diff(line, axis=0)
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip(((at - start) * along).sum(axis=1) / length, 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, None] * along - at, axis=1).min())
