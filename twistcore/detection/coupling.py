"""Chains that share a joint, solved together, frame by frame [MATH.md §4.5].

An error of chain k turns the joint that is also the parent of chain k+1, and the one that is also
the child of chain k−1: it shows as an *image* in x of k+1 and in y of k−1. The image depends on
the pose, but not on the level of the error, so an increment φ is undone at its frame, exactly:

    x of k+1:  q(t−1)⁻¹ R_a(φ) q(t)  = cos(φ/2) q(t−1)⁻¹ q(t) + sin(φ/2) q(t−1)⁻¹ a q(t)
    y of k−1:  q(t) R_a(−φ) q(t−1)⁻¹ = cos(φ/2) q(t) q(t−1)⁻¹ − sin(φ/2) q(t) a q(t−1)⁻¹

At every frame where something jumps, the set of chains is sought whose errors explain it cheapest.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cost import residual_cost
from twistcore.rotation import Array, conjugate, multiply, wrap

# Costs are negative log likelihoods. x of chain k and y of chain k−1 are one joint's motion: if
# both jump and no error explains it, that joint jumped by itself, once.
JOINT_JUMP = 16.0
CHAIN_ACTIVE = 6.0
# Two errors that begin in the same frame are rare, and two opposite ones in a straight limb leave
# the joint between them unturned: they look like two natural jumps. Tuned: rich false alarms.
ANOTHER_ACTIVE = 18.0
_SWEEPS = 4  # of Gauss-Seidel; three chains converge to < 0.01° in three


class _Image:
    """Twist angle of cos(φ/2)·plain + sin(φ/2)·turned as a function of φ."""

    def __init__(self, plain: Array, turned: Array, axis: Array) -> None:
        self._w, self._v = plain[:, 0], np.sum(plain[:, 1:] * axis, axis=-1)
        self._tw, self._tv = turned[:, 0], np.sum(turned[:, 1:] * axis, axis=-1)

    def __call__(self, angle: Array) -> Array:
        c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
        return wrap(2.0 * np.arctan2(c * self._v + s * self._tv, c * self._w + s * self._tw))


class Limb:
    """A line of chains, joint k the parent of chain k and joint k+1 its child.

    joints: local rotations, n + 1 arrays (frames, 4); axes: n arrays (3,) or (frames, 3).
    """

    def __init__(self, joints: Sequence[Array], axes: Sequence[Array]) -> None:
        self.joints, self.axes = joints, axes

    def __len__(self) -> int:
        return len(self.axes)

    def _axis(self, k: int, t: NDArray[np.int64]) -> Array:
        axis = self.axes[k]
        return np.broadcast_to(axis, (len(t), 3)) if axis.ndim == 1 else axis[t]

    def images(self, t: NDArray[np.int64]) -> tuple[list[_Image], list[_Image]]:
        """Images of d_k in x of chain k+1, and of d_{k+1} in y of chain k, at frames t ≥ 1."""
        down, up = [], []
        for k in range(len(self) - 1):
            q0, q1 = conjugate(self.joints[k + 1][t - 1]), self.joints[k + 1][t]
            above, below = self._axis(k, t), self._axis(k + 1, t)
            pure = np.zeros((2, len(t), 4))
            pure[0, :, 1:], pure[1, :, 1:] = above, below
            down.append(_Image(multiply(q0, q1), multiply(multiply(q0, pure[0]), q1), below))
            up.append(_Image(multiply(q1, q0), -multiply(multiply(q1, pure[1]), q0), above))
        return down, up


def explain_frames(
    limb: Limb, t: NDArray[np.int64], signals: Array, predicted: Array, sigma: Array
) -> Array:
    """Increments x, y at frames t without the images of the neighbours' errors, (2, n, len(t)).

    signals, predicted, sigma: (2, n, len(t)), radians.
    """
    n = len(limb)
    down, up = limb.images(t)
    x, y = signals
    weight = sigma[0] ** 2 / (sigma[0] ** 2 + sigma[1] ** 2)
    best = np.full(len(t), np.inf)
    clean = signals.copy()

    def without_images(k: int, d: Array, on: Sequence[int]) -> tuple[Array, Array]:
        return (
            down[k - 1](d[k - 1]) if k - 1 in on else x[k],
            up[k](d[k + 1]) if k + 1 in on else y[k],
        )

    def solve(on: Sequence[int], tip_first: bool) -> Array:
        """d (n, len(t)) of the active chains: the first sweep trusts the side without images."""
        d = np.zeros((n, len(t)))
        for sweep in range(_SWEEPS if len(on) > 1 else 1):
            for k in reversed(on) if tip_first else on:
                xk, yk = without_images(k, d, on)
                rx, ry = wrap(xk - predicted[0, k]), wrap(yk - predicted[1, k])
                if sweep == 0 and not tip_first and k + 1 in on:
                    d[k] = rx
                elif sweep == 0 and tip_first and k - 1 in on:
                    d[k] = -ry
                else:
                    d[k] = wrap(rx - wrap(rx + ry) * weight[k])
        return d

    for active in product((False, True), repeat=n):
        on = [k for k in range(n) if active[k]]
        for tip_first in (False, True) if len(on) > 1 else (False,):
            d = solve(on, tip_first)
            trial = np.array([without_images(k, d, on) for k in range(n)]).transpose(1, 0, 2)
            cost_x = residual_cost(wrap(trial[0] - predicted[0] - d) / sigma[0])
            cost_y = residual_cost(wrap(trial[1] - predicted[1] + d) / sigma[1])
            cost = CHAIN_ACTIVE * len(on) + ANOTHER_ACTIVE * max(0, len(on) - 1)
            total = cost + cost_x[0] + cost_y[-1]
            total = total + np.minimum(cost_x[1:] + cost_y[:-1], JOINT_JUMP).sum(axis=0)
            better = total < best - 1e-9
            best[better] = total[better]
            clean[:, :, better] = trial[:, :, better]
    return clean
