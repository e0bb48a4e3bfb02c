"""The counter-rotation d(t) of every chain of a limb, with its scale [MATH.md §4.2-4.3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.detection.coupling import Limb, explain_frames
from twistcore.detection.increments import twist_increments
from twistcore.detection.prediction import (
    Mask,
    coarse_residual,
    gap_growth,
    good_neighbours,
    growth_at,
    half_window,
    local_scale,
    predict,
)
from twistcore.rotation import Array, wrap

SIGNIFICANT = 4.0  # |d| in σ: natural motion passes in ~1 % of the frames, before any pairing
AGREE_SHARE, AGREE_SIGMA = 0.4, 3.0  # |wrap(rx + ry)| that still counts as one and the same turn
LONE_JUMP, LONE_JUMP_COARSE = 6.0, 8.0  # a jump in one signal, in σ: no sample to predict from
COARSE_STEPS = (4, 4, 7, 7)  # frames; 7 sees ramps of 5 frames and edges close together, 4 the rest
ROUNDS = 6
RESOLVE = 4.0  # a jump in any signal of a limb, in σ, has all its chains solved together
STEADY_GAP = 4.0  # frames; residuals across wider gaps tell nothing of the local σ


@dataclass(frozen=True, eq=False)
class CounterRotation:
    """What is left of a limb's increments when natural motion is taken out; all (chains, frames).

    x, y: increments as captured; rx, ry: residuals, without images of the neighbours' errors;
    sigma_x, sigma_y: their scales; d: their common counter-rotation (inverse-variance weighted,
    circular), sigma: its scale; event: significant, and both signals agree; agree; lone: only one
    of the two jumps. Radians.
    """

    x: Array
    y: Array
    rx: Array
    ry: Array
    sigma_x: Array
    sigma_y: Array
    d: Array
    sigma: Array
    event: Mask
    agree: Mask
    lone: Mask


def counter_rotation(limb: Limb, fps: float, cut: Mask) -> CounterRotation:
    """Residuals of all chains of a limb; cut (frames,): increments across a cut, never used."""
    pairs = [
        twist_increments(limb.joints[k], limb.joints[k + 1], limb.axes[k]) for k in range(len(limb))
    ]
    captured = np.stack([[x for x, _ in pairs], [y for _, y in pairs]])
    live = np.broadcast_to(~cut, captured.shape[1:])
    signals, half = captured, half_window(fps)
    good = _coarsely_good(signals, live, half)
    cubic_fits = np.zeros((*signals.shape[:2], 1), dtype=bool)
    growth = np.ones((*signals.shape[:2], 4))
    for turn in range(ROUNDS):
        cubic, linear, gap = predict(signals, good_neighbours(good))
        if turn <= 1:
            cubic_fits = _fit(signals - cubic, good) < _fit(signals - linear, good)
            growth = np.where(
                cubic_fits,
                gap_growth(signals, good, cubic=True),
                gap_growth(signals, good, cubic=False),
            )
        predicted = np.where(cubic_fits, cubic, linear)
        sigma = local_scale(wrap(signals - predicted), good & (gap < STEADY_GAP), half)
        sigma *= growth_at(growth, gap)
        if turn >= 1 and len(limb) > 1:
            signals = _without_images(limb, captured, predicted, sigma, cut)
        residual = wrap(signals - predicted)
        d, disagreement, sigma_d, sigma_e = combine(residual, sigma)
        agree = np.abs(disagreement) <= AGREE_SHARE * np.abs(d) + AGREE_SIGMA * sigma_e
        event = (np.abs(d) > SIGNIFICANT * sigma_d) & agree & live
        lone = (np.abs(residual) > LONE_JUMP * sigma).any(axis=0) & live
        now = live & ~event & ~(lone & ~agree)
        settled = turn > 1 and bool((now == good).all())
        good = now
        if settled:
            break
    return CounterRotation(
        captured[0], captured[1], residual[0], residual[1], sigma[0], sigma[1],
        np.where(live, d, 0.0), sigma_d, event, agree, lone,
    )  # fmt: skip


def combine(residual: Array, sigma: Array) -> tuple[Array, Array, Array, Array]:
    """d, disagreement wrap(rx + ry), and the scales of both; from (2, …) residuals and scales.

    d is the inverse-variance mean of rx and −ry, on the circle: near ±180° both may read the same
    sign, and their mean must not be 0.
    """
    variance = sigma * sigma
    both = variance[0] + variance[1]
    disagreement = wrap(residual[0] + residual[1])
    d = wrap(residual[0] - disagreement * variance[0] / both)
    return d, disagreement, np.sqrt(variance[0] * variance[1] / both), np.sqrt(both)


def _coarsely_good(signals: Array, live: Mask, half: int) -> Mask:
    """Frames without a sign of a jump, before anything is known; rather too few than too many."""
    good = live.copy()
    for step in COARSE_STEPS:
        residual = coarse_residual(signals, step)
        sigma = local_scale(residual, good, half)
        d, disagreement, sigma_d, sigma_e = combine(residual, sigma)
        agree = np.abs(disagreement) <= AGREE_SHARE * np.abs(d) + AGREE_SIGMA * sigma_e
        lone = (np.abs(residual) > LONE_JUMP_COARSE * sigma).any(axis=0)
        good &= ~((np.abs(d) > SIGNIFICANT * sigma_d) & agree) & ~lone
    return good


def _fit(error: Array, good: Mask) -> Array:
    """Mean √|error| over the good frames, (2, chains, 1)."""
    return np.asarray((np.sqrt(np.abs(wrap(error))) * good).sum(-1, keepdims=True))


def _without_images(
    limb: Limb, captured: Array, predicted: Array, sigma: Array, cut: Mask
) -> Array:
    """The increments with the neighbours' errors undone wherever something jumps."""
    jumps = np.abs(wrap(captured - predicted)) > RESOLVE * sigma
    t = np.flatnonzero(jumps.any(axis=(0, 1)) & ~cut)
    if not len(t):
        return captured
    clean = captured.copy()
    clean[:, :, t] = explain_frames(limb, t, captured[:, :, t], predicted[:, :, t], sigma[:, :, t])
    return clean
