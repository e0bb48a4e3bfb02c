"""Vectors of one frame, (3,): their angles and directions."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array, normalise

_NO_TURN = 1e-9  # length of a vector that has no direction any more


def at_frame(vector: Array, frame: int) -> Array:
    """The vector of a frame, (3,), where it varies."""
    return vector if vector.ndim == 1 else vector[frame]


def angle_between(u: Array, v: Array) -> float:
    """The angle between two unit vectors, exact near 0 and π too, where the cosine is not."""
    return float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))


def direction(v: Array) -> Array:
    """The unit vector of (3,), zeros where it has none."""
    return normalise(v) if float(np.linalg.norm(v)) > _NO_TURN else np.zeros(3)


def perpendicular(axis: Array) -> Array:
    """A unit vector square to another, always the same one."""
    return normalise(cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]))


def cross(u: Array, v: Array) -> Array:
    """u × v of two vectors (3,), at a tenth of what np.cross costs."""
    (a, b, c), (x, y, z) = u.tolist(), v.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])
