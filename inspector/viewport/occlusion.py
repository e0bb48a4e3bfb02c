"""Measure how much of a limb is hidden by other bones, from many directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from inspector.viewport.bodies import BoneSegment
from twistcore.skeleton.rotation import Array

# Minimum radius of a bone in figure heights; a thinner bone is treated as this thick. The search
# for the best direction of the camera uses _THICK, and the search for bones that hide the error
# uses _THIN.
_THICK = 0.036
_THIN = 0.032
_CLEAR = 0.8  # share of a bone's radius that hides points; near its border, parts remain visible
_BODY = 0.030  # radius, in figure heights, above which a body also hides the bones inside it
_FEW = 0.06  # share of the points that may be hidden without any bone being drawn as translucent
_LITTLE = 0.02  # share of the points that a single bone may hide without being translucent


@dataclass(frozen=True, eq=False)
class Occluders:
    """Bones as rods that hide the points behind them.

    Attributes
    ----------
    starts, stops
        The ends of the rods, (rods, 3).
    radius
        The radius of each rod, (rods,).
    """

    starts: Array
    stops: Array
    radius: Array

    def hidden_share(self, points: Array, directions: Array) -> Array:
        """Return the share of the points that are hidden from each direction, (directions,).

        Parameters
        ----------
        points
            The points, (n, 3).
        directions
            Unit vectors towards the viewer, (directions, 3).
        """
        if not len(points):
            return np.zeros(len(directions))
        found: Array = self.hides(points, directions, self.radius).any(axis=2).mean(axis=1)
        return found

    def hides(self, points: Array, directions: Array, behind: Array) -> NDArray[np.bool_]:
        """Return a mask of the points that each rod hides from each direction.

        Parameters
        ----------
        points
            The points, (n, 3).
        directions
            Unit vectors towards the viewer, (directions, 3).
        behind
            The minimum distance of hidden points behind the axis of each rod, (rods,). With a
            negative value, points slightly in front of the axis are hidden as well.

        Returns
        -------
        ndarray of bool
            The mask, (directions, n, rods).
        """
        aside = np.cross(directions, np.where(np.abs(directions[:, :1]) < 0.9, [[1.0, 0.0, 0.0]],
                                              [[0.0, 1.0, 0.0]]))  # fmt: skip
        aside /= np.linalg.norm(aside, axis=1, keepdims=True)
        # The axes of the image and the direction to the viewer, (directions, 3, 3)
        axes = np.stack([aside, np.cross(directions, aside), directions], axis=1)
        # Arrays (3, directions, rods or points): x and y in the image plane, and the position
        # towards the viewer. Calculations with one array per coordinate are faster than
        # calculations with rows of three coordinates.
        start = np.einsum("dij,bj->idb", axes, self.starts)
        along = np.einsum("dij,bj->idb", axes, self.stops - self.starts)
        own = np.einsum("dij,nj->idn", axes, points)
        length = np.maximum(along[0] ** 2 + along[1] ** 2, 1e-12)
        # From the start of each rod to each point: three arrays (directions, n, rods)
        ahead = [own[k][:, :, None] - start[k][:, None] for k in range(3)]
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
    """Return the bones that may hide a limb, which are all bones except the limb's bones.

    Parameters
    ----------
    bones
        All bones of the figure.
    ends
        The end of each bone in world space, (bones, 3).
    positions
        The positions of the joints, (joints, 3).
    own
        The bones of the limb, as (parent, child).
    height
        The height of the figure.
    """
    kept = [k for k, b in enumerate(bones) if (b.parent, b.child) not in own]
    return Occluders(
        positions[[bones[k].parent for k in kept]],
        ends[kept],
        np.array([max(bones[k].width, _THICK * height) for k in kept]),
    )


def occluding_bone_mask(
    ends: Array,
    widths: Array,
    own: NDArray[np.bool_],
    height: float,
    points: Array,
    direction: Array,
) -> NDArray[np.bool_] | None:
    """Return a mask of the bones that hide the points, (bones,), or None if few are hidden.

    Parameters
    ----------
    ends
        The ends of the bones, (bones, 2, 3).
    widths
        Half the width of each bone, (bones,).
    own
        A mask of the bones that are never included in the result, (bones,).
    height
        The height of the figure.
    points
        The points, (n, 3).
    direction
        The unit vector towards the viewer, (3,).
    """
    rods = Occluders(ends[:, 0], ends[:, 1], _CLEAR * np.maximum(widths, _THIN * height))
    inside = widths > _BODY * height
    behind = np.where(inside, -rods.radius, rods.radius)
    hides = rods.hides(points, direction[None], behind)[0] & ~own
    found: NDArray[np.bool_] = hides.mean(axis=0) > _LITTLE
    return found if hides.any(axis=1).mean() > _FEW and found.any() else None
