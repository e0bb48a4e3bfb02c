"""What a chain shows of a twist: the turns of both joints, and the side to which C's bone leaves.

A twist δ of P that C takes back turns P by δ, C by −δ, and the azimuth of C's bone about P's by −δ;
the turn of P and C together stays. All angles in degrees.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.noise_bursts import turns_of
from twistcore.detection.twist_increments import twist_increments
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    multiply,
    quaternion_from_axis_angle,
    rotate,
)
from twistcore.work.frozen import dataclass

Mask = NDArray[np.bool_]
_K = TypeVar("_K")
_V = TypeVar("_V")

PACE = 2  # frames on either side that tell the pace at an edge
ALONG = np.sin(np.radians(10.0))  # of a limb straighter than so the azimuth says nothing


_KEPT, _FEWEST_KEPT = 1 << 18, 12  # numbers in the series of a chain, or so many series


@dataclass(frozen=True, eq=False)
class Witnesses:
    """The signals of one chain, made when first asked for; see :meth:`of`.

    q_parent, q_child: local rotations, (frames, 4); axis, arm: unit, (3,) or (frames, 3);
    hinged: whether C has a child, whose place tells the azimuth; segment: of the chain, or
    '' before a further piece of the bone; noise: σ of a burst of it in any joint that matters,
    (frames,).
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
    def of(cls, motion: Motion, chain: Chain, noise: Array | None = None) -> Witnesses:
        """Those of a chain of a motion; noise: none where it is not given."""
        noise = np.zeros(motion.frames) if noise is None else noise
        q_parent, q_child = (motion.rotations[:, j] for j in (chain.parent, chain.child))
        hinged = chain.grandchild >= 0
        segment = chain.segment if chain.ends else ""  # between two pieces there is no joint
        return cls(q_parent, q_child, chain.axis, chain.arm, hinged, motion.fps, segment, noise)

    @property
    def frames(self) -> int:
        """How many there are."""
        return len(self.q_parent)

    @cached_property
    def _turns(self) -> tuple[Array, Array]:
        x, y = twist_increments(self.q_parent, self.q_child, self.axis)
        return np.degrees(x), np.degrees(y)

    @property
    def x(self) -> Array:
        """Turns of P about its bone from the frame before, (frames,)."""
        return self._turns[0]

    @property
    def y(self) -> Array:
        """Turns of C about P's bone, likewise."""
        return self._turns[1]

    @cached_property
    def _sides(self) -> tuple[Array, Array]:
        """The bend and the azimuth of C's bone, from its parts along P's bone and across it."""
        axis = np.broadcast_to(self.axis, (self.frames, 3))
        first = self.azimuth_zero - (axis @ self.azimuth_zero)[:, None] * axis
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        bone = rotate(self.q_child, np.broadcast_to(self.arm, (self.frames, 3)))
        parts = (axis, first, np.cross(axis, first))
        along, one, other = np.stack([(bone * d).sum(-1) for d in parts], -1).T
        bend = np.degrees(np.arctan2(np.hypot(one, other), along))
        return bend, np.degrees(np.arctan2(other, one))

    @property
    def azimuth_zero(self) -> Array:
        """The direction across P's bone, in the first frame, whose azimuth is 0, (3,)."""
        axis = np.atleast_2d(self.axis)[0]
        across: Array = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        return across / np.linalg.norm(across)

    @property
    def bend(self) -> Array:
        """Angle between P's bone and C's, 0 where the limb is straight, (frames,)."""
        return self._sides[0]

    @property
    def azimuth(self) -> Array:
        """θc [Choi26 Eq. 6-7]: the side to which C's bone leaves P's, (−180, 180], (frames,)."""
        return self._sides[1]

    @cached_property
    def azimuth_turns(self) -> Array:
        """Changes of the azimuth from the frame before, (frames,)."""
        return np.concatenate([[0.0], wrapped(np.diff(self.azimuth))])

    @property
    def unrolled(self) -> Array:
        """Rotations that turn P's axis to where C's bone is, without any roll, (frames, 4)."""
        axis = np.atleast_2d(self.axis)[0]
        bend = quaternion_from_axis_angle(np.cross(axis, self.azimuth_zero), np.radians(self.bend))
        azimuth = quaternion_from_axis_angle(self.axis, np.radians(self.azimuth))
        return multiply(azimuth, bend)

    @cached_property
    def roll_turns(self) -> Array:
        """Turns of C about its own bone from the frame before, (frames,); of a constant axis.

        y is the azimuth's turn and, by the cosine of the bend, that of the roll.
        """
        rolled = multiply(conjugate(self.unrolled), self.q_child)
        return np.degrees(twist_increments(self.q_parent, rolled, self.axis)[1])

    @cached_property
    def sine(self) -> Array:
        """Sine of the bend: how well the azimuth is known, 0…1, (frames,)."""
        return np.sin(np.radians(self.bend))

    @cached_property
    def both_frames(self) -> Array:
        """The smaller sine of a frame and the one before, (frames,); 0 for the first."""
        return np.concatenate([[0.0], np.minimum(self.sine[1:], self.sine[:-1])])

    def together(self, low: int, high: int) -> Array:
        """Turns of P and C together in frames [low, high), the first one's 0: vectors, (n, 3).

        No twist error changes them.
        """
        return turns_of(multiply(self.q_parent[low:high], self.q_child[low:high]))

    def beyond_pace(self, name: str, width: int) -> Array:
        """By how much a signal turns in [t, t + width) beyond the pace beside it, (frames,); NaN.

        name: x, y, azimuth_turns or roll_turns; the pace is that of two frames on either side, NaN
        where these are not there.
        """
        if (name, width) not in self._series:
            turns: Array = getattr(self, name)
            total = np.concatenate([[0.0], np.cumsum(turns)])
            t = np.arange(PACE + 1, len(turns) - width - PACE)
            beside = [t - 1, t - 2, t + width, t + width + 1]
            pace = sum(turns[k] for k in beside) / (2.0 * PACE)
            out = np.full(len(turns), np.nan)
            out[t] = wrapped(total[t + width] - total[t] - width * pace)
            keep_few(self._series, len(turns))[name, width] = out
        return self._series[name, width]

    def bent(self, width: int) -> Mask:
        """Where the limb is bent before turns [t, t + width) and after them, (frames,)."""
        t = np.arange(self.frames)
        before = self.sine[np.maximum(t - 1, 0)]
        after = self.sine[np.minimum(t + width - 1, self.frames - 1)]
        return np.asarray(np.minimum(before, after) > ALONG)


def keep_few(made: dict[_K, _V], frames: int) -> dict[_K, _V]:
    """The dictionary with room for one more series of so many frames: the oldest ones go."""
    while len(made) >= max(_FEWEST_KEPT, _KEPT // max(frames, 1)):
        del made[next(iter(made))]
    return made


def wrapped(degrees: Array) -> Array:
    """Angles in [−180, 180)."""
    return np.asarray((np.asarray(degrees) + 180.0) % 360.0 - 180.0)
