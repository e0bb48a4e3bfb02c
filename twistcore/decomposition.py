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
    along; toward: the unit vector w that the bone is pointed to, in the coordinates that P's
    rotation is given in; swing: the angle α between a and w, set after `toward`; bend: the angle
    between v and a; nudge: by which the bone and v are tipped sideways, out of the planes in which
    α and the bend are measured; applied: the share, 0…1, of offset(t) that is taken off (Eq. 15).
    """

    twist: float = 0.0
    counter: bool = False
    swing: float | None = None
    bend: float | None = None
    nudge: float = 0.0
    toward: tuple[float, float, float] | None = None
    applied: float = 0.0

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
    motion: Motion,
    chain: Chain,
    frame: int,
    what_if: WhatIf | None = None,
    *,
    offset: float = 0.0,
    stage: float | None = None,
) -> Decomposition:
    """The quantities of a chain at a frame, altered or as captured, against the frame before.

    offset, stage: see :func:`altered`. Frame 0 is compared with itself as captured, so that its
    increments are 0.
    """
    before = max(frame - 1, 0)
    captured = what_if is None and stage is None
    now = motion
    if not captured:
        now = altered(motion, chain, frame, what_if or WhatIf(), offset=offset, stage=stage)
    at = frame if captured else 0
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


def altered(
    motion: Motion,
    chain: Chain,
    frame: int,
    what_if: WhatIf,
    *,
    offset: float = 0.0,
    stage: float | None = None,
) -> Motion:
    """One frame of the motion, altered; a Motion of length 1.

    First bend, swing and nudge, which leave the twist's own quaternion alone, then the twist. With
    `counter` every child of P turns back, which is what a twist error does (Eq. 14). Then as much
    of `offset`, radians, is taken off as the what-if applies. stage: how much of P's rotation is
    there, the children carried: 0 none, 1 the whole swing, 2 the whole twist on top of it.
    """
    one = motion.sliced(frame, frame + 1)
    here = replace(chain, axis=_at(chain.axis, frame), arm=_at(chain.arm, frame))
    rotations = one.rotations.copy()
    q, q_child = rotations[0, chain.parent], rotations[0, chain.child]
    rotations[0, chain.parent] = normalise(_swung(q, here.axis, what_if))
    rotations[0, chain.child] = normalise(_bent(q_child, here, what_if))
    if not what_if.counter:
        along = quaternion_from_axis_angle(here.axis, what_if.twist)
        rotations[0, chain.parent] = normalise(multiply(rotations[0, chain.parent], along))
    back = what_if.applied * offset - (what_if.twist if what_if.counter else 0.0)
    one = remove_twist(one.with_rotations(rotations), [here], {chain.name: np.array([back])})
    if stage is None:
        return one
    rotations = one.rotations.copy()
    rotations[0, chain.parent] = staged(rotations[0, chain.parent], here.axis, stage)
    return one.with_rotations(rotations)


def staged(q: Array, axis: Array, stage: float) -> Array:
    """A rotation on its way from none, by its swing (stage 0…1), to all of it (1…2), (4,)."""
    swing, twist = swing_twist(q, axis)
    normal, angle = _swing_turn(swing)
    part = quaternion_from_axis_angle(normal, float(np.clip(stage, 0.0, 1.0)) * angle)
    rolled = float(np.clip(stage - 1.0, 0.0, 1.0)) * float(twist_angle(twist, axis))
    return normalise(multiply(part, quaternion_from_axis_angle(axis, rolled)))


def _swing_turn(swing: Array) -> tuple[Array, float]:
    """The unit normal of a swing, zeros where it has none, and its angle in [0, π]."""
    vector = swing[1:] * (1.0 if swing[0] >= 0.0 else -1.0)
    return _direction(vector), float(2.0 * np.arctan2(np.linalg.norm(vector), abs(swing[0])))


def _swung(q: Array, axis: Array, what_if: WhatIf) -> Array:
    """P's rotation with another swing and the same twist, tipped by the nudge."""
    swing, twist = swing_twist(q, axis)
    normal, angle = _swing_turn(swing)
    if what_if.toward is not None:
        w = normalise(what_if.toward)
        across, angle = np.cross(axis, w), _angle(axis, w)
        normal = _direction(across) if _direction(across).any() else normal
    if not normal.any():
        normal = _beside(axis)
    if what_if.swing is not None:
        angle = what_if.swing
    if what_if.swing is not None or what_if.toward is not None:
        q = multiply(quaternion_from_axis_angle(normal, angle), twist)
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
