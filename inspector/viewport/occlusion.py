"""Measure how much of a limb is hidden behind other bones, from many directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from inspector.viewport.bodies import BoneSegment
from twistcore.skeleton.rotation import Array

_THICK = 0.036  # smallest radius of a bone that may hide others, in figure heights
_THIN = 0.032  # and that may be drawn as translucent
_CLEAR = 0.8  # share of that radius that covers; near the border, parts remain visible
_BODY = 0.030  # smallest radius of a head or chest, which also hides bones inside it
_FEW = 0.06  # hidden share of points that does not matter
_LITTLE = 0.02  # and by a single bone


@dataclass(frozen=True, eq=False)
class Occluders:
    """Bones as rods.

    `starts` and `stops` have the shape (B, 3), and `radius` has the shape (B,).
    """

    starts: Array
    stops: Array
    radius: Array

    def hidden_share(self, points: Array, directions: Array) -> Array:
        """Return the share of points (n, 3) that are hidden from each direction, (d,).

        `directions` are the unit vectors (d, 3) from which the points are seen.
        """
        if not len(points):
            return np.zeros(len(directions))
        found: Array = self.hides(points, directions, self.radius).any(axis=2).mean(axis=1)
        return found

    def hides(self, points: Array, directions: Array, behind: Array) -> NDArray[np.bool_]:
        """Return which rod hides which point from each direction, (d, n, B).

        A hidden point is farther from the viewer than the rod's line by `behind`, (B,).
        """
        aside = np.cross(directions, np.where(np.abs(directions[:, :1]) < 0.9, [[1.0, 0.0, 0.0]],
                                              [[0.0, 1.0, 0.0]]))  # fmt: skip
        aside /= np.linalg.norm(aside, axis=1, keepdims=True)
        axes = np.stack([aside, np.cross(directions, aside), directions], axis=1)  # (d, 3, 3)
        # (3, d, bones or points): x and y in the image plane, and the distance to the viewer.
        # Arrays of one coordinate each are faster than rows of three.
        start = np.einsum("dij,bj->idb", axes, self.starts)
        along = np.einsum("dij,bj->idb", axes, self.stops - self.starts)
        own = np.einsum("dij,nj->idn", axes, points)
        length = np.maximum(along[0] ** 2 + along[1] ** 2, 1e-12)
        ahead = [own[k][:, :, None] - start[k][:, None] for k in range(3)]  # (d, n, b) each
        steps = along[:, :, None]
        share = np.clip((ahead[0] * steps[0] + ahead[1] * steps[1]) / length[:, None], 0.0, 1.0)
        x, y, depth = (ahead[k] - share * steps[k] for k in range(3))
        near = x**2 + y**2 < self.radius**2
        hides: NDArray[np.bool_] = near & (-depth > behind)
        return hides


def occluders(
    bones: Sequence[BoneSegment],
    ends: Array,
    positions: Array,
    own: Sequence[tuple[int, int]],
    height: float,
) -> Occluders:
    """Return the bones that may hide a limb: all except its own.

    - ends: the tips of all bones in world space, (bones, 3)
    - positions: the positions of the joints, (joints, 3)
    - own: the limb's bones, as (parent, child)
    - height: the height of the figure
    """
    kept = [k for k, b in enumerate(bones) if (b.parent, b.child) not in own]
    return Occluders(
        positions[[bones[k].parent for k in kept]],
        ends[kept],
        np.array([max(bones[k].width, _THICK * height) for k in kept]),
    )


def covering(
    ends: Array,
    widths: Array,
    own: NDArray[np.bool_],
    height: float,
    points: Array,
    direction: Array,
) -> NDArray[np.bool_] | None:
    """Return a mask (bones,) of the bones that cover points (n, 3), or None if they cover few.

    - ends, widths: the ends (bones, 2, 3) and half widths (bones,) of the bones
    - own: mask of the bones that never count, (bones,)
    - height: the height of the figure
    - direction: the unit vector (3,) towards the viewer
    """
    rods = Occluders(ends[:, 0], ends[:, 1], _CLEAR * np.maximum(widths, _THIN * height))
    inside = widths > _BODY * height
    behind = np.where(inside, -rods.radius, rods.radius)
    hides = rods.hides(points, direction[None], behind)[0] & ~own
    found: NDArray[np.bool_] = hides.mean(axis=0) > _LITTLE
    return found if hides.any(axis=1).mean() > _FEW and found.any() else None
