"""Fit the filters, regressions and oracles with which benchmarks.quamo_bounds compares QuaMo.

q̂ and r̂ are the noisy rotations and root positions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.linalg import solve_triangular

from twistcore.analysis.quality.figure import foot_contact_mask, positions_relative_to_root
from twistcore.formats.smpl.skeleton import ANKLES, TOES
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array, conjugate, exponential, logarithm, multiply
from twistcore.study.quamo.noise import SMOOTH_SECONDS, Noise
from twistcore.study.quamo.pose_errors import second_difference
from twistcore.study.quamo.sequences import Sequence24
from twistcore.study.quamo.tables import Method, noisy_clip

FIT_SEEDS = (100, 101)  # seeds of the noise used for fitting
PATH_TAPS, ROOT_TAPS = 20, 50  # numbers of past frames that filters use (0.8 s and 2 s)
ROUNDS, SMALLEST_MM, RIDGE = 4, 0.5, 1e-3


class LeaveOneOut:
    """Least squares fitted to the clips of other subjects.

    The normal equations are stored for each subject separately.
    """

    def __init__(self, ridge: float) -> None:
        self._ridge = ridge
        self._sums: dict[str, tuple[Array, Array]] = {}
        self._solved: dict[tuple[str, bool], Array] = {}

    def add(self, subject: str, x: Array, y: Array) -> None:
        """Add inputs `x` (…, rows, inputs) and targets `y` (…, rows, outputs) for a subject."""
        turned = np.swapaxes(x, -1, -2)
        before = self._sums.get(subject, (0.0, 0.0))
        self._sums[subject] = (before[0] + turned @ x, before[1] + turned @ y)

    def weights(self, subject: str, *, own: bool = False) -> Array:
        """Return weights, shape (…, inputs, outputs), fitted to all other subjects.

        If `own` is True, they are fitted only to this subject.
        """
        if (subject, own) not in self._solved:
            kept = [v for k, v in self._sums.items() if (k == subject) is own]
            xx, xy = sum(k[0] for k in kept), sum(k[1] for k in kept)
            size = np.trace(xx, axis1=-2, axis2=-1)[..., None, None] / xx.shape[-1]
            xx = xx + (self._ridge * size + 1e-12) * np.eye(xx.shape[-1])
            self._solved[subject, own] = np.linalg.solve(xx, xy)
        return self._solved[subject, own]


# -- positions: the best linear filter of each joint's own path --------------------------------


def own_path(places: Array) -> Array:
    """Return the path of the root, and the other joints' paths relative to it, (frames, 24, 3).

    `places` are positions of shape (frames, 24, 3).
    """
    return np.concatenate([places[:, :1], positions_relative_to_root(places)[:, 1:]], axis=1)


def neighbours(x: Array, ahead: int) -> Array:
    """Return earlier values and up to `ahead` later values of `x`, relative to `x`.

    `x` has the shape (frames, 24, 3), and the result has the shape (frames, 24, 3, taps).
    """
    at = np.arange(len(x))
    shifts = [k for k in range(-PATH_TAPS, ahead + 1) if k]
    near = [x[np.clip(at + k, 0, len(x) - 1)] - x for k in shifts]
    return np.stack(near, axis=-1)


class PathFilter:
    """The filter of a joint's path that minimises mean distance + weight · mean Accel.

    Each joint has one set of taps for all three axes. As in the metrics, the means are of norms and
    not of squares. They are minimised by iteratively reweighted least squares, with the inverse of
    the residual as the weight.
    """

    def __init__(self, clips: Sequence[Sequence24], noise: Noise, ahead: int) -> None:
        self._ahead = ahead
        rows = []
        for clip in clips:
            given = own_path(clip.places_mm(*noisy_clip(clip, noise, FIT_SEEDS[0])))
            left = own_path(clip.places_mm(clip.q, clip.r)) - given
            rows.append((neighbours(given, ahead), left))
        self._terms = [
            tuple(np.concatenate(side).astype(np.float32) for side in zip(*term, strict=True))
            for term in (rows, [tuple(map(second_difference, row)) for row in rows])
        ]
        self._subjects = [
            np.repeat([c.subject for c in clips], [len(c.q) - cut for c in clips]) for cut in (0, 2)
        ]

    def taps(self, held_out: str, weight: float) -> Array:
        """Return the filter taps, shape (24, taps), fitted to all subjects except `held_out`.

        `weight` is the weight of Accel.
        """
        taps: Array | None = None
        for _ in range(ROUNDS):
            xx: Array | float = 0.0
            xy: Array | float = 0.0
            for (x, y), subjects, share in zip(
                self._terms, self._subjects, (1.0, weight), strict=True
            ):
                # The first weights come from the input's own error.
                left = y if taps is None else y - np.einsum("fjat,jt->fja", x, taps)
                away = np.maximum(np.linalg.norm(left, axis=-1), SMALLEST_MM)
                w = share * (subjects != held_out)[:, None] / away
                weighted = (x * w[..., None, None]).transpose(1, 3, 0, 2)
                weighted = weighted.reshape(*weighted.shape[:2], -1)
                xx = xx + weighted @ x.transpose(1, 0, 2, 3).reshape(24, -1, x.shape[-1])
                xy = xy + weighted @ y.transpose(1, 0, 2).reshape(24, -1, 1)
            taps = np.linalg.solve(xx + RIDGE * np.eye(x.shape[-1]), xy)[..., 0]
        assert taps is not None
        return taps

    def filtered(self, places: Array, taps: Array) -> Array:
        """Return noisy positions, (frames, 24, 3), after filtering."""
        path = own_path(places)
        path = path + np.einsum("fjat,jt->fja", neighbours(path, self._ahead), taps)
        return np.concatenate([path[:, :1], path[:, :1] + path[:, 1:]], axis=1)


# -- the root: the best linear filter of r̂, alone and with steps of the feet -------------------

Steps = Callable[[Sequence24, Array, Array], Array]  # clip, q̂, r̂ -> the root's path (frames, 3)


def history(x: Array) -> Array:
    """Return the past values of `x` (frames, 3), relative to `x`, with shape (3, frames, taps)."""
    frames = len(x)
    near = [np.maximum(np.arange(frames) - k, 0) for k in range(1, ROOT_TAPS + 1)]
    return np.moveaxis(np.stack([x[at] - x for at in near], axis=-1), 1, 0)


def root_filter(clips: Sequence[Sequence24], noise: Noise, steps: Steps | None = None) -> Method:
    """Return a method that filters r̂ along each axis.

    `steps` is a function that returns the root's path according to the feet. With it, the filter
    also uses r̂ minus this path.
    """
    fit = LeaveOneOut(1e-4)

    def inputs(clip: Sequence24, q_hat: Array, r_hat: Array) -> Array:
        known = [history(r_hat)]
        if steps is not None:
            known.append(history(r_hat - steps(clip, q_hat, r_hat)))
        return np.concatenate(known, axis=-1)

    for clip in clips:
        for seed in FIT_SEEDS:
            q_hat, r_hat = noisy_clip(clip, noise, seed)
            fit.add(clip.subject, inputs(clip, q_hat, r_hat), (clip.r - r_hat).T[..., None])

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        taps = fit.weights(clip.subject)
        found = r_hat.copy()
        for k in range(r_hat.shape[1]):
            found[:, k] += (inputs(clip, q_hat[:, k], r_hat[:, k]) @ taps)[..., 0].T
        return q_hat, found

    return run


def foot_steps(true_pose: bool, true_contact: bool) -> Steps:
    """Return a function that computes the root's path if a foot on the ground stays fixed.

    In the air, the steps of r̂ are used. Without true contacts, the lower foot is assumed to be on
    the ground, and so is the other foot if it is at most 3 cm higher. `true_pose` and
    `true_contact` are True to use the true pose and the true contacts.
    """

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> Array:
        q = clip.q if true_pose else q_hat
        places = clip.places_mm(q, np.zeros_like(clip.r))
        feet = 0.5 * (places[:, ANKLES] + places[:, TOES])
        if true_contact:
            down = foot_contact_mask(clip.places_mm(clip.q, clip.r))
        else:
            down = feet[..., 1] < feet[..., 1].min(axis=1, keepdims=True) + 30.0
        both = (down[1:] & down[:-1])[..., None]
        count = both.sum(axis=1)
        by_feet = -(np.diff(feet, axis=0) * both).sum(axis=1) / np.maximum(count, 1) / 1000.0
        step = np.where(count > 0, by_feet, np.diff(r_hat, axis=0))
        return np.concatenate([np.zeros((1, 3)), np.cumsum(step, axis=0)])

    return run


def known_way(noise: Noise) -> Method:
    """Return an oracle that knows all steps of the root and the noise's covariance K.

    Only the start of the path is unknown. It is estimated as the generalised mean of r̂ − path up
    to the current frame. With K = LLᵀ, the leading blocks of L⁻¹ are the inverse factors of the
    leading blocks of K, so one factorisation serves all frames.
    """

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        times = NETWORK_DT * np.arange(len(clip.r))
        apart = (times[:, None] - times) / (2.0 * SMOOTH_SECONDS)
        smooth, white = np.mean(noise.level.root_smooth), noise.level.root_white
        low = np.linalg.cholesky(smooth**2 * np.exp(-(apart**2)) + white**2 * np.eye(len(times)))
        away = r_hat - clip.r[:, None]
        ones = solve_triangular(low, np.ones(len(times)), lower=True)[:, None, None]
        given = solve_triangular(low, away.reshape(len(away), -1), lower=True).reshape(away.shape)
        return q_hat, clip.r[:, None] + np.cumsum(ones * given, 0) / np.cumsum(ones**2, 0)

    return run


# -- poses: knowledge of poses without motion --------------------------------------------------


def without_offset(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
    """Subtract each joint's mean error over the clip, which only an oracle knows."""
    error = logarithm(multiply(clip.q[:, None], conjugate(q_hat)))
    return multiply(exponential(error.mean(axis=0)), q_hat), r_hat


def shrunk(clips: Sequence[Sequence24], noise: Noise, width: float) -> Method:
    """Return a method that moves each joint towards the mean of other subjects.

    The prior covariance is `width` times the covariance of the other subjects.
    """

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        seen = np.concatenate([logarithm(c.q[:, 1:]) for c in clips if c.subject != clip.subject])
        mean = seen.mean(axis=0)
        spread = width * np.einsum("fja,fjb->jab", seen - mean, seen - mean) / len(seen)
        share = spread @ np.linalg.inv(spread + np.radians(noise.level.smooth) ** 2 * np.eye(3))
        out = q_hat.copy()
        off = logarithm(q_hat[..., 1:, :]) - mean
        out[..., 1:, :] = exponential(mean + np.einsum("jab,...jb->...ja", share, off))
        return out, r_hat

    return run


def pose_regression(
    clips: Sequence[Sequence24], noise: Noise, ridge: float, *, own: bool = False
) -> Method:
    """Return a method that predicts each joint's error by linear regression on the noisy pose.

    If `own` is True, the regression is fitted to the subject's own clips. `ridge` is the
    regularisation.
    """
    fit = LeaveOneOut(ridge)

    def inputs(q_hat: Array) -> Array:
        pose = logarithm(q_hat[..., 1:, :]).reshape(*q_hat.shape[:-2], -1)
        return np.concatenate([pose, np.ones((*pose.shape[:-1], 1))], axis=-1)

    for clip in clips:
        for seed in FIT_SEEDS:
            q_hat, _ = noisy_clip(clip, noise, seed)
            error = logarithm(multiply(clip.q, conjugate(q_hat)))[:, 1:]
            fit.add(clip.subject, inputs(q_hat), error.reshape(len(error), -1))

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        step = np.zeros((*q_hat.shape[:-1], 3))
        step[..., 1:, :] = (inputs(q_hat) @ fit.weights(clip.subject, own=own)).reshape(
            *q_hat.shape[:-2], -1, 3
        )
        return multiply(exponential(step), q_hat), r_hat

    return run
