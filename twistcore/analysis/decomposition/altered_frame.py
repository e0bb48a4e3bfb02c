"""A frame with changes made by a user, as a motion of one frame."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from twistcore.analysis.correction import remove_twist
from twistcore.analysis.decomposition.directions import (
    angle_between,
    at_frame,
    direction,
    perpendicular,
)
from twistcore.skeleton.chain import Chain
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
    """The changes to a frame. Angles are in radians; None leaves a quantity as captured.

    - twist: the angle by which P is twisted about its bone
    - counter: True if C turns back by the same angle, False if it turns with P
    - toward: the unit vector w, the direction of the bone, in the coordinates of P's rotation
    - swing: the angle α between a and w, applied after `toward`
    - bend: the angle between v and a
    - nudge: the angle by which the bone and v are tipped sideways, out of the planes in which α and
      the bend are measured
    - applied: the fraction, 0…1, of offset(t) that is removed (Eq. 15)
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


def altered(
    motion: Motion,
    chain: Chain,
    frame: int,
    what_if: WhatIf,
    *,
    offset: float = 0.0,
    stage: float | None = None,
) -> Motion:
    """Return one frame of the motion with the changes, as a Motion of length 1.

    Bend, swing and nudge are applied before the twist, because they do not change the twist's own
    quaternion. With `counter`, every child of P turns back, as in a twist error (Eq. 14). Finally,
    the fraction `applied` of `offset`, in radians, is removed. `stage` selects the part of P's
    rotation that is included and that the children follow: 0 for none, 1 for the swing, 2 for the
    twist as well, and fractions in between.
    """
    one = motion.sliced(frame, frame + 1)
    here = replace(chain, axis=at_frame(chain.axis, frame), arm=at_frame(chain.arm, frame))
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
    """Return the part of a rotation up to a stage, (4,).

    This is the identity at stage 0, the swing at stage 1, and the whole rotation at stage 2.
    """
    swing, twist = swing_twist(q, axis)
    normal, angle = _swing_turn(swing)
    part = quaternion_from_axis_angle(normal, float(np.clip(stage, 0.0, 1.0)) * angle)
    rolled = float(np.clip(stage - 1.0, 0.0, 1.0)) * float(twist_angle(twist, axis))
    return normalise(multiply(part, quaternion_from_axis_angle(axis, rolled)))


def _swing_turn(swing: Array) -> tuple[Array, float]:
    """Return the unit normal of a swing and its angle in [0, π].

    The normal is zeros if there is no swing.
    """
    vector = swing[1:] * (1.0 if swing[0] >= 0.0 else -1.0)
    return direction(vector), float(2.0 * np.arctan2(np.linalg.norm(vector), abs(swing[0])))


def _swung(q: Array, axis: Array, what_if: WhatIf) -> Array:
    """Return P's rotation with a changed swing and the same twist, tipped by the nudge."""
    swing, twist = swing_twist(q, axis)
    normal, angle = _swing_turn(swing)
    if what_if.toward is not None:
        w = normalise(what_if.toward)
        across, angle = np.cross(axis, w), angle_between(axis, w)
        normal = direction(across) if direction(across).any() else normal
    if not normal.any():
        normal = perpendicular(axis)
    if what_if.swing is not None:
        angle = what_if.swing
    if what_if.swing is not None or what_if.toward is not None:
        q = multiply(quaternion_from_axis_angle(normal, angle), twist)
    return multiply(_tip(rotate(q, axis), normal, what_if.nudge), q)


def _bent(q: Array, chain: Chain, what_if: WhatIf) -> Array:
    """Return C's rotation with a changed angle between v and a, tipped by the nudge."""
    v = rotate(q, chain.arm)
    normal = direction(np.cross(chain.axis, v))
    if not normal.any():
        normal = perpendicular(chain.axis)
    if what_if.bend is not None:
        turn = what_if.bend - angle_between(chain.axis, v)
        q = multiply(quaternion_from_axis_angle(normal, turn), q)
    return multiply(_tip(rotate(q, chain.arm), normal, what_if.nudge), q)


def _tip(tip: Array, normal: Array, angle: float) -> Array:
    """Return the rotation that tips the unit vector `tip` by an angle towards `normal`."""
    return quaternion_from_axis_angle(np.cross(tip, normal), angle)
