"""Compute the counter-rotation: opposite rotations of parent and child [Method, steps 2-3]."""

from __future__ import annotations

import numpy as np

from twistcore.detection.counter_twist.coupling import remove_neighbour_errors
from twistcore.detection.limbs import Limbs
from twistcore.detection.prediction import (
    GapGrowth,
    Index,
    Mask,
    Predictor,
    interpolate_sigma_growth_over_gaps,
    local_sigma_of_increment_residuals,
    predict_increments_between_linear_keys,
    residual_from_coarse_median,
    residual_sigma_half_window_frames,
    smallest_increment_residual_sigma,
)
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress

SIGNIFICANT = 4.0  # minimum |d| in σ; natural motion exceeds it in about 1 % of the frames
# The residuals rx and ry show the same rotation if |wrap(rx + ry)| is at most this share of |d|
# plus this multiple of the σ of rx + ry.
AGREE_SHARE, AGREE_SIGMA = 0.4, 3.0
LONE_JUMP, LONE_JUMP_COARSE = 6.0, 8.0  # in σ; a frame with such a jump of one signal is not good
# The limit for |d| in the first round. It is better to exclude too many frames there: a clean
# frame is used again in the next round, but a ramp that is mistaken for motion increases σ until no
# frame next to it is significant. On half of the CMU clips, the change from 4 to 3 raised the
# success rate from 90.1 to 97.5 % for ramps of 4 frames at 30 Hz, and from 82.2 to 88.3 % for
# protocols with several errors at 60 Hz.
SIGNIFICANT_COARSE = 3.0
# Distances between samples for the median, in frames, by round: 7 for ramps of 5 frames and edges
# that are close together, 4 for all others.
COARSE_STEPS = (4, 4, 7, 7)
ROUNDS = 6  # maximum number of rounds
RESOLVE = 4.0  # in σ; in frames with such a jump, the chains of a limb are solved together
SAME = 1e-9  # σ; smaller differences are ignored
# The minimum σ between linear keys, as a share of the pace there. If channels change evenly, a
# joint rotates unevenly, especially if it rotates far.
UNEVEN = 0.15
STEADY_GAP = 4.0  # frames; residuals across longer gaps do not show the local σ


@dataclass(frozen=True, eq=False)
class CounterRotation:
    """The part of the twist increments of chains that natural motion does not explain.

    All arrays have the shape (chains, frames), and angles are in radians.

    Attributes
    ----------
    x, y
        The captured twist increments of the parent and the child of each chain.
    rx, ry
        The residuals of x and y: the captured minus the predicted increments, without the effects
        of errors in neighbouring chains.
    sigma_x, sigma_y
        The scales of the residuals.
    d
        The counter-rotation: the circular mean of rx and −ry, weighted by inverse variance.
    sigma
        The scale of d.
    event
        True where d is significant and both residuals agree.
    lone
        True where one residual is very large, whether or not the other agrees.
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


def counter_rotation(
    limbs: Limbs, fps: float, cut: Mask, tell: Tell | None = None
) -> CounterRotation:
    """Return the counter-rotation of all chains of limbs.

    `cut` is the mask of the increments that cross a cut and are not used, shape (frames,). `tell`
    is called with the progress before each round.
    """
    tell = tell or ignore_progress
    captured = limbs.increments()
    live = np.broadcast_to(~cut, captured.shape[1:])
    half = residual_sigma_half_window_frames(fps)
    good = _coarsely_good(captured, live, half, limbs)
    rounds = _Rounds(captured, limbs, cut, half)
    moving = np.ones(len(good), dtype=bool)  # chains of limbs that have not converged
    for turn in range(ROUNDS):
        tell(turn / ROUNDS)
        increments = rounds.next(good, turn)
        new = *increments, *_jumps(*increments)
        if moving.all():
            residual, sigma, event, lone, denied = new
        else:
            for kept, value in zip((residual, sigma, event, lone, denied), new, strict=True):
                kept[..., moving, :] = value[..., moving, :]
        now = live & ~event & ~(lone & denied)
        if turn > 1:
            same = (now == good).reshape(len(limbs), limbs.count, -1).all(axis=(0, 2))
            moving &= np.tile(~same, len(limbs))
        good = now
        if not moving.any():
            break
    event, lone = event & live, lone & live
    d, _, sigma_d, _ = combine_counter_rotation_residuals(residual, sigma)
    return CounterRotation(
        captured[0], captured[1], residual[0], residual[1], sigma[0], sigma[1],
        np.where(live, d, 0.0), sigma_d, event, lone,
    )  # fmt: skip


class _Rounds:
    """The rounds of an iteration, each of which uses the good frames of the previous round.

    Good frames show natural motion: they are not part of a cut or of a possible error. In each
    round, the increments are predicted, the scales are measured, and the effects of errors on
    neighbouring chains are removed.
    """

    def __init__(self, captured: Array, limbs: Limbs, cut: Mask, half: int) -> None:
        self._captured, self._limbs, self._half = captured, limbs, half
        self._live = np.tile(~cut, limbs.count)  # (limbs · frames,)
        self._least = smallest_increment_residual_sigma(limbs.step)
        self._predictor = Predictor(captured)
        self._signals = captured
        self._changed = np.zeros(captured.shape[1:], dtype=bool)
        self._t = np.zeros(0, dtype=np.int64)  # frames solved in the previous round
        self._then: list[Array] = []  # their predictions and scales
        self._clean = captured  # their solutions
        self._gaps: GapGrowth | None = None
        self._cubic_fits = np.zeros((*captured.shape[:2], 1), dtype=bool)

    def next(self, good: Mask, turn: int) -> tuple[Array, Array]:
        """Return the residuals and scales of the next round, both (2, chains, frames).

        `good` is the mask of the good frames, (chains, frames), and `turn` is the number of the
        round.
        """
        if self._limbs.keys is not None:
            return self._between_keys(good, turn)
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
        sigma = local_sigma_of_increment_residuals(root, steady, self._half, self._least)
        wide = p.gap > 1.0
        at = p.at[wide]
        sigma.reshape(flat)[:, at] *= interpolate_sigma_growth_over_gaps(
            self._growth, chain[wide], p.gap[wide]
        )
        return self._without_images(predicted, sigma, turn)

    def _between_keys(self, good: Mask, turn: int) -> tuple[Array, Array]:
        """Return the residuals and scales in a clip with linear keys, both (2, chains, frames).

        The predictions assume that the pace of natural motion is constant between two keys.
        """
        assert self._limbs.keys is not None
        keys = self._limbs.keys
        predicted = predict_increments_between_linear_keys(self._signals, good, keys)
        root = np.sqrt(np.abs(wrap(self._signals - predicted)))
        sigma = local_sigma_of_increment_residuals(root, good, self._half, self._least)
        sigma = np.maximum(sigma, UNEVEN * np.abs(predicted))
        return self._without_images(predicted, sigma, turn)

    def _without_images(self, predicted: Array, sigma: Array, turn: int) -> tuple[Array, Array]:
        """Return the residuals of predictions, and their scales, both (2, chains, frames).

        From the second round on, the effects of errors in neighbouring chains are removed.
        """
        residual = wrap(self._captured - predicted)
        if turn >= 1 and len(self._limbs) > 1:
            self._undo_images(residual, predicted, sigma)
        return residual, sigma

    def _choose(self, good: Mask, at: Index, root_cubic: Array, root_linear: Array) -> None:
        """Choose cubic or linear prediction for each signal by the errors of both in good frames.

        `root_cubic` and `root_linear` are the square roots of the absolute errors in the irregular
        frames, which have the flat indices `at`.
        """
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
        """Remove the effects of errors in neighbouring chains from `residual`, in place.

        Only frames with a jump are examined. The solution of a frame is reused if its predictions
        and scales have not changed since the previous round.
        """
        flat = 2, len(self._limbs), -1
        jumps = (np.abs(residual) > RESOLVE * sigma).reshape(2 * len(self._limbs), -1)
        t = np.flatnonzero(np.logical_or.reduce(jumps) & self._live)
        here = [v.reshape(flat)[..., t] for v in (self._captured, predicted, sigma)]
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
            clean[..., new] = remove_neighbour_errors(
                self._limbs, t[new], *(v[..., new] for v in here)
            )
        self._t, self._then, self._clean = t, here[1:], clean
        self._signals = self._captured.copy()
        self._signals.reshape(flat)[..., t] = clean
        self._changed[:] = False
        self._changed.reshape(flat[1:])[:, t] = (clean != here[0]).any(axis=0)
        residual.reshape(flat)[..., t] = wrap(clean - here[1])


def _jumps(
    residual: Array, sigma: Array, significant: float = SIGNIFICANT, lone_jump: float = LONE_JUMP
) -> tuple[Mask, Mask, Mask]:
    """Return masks of the events, the lone jumps, and the frames with residuals that disagree.

    `residual` and `sigma` have the shape (2, chains, frames), and the masks have the shape (chains,
    frames). `significant` and `lone_jump` are the limits of events and lone jumps in σ.
    """
    # Examine only frames with a large norm of (rx/σx, ry/σy), which is at least |d|/σ because of
    # the Cauchy-Schwarz inequality. Above 1.5 radians, this does not hold, because d wraps.
    z = residual / sigma
    z *= z
    may = z[0] + z[1] > 0.99 * significant**2
    for r in residual:
        may |= r > 1.5
        may |= r < -1.5
    at = np.flatnonzero(may)
    event, lone, denied = (np.zeros(may.size, dtype=bool) for _ in range(3))
    some = residual.reshape(2, -1)[:, at]
    sigmas = sigma.reshape(2, -1)[:, at]
    d, disagreement, sigma_d, sigma_e = combine_counter_rotation_residuals(some, sigmas)
    denied[at] = np.abs(disagreement) > AGREE_SHARE * np.abs(d) + AGREE_SIGMA * sigma_e
    event[at] = (np.abs(d) > significant * sigma_d) & ~denied[at]
    lone[at] = (np.abs(some) > lone_jump * sigmas).any(axis=0)
    return event.reshape(may.shape), lone.reshape(may.shape), denied.reshape(may.shape)


def combine_counter_rotation_residuals(
    residual: Array, sigma: Array
) -> tuple[Array, Array, Array, Array]:
    """Combine the residuals rx and ry, (2, …), with their scales `sigma`, (2, …).

    Returns the counter-rotation d, the disagreement wrap(rx + ry), and the scales of both, each
    (…). d is the circular mean of rx and −ry, weighted by inverse variance. Near ±180°, both
    residuals may have the same sign, and the mean must not become 0.
    """
    variance = sigma * sigma
    both = variance[0] + variance[1]
    disagreement = wrap(residual[0] + residual[1])
    d = wrap(residual[0] - disagreement * variance[0] / both)
    return d, disagreement, np.sqrt(variance[0] * variance[1] / both), np.sqrt(both)


def _coarsely_good(signals: Array, live: Mask, half: int, limbs: Limbs) -> Mask:
    """Return the initial mask of the good frames, (chains, frames), which excludes doubtful frames.

    `signals` contains the captured increments, (2, chains, frames), `live` is the mask of the
    frames to use, and `half` is half the window for the local scale, in frames.
    """
    good = live.copy()
    residual = root = signals
    known = 0
    for step in COARSE_STEPS:
        if step != known:
            if limbs.keys is None:
                residual = residual_from_coarse_median(signals, step)
            else:
                residual = wrap(
                    signals - predict_increments_between_linear_keys(signals, good, limbs.keys)
                )
            root = np.sqrt(np.abs(residual))
            known = step
        sigma = local_sigma_of_increment_residuals(
            root, good, half, smallest_increment_residual_sigma(limbs.step)
        )
        event, lone, _ = _jumps(residual, sigma, SIGNIFICANT_COARSE, LONE_JUMP_COARSE)
        good &= ~event & ~lone
    return good
