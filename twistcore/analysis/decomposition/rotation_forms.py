"""Convert a rotation to other forms: twist before swing, −q, and Euler angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from twistcore.formats.bvh.euler_branch import continuous_euler_angles
from twistcore.skeleton.rotation import Array, conjugate, multiply, swing_twist

# If the first and last axes are closer than this, a rotation is nearly in gimbal lock.
LOCK = float(np.radians(5.0))


def twist_times_swing_factors(q: Array, axis: Array) -> tuple[Array, Array]:
    """Return the factors twist and swing' of q = twist ⊗ swing', each of shape (4,).

    The twist and the angle of the swing are the same as in q = swing ⊗ twist, but the normal of the
    swing is rotated by the inverse of the twist.
    """
    _, twist = swing_twist(q, axis)
    return twist, multiply(conjugate(twist), q)


def double_cover_twist_angle(q: ArrayLike, axis: Array) -> float:
    """Return the twist angle 2·atan2(v·a, w) of q = (w, v), radians in (−2π, 2π].

    The angles of q and −q differ by a full turn.
    """
    q = np.asarray(q, dtype=np.float64)
    return float(2.0 * np.arctan2(q[1:] @ axis, q[0]))


@dataclass(frozen=True, eq=False)
class EulerChannels:
    """A rotation as the Euler angles of a BVH file.

    Parameters
    ----------
    order
        The axes in the order of the file, such as 'ZYX'.
    angles
        The angles in radians, shape (3,).
    between
        Angle between the first axis and the last axis after the middle rotation, in [0, π/2]. At 0,
        the two axes coincide (gimbal lock).
    """

    order: str
    angles: Array
    between: float

    @property
    def locked(self) -> bool:
        """True if the first and the last axis nearly coincide."""
        return self.between < LOCK


def decompose_into_euler_channels(order: str, q: Array, near: Array) -> EulerChannels:
    """Return a rotation as Euler angles.

    Parameters
    ----------
    order
        The axes, such as 'ZYX'.
    q
        The rotation, shape (4,).
    near
        Angles in radians, shape (3,). Of all solutions, the one nearest to them is returned.
    """
    angles = continuous_euler_angles(order, q[None], near[None], near, None)[0]
    between = float(np.arctan2(abs(np.cos(angles[1])), abs(np.sin(angles[1]))))
    return EulerChannels(order, angles, between)
