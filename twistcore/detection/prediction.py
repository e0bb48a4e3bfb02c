"""Natural motion predicted from good neighbours, and how well [MATH.md §4.2].

Signals are stacked (2, chains, frames): x and y. A frame is *good* for a chain where nothing
jumps; predictions look at good frames only, and never at the frame they predict. Most frames have
two good neighbours on either side: their predictions never change and are made once; the rest, the
*irregular* ones, are made anew each round, as flat indices into (chains, frames).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.rotation import Array, wrap

Mask = NDArray[np.bool_]
Index = NDArray[np.int64]

FLOOR = float(np.radians(0.005))  # rounding of BVH text; keeps σ > 0 where a joint does not twist
WINDOW_SECONDS, WINDOW_FRAMES = 0.15, 12  # half window of σ: motion changes its pace within ~0.3 s
_DISTANCES = (1, 2, 3, 5)  # to the nearer neighbour, where the growth of σ is measured
_GAPS = np.log(np.array([2.0 * k - 1.0 for k in _DISTANCES]))


def half_window(fps: float) -> int:
    """Half the window of the local scale, frames."""
    return max(WINDOW_FRAMES, round(WINDOW_SECONDS * fps))


def coarse_residual(signals: Array, step: int) -> Array:
    """Signals less the median of 5 samples `step` frames apart, radians.

    Before anything is known about jumps: a short interval or a ramp is outvoted.
    """
    n = signals.shape[-1]
    padded = np.pad(signals, ((0, 0), (0, 0), (2 * step, 2 * step)), mode="edge")
    # The median of a, b, c, d, e is that of e, max(min(a, b), min(c, d)), min(max(a, b), max(c, d));
    # with e in the middle both pairs are neighbours, so each minimum serves twice.
    low = np.minimum(padded[..., :-step], padded[..., step:])
    high = np.maximum(padded[..., :-step], padded[..., step:])
    f = np.maximum(low[..., :n], low[..., 3 * step : 3 * step + n])
    g = np.minimum(high[..., :n], high[..., 3 * step : 3 * step + n])
    low_, high_ = np.minimum(f, g), np.maximum(f, g)
    median = np.maximum(low_, np.minimum(high_, signals))
    return wrap(signals - median)


def _box_sum(values: Array | Mask, half: int) -> Array:
    """Sum over t − half … t + half along the last axis, cut at the ends."""
    n = values.shape[-1]
    kind = np.int32 if values.dtype == bool else values.dtype  # whole numbers add up faster
    total = np.empty((*values.shape[:-1], n + 2 * half + 1), dtype=kind)
    total[..., : half + 1] = 0
    np.cumsum(values, axis=-1, out=total[..., half + 1 : half + 1 + n])
    total[..., half + 1 + n :] = total[..., half + n : half + n + 1]
    sums: Array = total[..., 2 * half + 1 :] - total[..., :n]
    return sums


def local_scale(root: Array, good: Mask, half: int) -> Array:
    """σ = 1.48·(mean √|r|)² over the good frames near t, radians; root = √|r|, (2, chains, frames).

    The mean of square roots is a standard deviation that few jumps move (1.48 makes it one for a
    normal distribution). Where few good frames are near it borrows from a window four times as
    wide, and there from the whole clip.
    """
    root = root * good
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
    return np.maximum(mean, FLOOR, out=mean)


@dataclass(frozen=True, eq=False)
class Predictions:
    """Predictions of irregular frames: flat indices `at`, the rest (2, len(at)) and (len(at),).

    The gap is 1 for a frame between two good ones.
    """

    at: Index
    cubic: Array
    linear: Array
    gap: Array


class Predictor:
    """Predicts signals (2, chains, frames) from good frames.

    cubic, linear: of each frame from its two neighbours on either side, good or not.
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
        """√|error| of the regular cubic predictions, (2, chains, frames)."""
        return np.sqrt(np.abs(wrap(self.signals - self.cubic)))

    @cached_property
    def linear_root(self) -> Array:
        """√|error| of the regular linear predictions, (2, chains, frames)."""
        return np.sqrt(np.abs(wrap(self.signals - self.linear)))

    def irregular(self, good: Mask, changed: Mask, signals: Array) -> Predictions:
        """Frames whose neighbours are not all good or not all as they were, predicted.

        signals: with the changes. Cubic: the Lagrange polynomial of the two good neighbours on
        either side. At an end: the mean of the nearest two.
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
        return _predicted(signals.reshape(2, -1), good.ravel(), at, frames)


def _predicted(flat: Array, good: Mask, at: Index, frames: int) -> Predictions:
    """Predictions of the frames `at` of (chains · frames) from their good neighbours."""
    none = np.array([-1, -1])
    known = np.concatenate([none, np.flatnonzero(good), none])
    rank = np.cumsum(good)[at] - good[at] + 2  # place of the first good frame not before `at`
    behind = rank + good[at]
    k_b2, k_b, k_a, k_a2 = known[rank - 2], known[rank - 1], known[behind], known[behind + 1]
    first = at - at % frames
    has_b, has_a = k_b >= first, (k_a >= 0) & (k_a < first + frames)
    has_b2, has_a2 = k_b2 >= first, (k_a2 >= 0) & (k_a2 < first + frames)
    s_b2, s_b, s_a, s_a2 = flat[:, k_b2], flat[:, k_b], flat[:, k_a], flat[:, k_a2]
    b, a = (at - k_b).astype(np.float64), (k_a - at).astype(np.float64)
    b2, a2 = (at - k_b2).astype(np.float64), (k_a2 - at).astype(np.float64)
    inside, whole = has_b & has_a, has_b2 & has_a2
    share = np.where(inside, a, 1.0) / np.where(inside, b + a, 1.0)
    share = np.where(inside, share, has_b.astype(np.float64))
    linear = share * s_b + np.where(has_a, 1.0 - share, 0.0) * s_a
    linear = np.where(has_b & ~has_a, np.where(has_b2, 0.5 * (s_b + s_b2), s_b), linear)
    linear = np.where(has_a & ~has_b, np.where(has_a2, 0.5 * (s_a + s_a2), s_a), linear)
    b2, b, a, a2 = (np.where(whole, v, w) for v, w in ((b2, 2.0), (b, 1.0), (a, 1.0), (a2, 2.0)))
    cubic = (
        -(b * a * a2) / ((b2 - b) * (b2 + a) * (b2 + a2)) * s_b2
        + (b2 * a * a2) / ((b2 - b) * (b + a) * (b + a2)) * s_b
        + (b2 * b * a2) / ((b2 + a) * (b + a) * (a2 - a)) * s_a
        - (b2 * b * a) / ((b2 + a2) * (b + a2) * (a2 - a)) * s_a2
    )
    cubic = np.where(whole, cubic, linear)
    ahead, back = k_a - at, at - k_b
    gap = np.where(inside, ahead + back - 1, np.where(has_b, 2 * back, 2 * ahead))
    return Predictions(at, cubic, linear, np.where(has_b | has_a, gap, frames).astype(np.float64))


class GapGrowth:
    """σ of a prediction over gaps of 1, 3, 5, 9 frames relative to gap 1.

    Measured on the clip itself: mid-frame error of the same interpolation across wider gaps.
    """

    def __init__(self, signals: Array, cubic: Mask) -> None:
        """signals: (2, chains, frames); cubic: (2, chains, 1), else linear."""
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
        """Growth at the four gaps, ≥ 1, (2, chains, 4), from good frames only."""
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


def growth_at(growth: Array, chain: Index, gap: Array) -> Array:
    """Growth of σ of chains at gaps > 1, (2, n): log-log between the measured gaps."""
    level = np.log(growth)
    slope = np.diff(level, axis=-1) / np.diff(_GAPS)
    x = np.log(gap)
    piece = np.clip(np.searchsorted(_GAPS, x, side="right") - 1, 0, 2)
    return np.asarray(
        np.exp(level[:, chain, piece] + slope[:, chain, piece] * (x - _GAPS[piece]))
    )
