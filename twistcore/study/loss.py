"""Counter-rotation as a loss for training motion models [Choi26 §5]."""

from __future__ import annotations

from typing import Any

import numpy as np

# Radians; below this angle the loss is quadratic, so that its gradient is smooth at rest.
_SOFT = 1e-3


def twist_consistency_loss(q_p: Any, q_c: Any, axis: Any, xp: Any = np) -> Any:
    """Return the mean angle by which a parent and its child rotate in opposite directions.

    If x and y are the twist increments of parent and child, the loss of a frame is max(0, −x·y) /
    √(x² + y² + ε²). It is 0 if they rotate in the same direction, and |x|/√2 if they cancel. The
    signs of the quaternions do not matter. Only elementary functions of `xp` are used, so that the
    loss is differentiable with torch or jax.numpy.

    Parameters
    ----------
    q_p, q_c
        Local unit quaternions (w, x, y, z) of parent and child, shape (frames, 4).
    axis
        Unit bone axis in the parent's coordinates, shape (3,).
    xp
        The array library, such as numpy or torch.

    Returns
    -------
    scalar of the array library
        The loss, radians.
    """
    x = _twist_increment(q_p[:-1], q_p[1:], axis, xp, inverse_first=True)
    y = _twist_increment(q_c[:-1], q_c[1:], axis, xp, inverse_first=False)
    against = -x * y
    against = 0.5 * (against + xp.abs(against))
    return xp.mean(against / xp.sqrt(x * x + y * y + _SOFT * _SOFT))


def _twist_increment(before: Any, after: Any, axis: Any, xp: Any, *, inverse_first: bool) -> Any:
    """Return the twist increments of a joint about an axis, radians, (frames − 1,).

    The increment is the twist of q(t−1)⁻¹ q(t) for the parent (`inverse_first` is True), and of
    q(t) q(t−1)⁻¹ for the child.
    """
    (bw, bx, by, bz), (aw, ax, ay, az) = ([q[:, k] for k in range(4)] for q in (before, after))
    w = bw * aw + bx * ax + by * ay + bz * az
    sign = 1.0 if inverse_first else -1.0
    vx = bw * ax - bx * aw - sign * (by * az - bz * ay)
    vy = bw * ay - by * aw - sign * (bz * ax - bx * az)
    vz = bw * az - bz * aw - sign * (bx * ay - by * ax)
    along = vx * axis[0] + vy * axis[1] + vz * axis[2]
    # For any sign of the quaternions, this is the shorter direction, atan(v·a / w).
    return 2.0 * xp.arctan2(along * xp.sign(w), xp.abs(w))
