"""One frame of one chain, quantity by quantity: what [Choi26 §3] computes, for those who learn it.

:func:`twistcore.signals.twist_signals` gives the same angles for a whole clip at once. Here every
vector and quaternion on the way is kept, and a frame may be altered first (:class:`WhatIf`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from twistcore.chain import Chain
from twistcore.motion import Motion
from twistcore.refinement import remove_twist
from twistcore.rotation import (
    Array,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    rotate,
    swing_twist,
    twist_angle,
    twist_reliability,
    wrap,
)
from twistcore.signals import azimuth_increments, counter_rotation

_NO_TURN = 1e-9  # length of a vector that has no direction any more


@dataclass(frozen=True)
class WhatIf:
    """How a frame is altered; angles in radians, None: as captured.

    twist: by which P is twisted about its bone; counter: C turns back by as much, else it goes
    along; swing: the angle α between a and w; bend: the angle between v and a; nudge: by which the
    bone and v are tipped sideways, out of the planes in which α and the bend are measured.
    """

    twist: float = 0.0
    counter: bool = False
    swing: float | None = None
    bend: float | None = None
    nudge: float = 0.0

    @property
    def changes(self) -> bool:
        """Whether anything is other than captured."""
        return self != WhatIf(counter=self.counter)


@dataclass(frozen=True, eq=False)
class Decomposition:
    """The quantities of Eq. 1-13 at one frame; vectors (3,), quaternions (4,), angles in radians.

    a: the bone in P's coordinates; q: P's rotation, its sign such that q = swing ⊗ twist; w: a
    turned by q; n: the swing's unit normal, zeros where it has none; alpha: the swing's angle,
    [0, π]; swing, twist: the two factors; theta_p, dtheta_p: the twist and its change;
    swing_reliability: 0 where θp is undefined; v: C→G in P's coordinates; across: v⊥;
    v_before, across_before: those of the frame before; v_ideal: v as it were if C had kept its
    azimuth (Fig. 2); dtheta_c: the azimuth's change; azimuth_reliability: ‖v⊥‖, 0 where Δθc is
    undefined; bend: the angle between v and a; strength: m.
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
        """Δθp·Δθc in square radians: below 0 they are opposed [Choi26 Eq. 1]."""
        return self.dtheta_p * self.dtheta_c


def decompose(
    motion: Motion, chain: Chain, frame: int, what_if: WhatIf | None = None
) -> Decomposition:
    """The quantities of a chain at a frame, altered or as captured, against the frame before.

    Frame 0 is compared with itself as captured, so that its increments are 0.
    """
    before = max(frame - 1, 0)
    now = motion if what_if is None else altered(motion, chain, frame, what_if)
    at = frame if what_if is None else 0
    q, q_child = now.rotations[at, chain.parent], now.rotations[at, chain.child]
    a, a_before = _at(chain.axis, frame), _at(chain.axis, before)
    swing, twist = swing_twist(q, a)
    if swing[0] < 0.0:  # q and −q are one rotation; Eq. 6 has cos(α/2) ≥ 0
        q, swing = -q, -swing
    n = _direction(swing[1:])
    w = rotate(q, a)
    theta_p = float(twist_angle(q, a))
    theta_before = float(twist_angle(motion.rotations[before, chain.parent], a_before))
    v = rotate(q_child, _at(chain.arm, frame))
    v_before = rotate(motion.rotations[before, chain.child], _at(chain.arm, before))
    across, across_before = _across(v, a), _across(v_before, a_before)
    dtheta_p = float(wrap(theta_p - theta_before))
    dtheta_c = float(azimuth_increments(np.stack([across_before, across]), np.stack([a, a]))[1])
    return Decomposition(
        a=a,
        q=q,
        w=w,
        n=n,
        alpha=_angle(a, w),
        swing=swing,
        twist=twist,
        theta_p=theta_p,
        theta_p_before=theta_before,
        dtheta_p=dtheta_p,
        swing_reliability=float(twist_reliability(q, a)),
        v=v,
        v_before=v_before,
        v_ideal=rotate(quaternion_from_axis_angle(a, -dtheta_c), v),
        across=across,
        across_before=across_before,
        bend=_angle(a, v),
        dtheta_c=dtheta_c,
        azimuth_reliability=float(np.linalg.norm(across)),
        strength=float(counter_rotation(np.array([dtheta_p]), np.array([dtheta_c]))[0]),
    )


def altered(motion: Motion, chain: Chain, frame: int, what_if: WhatIf) -> Motion:
    """One frame of the motion, altered; a Motion of length 1.

    First bend, swing and nudge, which leave the twist's own quaternion alone, then the twist. With
    `counter` every child of P turns back, which is what a twist error does (Eq. 14).
    """
    one = motion.sliced(frame, frame + 1)
    here = replace(chain, axis=_at(chain.axis, frame), arm=_at(chain.arm, frame))
    rotations = one.rotations.copy()
    q, q_child = rotations[0, chain.parent], rotations[0, chain.child]
    rotations[0, chain.parent] = normalise(_swung(q, here.axis, what_if))
    rotations[0, chain.child] = normalise(_bent(q_child, here, what_if))
    one = one.with_rotations(rotations)
    if what_if.counter:
        return remove_twist(one, [here], {chain.name: np.array([-what_if.twist])})
    rotations[0, chain.parent] = normalise(
        multiply(rotations[0, chain.parent], quaternion_from_axis_angle(here.axis, what_if.twist))
    )
    return one


def _swung(q: Array, axis: Array, what_if: WhatIf) -> Array:
    """P's rotation with another swing and the same twist, tipped by the nudge."""
    swing, twist = swing_twist(q, axis)
    normal = _direction(swing[1:] * (1.0 if swing[0] >= 0.0 else -1.0))
    if not normal.any():
        normal = _beside(axis)
    if what_if.swing is not None:
        q = multiply(quaternion_from_axis_angle(normal, what_if.swing), twist)
    return multiply(_tip(rotate(q, axis), normal, what_if.nudge), q)


def _bent(q: Array, chain: Chain, what_if: WhatIf) -> Array:
    """C's rotation with another angle between v and a, tipped by the nudge."""
    v = rotate(q, chain.arm)
    normal = _direction(np.cross(chain.axis, v))
    if not normal.any():
        normal = _beside(chain.axis)
    if what_if.bend is not None:
        turn = what_if.bend - _angle(chain.axis, v)
        q = multiply(quaternion_from_axis_angle(normal, turn), q)
    return multiply(_tip(rotate(q, chain.arm), normal, what_if.nudge), q)


def _tip(tip: Array, normal: Array, angle: float) -> Array:
    """The rotation that moves a unit vector by so much towards another, square to it."""
    return quaternion_from_axis_angle(np.cross(tip, normal), angle)


def _at(vector: Array, frame: int) -> Array:
    """The vector of a frame, (3,), where it varies."""
    return vector if vector.ndim == 1 else vector[frame]


def _across(v: Array, axis: Array) -> Array:
    """v⊥ = v − (v·a)a [Choi26 Eq. 11]."""
    across: Array = v - float(v @ axis) * axis
    return across


def _angle(u: Array, v: Array) -> float:
    """The angle between two unit vectors, exact near 0 and π too, where the cosine is not."""
    return float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))


def _direction(v: Array) -> Array:
    """The unit vector of (3,), zeros where it has none."""
    return normalise(v) if float(np.linalg.norm(v)) > _NO_TURN else np.zeros(3)


def _beside(axis: Array) -> Array:
    """A unit vector square to another."""
    return normalise(np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]))
