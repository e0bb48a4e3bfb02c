"""Apply a user's changes to a single frame of a motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.directions import (
    angle_between,
    perpendicular,
    unit_vector,
    vector_at_frame,
)
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    rotate,
    swing_twist,
    twist_angle,
)


@dataclass(frozen=True)
class WhatIf:
    """A user's changes to a frame. Angles are in radians. None means that a quantity is unchanged.

    P, C and G are the chain's parent, child and grandchild. a is the bone axis, w is the direction
    of the bone after P's rotation, and v is the direction from C to G in P's coordinates.

    Attributes
    ----------
    twist
        Angle by which P is twisted about its bone.
    counter
        True if C rotates back by the same angle, False if it rotates with P.
    swing
        Swing angle α between a and w. It is applied after `toward`.
    bend
        Angle between v and a.
    nudge
        Angle by which the bone and v are tipped sideways, out of the planes in which swing and bend
        are measured.
    toward
        Direction w, unit vector (x, y, z).
    applied
        Fraction of offset(t) that is removed, 0…1 [Choi26 Eq. 15].
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
        """True if any quantity differs from the captured frame."""
        return self != WhatIf(counter=self.counter)


def frame_motion_with_user_changes(
    motion: Motion,
    chain: Chain,
    frame: int,
    what_if: WhatIf,
    *,
    offset: float = 0.0,
    stage: float | None = None,
) -> Motion:
    """Return a frame of the motion with a user's changes, as a motion of one frame.

    Bend, swing and nudge are applied before the twist, because they do not change the twist's
    quaternion. With `what_if.counter`, each child of P rotates back, as in a twist error [Choi26
    Eq. 14]. Finally, the fraction `what_if.applied` of the offset is removed.

    Parameters
    ----------
    motion, chain, frame
        The frame to change.
    what_if
        The changes.
    offset
        The offset of an error in this frame, radians.
    stage
        How much of P's rotation to include, as in :func:`swing_then_twist_at_stage`. None for all
        of it.
    """
    one = motion.sliced(frame, frame + 1)
    here = replace(
        chain, axis=vector_at_frame(chain.axis, frame), arm=vector_at_frame(chain.arm, frame)
    )
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
    rotations[0, chain.parent] = swing_then_twist_at_stage(
        rotations[0, chain.parent], here.axis, stage
    )
    return one.with_rotations(rotations)


def swing_then_twist_at_stage(q: Array, axis: Array, stage: float) -> Array:
    """Return a partial rotation as a quaternion, (4,).

    Stage 0 is no rotation, stage 1 the swing, and stage 2 the whole rotation. Values in between
    give fractions of the swing or the twist.
    """
    swing, twist = swing_twist(q, axis)
    normal, angle = _swing_turn(swing)
    part = quaternion_from_axis_angle(normal, float(np.clip(stage, 0.0, 1.0)) * angle)
    rolled = float(np.clip(stage - 1.0, 0.0, 1.0)) * float(twist_angle(twist, axis))
    return normalise(multiply(part, quaternion_from_axis_angle(axis, rolled)))


def _swing_turn(swing: Array) -> tuple[Array, float]:
    """Return the unit normal of a swing, (3,), and its angle in [0, π], radians.

    If there is no swing, the normal is zero.
    """
    vector = swing[1:] * (1.0 if swing[0] >= 0.0 else -1.0)
    return unit_vector(vector), float(2.0 * np.arctan2(np.linalg.norm(vector), abs(swing[0])))


def _swung(q: Array, axis: Array, what_if: WhatIf) -> Array:
    """Return the parent's rotation after the changes to swing and nudge, with the same twist."""
    swing, twist = swing_twist(q, axis)
    normal, angle = _swing_turn(swing)
    if what_if.toward is not None:
        w = normalise(what_if.toward)
        across, angle = np.cross(axis, w), angle_between(axis, w)
        normal = unit_vector(across) if unit_vector(across).any() else normal
    if not normal.any():
        normal = perpendicular(axis)
    if what_if.swing is not None:
        angle = what_if.swing
    if what_if.swing is not None or what_if.toward is not None:
        q = multiply(quaternion_from_axis_angle(normal, angle), twist)
    return multiply(_tip(rotate(q, axis), normal, what_if.nudge), q)


def _bent(q: Array, chain: Chain, what_if: WhatIf) -> Array:
    """Return the child's rotation after the changes to bend and nudge."""
    v = rotate(q, chain.arm)
    normal = unit_vector(np.cross(chain.axis, v))
    if not normal.any():
        normal = perpendicular(chain.axis)
    if what_if.bend is not None:
        turn = what_if.bend - angle_between(chain.axis, v)
        q = multiply(quaternion_from_axis_angle(normal, turn), q)
    return multiply(_tip(rotate(q, chain.arm), normal, what_if.nudge), q)


def _tip(tip: Array, normal: Array, angle: float) -> Array:
    """Return the rotation that tips the unit vector `tip` towards `normal` by an angle."""
    return quaternion_from_axis_angle(np.cross(tip, normal), angle)
