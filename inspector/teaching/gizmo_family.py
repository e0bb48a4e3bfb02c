"""The geometry of the family of (n, θp) pairs that give the same pose at a swing of 180°.

A half turn about any axis perpendicular to the bone axis a makes the bone point backward, so the
pose does not show which axis n was used. If n is rotated by φ about a, then a θp that is larger by
2φ gives the same pose:

    q = swing(n, 180°) ⊗ twist(θp) = swing(n rotated by φ, 180°) ⊗ twist(θp + 2φ)
"""

from __future__ import annotations

import numpy as np

from inspector.teaching.equation_table import NEAR_SWING
from inspector.teaching.gizmo_shapes import (
    BOLD,
    CLEAR,
    THIN,
    GizmoPart,
    Mark,
    Sketch,
    rotate_perpendicular_vector,
)
from inspector.viewport.mesh_actor import Index, segments
from inspector.widgets.signed_numbers import format_signed_number
from twistcore.analysis.decomposition import Decomposition
from twistcore.skeleton.directions import perpendicular
from twistcore.skeleton.rotation import Array, conjugate, multiply, rotate, wrap

MEMBERS = 8
_STEPS = 16  # steps around the edge of a dial
_OUT, _SIZE = 0.62, 0.13  # distance of the dials from the parent, and their radius, in bone lengths
_TURNS: Array = np.linspace(0.0, 2.0 * np.pi, MEMBERS, endpoint=False)


def equivalent_swing_axes(d: Decomposition) -> tuple[Array, Array]:
    """Return several swing axes n and, for each, the θp that gives the same pose.

    The axes, (MEMBERS, 3), are unit vectors in the coordinates of the joint above the parent; the
    angles, (MEMBERS,), are in radians. The first pair is the (n, θp) of the frame itself.
    """
    n = d.n if d.n.any() else perpendicular(d.a)
    normals: Array = rotate_perpendicular_vector(n, d.a, _TURNS[:, None])
    return normals, np.asarray(wrap(d.theta_p + 2.0 * _TURNS))


def add_swing_axis_fan(out: Sketch, d: Decomposition, q_parent: Array, parent: Array) -> None:
    """Add a fan of swing axes around the parent to `out`, each with a dial for its θp.

    The fan is visible only if the swing is close to 180°. All hands of the dials point in the same
    direction, because the pose is the same, but the zeros of the dials differ.
    """
    spokes, rings = np.zeros((MEMBERS, 2, 3)), np.zeros((MEMBERS, _STEPS + 1, 3))
    sectors, hands = np.zeros((MEMBERS, _STEPS + 2, 3)), np.zeros((MEMBERS, 2, 3))
    if d.swing_reliability < NEAR_SWING:
        above = multiply(q_parent, conjugate(d.q))
        normals, angles = equivalent_swing_axes(d)
        zero = 2.0 * (normals @ perpendicular(d.a))[:, None] * normals - perpendicular(d.a)
        ways, zero, axis = rotate(above, normals), rotate(above, zero), rotate(above, -d.a)
        centres = _OUT * out.unit * ways
        radius = _SIZE * out.unit
        shares = np.linspace(0.0, 1.0, _STEPS + 1)
        spokes[:, 1] = centres - radius * ways
        rings[:] = centres[:, None] + radius * _around(zero, axis, 2.0 * np.pi * shares)
        sectors[:, 0] = centres
        sectors[:, 1:] = centres[:, None] + radius * _around(zero, axis, angles[:, None] * shares)
        hands[:, 0], hands[:, 1] = centres, centres + 1.25 * (sectors[:, -1] - centres)
        for way, angle in zip(ways, angles, strict=True):
            at = parent + (_OUT + _SIZE) * out.unit * way
            words = f"{format_signed_number(float(np.degrees(angle)), 0)}°"
            out.marks.append(Mark("theta_p", at, parent, words))
    for symbol, look, lines, share in (
        ("n", THIN, spokes, 0.8),
        ("theta_p", THIN, rings, 0.7),
        ("theta_p", BOLD, hands, 1.0),
    ):
        cells = segments(np.arange(lines[..., 0].size).reshape(MEMBERS, -1))
        out.parts.append(GizmoPart(symbol, look, parent + lines.reshape(-1, 3), cells, share))
    out.parts.append(GizmoPart("theta_p", CLEAR, parent + sectors.reshape(-1, 3), _FACES, 0.5))


def _around(start: Array, axis: Array, angles: Array) -> Array:
    """Rotate each vector in `start`, (n, 3), about its axis by m angles; return them, (n, m, 3).

    Each axis is a unit vector perpendicular to its vector. `angles` are in radians, (n or 1, m).
    """
    across = np.cross(axis, start)
    angles = np.atleast_2d(angles)[..., None]
    out: Array = np.cos(angles) * start[:, None] + np.sin(angles) * across[:, None]
    return out


def _fans() -> Index:
    """Return the faces of all dials, as point indices (n, 4).

    Each face is a triangle between the centre of a dial, which is the dial's first point, and its
    edge. The last index is repeated.
    """
    rim = segments(np.arange(1, _STEPS + 2))
    one = np.column_stack([np.zeros(len(rim), np.int64), rim, rim[:, 1]])
    return (one + (_STEPS + 2) * np.arange(MEMBERS)[:, None, None]).reshape(-1, 4)


_FACES = _fans()
