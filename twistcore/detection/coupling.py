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
from dataclasses import dataclass
from itertools import product

import numpy as np

from twistcore.detection.cost import CAP, residual_cost
from twistcore.detection.increments import twist_increments
from twistcore.detection.prediction import Index
from twistcore.rotation import Array, conjugate, multiply, wrap

# Costs are negative log likelihoods. x of chain k and y of chain k−1 are one joint's motion: if
# both jump and no error explains it, that joint jumped by itself, once.
JOINT_JUMP = 16.0
CHAIN_ACTIVE = 6.0
# Two errors that begin in the same frame are rare, and two opposite ones in a straight limb leave
# the joint between them unturned: they look like two natural jumps. Tuned: rich false alarms.
ANOTHER_ACTIVE = 18.0
# A joint that jumps by itself lands anywhere, and the caps stand for how rare that is beside the
# usual residual. Where that is small, as at a hinge, a jump is rarer still: log(HINGE / σ) more.
# Measured on CMU: elbows of σ 0.005° were left 0.4° and 1.9° off for 14 nats.
HINGE = float(np.radians(0.3))
_SWEEPS = 4  # of Gauss-Seidel; three chains converge to < 0.01° in three


class _Image:
    """Twist angle of cos(φ/2)·plain + sin(φ/2)·turned as a function of φ."""

    def __init__(self, plain: Array, turned: Array, axis: Array) -> None:
        self._parts = np.stack(
            [
                plain[:, 0],
                np.einsum("ti,ti->t", plain[:, 1:], axis),
                turned[:, 0],
                np.einsum("ti,ti->t", turned[:, 1:], axis),
            ]
        )

    def __call__(self, angle: Array, at: Index) -> Array:
        w, v, tw, tv = self._parts[:, at]
        c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
        return wrap(2.0 * np.arctan2(c * v + s * tv, c * w + s * tw))


class Limbs:
    """Lines of n chains each: joint k the parent of chain k and joint k+1 its child.

    Limbs of equal length, such as both arms, are solved at once, their frames one after the other.
    joints: local rotations, n + 1 arrays (limbs, frames, 4); axes: n arrays (limbs, 3) or
    (limbs, frames, 3).
    """

    def __init__(self, joints: Sequence[Array], axes: Sequence[Array]) -> None:
        self.joints, self.axes = joints, axes
        self.count, self.frames = joints[0].shape[:2]

    def __len__(self) -> int:
        """Chains a limb."""
        return len(self.axes)

    def increments(self) -> Array:
        """x and y of all chains, (2, n·limbs, frames): chain k of limb i in row k·limbs + i."""
        out = np.empty((2, len(self), self.count, self.frames))
        for k, axes in enumerate(self.axes):
            for i, axis in enumerate(axes):
                pair = twist_increments(self.joints[k][i], self.joints[k + 1][i], axis)
                out[0, k, i], out[1, k, i] = pair
        return out.reshape(2, -1, self.frames)

    def _axis(self, k: int, t: Index) -> Array:
        axis = self.axes[k]
        return axis[t // self.frames] if axis.ndim == 2 else axis.reshape(-1, 3)[t]

    def images(self, t: Index) -> tuple[list[_Image], list[_Image]]:
        """Images of d_k in x of chain k+1, and of d_{k+1} in y of chain k.

        t: indices into (limbs · frames), never the first frame of a limb.
        """
        down, up = [], []
        for k in range(len(self) - 1):
            joint = self.joints[k + 1].reshape(-1, 4)
            q0, q1 = conjugate(joint[t - 1]), joint[t]
            above, below = self._axis(k, t), self._axis(k + 1, t)
            pure = np.zeros((2, len(t), 4))
            pure[0, :, 1:], pure[1, :, 1:] = above, below
            down.append(_Image(multiply(q0, q1), multiply(multiply(q0, pure[0]), q1), below))
            up.append(_Image(multiply(q1, q0), -multiply(multiply(q1, pure[1]), q0), above))
        return down, up


def explain_frames(limbs: Limbs, t: Index, signals: Array, predicted: Array, sigma: Array) -> Array:
    """Increments x, y at frames t without the images of the neighbours' errors, (2, n, len(t)).

    signals, predicted, sigma: (2, n, len(t)), radians.
    """
    n = len(limbs)
    down, up = limbs.images(t)
    weight = sigma[0] ** 2 / (sigma[0] ** 2 + sigma[1] ** 2)
    rarer = np.maximum(np.log(HINGE / sigma), 0.0)
    best = np.full(len(t), np.inf)
    clean = signals.copy()
    for active in sorted(product((False, True), repeat=n), key=sum):
        on = [k for k in range(n) if active[k]]
        cost = CHAIN_ACTIVE * len(on) + ANOTHER_ACTIVE * max(0, len(on) - 1)
        # Residuals cost ≥ 0: most frames are settled before two chains at once are tried.
        at = np.flatnonzero(best > cost)
        if not len(at):
            continue
        some = signals[..., at], predicted[..., at], sigma[..., at], weight[:, at], rarer[..., at]
        hypothesis = _Hypothesis(down, up, at, on, *some)
        for tip_first in (False, True) if len(on) > 1 else (False,):
            trial, total = hypothesis.solved(tip_first)
            total += cost
            better = total < best[at] - 1e-9
            best[at[better]] = total[better]
            clean[:, :, at[better]] = trial[:, :, better]
    return clean


@dataclass(frozen=True, eq=False)
class _Hypothesis:
    """The chains `on` have an error at the frames `at`, no other; arrays (2, n, len(at))."""

    down: list[_Image]
    up: list[_Image]
    at: Index
    on: Sequence[int]
    signals: Array
    predicted: Array
    sigma: Array
    weight: Array
    rarer: Array

    def solved(self, tip_first: bool) -> tuple[Array, Array]:
        """The increments without images, (2, n, len(at)), and what their residuals cost."""
        d = self._errors(tip_first)
        n = len(self.weight)
        trial = np.array([self._without_images(k, d) for k in range(n)]).transpose(1, 0, 2)
        residual = trial - self.predicted
        residual[0] -= d
        residual[1] += d
        cost_x, cost_y = residual_cost(wrap(residual) / self.sigma, CAP + self.rarer)
        total = cost_x[0] + cost_y[-1]
        most = JOINT_JUMP + np.minimum(self.rarer[0, 1:], self.rarer[1, :-1])
        return trial, total + np.minimum(cost_x[1:] + cost_y[:-1], most).sum(axis=0)

    def _without_images(self, k: int, d: Array) -> tuple[Array, Array]:
        x, y = self.signals
        return (
            self.down[k - 1](d[k - 1], self.at) if k - 1 in self.on else x[k],
            self.up[k](d[k + 1], self.at) if k + 1 in self.on else y[k],
        )

    def _errors(self, tip_first: bool) -> Array:
        """d (n, len(at)) of the active chains: the first sweep trusts the side without images."""
        d = np.zeros_like(self.weight)
        for sweep in range(_SWEEPS if len(self.on) > 1 else 1):
            for k in reversed(self.on) if tip_first else self.on:
                xk, yk = self._without_images(k, d)
                rx, ry = wrap(xk - self.predicted[0, k]), wrap(yk - self.predicted[1, k])
                if sweep == 0 and not tip_first and k + 1 in self.on:
                    d[k] = rx
                elif sweep == 0 and tip_first and k - 1 in self.on:
                    d[k] = -ry
                else:
                    d[k] = wrap(rx - wrap(rx + ry) * self.weight[k])
        return d
