"""The geometry of the gizmo: shapes that show the symbols of the paper in 3D for one frame.

The gizmo has the same number of points in every frame, so that a new frame only moves the points.
The symbols are explained in `inspector/teaching/symbols.py`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from inspector.viewport.bodies import SPHERE, TRIANGLES
from inspector.viewport.mesh_actor import Index, segments
from twistcore.analysis.decomposition import Decomposition
from twistcore.skeleton.directions import cross, perpendicular
from twistcore.skeleton.rotation import Array, conjugate, multiply, rotate

_ARC = 32  # steps of an arc
_DASHES = 9
_HEAD = (0.105, 0.030)  # length and radius of an arrow head, in bone lengths
_RING = 10
_CONE = np.array([(end, 2 + k, 2 + (k + 1) % _RING) for end in (0, 1) for k in range(_RING)])
_SIDES = np.sort(TRIANGLES[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
_WIRES = np.unique(_SIDES, axis=0)  # edges of a sphere's triangles
_SEEN = np.radians(1.0)  # smaller differences of angles are not drawn
W_LONG = 0.92  # length of the arrow w, in bone lengths
# Distance of the dial from the parent along w, and its radius, in bone lengths
DIAL_AT, DIAL_SIZE = 0.60, 0.25
HAND_LONG = 1.12  # length of the dial's hand, relative to the radius of the dial

# How a part is drawn: as bold or thin lines, or as solid or clear faces.
BOLD, THIN = "bold", "thin"
SOLID, CLEAR = "solid", "clear"


@dataclass(frozen=True, eq=False)
class GizmoPart:
    """A part of the gizmo: points, and the lines or faces between them.

    Attributes
    ----------
    symbol
        The symbol that the part shows.
    look
        BOLD or THIN for lines, SOLID or CLEAR for faces.
    points
        The positions, (n, 3).
    cells
        The point indices of lines, (m, 2), or of faces, (m, 3 or 4).
    share
        The opacity of a line or a CLEAR face, 0…1.
    """

    symbol: str
    look: str
    points: Array
    cells: Index
    share: float = 1.0


@dataclass(frozen=True, eq=False)
class Mark:
    """A label at a point.

    Attributes
    ----------
    symbol
        A key of symbols.MARKS.
    at
        The position, (3,).
    away
        A point, (3,), from which the label is shifted away.
    words
        The text of the label; if '', the label shows the symbol.
    """

    symbol: str
    at: Array
    away: Array
    words: str = ""


@dataclass
class Sketch:
    """The parts and the labels of the gizmo in a frame.

    Attributes
    ----------
    unit
        The bone length that determines the size of the parts.
    """

    unit: float
    parts: list[GizmoPart] = field(default_factory=list)
    marks: list[Mark] = field(default_factory=list)

    def line(self, symbol: str, points: Array, look: str = BOLD, share: float = 1.0) -> None:
        """Add a line through points, (n, 3). `share` is its opacity, 0…1."""
        self.parts.append(GizmoPart(symbol, look, points, segments(np.arange(len(points))), share))

    def dashes(self, symbol: str, start: Array, stop: Array, share: float = 1.0) -> None:
        """Add a dashed line from `start` to `stop`, (3,) each."""
        at = np.linspace(0.0, 1.0, 2 * _DASHES)[:, None]
        cells = np.arange(2 * _DASHES).reshape(-1, 2)
        self.parts.append(GizmoPart(symbol, THIN, start + at * (stop - start), cells, share))

    def arrow(self, symbol: str, start: Array, way: Array) -> None:
        """Add an arrow from `start` along the vector `way`. A short arrow has a smaller head."""
        size = float(np.linalg.norm(way))
        along = way / size if size > 0.0 else np.array([0.0, 1.0, 0.0])
        head = min(_HEAD[0] * self.unit, 0.6 * size)
        tip = start + way
        self.line(symbol, np.stack([start, tip - head * along]))
        turn = np.linspace(0.0, 2.0 * np.pi, _RING, endpoint=False)[:, None]
        ring = rotate_perpendicular_vector(perpendicular(along), along, turn)
        radius = head * _HEAD[1] / _HEAD[0]
        points = np.vstack([tip, tip - head * along, tip - head * along + radius * ring])
        self.parts.append(GizmoPart(symbol, SOLID, points, _CONE))

    def sector(
        self, symbol: str, centre: Array, rim: Array, share: float, inner: float = 0.0
    ) -> None:
        """Add a transparent face between a centre, (3,), and an edge `rim`, (n, 3).

        `inner` is the share of the radius around the centre that stays empty.
        """
        low = centre + inner * (rim - centre)
        steps = segments(np.arange(len(rim)))
        cells = np.hstack([steps, len(rim) + steps[:, ::-1]])
        self.parts.append(GizmoPart(symbol, CLEAR, np.vstack([low, rim]), cells, share))

    def ball(self, symbol: str, centre: Array, radius: float, *, hollow: bool = False) -> None:
        """Add a small sphere or, if `hollow` is True, only the edges of its triangles."""
        look, cells = (THIN, _WIRES) if hollow else (SOLID, TRIANGLES)
        self.parts.append(GizmoPart(symbol, look, centre + radius * SPHERE, cells))

    def mark(self, symbol: str, at: Array, away: Array, *, shown: bool = True) -> None:
        """Add a label at a point, (3,), if `shown` is True.

        The label is shifted away from the point `away`.
        """
        if shown:
            self.marks.append(Mark(symbol, at, away))


def sketch_gizmo(
    d: Decomposition,
    q_parent: Array,
    parent: Array,
    child: Array,
    reach: float,
    least: float,
    *,
    staged: bool = False,
) -> Sketch:
    """Return the gizmo of a frame in world coordinates.

    Parameters
    ----------
    d
        The quantities of the frame.
    q_parent
        The global rotation of the parent, (4,).
    parent, child
        The positions of the parent and the child, (3,) each.
    reach
        The length with which v, the direction of the child's bone, is drawn.
    least
        The smallest bone length to draw, in the unit of the file.
    staged
        True if the parent's rotation is animated. Changes since the previous frame are then not
        drawn.
    """
    out = Sketch(max(float(np.linalg.norm(child - parent)), least))
    along = rotate(q_parent, d.a)
    d = _drawn(d, staged=staged)
    _swing(out, d, q_parent, along, parent)
    _twist(out, d, q_parent, along, parent)
    _azimuth(out, d, q_parent, along, child, max(reach, 0.5 * out.unit))
    return out


def _drawn(d: Decomposition, *, staged: bool) -> Decomposition:
    """Return the quantities of a frame with undefined values set to zero, so they are not drawn.

    If `staged` is True, changes since the previous frame are also set to zero.
    """
    if not d.swing_is_one:
        d = replace(d, theta_p=0.0)
    if staged or not d.dtheta_p_is_defined:
        d = replace(d, theta_p_before=d.theta_p, dtheta_p=0.0)
    if staged or not d.dtheta_c_is_defined:
        d = replace(d, across_before=d.across, v_ideal=d.v, dtheta_c=0.0)
    return d


def _swing(out: Sketch, d: Decomposition, q_parent: Array, along: Array, parent: Array) -> None:
    # `above` is the global rotation of the joint above the parent
    above, unit = multiply(q_parent, conjugate(d.q)), out.unit
    bone, normal = rotate(above, d.a), rotate(above, d.n)
    out.arrow("a", parent, 0.92 * unit * bone)
    out.mark("a", parent + 0.92 * unit * bone, parent)
    out.arrow("w", parent, W_LONG * unit * along)
    out.mark("w", parent + 0.80 * unit * along, parent + 0.80 * unit * bone)
    # At a swing of 180°, any normal is possible, so no arrow is drawn.
    arrow = normal if d.n_is_defined else np.zeros(3)
    out.arrow("n", parent, 0.5 * unit * arrow)
    out.mark("n", parent + 0.5 * unit * arrow, parent, shown=bool(arrow.any()))
    arc = 0.46 * unit * fan(bone, normal, d.alpha)
    out.sector("alpha", parent, parent + arc, 0.24)
    out.line("alpha", parent + arc)
    middle = parent + 1.12 * arc[_ARC // 2]
    out.mark("alpha", middle, parent, shown=d.alpha > 4.0 * _SEEN)


def _twist(out: Sketch, d: Decomposition, q_parent: Array, along: Array, parent: Array) -> None:
    """Add the dial of θp. Its hand points in the direction of a fixed mark on the bone.

    The zero of the dial is the direction that this mark would have after the swing alone.
    """
    centre, radius = parent + DIAL_AT * out.unit * along, DIAL_SIZE * out.unit
    hand = rotate(q_parent, perpendicular(d.a))
    zero = rotate_perpendicular_vector(hand, along, -d.theta_p)
    before = rotate_perpendicular_vector(zero, along, d.theta_p_before)
    ring = centre + radius * fan(zero, along, 2.0 * np.pi)
    out.line("theta_p", ring, THIN, 0.75)
    out.sector("theta_p", centre, centre + radius * fan(zero, along, d.theta_p), 0.40)
    out.line("theta_p", np.stack([centre, centre + HAND_LONG * radius * zero]), THIN, 0.75)
    out.line("theta_p", np.stack([centre, centre + HAND_LONG * radius * hand]))
    rim = centre + 1.22 * radius * fan(before, along, d.dtheta_p)
    out.sector("dtheta_p", centre, rim, 0.55, inner=0.84)
    out.line("dtheta_p", rim)
    middle = rotate_perpendicular_vector(zero, along, 0.5 * d.theta_p)
    out.mark("theta_p", centre + 0.9 * radius * middle, centre, shown=abs(d.theta_p) > _SEEN)
    out.mark("dtheta_p", rim[_ARC // 2], centre, shown=abs(d.dtheta_p) > _SEEN)


def _azimuth(
    out: Sketch, d: Decomposition, q_parent: Array, along: Array, child: Array, reach: float
) -> None:
    v, flat = rotate(q_parent, d.v), rotate(q_parent, d.across)
    flat_before = rotate(q_parent, d.across_before)
    ideal = rotate(q_parent, d.v_ideal)
    apart = abs(d.dtheta_c) > 2.0 * _SEEN and d.azimuth_reliability > 0.01
    out.arrow("v", child, reach * v)
    out.mark("v", child + 0.55 * reach * v, child + reach * flat)
    out.arrow("across", child, reach * flat)
    out.dashes("across", child + reach * v, child + reach * flat, 0.8)
    out.mark("across", child + reach * flat, child, shown=d.azimuth_reliability > 0.05)
    out.dashes("dtheta_c", child, child + reach * flat_before, 0.9)
    length = float(np.linalg.norm(flat_before))
    start = flat_before / length if length > 0.0 else flat_before
    radius = min(0.62 * reach * max(length, 0.12), 0.30 * out.unit)
    rim = child + radius * fan(start, along, d.dtheta_c)
    out.line("across", child + radius * fan(start, along, 2.0 * np.pi), THIN, 0.6)
    out.sector("dtheta_c", child, rim, 0.50)
    out.line("dtheta_c", rim)
    out.mark("dtheta_c", rim[_ARC // 2], child, shown=abs(d.dtheta_c) > _SEEN)
    size = 0.030 * out.unit
    out.ball("v", child + reach * v, size)
    shown = ideal if apart else v
    out.ball("ideal", child + reach * shown, 1.35 * size if apart else 0.0, hollow=True)
    out.dashes("ideal", child, child + (reach if apart else 0.0) * shown)
    out.mark("real", child + reach * v, child, shown=apart)
    out.mark("ideal", child + reach * ideal, child, shown=apart)


def fan(start: Array, axis: Array, angle: float) -> Array:
    """Return the points of an arc, (_ARC + 1, 3), from the vector `start` to `angle` radians.

    The arc is about a unit axis perpendicular to `start`.
    """
    return rotate_perpendicular_vector(start, axis, np.linspace(0.0, angle, _ARC + 1)[:, None])


def rotate_perpendicular_vector(v: Array, axis: Array, angle: Array | float) -> Array:
    """Rotate a vector, (3,), by an angle in radians about a unit axis perpendicular to it."""
    turned: Array = np.cos(angle) * v + np.sin(angle) * cross(axis, v)
    return turned
