"""All quantities of one frame of one chain, by Eq. 1-13 of [Choi26 §3], for teaching.

:func:`twistcore.skeleton.signals.twist_signals` computes the same angles for a whole clip. This
module also returns every intermediate vector and quaternion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.analysis.decomposition.altered_frame import WhatIf, altered
from twistcore.analysis.decomposition.directions import angle_between, at_frame, direction
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    quaternion_from_axis_angle,
    rotate,
    swing_twist,
    twist_angle,
    twist_reliability,
    wrap,
)
from twistcore.skeleton.signals import azimuth_increments, counter_rotation

UNDEFINED = 1e-6  # an angle with at most this reliability is only rounding noise


@dataclass(frozen=True, eq=False)
class Decomposition:
    """The quantities of Eq. 1-13 in one frame: vectors (3,), quaternions (4,), angles (radians).

    - a: the bone in P's coordinates
    - q: P's rotation, with the sign for which q = swing ⊗ twist
    - w: a turned by q
    - n: the unit normal of the swing, zeros if there is no swing
    - alpha: the angle of the swing, [0, π]
    - swing, twist: the two factors of q
    - theta_p, dtheta_p: the twist and its change
    - swing_reliability, swing_reliability_before: 0 if θp is undefined, for this frame and for the
      previous one
    - v: C→G in P's coordinates
    - across: v⊥
    - v_before, across_before: v and v⊥ of the previous frame
    - v_ideal: v if C had kept its azimuth (Fig. 2)
    - dtheta_c: the change of the azimuth
    - azimuth_reliability: ‖v⊥‖, 0 if Δθc is undefined
    - bend: the angle between v and a
    - strength: m
    """

    a: Array
    q: Array
    w: Array
    n: Array
    alpha: float
    swing: Array
    twist: Array
    theta_p: float
    theta_p_before: float
    dtheta_p: float
    swing_reliability: float
    swing_reliability_before: float
    v: Array
    v_before: Array
    v_ideal: Array
    across: Array
    across_before: Array
    bend: float
    dtheta_c: float
    azimuth_reliability: float
    strength: float

    @property
    def product(self) -> float:
        """Δθp·Δθc, square radians [Choi26 Eq. 1]; negative for opposite turns."""
        return self.dtheta_p * self.dtheta_c

    @property
    def swing_is_one(self) -> bool:
        """True if the swing is unique. If w is opposite to a, many pairs (n, θp) give q."""
        return self.swing_reliability > UNDEFINED

    @property
    def n_is_defined(self) -> bool:
        """True if a × w has a direction [Choi26 Eq. 4]. At 0° and 180° it has none."""
        return self.swing_is_one and bool(self.n.any())

    @property
    def dtheta_p_is_defined(self) -> bool:
        """True if θp is defined in this frame and the previous one."""
        return self.swing_is_one and self.swing_reliability_before > UNDEFINED

    @property
    def dtheta_c_is_defined(self) -> bool:
        """True if v⊥ has a direction in this frame and the previous one.

        In a straight limb, v⊥ has no direction.
        """
        before = float(np.linalg.norm(self.across_before))
        return min(self.azimuth_reliability, before) > UNDEFINED

    @property
    def strength_is_defined(self) -> bool:
        """True if Δθp·Δθc and m are defined."""
        return self.dtheta_p_is_defined and self.dtheta_c_is_defined


def decompose(
    motion: Motion,
    chain: Chain,
    frame: int,
    what_if: WhatIf | None = None,
    *,
    offset: float = 0.0,
    stage: float | None = None,
) -> Decomposition:
    """Return the quantities of a chain at a frame and at the previous frame.

    `what_if` changes the frame; None leaves it as captured. For `offset` and `stage`, see
    :func:`altered`. Frame 0 is compared with itself as captured, so that its increments are 0.
    """
    before = max(frame - 1, 0)
    captured = what_if is None and stage is None
    now = motion
    if not captured:
        now = altered(motion, chain, frame, what_if or WhatIf(), offset=offset, stage=stage)
    at = frame if captured else 0
    q, q_child = now.rotations[at, chain.parent], now.rotations[at, chain.child]
    a, a_before = at_frame(chain.axis, frame), at_frame(chain.axis, before)
    swing, twist = swing_twist(q, a)
    if swing[0] < 0.0:  # q and −q are the same rotation; Eq. 6 has cos(α/2) ≥ 0
        q, swing = -q, -swing
    n = direction(swing[1:])
    w = rotate(q, a)
    theta_p = float(twist_angle(q, a))
    q_before = motion.rotations[before, chain.parent]
    theta_before = float(twist_angle(q_before, a_before))
    v = rotate(q_child, at_frame(chain.arm, frame))
    v_before = rotate(motion.rotations[before, chain.child], at_frame(chain.arm, before))
    across, across_before = _across(v, a), _across(v_before, a_before)
    dtheta_p = float(wrap(theta_p - theta_before))
    dtheta_c = float(azimuth_increments(np.stack([across_before, across]), np.stack([a, a]))[1])
    return Decomposition(
        a=a,
        q=q,
        w=w,
        n=n,
        alpha=angle_between(a, w),
        swing=swing,
        twist=twist,
        theta_p=theta_p,
        theta_p_before=theta_before,
        dtheta_p=dtheta_p,
        swing_reliability=float(twist_reliability(q, a)),
        swing_reliability_before=float(twist_reliability(q_before, a_before)),
        v=v,
        v_before=v_before,
        v_ideal=rotate(quaternion_from_axis_angle(a, -dtheta_c), v),
        across=across,
        across_before=across_before,
        bend=angle_between(a, v),
        dtheta_c=dtheta_c,
        azimuth_reliability=float(np.linalg.norm(across)),
        strength=float(counter_rotation(np.array([dtheta_p]), np.array([dtheta_c]))[0]),
    )


def _across(v: Array, axis: Array) -> Array:
    """Return v⊥ = v − (v·a)a [Choi26 Eq. 11]."""
    across: Array = v - float(v @ axis) * axis
    return across
