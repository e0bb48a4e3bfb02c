"""The signals of a chain that show a twist error: rotations of both joints, azimuth and bend.

If the parent P of a chain has a twist error δ, P rotates by δ, the child C rotates by −δ, and
the azimuth of C's bone about P's bone changes by −δ. The combined rotation of P and C does not
change. All angles are in degrees.
"""

from __future__ import annotations

from dataclasses import field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.noise_bursts import rotation_vector_steps
from twistcore.skeleton.angles import wrap_degrees
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    cross_products,
    multiply,
    quaternion_from_axis_angle,
    rotate,
    vector_lengths,
)
from twistcore.skeleton.twist_increments import twist_increments
from twistcore.work.frozen import dataclass

Mask = NDArray[np.bool_]
_K = TypeVar("_K")
_V = TypeVar("_V")

PACE = 2  # number of frames on either side of an edge in which the pace is measured
ALONG = np.sin(np.radians(10.0))  # the azimuth of a straighter limb is meaningless


# The size of the cache of a chain: the number of values, and at least the number of arrays.
_KEPT, _FEWEST_KEPT = 1 << 18, 12


@dataclass(frozen=True, eq=False)
class ChainSignals:
    """The signals of one chain. Each signal is computed when it is first used.

    Attributes
    ----------
    q_parent, q_child
        Local rotations, shape (frames, 4).
    axis, arm
        Unit vectors along P's bone and C's bone, (3,) or (frames, 3).
    hinged
        True if C has a child, so that the azimuth is known.
    fps
        The frame rate.
    segment
        The segment of the chain, or '' if another piece of the same bone follows.
    noise
        The largest σ of a burst of noise in the joints of the person's chains, degrees, shape
        (frames,). 0 if there is no noise.
    """

    q_parent: Array
    q_child: Array
    axis: Array
    arm: Array
    hinged: bool
    fps: float
    segment: str
    noise: Array
    _series: dict[tuple[str, int], Array] = field(default_factory=dict)  # the latest few

    @classmethod
    def of(cls, motion: Motion, chain: Chain, noise: Array | None = None) -> ChainSignals:
        """Return the signals of a chain of a motion.

        `noise` contains the σ of noise in each frame; None means that there is no noise.
        """
        noise = np.zeros(motion.frames) if noise is None else noise
        q_parent, q_child = (motion.rotations[:, j] for j in (chain.parent, chain.child))
        hinged = chain.grandchild >= 0
        segment = chain.segment if chain.ends else ""  # pieces of a bone have no joint between them
        return cls(q_parent, q_child, chain.axis, chain.arm, hinged, motion.fps, segment, noise)

    def detached(self) -> ChainSignals:
        """Return the signals with copies of the rotations, so that the motion can be freed."""
        q_parent, q_child = self.q_parent.copy(), self.q_child.copy()
        return replace(self, q_parent=q_parent, q_child=q_child, _series={})

    @property
    def frames(self) -> int:
        """The number of frames."""
        return len(self.q_parent)

    @cached_property
    def _turns(self) -> tuple[Array, Array]:
        x, y = twist_increments(self.q_parent, self.q_child, self.axis)
        return np.degrees(x), np.degrees(y)

    @property
    def x(self) -> Array:
        """The twist of the parent P about its bone since the previous frame, degrees, (frames,)."""
        return self._turns[0]

    @property
    def y(self) -> Array:
        """The twist of the child C about P's bone since the previous frame, degrees, (frames,)."""
        return self._turns[1]

    @cached_property
    def _sides(self) -> tuple[Array, Array]:
        """The bend and the azimuth of the child's bone, in degrees, each (frames,)."""
        axis = np.atleast_2d(self.axis)  # (1, 3) if it is constant
        first = self.azimuth_zero - (axis @ self.azimuth_zero)[:, None] * axis
        first /= vector_lengths(first)[:, None]
        bone = rotate(self.q_child, np.broadcast_to(self.arm, (self.frames, 3)))
        parts = (axis, first, cross_products(axis, first))
        along, one, other = np.stack([(bone * d).sum(-1) for d in parts], -1).T
        bend = np.degrees(np.arctan2(np.hypot(one, other), along))
        return bend, np.degrees(np.arctan2(other, one))

    @property
    def azimuth_zero(self) -> Array:
        """The direction of azimuth 0 in frame 0, perpendicular to the parent's bone, (3,)."""
        axis = np.atleast_2d(self.axis)[0]
        across = cross_products(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        return across / np.linalg.norm(across)

    @property
    def bend(self) -> Array:
        """The angle between the parent's bone and the child's bone, in degrees, (frames,).

        The angle is 0 for a straight limb.
        """
        return self._sides[0]

    @property
    def azimuth(self) -> Array:
        """The azimuth θc of the child's bone about the parent's bone [Choi26 Eq. 6-7], (frames,).

        The azimuth is in degrees, in (−180, 180].
        """
        return self._sides[1]

    @cached_property
    def azimuth_turns(self) -> Array:
        """The change of the azimuth since the previous frame, in degrees, (frames,)."""
        return np.concatenate([[0.0], wrap_degrees(np.diff(self.azimuth))])

    @property
    def unrolled(self) -> Array:
        """The rotations of the child C without its roll about its own bone, (frames, 4).

        They rotate the parent's bone axis to the direction of C's bone.
        """
        axis = np.atleast_2d(self.axis)[0]
        bend = quaternion_from_axis_angle(
            cross_products(axis, self.azimuth_zero), np.radians(self.bend)
        )
        azimuth = quaternion_from_axis_angle(self.axis, np.radians(self.azimuth))
        return multiply(azimuth, bend)

    @cached_property
    def roll_turns(self) -> Array:
        """The roll of the child C about its own bone since the previous frame, degrees, (frames,).

        The parent's bone axis must be constant. :attr:`y` is the change of the azimuth plus this
        roll times the cosine of the bend.
        """
        rolled = multiply(conjugate(self.unrolled), self.q_child)
        return np.degrees(twist_increments(self.q_parent, rolled, self.axis)[1])

    @cached_property
    def sine(self) -> Array:
        """The sine of the bend, 0…1, (frames,). A larger sine defines the azimuth better."""
        return np.sin(np.radians(self.bend))

    @cached_property
    def both_frames(self) -> Array:
        """The smaller :attr:`sine` of each frame and the previous one, (frames,). 0 in frame 0."""
        return np.concatenate([[0.0], np.minimum(self.sine[1:], self.sine[:-1])])

    def together(self, low: int, high: int) -> Array:
        """Return the combined rotations of P and C since the previous frame, in [low, high).

        P is the parent and C the child. The results are rotation vectors in degrees, (high - low,
        3), and 0 in the first of these frames. A twist error does not change them.
        """
        return rotation_vector_steps(multiply(self.q_parent[low:high], self.q_child[low:high]))

    def beyond_pace(self, name: str, width: int) -> Array:
        """Return how much a signal changes in frames [t, t + width), compared with its usual pace.

        The result has a value in degrees for each t, (frames,). `name` is 'x', 'y', 'azimuth_turns'
        or 'roll_turns'. The usual pace is the mean change per frame in two frames on either side.
        The value is NaN if there are fewer frames.
        """
        if (name, width) not in self._series:
            turns, total = self._totals(name)
            out = np.full(len(turns), np.nan)
            first, count = PACE + 1, len(turns) - width - 2 * PACE - 1  # the frames t
            if count > 0:
                near = (first - 1, first - 2, first + width, first + width + 1)
                pace = turns[near[0] :][:count] + turns[near[1] :][:count]
                pace += turns[near[2] :][:count]
                pace += turns[near[3] :][:count]
                pace /= 2.0 * PACE
                pace *= width
                over = total[first + width :][:count] - total[first : first + count]
                over -= pace
                out[first : first + count] = wrap_degrees(over)
            evict_oldest_cache_entries(self._series, len(turns))[name, width] = out
        return self._series[name, width]

    def _totals(self, name: str) -> tuple[Array, Array]:
        """Return a signal and its sums over the frames before each frame, (frames + 1,)."""
        if (name, 0) not in self._series:
            total = np.concatenate([[0.0], np.cumsum(getattr(self, name))])
            evict_oldest_cache_entries(self._series, len(total))[name, 0] = total
        return getattr(self, name), self._series[name, 0]

    def bent(self, width: int) -> Mask:
        """Return a mask of the frames t in which an edge may begin with a bent limb, (frames,).

        The limb must be bent in frames t − 1 and t + width − 1, directly before an edge of `width`
        frames and at its end.
        """
        t = np.arange(self.frames)
        before = self.sine[np.maximum(t - 1, 0)]
        after = self.sine[np.minimum(t + width - 1, self.frames - 1)]
        return np.asarray(np.minimum(before, after) > ALONG)


def evict_oldest_cache_entries(
    made: dict[_K, _V], frames: int, fewest: int = _FEWEST_KEPT
) -> dict[_K, _V]:
    """Remove the oldest entries of a cache until there is room for one more, and return the cache.

    `frames` is the length of the arrays in the cache, and `fewest` is the number of arrays for
    which there is always room.
    """
    while len(made) >= max(fewest, _KEPT // max(frames, 1)):
        del made[next(iter(made))]
    return made
