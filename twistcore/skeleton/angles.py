"""Mean, median and wrapping of angles, and angles between vectors about an axis."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array, cross_products, wrap


def circular_median(angles: Array) -> float:
    """Return the circular median of angles (n,), radians in (−π, π], or 0 if there are none."""
    if len(angles) == 0:
        return 0.0
    centre = np.angle(np.exp(1j * angles).sum()) if len(angles) > 1 else angles[0]
    return float(wrap(centre + median(wrap(angles - centre))))


def circular_mean(angles: Array) -> float:
    """Return the circular mean of angles, in radians."""
    return float(np.arctan2(np.sin(angles).sum(), np.cos(angles).sum()))


def wrap_degrees(degrees: Array) -> Array:
    """Return angles in degrees wrapped to [−180, 180)."""
    shifted = np.asarray(degrees) + 180.0
    if not (shifted.size and shifted.min() >= 0.0 and shifted.max() < 360.0):
        shifted = shifted % 360.0  # slow, and not needed for small angles
    return np.asarray(shifted - 180.0)


def vector_angles_about_axis(axis: Array, a: Array, b: Array) -> Array:
    """Return the angles from vectors a to b about a unit axis that is perpendicular to both.

    All vectors have the shape (n, 3), and the angles are in radians, (n,).
    """
    across = np.einsum("ti,ti->t", cross_products(a, b), axis)
    angle: Array = np.arctan2(across, np.einsum("ti,ti->t", a, b))
    return angle
