"""The circle on which a limb's middle joint moves, about the line from its first joint to its end.

A limb flip moves the knee or elbow along this circle, and the limb's first joint and end do not
move. A twist bone, which is often invisible, has a circle about its parent's bone, with a mark that
shows its roll. A rolled bone has a circle about its middle, with a fan from its captured front to
its corrected front.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport.bodies import SPHERE, TRIANGLES
from inspector.viewport.bone_colours import rgb
from inspector.viewport.mesh_actor import Piece, segments
from inspector.viewport.solid_and_ghost import SAME
from inspector.widgets.theme import Theme
from twistcore.detection.limb_flips import BENT
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb, joint_path
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, normalise, quaternion_from_axis_angle, rotate

# Radius of a bone's circle in bone lengths, and limits of the radius in figure heights
_FAN = 0.5, (0.08, 0.13)
LEAST_RADIUS = 0.07  # minimum radius of a limb's fan, in figure heights, outside its skin
_DIAL = 0.06  # radius of a twist bone's circle, in figure heights
# Position of the circle on the bone; closer to an end, a joint would hide the circle
_DIAL_AT = 0.25, 0.75
_FOLDED = 0.02  # relative to the limb's length; if its ends are closer, they define no line
_STEPS = 60  # steps of the circle
_ARC = 30  # steps of the arc from before to after
_DASHES = 11
# Radius of a mark: in figure heights and, about a bone, at most in radii and in lengths of the arc.
_MARK = 0.015, 0.10, 0.2
_HOLLOW = 1.25  # size of a hollow mark relative to a full mark
_CLEAR = 0.35  # opacity of the swept area
_ROUND = segments(np.arange(_STEPS + 1))
_RING = 20
_TURNS = np.linspace(0.0, 2.0 * np.pi, _RING, endpoint=False)
_FLAT = np.stack([np.cos(_TURNS), np.sin(_TURNS), np.zeros(_RING)], axis=1)
_HOOPS = np.vstack([np.roll(_FLAT, k, axis=1) for k in range(3)])  # a sphere of three rings
_WIRES = np.vstack([k * _RING + segments(np.append(np.arange(_RING), 0)) for k in range(3)])


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle about a line, on which a joint moves. All vectors are (3,).

    Attributes
    ----------
    first, end
        The ends of the line.
    axis
        The unit vector from `first` to `end`.
    centre
        The centre of the circle, on the line.
    aside
        The vector from the centre to the joint.
    """

    first: Array
    end: Array
    axis: Array
    centre: Array
    aside: Array

    def widened(self, radius: float) -> Circle:
        """Return the circle, enlarged if necessary to a radius of at least `radius`."""
        own = float(np.linalg.norm(self.aside))
        return self if own >= radius else replace(self, aside=self.aside * (radius / own))

    def at(self, angles: Array) -> Array:
        """Return the positions of the joint, (n, 3), after rotations by angles (n,) in radians."""
        return self.centre + rotate(quaternion_from_axis_angle(self.axis, angles), self.aside)


def find_limb_circle(limb: Limb, positions: Array) -> Circle | None:
    """Return a limb's circle for positions (joints, 3), or None if the limb is straight or folded.

    The middle joint of a straight limb has no angle about the line. The line of a folded limb has
    no direction, because its ends coincide.
    """
    first, middle, end = positions[[limb.parent, limb.child, limb.end]]
    length = float(np.linalg.norm(middle - first) + np.linalg.norm(end - middle))
    reach = float(np.linalg.norm(end - first))
    if reach <= _FOLDED * length:
        return None
    axis = (end - first) / reach
    centre = first + ((middle - first) @ axis) * axis
    aside = middle - centre
    bent = np.linalg.norm(aside) >= BENT * length
    return Circle(first, end, axis, centre, aside) if bent else None


def helper_circle(
    helper: Helper, skeleton: Skeleton, pose: tuple[Array, Array], height: float
) -> Circle | None:
    """Return the circle of a twist bone in a pose, or None if the bone is too short.

    `pose` contains the global rotations (joints, 4) and positions (joints, 3), and `height` is the
    height of the figure. The vector `aside` of the circle rotates with the twist bone.
    """
    rotations, positions = pose
    upper = int(skeleton.parents[helper.parent])
    first, end = positions[upper], positions[helper.child]
    length = float(np.linalg.norm(end - first))
    if length <= _FOLDED * height:
        return None
    axis = (end - first) / length
    share = np.clip((positions[helper.parent] - first) @ axis / length, *_DIAL_AT)
    own = np.mean(np.atleast_2d(helper.axis), axis=0)
    across = np.eye(3)[int(np.argmin(np.abs(own)))]
    across = rotate(rotations[helper.parent], across - (across @ own) * own)
    across = across - (across @ axis) * axis
    radius = min(_DIAL * height, 0.4 * length)
    return Circle(first, end, axis, first + share * length * axis, radius * normalise(across))


def bone_circle(ends: Array, front: Array, height: float) -> Circle | None:
    """Return the circle about the middle of a bone with the given ends, (2, 3), or None.

    `front` is the direction of the bone's front, (3,), and `height` is the height of the figure.
    The result is None if the bone is too short or if its front points along the bone.
    """
    first, end = ends
    length = float(np.linalg.norm(end - first))
    if length <= _FOLDED * height:
        return None
    axis = (end - first) / length
    across = front - (front @ axis) * axis
    if np.linalg.norm(across) < _FOLDED:
        return None
    share, bounds = _FAN
    radius = float(np.clip(share * length, *(height * np.array(bounds))))
    return Circle(first, end, axis, (first + end) / 2.0, radius * normalise(across))


def limb_bones(limb: Limb, skeleton: Skeleton) -> list[tuple[int, int]]:
    """Return the bones of a limb from its first joint to its end, as pairs (parent, joint)."""
    return [(int(skeleton.parents[j]), j) for j in joint_path(skeleton, limb.parent, limb.end)]


class LimbCircle:
    """The line and the circle of a limb or bone, and a fan with an arrow that shows the correction.

    The fan is the sector between the captured and the corrected position. A hollow mark on the
    circle shows the captured position, and a solid mark shows the corrected position.
    """

    def __init__(self, height: float, renderers: list[vtkRenderer]) -> None:
        dashes = np.arange(2 * _DASHES).reshape(-1, 2)
        way, rim = segments(np.arange(_ARC + 1)), segments(np.arange(1, _ARC + 2))
        fan = np.column_stack([np.zeros(_ARC, dtype=np.int64), rim])
        tip = [(_ARC, _ARC + 1), (_ARC, _ARC + 2)]
        self.line = Piece(2 * _DASHES, lines=dashes, channels=0).unlit(width=2.0)
        self.circle = Piece(_STEPS + 1, lines=_ROUND, channels=0).unlit(width=2.0)
        self.swept = Piece(_ARC + 2, faces=fan, channels=0).unlit().blended()
        self.swept.actor.GetProperty().SetOpacity(_CLEAR)
        edges = _ARC + 3 + np.arange(4).reshape(2, 2)  # edges of the fan
        self.way = Piece(_ARC + 7, lines=np.vstack([way, tip, edges])).unlit(width=4.0)
        self.before = Piece(len(_HOOPS), lines=_WIRES, channels=0).unlit(width=2.0)
        # This makes the mark look hollow.
        self.core = Piece(len(SPHERE), faces=TRIANGLES, channels=0).unlit()
        self.after = Piece(len(SPHERE), faces=TRIANGLES, channels=0).lit()
        self.pieces = (
            self.line, self.circle, self.swept, self.way, self.core, self.before, self.after
        )  # fmt: skip
        self._most, self._mark = _MARK[0] * height, 0.0
        for renderer in renderers:
            for piece in self.pieces:
                piece.add_to(renderer)

    def remove(self) -> None:
        """Remove the circle from the view."""
        for piece in self.pieces:
            piece.remove()

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        for piece in (self.line, self.circle):
            piece.tint(rgb(theme.soft))
        for piece in (self.swept, self.before):
            piece.tint(rgb(theme.before))
        self.core.tint(rgb(theme.raised))
        self.after.tint(rgb(theme.after))
        first = np.arange(_ARC + 7) >= _ARC + 5  # the edge at the captured position
        self.way.paint(np.where(first[:, None], rgb(theme.before), rgb(theme.after)))

    def draw(
        self,
        circle: Circle | None,
        offset: float,
        *,
        before: bool,
        after: Array | None,
        line: bool = True,
    ) -> None:
        """Draw the circle, or nothing if `circle` is None.

        Parameters
        ----------
        circle
            The circle before correction, or None.
        offset
            The offset of the limb in radians.
        before
            True to draw the captured mark.
        after
            The position of the corrected mark, (3,), or None for no mark.
        line
            True to draw the line and the circle. It is False for a bone, which has only a fan.
        """
        turned = circle is not None and bool(abs(offset) > SAME)
        both = turned and before and after is not None
        self.line.show(circle is not None and line)
        self.circle.show(circle is not None and line)  # for a bone, only the fan matters
        for piece in (self.swept, self.way):
            piece.show(both)
        self.before.show(turned and before)
        self.core.show(turned and before)
        self.after.show(turned and after is not None)
        if circle is None:
            return
        shares = np.linspace(0.0, 1.0, 2 * _DASHES)[:, None]
        self.line.move(circle.first + shares * (circle.end - circle.first))
        self.circle.move(circle.at(np.linspace(0.0, 2.0 * np.pi, _STEPS + 1)))
        if not turned:
            return
        radius = float(np.linalg.norm(circle.aside))
        self._mark = (
            self._most
            if line
            else min(self._most, _MARK[1] * radius, _MARK[2] * radius * abs(offset))
        )
        if before:
            place = circle.centre + circle.aside
            self.before.move(place + _HOLLOW * self._mark * _HOOPS)
            self.core.move(place + self._mark * SPHERE)
        if after is not None:
            self.after.move(after + self._mark * SPHERE)
        if both:
            rim = circle.at(np.linspace(0.0, -offset, _ARC + 1))
            self.swept.move(np.vstack([circle.centre, rim]))
            edges = [circle.centre, rim[-1], circle.centre, rim[0]]
            self.way.move(np.vstack([self._arrow(circle, -offset), edges]))

    def _arrow(self, circle: Circle, turn: float) -> Array:
        """Return the points of the arrow along the circle to the corrected mark, (n, 3).

        `turn` is the angle from the captured to the corrected mark in radians.
        """
        radius = float(np.linalg.norm(circle.aside))
        stop = turn - np.sign(turn) * min(self._mark / radius, 0.5 * abs(turn))
        size = min(2.0 * self._mark, 0.3 * radius * abs(stop))
        back = stop - np.sign(turn) * size / radius
        way = circle.at(np.append(np.linspace(0.0, stop, _ARC + 1), back))
        out = (way[-1] - circle.centre) / radius
        return np.vstack([way[:-1], way[-1] + 0.5 * size * np.array([[1.0], [-1.0]]) * out])
