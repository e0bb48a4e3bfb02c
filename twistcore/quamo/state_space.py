"""The equations of a tracking step for rotations, angular velocities, root position and velocity.

Equation numbers refer to [Le26], arXiv:2601.19580. q is a tracked rotation and q̂ its noisy
reference, r is the tracked position of the root and r̂ its reference, ω is the angular velocity of
a joint, v is the velocity of the root, and Δt is the frame time. Units are seconds, radians, and
metres or the length unit of the clip. Quaternions are scalar first. Angular velocities are in the
coordinate system of the parent, so rotations multiply from the left. All functions broadcast over
leading axes, so the documented shapes include only the last axes.
"""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array, conjugate, exponential, multiply
from twistcore.work.frozen import dataclass

NETWORK_DT = 0.04  # seconds: the frame time for which a network's gains and κA are tuned
EXACT, FIRST_ORDER = "exact", "first-order"  # methods of integrating a rotation


@dataclass(frozen=True, eq=False)
class Gains:
    """The gains of the meta-PD controller [Le26 Eq. 5].

    The gains for rotations are numbers or arrays that broadcast to the shape (…, joints, 3). The
    gains for the root's position are numbers or arrays that broadcast to the shape (…, 3).

    Attributes
    ----------
    kp, kd
        The gains κP of the error of a rotation, 1/s², and κD of the angular velocity, 1/s.
    ka
        The gain κA of the reference's acceleration, rad/s² for a second difference of 1 at 25 Hz.
    bias
        A constant angular acceleration, rad/s².
    root_kp, root_kd
        κP and κD of the root's position, 1/s² and 1/s.
    root_bias
        A constant acceleration of the root, length/s².
    clip
        The largest magnitude of each component of ω, rad/s.
    """

    kp: Array | float = 600.0
    kd: Array | float = 15.0
    ka: Array | float = 0.0
    bias: Array | float = 0.0
    root_kp: Array | float = 200.0
    root_kd: Array | float = 12.0
    root_bias: Array | float = 0.0
    clip: float = 25.0

    @classmethod
    def by_hand(cls, dt: float, *, causal: bool = True) -> Gains:
        """Return the hand-tuned gains for a frame time of `dt` seconds.

        At 25 Hz, these are the defaults. At other rates, they are κP/s² and κD/s with
        s = 0.3 + 0.7 Δt/(0.04 s), so they are stiffer at higher rates. They are stable at any rate.
        A joint that rotates steadily is 2κD/κP − Δt behind its reference, which is 10 ms at 25 Hz
        and less than 15 ms at any rate.

        `causal` is False for tracking forward and backward, without a lag. Other gains then reduce
        the acceleration error and do not increase the position error (MPJPE), measured on CMU
        subjects 02, 08 and 12 with synthetic noise.
        """
        at_25_hz = cls() if causal else cls(kp=550.0, kd=17.0, root_kp=200.0, root_kd=14.0)
        s = 0.3 + 0.7 * (dt / NETWORK_DT)
        return cls(
            kp=at_25_hz.kp / s**2,
            kd=at_25_hz.kd / s,
            root_kp=at_25_hz.root_kp / s**2,
            root_kd=at_25_hz.root_kd / s,
        )


@dataclass(frozen=True, eq=False)
class AccelerationTerms:
    """The four terms of the angular acceleration of a step [Le26 Eq. 5].

    All are in rad/s² and have the shape (…, joints, 3).
    """

    proportional: Array
    damping: Array
    bias: Array
    acceleration: Array


def canonical_vector_part(q: Array) -> Array:
    """Return vec(±q): the axis of a rotation by θ times sin(θ/2), (…, 4) → (…, 3).

    The sign of the quaternion is chosen so that w ≥ 0.
    """
    return np.where(q[..., :1] < 0.0, -q[..., 1:], q[..., 1:])


def align_hemisphere(q_hat: Array, q: Array) -> Array:
    """Return q̂ or −q̂, whichever is in the hemisphere of q; both describe the same rotation."""
    dot = np.einsum("...i,...i->...", q_hat, q)
    return np.where(dot[..., None] < 0.0, -q_hat, q_hat)


def angular_acceleration(
    q: Array, omega: Array, q_hat: Array, curvature: Array | float, gains: Gains, dt: float
) -> AccelerationTerms:
    """Return the four terms of the angular acceleration of a step [Le26 Eq. 5].

    κA was tuned at 25 Hz and acts on a difference per frame², so it is scaled by (0.04 s/Δt)².

    Parameters
    ----------
    q, omega
        The rotations, (…, joints, 4), and the angular velocities, (…, joints, 3), before the step.
    q_hat
        The reference of the step, shape (…, joints, 4).
    curvature
        The change of the result of :func:`tracker_reference_rotation_step` since the previous step,
        (…, joints, 3).
    gains
        The gains of the step.
    dt
        The frame time in seconds.
    """
    error = canonical_vector_part(multiply(q_hat, conjugate(q)))
    ka = gains.ka * (NETWORK_DT / dt) ** 2
    shape = error.shape
    return AccelerationTerms(
        gains.kp * error,
        -(gains.kd * omega),
        np.broadcast_to(np.asarray(gains.bias, dtype=np.float64), shape),
        np.broadcast_to(np.asarray(ka * curvature, dtype=np.float64), shape),
    )


def tracker_reference_rotation_step(q_hat: Array, before: Array) -> Array:
    """Return vec(±(q̂ ⊗ q̂_before*)) of a step of the reference, (…, 4) → (…, 3).

    For a step by the angle θ, this is the axis of the step times sin(θ/2).
    """
    return canonical_vector_part(multiply(q_hat, conjugate(before)))


def next_velocity(omega: Array, parts: AccelerationTerms, dt: float, clip: float) -> Array:
    """Return ω after a step, with each component limited to ±`clip` [Le26 Eq. 1, 5]."""
    rate = parts.proportional + parts.damping + parts.bias + parts.acceleration
    return np.clip(omega + dt * rate, -clip, clip)


def next_quaternion(q: Array, omega: Array, dt: float, integration: str = EXACT) -> Array:
    """Return q after a step with a constant ω.

    With the integration 'exact', the result is Exp(ωΔt) ⊗ q, which is always a unit quaternion
    [Le26 Eq. 4]. With 'first-order', it is the normalised tangent step q + ½Δt (0, ω) ⊗ q, as in
    earlier work [Le26 supplement E].
    """
    if integration == EXACT:
        return multiply(exponential(dt * omega), q)
    tangent = np.empty_like(q)
    tangent[..., 0] = 0.0
    tangent[..., 1:] = (0.5 * dt) * omega
    moved = q + multiply(tangent, q)
    unit: Array = moved / np.sqrt(np.einsum("...i,...i->...", moved, moved))[..., None]
    return unit


def next_translation(
    r: Array, v: Array, r_hat: Array, gains: Gains, dt: float
) -> tuple[Array, Array]:
    """Return the root's position and velocity after a step, each (…, 3) [Le26 §3.3]."""
    v = v + dt * (gains.root_kp * (r_hat - r) - gains.root_kd * v + gains.root_bias)
    return r + dt * v, v
