"""Limbs as sequences of chains that share joints, and the effect of errors on adjacent chains.

See [Method, step 4].

The twist increments of a chain are x for its parent and y for its child. An error of chain k
rotates the parent of chain k+1 and the child of chain k−1, so it has an *image* in x of chain k+1
and in y of chain k−1. The image depends on the pose and on the increment φ of the error in the same
frame, but not on earlier increments. It can therefore be removed exactly, frame by frame:

    x of k+1:  q(t−1)⁻¹ R_a(φ) q(t)  = cos(φ/2) q(t−1)⁻¹ q(t) + sin(φ/2) q(t−1)⁻¹ a q(t)
    y of k−1:  q(t) R_a(−φ) q(t−1)⁻¹ = cos(φ/2) q(t) q(t−1)⁻¹ − sin(φ/2) q(t) a q(t−1)⁻¹
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.prediction import Index
from twistcore.skeleton.notation import Keys
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    wrap,
)
from twistcore.skeleton.twist_increments import twist_increments


class Image:
    """The twist angle of the quaternion cos(φ/2)·plain + sin(φ/2)·turned as a function of φ.

    The object is an array of such functions. An element that has not been set returns 0.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._parts = np.zeros((4, *shape))
        self._parts[0] = 1.0

    def set(self, at: Index, plain: Array, turned: Array, axis: Array) -> None:
        """Set the quaternions, (n, 4), and twist axes, (n, 3), of the elements at flat indices."""
        parts = self._parts.reshape(4, -1)
        for row, q in ((0, plain), (2, turned)):
            parts[row, at] = q[:, 0]
            parts[row + 1, at] = np.einsum("ti,ti->t", q[:, 1:], axis)

    def __call__(self, angle: Array, row: int | slice = slice(None)) -> Array:
        """Return the twist angles of the given row or of all rows, in radians.

        `angle` contains φ, in radians, and has the same shape as the result.
        """
        w, v, tw, tv = self._parts[:, row]
        c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
        return wrap(2.0 * np.arctan2(c * v + s * tv, c * w + s * tw))


class Limbs:
    """Limbs of n chains each. Joint k is the parent and joint k+1 the child of chain k.

    Limbs with the same number of chains, such as both arms, are analysed together.

    Parameters
    ----------
    joints
        Local rotations, shape (n + 1, limbs, frames, 4).
    axes
        The bone axis of each chain, (n, limbs, 3) or (n, limbs, frames, 3).
    step
        The rounding step of the angles in the file, radians; 0 if it is negligible.
    keys
        The linear keys of the clip, or None. Between two keys, motion has a constant pace.
    """

    def __init__(
        self, joints: Array, axes: Array, step: float = 0.0, keys: Keys | None = None
    ) -> None:
        self.joints, self.axes, self.step, self.keys = joints, axes, step, keys
        self.count, self.frames = joints.shape[1:3]

    def __len__(self) -> int:
        """The number of chains in a limb."""
        return len(self.axes)

    def increments(self) -> Array:
        """Return the twist increments x and y of all chains, in radians, (2, n·limbs, frames).

        Chain k of limb i is in row k·limbs + i.
        """
        out = np.empty((2, len(self), self.count, self.frames))
        for k, axes in enumerate(self.axes):
            for i, axis in enumerate(axes):
                pair = twist_increments(self.joints[k, i], self.joints[k + 1, i], axis)
                out[0, k, i], out[1, k, i] = pair
        return out.reshape(2, -1, self.frames)

    def turned(self, turns: Sequence[tuple[int, int, Array]]) -> Limbs:
        """Return a copy in which the children of some chains are rotated about their chains' axes.

        Each item of `turns` is (row of the chain, first frame, angles in radians). The axis is in
        the coordinates of the chain's parent.
        """
        joints = self.joints.copy()
        for row, start, angle in turns:
            k, i = divmod(row, self.count)
            at = slice(start, start + len(angle))
            axis = self.axes[k, i] if self.axes.ndim == 3 else self.axes[k, i, at]
            turn = quaternion_from_axis_angle(axis, angle)
            joints[k + 1, i, at] = normalise(multiply(turn, joints[k + 1, i, at]))
        return self.with_joints(joints)

    def only(self, limb: int) -> Limbs:
        """Return a copy that contains only the limb with the given index."""
        at = slice(limb, limb + 1)
        return Limbs(self.joints[:, at], self.axes[:, at], self.step, self.keys)

    def with_joints(self, joints: Array) -> Limbs:
        """Return a copy with different local rotations, which have the shape of :attr:`joints`."""
        return Limbs(joints, self.axes, self.step, self.keys)

    def images(self, first: Index, length: int, t: Index) -> tuple[Image, Image]:
        """Return the effects (images) of errors in runs of `length` chains on adjacent chains.

        Row s of the first image is the effect of an error of chain first + s on x of the next
        chain. Row s of the second image is its effect on y of the previous chain. If there is no
        next or previous chain, the image is 0.

        Parameters
        ----------
        first
            The index of the first chain of each run, shape (runs,).
        length
            The number of chains in each run.
        t
            The frame of each run as a flat index into (limbs, frames), shape (runs,). Frame 0 of a
            limb is not allowed, because it has no increment.
        """
        down, up = Image((length, len(t))), Image((length, len(t)))
        chain = (first + np.arange(length)[:, None]).ravel()
        t = np.tile(t, length)
        at = np.flatnonzero(chain + 1 < len(self))
        q0, q1, here, near = self._shared_joint(chain[at], 1, t[at])
        down.set(at, multiply(q0, q1), multiply(multiply(q0, here), q1), near)
        at = np.flatnonzero(chain > 0)
        q0, q1, here, near = self._shared_joint(chain[at], -1, t[at])
        up.set(at, multiply(q1, q0), -multiply(multiply(q1, here), q0), near)
        return down, up

    def _shared_joint(self, chain: Index, side: int, t: Index) -> tuple[Array, Array, Array, Array]:
        """Return q(t−1)⁻¹ and q(t) of the joint that two chains share, and the axes of the chains.

        `side` is 1 if `chain` shares the joint with the next chain, and −1 for the previous chain.
        The axis of `chain` is returned as a quaternion, and the axis of the other chain as a
        vector.
        """
        joints = self.joints.reshape(len(self.joints), -1, 4)
        joint = chain + (side > 0)
        own = np.zeros((len(t), 4))
        own[:, 1:] = self._axis(chain, t)
        return conjugate(joints[joint, t - 1]), joints[joint, t], own, self._axis(chain + side, t)

    def _axis(self, chain: Index, t: Index) -> Array:
        if self.axes.ndim == 3:
            return np.asarray(self.axes[chain, t // self.frames])
        return np.asarray(self.axes.reshape(len(self), -1, 3)[chain, t])
