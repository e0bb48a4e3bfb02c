"""Transfer poses from SMPL's rest pose to a skeleton with a different rest pose.

In SMPL, the rotation of a joint rotates its bones from their directions in a T-pose: y is up, the
figure faces z with its left side at +x, its legs are straight down, and its arms are level. On a
skeleton whose legs are apart or whose arms hang, the same rotations result in other directions. Let
A be the rotation from the direction d of a bone in the skeleton's rest pose to its direction in
SMPL's, d_SMPL = A d. If the world rotation G of the joint is replaced by G A, the bone has the same
direction as in SMPL, since G A d = G d_SMPL. The local rotation q must therefore be replaced by
A_parent⁻¹ q A.

The roll of a bone in a rest pose is unknown, since offsets have no roll. A is the smallest possible
rotation, so it changes the roll of a limb no more than lifting the limb sideways would. In SMPL
itself, the directions of bones differ from the axes by a few degrees, depending on the body. A limb
within that angle of its axis is therefore not rotated.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from twistcore.errors import TwistError
from twistcore.formats.smpl.skeleton import ANKLES, JOINTS, PARENTS, SMPL_NAMES, TOES
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    rotate,
)

_X, _Y, _Z = np.eye(3)
# For each limb: the joint, its child, the direction of the bone between them in the T-pose, the
# angle within which the bone is not rotated, and the largest angle for which the direction of this
# rotation is certain. Angles are in degrees. In SMPL itself, feet point down by about 25°.
_LIMBS = (
    *((j, j + 3, -_Y, 8.0, 60.0) for j in (1, 2, 4, 5)),
    *((j, j + 3, _Z, 50.0, 100.0) for j in ANKLES),
    *((j, j + 2, x, tolerance, 100.0)
      for first, tolerance in ((16, 8.0), (18, 8.0), (20, 20.0))
      for j, x in ((first, _X), (first + 1, -_X))),
)  # fmt: skip
_HIPS, _CHEST, _HEAD = (1, 2), 9, 15
_ASKEW = 30.0  # maximum angle in degrees between the axes of the body and of the file
_SHORT = 1e-6  # share of the body's size; a shorter bone has no direction


@dataclass(frozen=True, eq=False)
class RestChange:
    """The rotations from the rest pose of a skeleton to SMPL's rest pose.

    Attributes
    ----------
    turns
        The rotation A of each joint as a unit quaternion, shape (24, 4).
    notes
        Sentences about the differences between the rest poses.
    """

    turns: Array
    notes: tuple[str, ...]

    def carried(self, rotations: Array) -> Array:
        """Convert local rotations, (frames, 24, 4), from SMPL's rest pose to the skeleton's."""
        out = multiply(rotations, self.turns)
        for j, parent in enumerate(PARENTS):
            if parent >= 0:
                out[:, j] = multiply(conjugate(self.turns[parent]), out[:, j])
        return out


def smpl_rest_pose_change(offsets: Array, rest: Array | None = None) -> RestChange:
    """Compute the rotations from the rest pose of a skeleton to SMPL's rest pose.

    The trunk keeps its shape: hips, spine and collars, where several bones meet at one joint, are
    rotated only with the whole body, by multiples of 90°.

    Parameters
    ----------
    offsets
        The rest offsets of the skeleton, shape (24, 3).
    rest
        The rest offsets of SMPL's skeleton for the same body, shape (24, 3). If they are given, the
        limbs are rotated to their directions, even by small angles. If not, the limbs are rotated
        to the axes of the T-pose.

    Raises
    ------
    TwistError
        If the rest pose is not upright along an axis, or a limb is too far from the T-pose.
    """
    body = _body(offsets)
    directions = rotate(body, offsets)
    size = float(np.linalg.norm(offsets, axis=1).sum())
    turns = np.tile(body, (JOINTS, 1))
    moved: list[str] = []
    own = {row[0]: row for row in _LIMBS}
    for j, parent in enumerate(PARENTS):
        if j not in own:
            if j in (*TOES, 22, 23):
                turns[j] = turns[parent]
            continue
        _, below, wanted, tolerance, most = own[j]
        if rest is not None and np.linalg.norm(rest[below]) > 0.0:
            wanted, tolerance = normalise(rest[below]), 0.0
        length = float(np.linalg.norm(offsets[below]))
        if length <= _SHORT * size:  # a joint without a bone rotates with its parent
            if parent in own:
                turns[j] = turns[parent]
            continue
        found = directions[below] / length
        angle = float(np.degrees(_angle(found, wanted)))
        if angle > most:
            raise TwistError(
                f"expected a rest pose like a T-pose, upright with arms level or down; the "
                f"bone below {SMPL_NAMES[j]} is {angle:.0f}° off"
            )
        if angle > tolerance:
            turns[j] = multiply(_shortest(found, wanted), body)
            if angle > 1.0:
                moved.append(f"{SMPL_NAMES[j]} by {angle:.0f}°")
    notes = []
    if abs(body[0]) < 1.0 - 1e-9:
        turned = np.degrees(2.0 * np.arccos(min(1.0, abs(body[0]))))
        notes.append(
            "The skeleton's rest pose does not face the same way as SMPL's: it is turned by "
            f"{turned:.0f}°."
        )
    if moved:
        notes.append(
            f"The skeleton's rest pose differs from SMPL's T-pose at these joints: "
            f"{', '.join(moved)}. The roll of limbs at rest is unknown."
        )
    return RestChange(turns, tuple(notes))


def _body(offsets: Array) -> Array:
    """Return the rotation by quarter turns, (4,), that makes a rest pose upright, facing z."""
    places = np.zeros((JOINTS, 3))
    for j, parent in enumerate(PARENTS):
        places[j] = (places[parent] + offsets[j]) if parent >= 0 else 0.0
    across = places[_HIPS[0]] - places[_HIPS[1]]
    up = places[[_CHEST, _HEAD]].mean(axis=0) - places[list(_HIPS)].mean(axis=0)
    size = float(np.ptp(places, axis=0).max())
    ahead = np.cross(across, up)
    if not np.linalg.norm(ahead) > 1e-4 * size**2 or size == 0.0:
        raise TwistError("expected a rest pose with two separate hips and a trunk above them")
    ahead = normalise(ahead)
    across = normalise(across)
    measured = np.stack([across, np.cross(ahead, across), ahead])  # rows: into SMPL's axes
    best: Array = max(_quarter_turns(), key=lambda m: float(np.trace(m @ measured.T)))
    off = np.degrees(np.arccos(np.clip((np.trace(best @ measured.T) - 1.0) / 2.0, -1.0, 1.0)))
    if off > _ASKEW:
        raise TwistError(
            "expected a rest pose that is upright and faces along an axis, found a "
            f"deviation of {off:.0f}°"
        )
    feet = sum(best @ offsets[toe] for toe in TOES)
    if feet[2] < -0.5 * np.linalg.norm(feet):
        raise TwistError(
            "the feet point backwards in the rest pose: left and right seem to be swapped"
        )
    return _quaternion(best)


@cache
def _quarter_turns() -> tuple[Array, ...]:
    """Return the 24 rotation matrices that map coordinate axes to coordinate axes."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            m = np.zeros((3, 3))
            m[range(3), order] = signs
            if np.linalg.det(m) > 0.0:
                found.append(m)
    return tuple(found)


def _quaternion(m: Array) -> Array:
    q: Array = Rotation.from_matrix(m).as_quat(canonical=True, scalar_first=True)
    return q


def _angle(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _shortest(a: Array, b: Array) -> Array:
    """Return the smallest rotation, (4,), from unit vector a to b, which must not be opposite."""
    axis = np.cross(a, b)
    size = float(np.linalg.norm(axis))
    if size == 0.0:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return quaternion_from_axis_angle(axis / size, _angle(a, b))
