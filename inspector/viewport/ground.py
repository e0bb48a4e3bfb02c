"""The ground under a clip: where it is, its grid, and shadows on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyvista as pv

from twistcore.rotation import Array

_CELLS = 3.0  # cells to a figure's height, about
_STOPS = 9  # points on a grid line, between which its colour fades


@dataclass(frozen=True, eq=False)
class Ground:
    """A disc: centre (3,) on the ground, up (3,), radius and cell in the file's length unit."""

    centre: Array
    up: Array
    radius: float
    cell: float

    @property
    def level(self) -> float:
        """Height of the ground."""
        return float(self.centre @ self.up)


def lowest(positions: Array, up: Array, height: float) -> Ground:
    """The ground of a clip at its lowest joint, from positions (frames, joints, 3).

    The radius covers the way of the root with some margin.
    """
    root = positions[:, 0]
    middle = (root.min(axis=0) + root.max(axis=0)) / 2.0
    level = float((positions @ up).min())
    centre = middle + (level - middle @ up) * up
    away = root - centre
    away = away - (away @ up)[:, None] * up
    radius = float(np.linalg.norm(away, axis=1).max()) + 1.6 * height
    # 1, 2 or 5 times a power of ten, so that a person can count off lengths.
    exact = height / _CELLS
    power = 10.0 ** np.floor(np.log10(exact))
    cell = power * min((1.0, 2.0, 5.0, 10.0), key=lambda c: abs(np.log(c * power / exact)))
    return Ground(centre, up, radius, max(float(cell), radius / 60.0))


def ground_mesh(ground: Ground) -> pv.PolyData:
    """Grid lines with 'fade' at the points: 1 in the middle, 0 at the rim.

    Opaque lines that take the background's colour at the rim: blended ones cost a pass of their
    own, a third of the whole frame where the processor draws.
    """
    first = np.eye(3)[0]
    second = np.cross(ground.up, first)
    count = int(np.ceil(ground.radius / ground.cell))
    # Lines of the world's grid, not of the disc's: zero stays a line.
    frame = np.stack([first, second])
    origin = np.round(frame @ ground.centre / ground.cell) * ground.cell @ frame
    origin = origin + ground.level * ground.up
    radius = count * ground.cell
    stops = np.linspace(-1.0, 1.0, _STOPS)
    points: list[Array] = []
    lines: list[int] = []
    fade: list[float] = []
    for along, across in ((first, second), (second, first)):
        for s in np.arange(1 - count, count) * ground.cell:
            half = np.sqrt(radius**2 - s**2)  # as far as the disc reaches
            lines += [_STOPS, *range(len(points), len(points) + _STOPS)]
            points += [origin + s * across + half * t * along for t in stops]
            fade += [(1.0 - np.hypot(s, half * t) / radius) ** 0.8 for t in stops]
    mesh = pv.PolyData(np.array(points, dtype=np.float32), lines=np.array(lines))
    mesh["fade"] = np.array(fade)
    mesh["rgb"] = np.zeros((len(points), 3), dtype=np.uint8)
    return mesh


def shadow_points(points: Array, ground: Ground) -> Array:
    """Points (V, 3) cast straight down, a hair above the grid."""
    above = points @ ground.up - (ground.level + 2e-4 * ground.radius)
    shadow: Array = points - above[:, None] * ground.up
    return shadow
