"""The 24 joints of SMPL, which QuaMo uses, and how to find them in any other skeleton."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.formats.npz.body import BODIES
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, conjugate, multiply, rotate
from twistcore.work.frozen import dataclass

CMU_UNIT = 0.056444  # metres: lengths in CMU's skeletons are inches divided by 0.45

# The joints are in SMPL's order, so that its poses need not be reordered. CMU_NAMES contains the
# corresponding joints of CMU's skeletons, and MIRROR the index of each joint on the other side.
SMPL_NAMES, PARENTS = BODIES[24].names, tuple(BODIES[24].parents.tolist())
CMU_NAMES = (
    "Hips", "LeftUpLeg", "RightUpLeg", "LowerBack", "LeftLeg", "RightLeg", "Spine",
    "LeftFoot", "RightFoot", "Spine1", "LeftToeBase", "RightToeBase", "Neck", "LeftShoulder",
    "RightShoulder", "Head", "LeftArm", "RightArm", "LeftForeArm", "RightForeArm",
    "LeftHand", "RightHand", "LeftHandIndex1", "RightHandIndex1",
)  # fmt: skip
MIRROR = (0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10, 12, 14, 13, 15, 17, 16, 19, 18, 21, 20, 23, 22)
ANKLES, TOES = (7, 8), (10, 11)
JOINTS = len(CMU_NAMES)


def metres_per_unit(skeleton: Skeleton, unit: float | None = None) -> float:
    """Return the length of one unit of a skeleton in metres: `unit` if given, or CMU's unit.

    Raises TwistError if the unit is not given and cannot be CMU's, because the joint names are
    different or the height is impossible for a person.
    """
    if unit is not None:
        return unit
    height = CMU_UNIT * skeleton.height
    if set(CMU_NAMES) <= set(skeleton.names) and 1.0 < height < 2.5:
        return CMU_UNIT
    raise TwistError(
        "the unit of this skeleton is unknown; set the length of one unit in metres with --unit"
    )


def make_smpl_skeleton(offsets: Array) -> Skeleton:
    """Return a skeleton of the 24 joints with the given rest offsets, (24, 3)."""
    return Skeleton(SMPL_NAMES, np.array(PARENTS), np.asarray(offsets, dtype=np.float64))


@dataclass(frozen=True, eq=False)
class Topology:
    """The 24 SMPL joints within a skeleton that may have more joints.

    Attributes
    ----------
    joints
        The index of each of the 24 joints in the skeleton, shape (24,).
    folded
        For each of the 24 joints, the indices of the skeleton's joints between this joint and its
        parent among the 24, in order from the root. Their rotations are combined with the rotation
        of the joint.
    skeleton
        The skeleton.
    """

    joints: NDArray[np.int64]
    folded: tuple[tuple[int, ...], ...]
    skeleton: Skeleton

    @cached_property
    def offsets(self) -> Array:
        """The rest offsets of the 24 joints, in the unit of the skeleton, (24, 3)."""
        own = self.skeleton.offsets
        parts = [
            own[j] + own[list(f)].sum(axis=0) for j, f in zip(self.joints, self.folded, strict=True)
        ]
        return np.stack(parts)

    def reduced(self, rotations: Array) -> Array:
        """Return the local rotations of the 24 joints, (frames, joints, 4) → (frames, 24, 4)."""
        out = rotations[:, self.joints].copy()
        for k, above in enumerate(self.folded):
            for joint in reversed(above):
                out[:, k] = multiply(rotations[:, joint], out[:, k])
        return out

    def restored(self, reduced: Array, rotations: Array) -> Array:
        """Return the skeleton's rotations with new rotations of the 24 joints.

        This is the inverse of :meth:`reduced`. `reduced` contains the new rotations of the 24
        joints, (frames, 24, 4), and `rotations` the rotations of the skeleton, (frames, joints, 4).
        All other joints keep their rotations.
        """
        out = rotations.copy()
        for k, (joint, above) in enumerate(zip(self.joints, self.folded, strict=True)):
            q = reduced[:, k]
            for upper in above:
                q = multiply(conjugate(rotations[:, upper]), q)
            out[:, joint] = q
        return out


def find_network_joints(skeleton: Skeleton) -> Topology:
    """Find the 24 joints in a skeleton by their names in CMU's or SMPL's skeleton.

    Raises TwistError if a joint is missing or the hierarchy is different.
    """
    for names in (CMU_NAMES, SMPL_NAMES):
        if set(names) <= set(skeleton.names):
            return _topology(skeleton, names)
    missing = [name for name in CMU_NAMES if name not in skeleton.names]
    raise TwistError(
        f"expected the 24 joints of CMU or SMPL, but the skeleton lacks {missing[0]!r}"
        + (f" and {len(missing) - 1} more" if len(missing) > 1 else "")
    )


def _topology(skeleton: Skeleton, names: tuple[str, ...]) -> Topology:
    joints = [skeleton.index(name) for name in names]
    folded: list[tuple[int, ...]] = []
    for k, joint in enumerate(joints):
        target = joints[PARENTS[k]] if PARENTS[k] >= 0 else -1
        between: list[int] = []
        above = int(skeleton.parents[joint])
        while above not in (target, -1):
            between.append(above)
            above = int(skeleton.parents[above])
        if above != target or any(b in joints for b in between):
            raise TwistError(
                f"expected {names[k]!r} to be below "
                f"{names[PARENTS[k]] if target >= 0 else 'nothing'!r} in the skeleton, as "
                "in CMU's and SMPL's skeletons"
            )
        folded.append(tuple(reversed(between)))
    return Topology(np.array(joints), tuple(folded), skeleton)


def smpl_joint_positions(offsets: Array, q: Array, r: Array) -> Array:
    """Return the positions of the 24 joints in world space, (…, 24, 3).

    `offsets` contains the rest offsets, (24, 3), `q` the local rotations, (…, 24, 4), and `r` the
    root's positions, (…, 3). All lengths must have the same unit.
    """
    turned = np.empty(q.shape)
    out = np.empty((*q.shape[:-1], 3))
    for k, parent in enumerate(PARENTS):
        if parent < 0:
            turned[..., k, :], out[..., k, :] = q[..., k, :], r
            continue
        turned[..., k, :] = multiply(turned[..., parent, :], q[..., k, :])
        out[..., k, :] = out[..., parent, :] + rotate(turned[..., parent, :], offsets[k])
    return out
