"""Twist increments of a chain, computed from frame-to-frame rotations [Method, step 1].

Unlike the differences of θp and θc, the increments are exact for a straight limb and across a swing
of 180°. Because of holonomy, their sum is not θp, so the two must not be compared.
"""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array, wrap


def twist_increments(q_parent: Array, q_child: Array, axis: Array) -> tuple[Array, Array]:
    """Return the twist increments x of a parent P and y of its child C about P's bone axis a.

    x(t) = twist_a(q_P(t−1)⁻¹ q_P(t)), y(t) = twist_a(q_C(t) q_C(t−1)⁻¹), and x(0) = y(0) = 0. A
    twist error δ of P (q_P ⊗ R_a(δ), R_a(−δ) ⊗ q_C) changes x and y by exactly +dδ and −dδ, where
    dδ is the change of δ since the previous frame.

    Parameters
    ----------
    q_parent, q_child
        Local rotations of P and C, shape (frames, 4).
    axis
        The unit vector a along P's bone in the coordinate system of P, shape (3,) or (frames, 3).

    Returns
    -------
    x, y
        The increments in radians, shape (frames,).
    """
    x, y = np.zeros(len(q_parent)), np.zeros(len(q_parent))
    a = axis if axis.ndim == 1 else axis[1:]
    x[1:] = _twist_between(q_parent, a, -1.0)
    y[1:] = _twist_between(q_child, a, 1.0)
    return x, y


def _twist_between(q: Array, axis: Array, cross_sign: float) -> Array:
    """Return the twist of q(t−1)⁻¹ q(t) if `cross_sign` is −1, or of q(t) q(t−1)⁻¹ if it is +1.

    Of the product (w, v), only w and the component of v along the axis are computed.
    """
    w0, w1 = q[:-1, 0], q[1:, 0]
    x0, y0, z0 = q[:-1, 1], q[:-1, 2], q[:-1, 3]
    x1, y1, z1 = q[1:, 1], q[1:, 2], q[1:, 3]
    ax, ay, az = axis[..., 0], axis[..., 1], axis[..., 2]
    w = w0 * w1 + x0 * x1 + y0 * y1 + z0 * z1
    straight = w0 * (x1 * ax + y1 * ay + z1 * az) - w1 * (x0 * ax + y0 * ay + z0 * az)
    cross = (y0 * z1 - z0 * y1) * ax + (z0 * x1 - x0 * z1) * ay + (x0 * y1 - y0 * x1) * az
    return wrap(2.0 * np.arctan2(straight + cross_sign * cross, w))
