"""Counter-rotation as a training loss for learned motion models [Choi26 §5]."""

from __future__ import annotations

from typing import Any

import numpy as np

_SOFT = 1e-3  # radians; the loss is quadratic below this angle, so its gradient is smooth at rest


def consistency_loss(q_p: Any, q_c: Any, axis: Any, xp: Any = np) -> Any:
    """Return the mean angle per frame by which a parent and its child rotate against each other.

    `q_p` and `q_c` are the local unit quaternions (w, x, y, z) of parent and child, (frames, 4),
    and `axis` is the unit bone axis in the parent's coordinates, (3,). With x and y the twist
    increments of parent and child about the axis, each frame costs max(0, −x·y) / √(x² + y² + ε²).
    This is 0 if they turn together, and |x|/√2 if they cancel. The loss does not depend on the
    quaternions' signs.

    Only elementary functions of `xp` are used, so the loss is differentiable with torch or
    jax.numpy as `xp`. Returns a number of that library, in radians.
    """
    x = _twist_increment(q_p[:-1], q_p[1:], axis, xp, inverse_first=True)
    y = _twist_increment(q_c[:-1], q_c[1:], axis, xp, inverse_first=False)
    against = -x * y
    against = 0.5 * (against + xp.abs(against))
    return xp.mean(against / xp.sqrt(x * x + y * y + _SOFT * _SOFT))


def _twist_increment(before: Any, after: Any, axis: Any, xp: Any, *, inverse_first: bool) -> Any:
    """Return the twist of q(t−1)⁻¹ q(t) (parent) or q(t) q(t−1)⁻¹ (child), (frames − 1,).

    Set `inverse_first` to True for the parent's form.
    """
    (bw, bx, by, bz), (aw, ax, ay, az) = ([q[:, k] for k in range(4)] for q in (before, after))
    w = bw * aw + bx * ax + by * ay + bz * az
    sign = 1.0 if inverse_first else -1.0
    vx = bw * ax - bx * aw - sign * (by * az - bz * ay)
    vy = bw * ay - by * aw - sign * (bz * ax - bx * az)
    vz = bw * az - bz * aw - sign * (bx * ay - by * ax)
    along = vx * axis[0] + vy * axis[1] + vz * axis[2]
    # The shorter direction for any sign of the quaternions: atan(v·a / w) instead of atan2.
    return 2.0 * xp.arctan2(along * xp.sign(w), xp.abs(w))
