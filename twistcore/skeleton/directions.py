"""Compute angles and directions of vectors in one frame."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array, normalise

_NO_TURN = 1e-9  # a vector that is at most this long has no direction


def vector_at_frame(vector: Array, frame: int) -> Array:
    """Return a vector at a frame, (3,). The input has the shape (3,) or (frames, 3)."""
    return vector if vector.ndim == 1 else vector[frame]


def angle_between(u: Array, v: Array) -> float:
    """Return the angle between two unit vectors, radians.

    Unlike the arc cosine, this method is accurate near 0 and π.
    """
    return float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))


def unit_vector(v: Array) -> Array:
    """Return a vector (3,) scaled to length 1, or zeros if the vector is too short."""
    return normalise(v) if float(np.linalg.norm(v)) > _NO_TURN else np.zeros(3)


def perpendicular(axis: Array) -> Array:
    """Return a unit vector perpendicular to a unit vector. Equal inputs give equal results."""
    return normalise(cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]))


def cross(u: Array, v: Array) -> Array:
    """Return u × v for two vectors (3,). This is about ten times as fast as np.cross."""
    (a, b, c), (x, y, z) = u.tolist(), v.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])
