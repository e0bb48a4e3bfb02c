"""One step of the state-space model: quaternions, angular velocities, root position and velocity.

Equation numbers refer to [Le26], arXiv:2601.19580. Units are seconds, radians, and
metres or the clip's length unit. Quaternions are scalar first. Angular velocities are in the
parent's frame and multiply from the left. Leading axes broadcast, so the shapes below give only the
last axes.
"""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array, conjugate, exponential, multiply
from twistcore.work.frozen import dataclass

NETWORK_DT = 0.04  # seconds: the frame time for which a network's gains and κA are tuned
EXACT, FIRST_ORDER = "exact", "first-order"


@dataclass(frozen=True, eq=False)
class Gains:
    """Gains of the meta-PD controller. Each is a number or an array that broadcasts.

    - kp (1/s²), kd (1/s), ka (rad/s² for a difference of 1 in vec at 25 Hz) and bias (rad/s²) act
      on rotations, shape (…, joints, 3)
    - root_kp, root_kd and root_bias (length/s²) act on the root's position, shape (…, 3)
    - clip is the largest magnitude of each component of ω, in rad/s
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
        """Return the hand-tuned gains for a frame time in seconds; stiffer at higher frame rates.

        The gains are the defaults at 25 Hz, and κP/s² and κD/s with s = 0.3 + 0.7 Δt/0.04 s at
        other rates. A joint that turns steadily is 2κD/κP − Δt behind its reference, which is 10 ms
        at 25 Hz and less than 15 ms at any rate. The gains are stable at any rate. `causal` is
        False for tracking forward and backward, where the lag is 0. In this case, κP 550, κD 17
        and, for the root, 200 and 14 at 25 Hz give a lower Accel at no higher MPJPE, on CMU's
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
    """The four terms of a step's angular acceleration, rad/s², each (…, joints, 3) [Le26 Eq. 5]."""

    proportional: Array
    damping: Array
    bias: Array
    acceleration: Array


def short_vector(q: Array) -> Array:
    """Return vec(±q), sin(θ/2) times the axis, with the sign that makes w ≥ 0, (…, 4) → (…, 3)."""
    return np.where(q[..., :1] < 0.0, -q[..., 1:], q[..., 1:])


def aligned(q_hat: Array, q: Array) -> Array:
    """Return q̂ or −q̂, the one in q's hemisphere, since both describe the same reference."""
    dot = np.einsum("...i,...i->...", q_hat, q)
    return np.where(dot[..., None] < 0.0, -q_hat, q_hat)


def angular_acceleration(
    q: Array, omega: Array, q_hat: Array, curvature: Array | float, gains: Gains, dt: float
) -> AccelerationTerms:
    """Return the four terms of the angular acceleration [Le26 Eq. 5].

    `curvature` is δ(t+1) − δ(t), with δ from :func:`increment`. The curvature is a difference per
    frame², so κA, which was tuned at 25 Hz, is scaled by (0.04/Δt)².
    """
    error = short_vector(multiply(q_hat, conjugate(q)))
    ka = gains.ka * (NETWORK_DT / dt) ** 2
    shape = error.shape
    return AccelerationTerms(
        gains.kp * error,
        -(gains.kd * omega),
        np.broadcast_to(np.asarray(gains.bias, dtype=np.float64), shape),
        np.broadcast_to(np.asarray(ka * curvature, dtype=np.float64), shape),
    )


def increment(q_hat: Array, before: Array) -> Array:
    """Return δ = vec(±(q̂(t+1) ⊗ q̂(t)*)), (…, 3): the axis of a reference step times sin(θ/2)."""
    return short_vector(multiply(q_hat, conjugate(before)))


def next_velocity(omega: Array, parts: AccelerationTerms, dt: float, clip: float) -> Array:
    """Return ω after a step, with each component limited to ±clip [Le26 Eq. 1, 5]."""
    rate = parts.proportional + parts.damping + parts.bias + parts.acceleration
    return np.clip(omega + dt * rate, -clip, clip)


def next_quaternion(q: Array, omega: Array, dt: float, integration: str = EXACT) -> Array:
    """Return q after a step with constant ω in the parent's frame.

    With integration 'exact', this is Exp(ωΔt) ⊗ q, which always stays on S³ [Le26 Eq. 4]. With
    'first-order', it is the renormalised tangent step q + ½Δt (0, ω) ⊗ q, as in earlier work [Le26
    supplement E].
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
