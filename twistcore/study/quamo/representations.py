"""Apply the PD controller to other representations of rotations, for comparison [Le26 §4.5].

The three numbers of a joint, which are Euler angles or a rotation vector, are tracked as if they
were an ordinary vector. The stiffness is κP/2, so that all representations obey the same equation
for small errors as the quaternion, whose error is sin(θ/2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.quamo.state_space import (
    EXACT,
    FIRST_ORDER,
    Gains,
    next_quaternion,
    next_translation,
)
from twistcore.skeleton.rotation import (
    Array,
    euler_from_quaternion,
    exponential,
    geodesic_angle,
    logarithm,
    quaternion_from_euler,
    wrap,
)


@dataclass(frozen=True)
class Representation:
    """A representation of rotations by three numbers.

    Attributes
    ----------
    name
        Name in tables.
    order
        Order of Euler angles, or '' for a rotation vector.
    wrapped
        True if errors are wrapped into (−π, π].
    """

    name: str
    order: str
    wrapped: bool = False


REPRESENTATIONS = (
    Representation("Euler XYZ, raw", "XYZ"),
    Representation("Euler ZXY, raw", "ZXY"),
    Representation("axis-angle, raw", ""),
    Representation("Euler XYZ, wrapped", "XYZ", True),
    Representation("Euler ZXY, wrapped", "ZXY", True),
)


def rotation_coordinates(q: Array, representation: Representation) -> Array:
    """Return the principal coordinates of rotations (…, 4) in each frame, shape (…, 3)."""
    if representation.order:
        return euler_from_quaternion(representation.order, q)
    return logarithm(q)


def rotations_from_coordinates(x: Array, representation: Representation) -> Array:
    """Return the rotations with the given coordinates (…, 3), shape (…, 4)."""
    if representation.order:
        return quaternion_from_euler(representation.order, x)
    return exponential(x)


def track_coordinates(
    q_hat: Array, dt: float, representation: Representation, gains: Gains
) -> Array:
    """Track rotations (frames, …, 4) by their three coordinates, starting at rest."""
    reference = rotation_coordinates(q_hat, representation)
    x = np.empty_like(reference)
    x[0] = reference[0]
    rate = np.zeros_like(x[0])
    for t in range(1, len(x)):
        error = reference[t] - x[t - 1]
        if representation.wrapped:
            error = wrap(error)
        rate = rate + dt * (0.5 * gains.kp * error - gains.kd * rate)
        rate = np.clip(rate, -gains.clip, gains.clip)
        x[t] = x[t - 1] + dt * rate
    return rotations_from_coordinates(x, representation)


def track_root_positions(r_hat: Array, dt: float, gains: Gains, steps: int = 1) -> Array:
    """Track root positions (frames, …, 3) like the tracker, starting at rest in the first frame.

    `steps` is the number of Euler steps per frame, all towards the same reference. Earlier work
    uses six [Le26 supplement F].
    """
    r = np.empty_like(r_hat)
    r[0] = r_hat[0]
    here, v = r_hat[0], np.zeros_like(r_hat[0])
    for t in range(1, len(r)):
        for _ in range(steps):
            here, v = next_translation(here, v, r_hat[t], gains, dt / steps)
        r[t] = here
    return r


def has_root_discontinuity(q: Array) -> bool:
    """Return True if a clip's root crosses a discontinuity of at least one representation.

    `q` has the shape (frames, joints, 4).
    """
    return any(
        bool((np.abs(np.diff(rotation_coordinates(q[:, 0], rep), axis=0)) > np.pi).any())
        for rep in REPRESENTATIONS
    )


def integration_errors_exact_first_order(speed: float, dt: float) -> tuple[float, float]:
    """Return the errors of exact and of first-order integration, in this order, in radians.

    The errors are measured after 100 steps of `dt` seconds at constant speed, in rad/s.
    """
    steps = 100
    axis = np.array([0.36, 0.48, 0.8])
    truth = exponential(axis * wrap(speed * dt * steps))
    drift = []
    for integration in (EXACT, FIRST_ORDER):
        q = np.array([1.0, 0.0, 0.0, 0.0])
        for _ in range(steps):
            q = next_quaternion(q, speed * axis, dt, integration)
        drift.append(float(geodesic_angle(q, truth)))
    return drift[0], drift[1]
