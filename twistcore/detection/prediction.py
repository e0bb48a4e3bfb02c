"""Predict natural motion from good neighbouring frames, and estimate its scale [Method, step 2].

The signals are the twist increments x and y of the parents and children of all chains, stacked as
(2, chains, frames). A frame is *good* for a chain if nothing jumps in it. Each frame is predicted
from nearby good frames, without the frame itself. Most frames have two good neighbours on either
side, so their predictions are computed only once. All other frames, called *irregular*, are
predicted again in every round. They are given by flat indices into (chains, frames).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.notation import Keys
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

Mask = NDArray[np.bool_]
Index = NDArray[np.int64]

# The smallest σ, from the rounding of BVH text. It keeps σ above 0 for joints that do not twist.
FLOOR = float(np.radians(0.005))
ROUNDED = 0.76  # σ of an increment's residual due to rounding, in rounding steps of the angles
# Half of the window for σ, in seconds and at least in frames: the pace changes within about 0.3 s.
WINDOW_SECONDS, WINDOW_FRAMES = 0.15, 12
_DISTANCES = (1, 2, 3, 5)  # frames to the nearer neighbour for which the growth of σ is measured
_GAPS = np.log(np.array([2.0 * k - 1.0 for k in _DISTANCES]))


def residual_sigma_half_window_frames(fps: float) -> int:
    """Return half the length of the window in which the local scale is measured, in frames."""
    return max(WINDOW_FRAMES, round(WINDOW_SECONDS * fps))


def residual_from_coarse_median(signals: Array, step: int) -> Array:
    """Return the signals minus the median of 5 samples, `step` frames apart, in radians.

    This is the first estimate of the residual, before the jumps are known. A short interval or a
    ramp does not affect the median.
    """
    n = signals.shape[-1]
    padded = np.pad(signals, ((0, 0), (0, 0), (2 * step, 2 * step)), mode="edge")
    # The median of a…e is the median of e, max(min(a, b), min(c, d)) and min(max(a, b), max(c, d)).
    # If e is the middle sample, a and b are neighbours, and so are c and d. Each minimum and each
    # maximum of two neighbours is therefore computed once and used twice.
    low = np.minimum(padded[..., :-step], padded[..., step:])
    high = np.maximum(padded[..., :-step], padded[..., step:])
    f = np.maximum(low[..., :n], low[..., 3 * step : 3 * step + n])
    g = np.minimum(high[..., :n], high[..., 3 * step : 3 * step + n])
    low_, high_ = np.minimum(f, g), np.maximum(f, g)
    median = np.maximum(low_, np.minimum(high_, signals))
    return wrap(signals - median)


def _box_sum(values: Array | Mask, half: int) -> Array:
    """Return the sum over frames t − half … t + half for each frame t along the last axis.

    At both ends, the sums include fewer frames.
    """
    n = values.shape[-1]
    kind = np.int32 if values.dtype == bool else values.dtype  # whole numbers are added faster
    total = np.empty((*values.shape[:-1], n + 2 * half + 1), dtype=kind)
    total[..., : half + 1] = 0
    np.cumsum(values, axis=-1, out=total[..., half + 1 : half + 1 + n])
    total[..., half + 1 + n :] = total[..., half + n : half + n + 1]
    sums: Array = total[..., 2 * half + 1 :] - total[..., :n]
    return sums


def local_sigma_of_increment_residuals(
    root: Array, good: Mask, half: int, least: float = FLOOR
) -> Array:
    """Return the local scale σ = 1.48·(mean √|r|)² of residuals r in each frame, in radians.

    The mean is over the good frames nearby. A few jumps have little effect on a mean of square
    roots. The factor 1.48 makes σ the standard deviation of a normal distribution. If there are few
    good frames nearby, a window four times as wide is used as well. If even that window contains
    too few, the whole clip is used.

    Parameters
    ----------
    root
        √|r|, the square roots of the absolute residuals, shape (2, chains, frames).
    good
        Mask of the good frames, shape (chains, frames).
    half
        Half the length of the window, in frames.
    least
        The smallest σ, in radians.
    """
    root = root * good.astype(np.float64)
    many, mean = _box_sum(good, half), _box_sum(root, half)
    if many.min() < 0.5 * half:
        overall = root.sum(-1, keepdims=True) / np.maximum(good.sum(-1, keepdims=True), 1)
        wide = (_box_sum(root, 4 * half) + 2.0 * overall) / (_box_sum(good, 4 * half) + 2.0)
        lacking = np.maximum(0.5 * half - many, 0.0)
        mean += lacking * wide
        many = many + lacking
    mean /= many
    mean *= mean
    mean *= 1.48
    return np.maximum(mean, least, out=mean)


def smallest_increment_residual_sigma(step: float) -> float:
    """Return the smallest σ of an increment's residual, in radians.

    `step` is the rounding step of the angles in the file.
    """
    return max(FLOOR, ROUNDED * step)


def predict_increments_between_linear_keys(signals: Array, good: Mask, keys: Keys) -> Array:
    """Predict the increments between two linear keys by their median.

    `signals` and the result are in radians and have the shape (2, chains, frames). `good` is the
    mask of the frames to use, shape (chains, frames). If there are no good frames between two keys,
    all frames between them are used.
    """
    frames, n = signals.shape[-1], keys.spacing
    before = (-keys.first - 1) % n  # the first piece began before the clip did
    behind = -(before + frames) % n
    pad = (*[(0, 0)] * (signals.ndim - 1), (before, behind))
    told = np.where(good, signals, np.nan)
    pieces, every = (
        np.pad(v, pad, constant_values=np.nan).reshape(*signals.shape[:-1], -1, n)
        for v in (told, signals)
    )
    none = ~np.isfinite(pieces).any(axis=-1, keepdims=True)
    pieces = np.sort(np.where(none, every, pieces), axis=-1)  # NaN last
    last = np.maximum(np.isfinite(pieces).sum(axis=-1, keepdims=True) - 1, 0)
    low, high = (np.take_along_axis(pieces, k, axis=-1) for k in (last // 2, (last + 1) // 2))
    median = np.broadcast_to(np.nan_to_num(0.5 * (low + high)), pieces.shape)
    flat: Array = median.reshape(*signals.shape[:-1], -1)[..., before : before + frames]
    return flat


@dataclass(frozen=True, eq=False)
class Irregular:
    """The irregular frames, and the good frames from which they are predicted.

    Attributes
    ----------
    at
        Flat indices of the frames, shape (n,).
    near
        The signals in the two good frames before and the two after each frame, shape (2, 4, n).
    cubic, linear
        The weights of these four good frames for cubic and for linear prediction, shape (4, n).
    gap
        The number of frames between the nearest good frames, shape (n,). It is 1 if both direct
        neighbours are good.
    """

    at: Index
    near: Array
    cubic: Array
    linear: Array
    gap: Array

    def predicted(self, weights: Array) -> Array:
        """Return the predictions in radians, (2, n), as the weighted sums of `near`.

        `weights` has the shape (4, n), or (2, 4, n) if x and y have different weights.
        """
        weights = np.broadcast_to(weights, self.near.shape)
        return np.asarray(np.einsum("skn,skn->sn", self.near, weights))


class Predictor:
    """A predictor of signals, (2, chains, frames), from neighbouring frames.

    The attributes `cubic` and `linear` contain the predictions of each frame from its two
    neighbours on either side, regardless of whether the neighbours are good.
    """

    def __init__(self, signals: Array) -> None:
        self.signals = signals
        self.cubic, self.linear = np.zeros_like(signals), np.zeros_like(signals)
        if signals.shape[-1] >= 5:
            near = signals[..., 1:-3] + signals[..., 3:-1]
            far = signals[..., :-4] + signals[..., 4:]
            self.linear[..., 2:-2] = 0.5 * near
            self.cubic[..., 2:-2] = (2.0 / 3.0) * near - far / 6.0

    @cached_property
    def cubic_root(self) -> Array:
        """The square roots of the absolute prediction errors of `cubic`, (2, chains, frames)."""
        return np.sqrt(np.abs(wrap(self.signals - self.cubic)))

    @cached_property
    def linear_root(self) -> Array:
        """The square roots of the absolute prediction errors of `linear`, (2, chains, frames)."""
        return np.sqrt(np.abs(wrap(self.signals - self.linear)))

    def irregular(self, good: Mask, changed: Mask, signals: Array) -> Irregular:
        """Return the irregular frames, with the weights for their prediction.

        A frame is irregular if the frame itself or one of the two frames on either side is not good
        or has changed. The first two and the last two frames are always irregular. The cubic
        weights belong to the Lagrange polynomial through the two good frames on either side. At the
        start and the end of the clip, the mean of the nearest two good frames is used.

        Parameters
        ----------
        good
            Mask of the good frames, shape (chains, frames).
        changed
            Mask of the frames whose signals have changed, shape (chains, frames).
        signals
            The changed signals, shape (2, chains, frames).
        """
        frames = good.shape[1]
        seed = ~good | changed
        near = seed.copy()
        for k in (1, 2):
            near[:, k:] |= seed[:, :-k]
            near[:, :-k] |= seed[:, k:]
        near[:, :2] = True
        near[:, -2:] = True
        at = np.flatnonzero(near)
        return _irregular(signals.reshape(2, -1), good.ravel(), at, frames)


def _irregular(flat: Array, good: Mask, at: Index, frames: int) -> Irregular:
    """Return the irregular frames at the given flat indices, with the nearest good frames.

    Parameters
    ----------
    flat
        The signals, shape (2, chains · frames).
    good
        Mask of the good frames, shape (chains · frames,).
    at
        The flat indices of the irregular frames.
    frames
        The number of frames in the clip.
    """
    none = np.array([-1, -1])
    known = np.concatenate([none, np.flatnonzero(good), none])
    # Rank of the first good frame at or after `at`.
    rank = np.cumsum(good, dtype=np.int32)[at] - good[at] + 2
    behind = rank + good[at]
    k = np.stack([known[rank - 2], known[rank - 1], known[behind], known[behind + 1]])
    first = at - at % frames
    has_b2, has_b = k[:2] >= first
    has_a, has_a2 = (k[2:] >= 0) & (k[2:] < first + frames)
    b2, b, a, a2 = np.abs(k - at).astype(np.float64)
    inside, whole = has_b & has_a, has_b2 & has_a2
    linear = np.zeros((4, len(at)))
    linear[1] = np.where(inside, a / (a + b), has_b)
    linear[2] = np.where(has_a, 1.0 - linear[1], 0.0)
    for far, near, alone in ((0, 1, has_b2 & ~has_a), (3, 2, has_a2 & ~has_b)):
        linear[near, alone] = linear[far, alone] = 0.5
    u = b[whole], b2[whole], a[whole], a2[whole]
    cubic = linear.copy()
    cubic[:, whole] = _lagrange(*u)
    gap = np.where(inside, a + b - 1.0, np.where(has_b, 2.0 * b, np.where(has_a, 2.0 * a, frames)))
    return Irregular(at, flat[:, k], cubic, linear, gap)


def _lagrange(b: Array, b2: Array, a: Array, a2: Array) -> Array:
    """Return the Lagrange weights, (4, n), of samples at −b2, −b, a and a2 for the value at 0."""
    p, q = b * a, b2 * a2
    return np.stack(
        [
            -(p * a2) / ((b2 - b) * (b2 + a) * (b2 + a2)),
            (q * a) / ((b2 - b) * (b + a) * (b + a2)),
            (q * b) / ((b2 + a) * (b + a) * (a2 - a)),
            -(p * b2) / ((b2 + a2) * (b + a2) * (a2 - a)),
        ]
    )


class GapGrowth:
    """The growth of the prediction error σ with the length of the gap: 1, 3, 5 or 9 frames.

    A gap is a run of frames that the prediction does not use. The growth is measured in the clip
    itself, by predicting the middle frame of gaps of these lengths.
    """

    def __init__(self, signals: Array, cubic: Mask) -> None:
        """Measure the prediction errors for each gap length.

        `signals` has the shape (2, chains, frames). `cubic` has the shape (2, chains, 1) and is
        True for cubic and False for linear prediction.
        """
        self._shape, frames = signals.shape[:2], signals.shape[-1]
        self._roots = []
        for k in _DISTANCES:
            if frames <= 2 * k + 12:
                break
            near = signals[..., 1 : frames - 2 * k - 1] + signals[..., 2 * k + 1 : frames - 1]
            far = signals[..., : frames - 2 * k - 2] + signals[..., 2 * k + 2 :]
            inner = np.where(cubic, 0.5 * (k + 1) ** 2 / (2 * k + 1), 0.5)
            near *= inner
            far *= inner - 0.5
            near -= signals[..., k + 1 : frames - k - 1]
            near -= far
            np.abs(near, out=near)
            self._roots.append(np.sqrt(near, out=near))

    def measured(self, good: Mask) -> Array:
        """Return σ for each gap length divided by σ for a gap of 1, at least 1, (2, chains, 4).

        `good` is the mask of the good frames, (chains, frames). Only these frames are used.
        """
        frames = good.shape[1]
        out: list[Array] = []
        for n, k in enumerate(_DISTANCES):
            if n >= len(self._roots):
                out.append(2.0 * out[-1] if out else np.ones(self._shape))
                continue
            usable = good[:, k + 1 : frames - k - 1] & good[:, 1 : frames - 2 * k - 1]
            usable &= good[:, 2 * k + 1 : frames - 1]
            many = np.maximum(usable.sum(-1), 1)
            root = np.einsum("scf,cf->sc", self._roots[n], usable.astype(np.float64)) / many
            out.append(root * root + 0.3 * FLOOR)
        growth = np.stack(out, axis=-1)
        return np.asarray(np.maximum.accumulate(growth / growth[..., :1], axis=-1))


def interpolate_sigma_growth_over_gaps(growth: Array, chain: Index, gap: Array) -> Array:
    """Return the factors by which σ grows for the given gap lengths, (2, n).

    Values between the measured gap lengths are interpolated on a log-log scale.

    Parameters
    ----------
    growth
        The result of :meth:`GapGrowth.measured`.
    chain
        The index of the chain of each gap, shape (n,).
    gap
        The gap lengths in frames, shape (n,).
    """
    level = np.log(growth)
    slope = np.diff(level, axis=-1) / np.diff(_GAPS)
    x = np.log(gap)
    piece = np.clip(np.searchsorted(_GAPS, x, side="right") - 1, 0, 2)
    return np.asarray(np.exp(level[:, chain, piece] + slope[:, chain, piece] * (x - _GAPS[piece])))
