"""The ground under a figure: its height, its grid, and the shadows on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inspector.viewport.mesh_actor import Index, segments
from twistcore.skeleton.rotation import Array

_CELLS = 3.0  # approximate number of cells per height of the figure
_STOPS = 9  # points on a line of the grid, between which its colour fades


@dataclass(frozen=True, eq=False)
class Ground:
    """A disc on the ground.

    Attributes
    ----------
    centre, up
        The centre and the upward direction, (3,) each.
    radius, cell
        The radius of the disc and the size of a cell of its grid, in the unit of the file.
    """

    centre: Array
    up: Array
    radius: float
    cell: float

    @property
    def level(self) -> float:
        """The height of the ground, measured along `up` from the origin."""
        return float(self.centre @ self.up)


def ground_at_lowest_joint(
    positions: Array, up: Array, height: float, roots: Sequence[int] = (0,)
) -> Ground:
    """Return the ground at the height of the lowest joint in a clip.

    The disc covers the paths of all `roots` (joint indices) with a margin. `positions` is
    (frames, joints, 3), and `height` is the height of the figure.
    """
    root = positions[:, list(roots)].reshape(-1, 3)
    middle = (root.min(axis=0) + root.max(axis=0)) / 2.0
    level = float((positions @ up).min())
    centre = middle + (level - middle @ up) * up
    away = root - centre
    away = away - (away @ up)[:, None] * up
    radius = float(np.linalg.norm(away, axis=1).max()) + 1.6 * height
    # A cell is 1, 2 or 5 times a power of ten long, so that the user can read off lengths.
    exact = height / _CELLS
    power = 10.0 ** np.floor(np.log10(exact))
    cell = power * min((1.0, 2.0, 5.0, 10.0), key=lambda c: abs(np.log(c * power / exact)))
    return Ground(centre, up, radius, max(float(cell), radius / 60.0))


def ground_lines(ground: Ground) -> tuple[Array, Index, Array]:
    """Return the points (n, 3), the lines (m, 2) and the strength (n,) of the grid.

    The strength is 1 in the middle and 0 at the edge. The lines are opaque, and their colour fades
    to the background colour. Blending would need another pass, which takes a third of the frame
    time with software rendering.
    """
    first = np.eye(3)[0]
    second = np.cross(ground.up, first)
    count = int(np.ceil(ground.radius / ground.cell))
    # The grid is aligned with the world axes, so that its lines go through the origin.
    frame = np.stack([first, second])
    origin = np.round(frame @ ground.centre / ground.cell) * ground.cell @ frame
    origin = origin + ground.level * ground.up
    radius = count * ground.cell
    aside = (np.arange(1 - count, count) * ground.cell)[:, None]
    # Each line ends at the edge of the disc.
    ahead = np.sqrt(radius**2 - aside**2) * np.linspace(-1.0, 1.0, _STOPS)
    points = [
        origin + aside[..., None] * across + ahead[..., None] * along
        for along, across in ((first, second), (second, first))
    ]
    strength = np.maximum(1.0 - np.hypot(aside, ahead) / radius, 0.0) ** 0.8
    lines = np.arange(2 * ahead.size).reshape(-1, _STOPS)
    return np.reshape(points, (-1, 3)), segments(lines), np.tile(strength.ravel(), 2)


def shadow_points(points: Array, ground: Ground) -> Array:
    """Return points (n, 3), projected straight down to slightly above the grid."""
    above = points @ ground.up - (ground.level + 2e-4 * ground.radius)
    shadow: Array = points - above[:, None] * ground.up
    return shadow
