"""The counter-rotation d(t) of every chain of a limb, with its scale [MATH.md §4.2-4.3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.detection.coupling import Limb, explain_frames
from twistcore.detection.increments import twist_increments
from twistcore.detection.prediction import (
    GapGrowth,
    Index,
    Mask,
    Predictor,
    coarse_residual,
    growth_at,
    half_window,
    local_scale,
)
from twistcore.rotation import Array, wrap

SIGNIFICANT = 4.0  # |d| in σ: natural motion passes in ~1 % of the frames, before any pairing
AGREE_SHARE, AGREE_SIGMA = 0.4, 3.0  # |wrap(rx + ry)| that still counts as one and the same turn
LONE_JUMP, LONE_JUMP_COARSE = 6.0, 8.0  # a jump in one signal, in σ: no sample to predict from
COARSE_STEPS = (4, 4, 7, 7)  # frames; 7 sees ramps of 5 frames and edges close together, 4 the rest
ROUNDS = 6
RESOLVE = 4.0  # a jump in any signal of a limb, in σ, has all its chains solved together
SAME = 1e-9  # σ; a difference that no decision turns on
STEADY_GAP = 4.0  # frames; residuals across wider gaps tell nothing of the local σ


@dataclass(frozen=True, eq=False)
class CounterRotation:
    """What is left of a limb's increments when natural motion is taken out; all (chains, frames).

    x, y: increments as captured; rx, ry: residuals, without images of the neighbours' errors;
    sigma_x, sigma_y: their scales; d: their common counter-rotation (inverse-variance weighted,
    circular), sigma: its scale; event: significant, and both signals agree; lone: one of them jumps,
    whether the other agrees or not. Radians.
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
    lone: Mask


def counter_rotation(limb: Limb, fps: float, cut: Mask) -> CounterRotation:
    """Residuals of all chains of a limb; cut (frames,): increments across a cut, never used."""
    pairs = [
        twist_increments(limb.joints[k], limb.joints[k + 1], limb.axes[k]) for k in range(len(limb))
    ]
    captured = np.stack([[x for x, _ in pairs], [y for _, y in pairs]])
    live = np.broadcast_to(~cut, captured.shape[1:])
    half = half_window(fps)
    good = _coarsely_good(captured, live, half)
    rounds = _Rounds(captured, limb, cut, half)
    for turn in range(ROUNDS):
        residual, sigma = rounds.next(good, turn)
        event, lone, denied = _jumps(residual, sigma)
        event &= live
        lone &= live
        now = live & ~event & ~(lone & denied)
        settled = turn > 1 and bool((now == good).all())
        good = now
        if settled:
            break
    d, _, sigma_d, _ = combine(residual, sigma)
    return CounterRotation(
        captured[0], captured[1], residual[0], residual[1], sigma[0], sigma[1],
        np.where(live, d, 0.0), sigma_d, event, lone,
    )  # fmt: skip


class _Rounds:
    """Rounds of prediction, scale and joint solution, each from the last one's good frames."""

    def __init__(self, captured: Array, limb: Limb, cut: Mask, half: int) -> None:
        self._captured, self._limb, self._cut, self._half = captured, limb, cut, half
        self._predictor = Predictor(captured)
        self._signals = captured
        self._changed = np.zeros(captured.shape[1:], dtype=bool)
        self._t = np.zeros(0, dtype=np.int64)  # frames solved in the round before
        self._gaps: GapGrowth | None = None
        self._cubic_fits = np.zeros((*captured.shape[:2], 1), dtype=bool)

    def next(self, good: Mask, turn: int) -> tuple[Array, Array]:
        """Residuals and their scales, (2, chains, frames)."""
        captured, flat = self._captured, (2, -1)
        frames = captured.shape[-1]
        p = self._predictor.irregular(good, self._changed, self._signals)
        chain = p.at // frames
        at_signals = self._signals.reshape(flat)[:, p.at]
        if turn <= 1:
            roots = [
                np.sqrt(np.abs(wrap(at_signals - p.predicted(w)))) for w in (p.cubic, p.linear)
            ]
            self._choose(good, p.at, *roots)
        fits = self._cubic_fits[:, chain, 0]
        at_predicted = p.predicted(np.where(fits[:, None], p.cubic, p.linear))
        predicted, root = self._predicted.copy(), self._root.copy()
        predicted.reshape(flat)[:, p.at] = at_predicted
        root.reshape(flat)[:, p.at] = np.sqrt(np.abs(wrap(at_signals - at_predicted)))
        steady = good.copy()
        steady.ravel()[p.at] &= p.gap < STEADY_GAP
        sigma = local_scale(root, steady, self._half)
        wide = p.gap > 1.0
        at = p.at[wide]
        sigma.reshape(flat)[:, at] *= growth_at(self._growth, chain[wide], p.gap[wide])
        residual = wrap(captured - predicted)
        if turn >= 1 and len(self._limb) > 1:
            self._undo_images(residual, predicted, sigma)
        return residual, sigma

    def _choose(self, good: Mask, at: Index, root_cubic: Array, root_linear: Array) -> None:
        """Cubic or linear, whichever fits a signal better over its good frames."""
        weight = good.astype(np.float64)
        fits = []
        for root, at_root in (
            (self._predictor.cubic_root, root_cubic),
            (self._predictor.linear_root, root_linear),
        ):
            root = root.copy()
            root.reshape(2, -1)[:, at] = at_root
            fits.append(np.einsum("scf,cf->sc", root, weight)[..., None])
        cubic_fits = fits[0] < fits[1]
        if self._gaps is None or (cubic_fits != self._cubic_fits).any():
            self._cubic_fits = cubic_fits
            p = self._predictor
            self._predicted = np.where(cubic_fits, p.cubic, p.linear)
            self._root = np.where(cubic_fits, p.cubic_root, p.linear_root)
            self._gaps = GapGrowth(self._captured, cubic_fits)
        self._growth = self._gaps.measured(good)

    def _undo_images(self, residual: Array, predicted: Array, sigma: Array) -> None:
        """Undo the neighbours' errors wherever something jumps: new signals; residual in place.

        A frame whose prediction and scale are those of the round before keeps its solution.
        """
        jumps = np.abs(residual) > RESOLVE * sigma
        t = np.flatnonzero(jumps.any(axis=(0, 1)) & ~self._cut)
        here = self._captured[:, :, t], predicted[:, :, t], sigma[:, :, t]
        clean = here[0].copy()
        at = np.minimum(np.searchsorted(self._t, t), len(self._t) - 1)
        if len(self._t):
            same = self._t[at] == t
            for now, then in zip(here[1:], self._then, strict=True):
                same &= (np.abs(now - then[..., at]) <= SAME * here[2]).all(axis=(0, 1))
            clean[..., same] = self._clean[..., at[same]]
            new = np.flatnonzero(~same)
        else:
            new = np.arange(len(t))
        if len(new):
            clean[..., new] = explain_frames(self._limb, t[new], *(v[..., new] for v in here))
        self._t, self._then, self._clean = t, here[1:], clean
        self._signals = self._captured.copy()
        self._signals[:, :, t] = clean
        self._changed[:] = False
        self._changed[:, t] = (clean != here[0]).any(axis=0)
        residual[:, :, t] = wrap(clean - here[1])


def _jumps(residual: Array, sigma: Array, lone_jump: float = LONE_JUMP) -> tuple[Mask, Mask, Mask]:
    """Events, frames where either signal jumps, and frames where the two disagree; (chains, frames).

    Only where |(rx/σx, ry/σy)| ≥ |d|/σ (Cauchy-Schwarz) is large can there be either.
    """
    z = residual / sigma
    z *= z
    may = z[0] + z[1] > 0.99 * SIGNIFICANT**2
    may |= (np.abs(residual) > 1.5).any(axis=0)  # radians; beyond, d is wrapped
    at = np.flatnonzero(may)
    event, lone, denied = (np.zeros(may.size, dtype=bool) for _ in range(3))
    some = residual.reshape(2, -1)[:, at]
    sigmas = sigma.reshape(2, -1)[:, at]
    d, disagreement, sigma_d, sigma_e = combine(some, sigmas)
    denied[at] = np.abs(disagreement) > AGREE_SHARE * np.abs(d) + AGREE_SIGMA * sigma_e
    event[at] = (np.abs(d) > SIGNIFICANT * sigma_d) & ~denied[at]
    lone[at] = (np.abs(some) > lone_jump * sigmas).any(axis=0)
    return event.reshape(may.shape), lone.reshape(may.shape), denied.reshape(may.shape)


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
    residual = root = signals
    known = 0
    for step in COARSE_STEPS:
        if step != known:
            residual = coarse_residual(signals, step)
            root = np.sqrt(np.abs(residual))
            known = step
        event, lone, _ = _jumps(residual, local_scale(root, good, half), LONE_JUMP_COARSE)
        good &= ~event & ~lone
    return good
