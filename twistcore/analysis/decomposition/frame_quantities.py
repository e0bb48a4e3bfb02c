"""Compute all quantities of a chain in one frame, by [Choi26 Eq. 1-13], for teaching.

:func:`twistcore.skeleton.signals.twist_signals` computes the same angles for a whole clip. This
module also returns all intermediate vectors and quaternions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.analysis.decomposition.altered_frame import WhatIf, frame_motion_with_user_changes
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.directions import angle_between, unit_vector, vector_at_frame
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

UNDEFINED = 1e-6  # an angle with at most this reliability consists of rounding errors


@dataclass(frozen=True, eq=False)
class Decomposition:
    """The quantities of [Choi26 Eq. 1-13] for a chain in one frame.

    Vectors have the shape (3,) and are in the parent's coordinates, quaternions have the shape
    (4,), and angles are in radians.

    Attributes
    ----------
    a
        The bone axis.
    q
        The parent's rotation, with the sign for which q = swing ⊗ twist.
    w
        The bone axis a, rotated by q.
    n
        Unit normal of the swing, or zeros if there is no swing.
    alpha
        Angle of the swing, in [0, π].
    swing, twist
        The factors of q.
    theta_p, theta_p_before, dtheta_p
        Twist θp in this and in the previous frame, and its change.
    swing_reliability, swing_reliability_before
        How well θp is defined in this and in the previous frame, 0…1.
    v, v_before
        Direction from the child to the grandchild in this and in the previous frame.
    v_ideal
        v if the child had kept its azimuth [Choi26 Fig. 2].
    across, across_before
        v⊥, the component of v perpendicular to a, in this and in the previous frame.
    bend
        Angle between v and a.
    dtheta_c
        Change of the azimuth θc.
    azimuth_reliability
        ‖v⊥‖, which is 0 if the azimuth is undefined.
    strength
        Strength m, which is compared with τ.
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
        """Δθp·Δθc, square radians, which is negative for opposite turns [Choi26 Eq. 1]."""
        return self.dtheta_p * self.dtheta_c

    @property
    def swing_is_one(self) -> bool:
        """True if the swing is unique.

        If w is opposite to a, q can be split into many pairs of swing and twist.
        """
        return self.swing_reliability > UNDEFINED

    @property
    def n_is_defined(self) -> bool:
        """True if a × w has a direction [Choi26 Eq. 4]. It has none if α is 0° or 180°."""
        return self.swing_is_one and bool(self.n.any())

    @property
    def dtheta_p_is_defined(self) -> bool:
        """True if θp is defined in this and in the previous frame."""
        return self.swing_is_one and self.swing_reliability_before > UNDEFINED

    @property
    def dtheta_c_is_defined(self) -> bool:
        """True if v⊥ has a direction in this and in the previous frame.

        It has none in a straight limb.
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
    """Compute all quantities of a chain in a frame.

    Parameters
    ----------
    motion, chain, frame
        The frame. In frame 0, the increments are relative to frame 0 as captured.
    what_if
        The user's changes to the frame, or None.
    offset, stage
        The same as in :func:`frame_motion_with_user_changes`.
    """
    before = max(frame - 1, 0)
    captured = what_if is None and stage is None
    now = motion
    if not captured:
        now = frame_motion_with_user_changes(
            motion, chain, frame, what_if or WhatIf(), offset=offset, stage=stage
        )
    at = frame if captured else 0
    q, q_child = now.rotations[at, chain.parent], now.rotations[at, chain.child]
    a, a_before = vector_at_frame(chain.axis, frame), vector_at_frame(chain.axis, before)
    swing, twist = swing_twist(q, a)
    if swing[0] < 0.0:  # q and −q are the same rotation, and Eq. 6 has cos(α/2) ≥ 0
        q, swing = -q, -swing
    n = unit_vector(swing[1:])
    w = rotate(q, a)
    theta_p = float(twist_angle(q, a))
    q_before = motion.rotations[before, chain.parent]
    theta_before = float(twist_angle(q_before, a_before))
    v = rotate(q_child, vector_at_frame(chain.arm, frame))
    v_before = rotate(motion.rotations[before, chain.child], vector_at_frame(chain.arm, before))
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
    """Return v⊥ = v − (v·a)a, the component of v perpendicular to the axis a [Choi26 Eq. 11]."""
    across: Array = v - float(v @ axis) * axis
    return across
