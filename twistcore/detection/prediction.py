"""Natural motion predicted from good neighbours, and how well [MATH.md §4.2].

Signals are stacked (2, chains, frames): x and y. A frame is *good* for a chain where nothing
jumps; predictions look at good frames only, and never at the frame they predict.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.rotation import Array, wrap

Mask = NDArray[np.bool_]
Index = NDArray[np.int64]

FLOOR = float(np.radians(0.005))  # rounding of BVH text; keeps σ > 0 where a joint does not twist
WINDOW_SECONDS, WINDOW_FRAMES = 0.15, 12  # half window of σ: motion changes its pace within ~0.3 s
_GAPS = np.log(np.array([1.0, 3.0, 5.0, 9.0]))


def half_window(fps: float) -> int:
    """Half the window of the local scale, frames."""
    return max(WINDOW_FRAMES, round(WINDOW_SECONDS * fps))


def coarse_residual(signals: Array, step: int) -> Array:
    """Signals less the median of 5 samples `step` frames apart, radians.

    Before anything is known about jumps: a short interval or a ramp is outvoted.
    """
    frames = signals.shape[-1]
    padded = np.pad(signals, ((0, 0), (0, 0), (2 * step, 2 * step)), mode="edge")
    samples = np.stack([padded[..., k * step : k * step + frames] for k in range(5)])
    samples.partition(2, axis=0)
    return wrap(signals - samples[2])


def _box_sum(values: Array, half: int) -> Array:
    """Sum over t − half … t + half along the last axis, cut at the ends."""
    n = values.shape[-1]
    total: Array = np.zeros((*values.shape[:-1], n + 2 * half + 1))
    np.cumsum(values, axis=-1, out=total[..., half + 1 : half + 1 + n])
    total[..., half + 1 + n :] = total[..., half + n : half + n + 1]
    sums: Array = total[..., 2 * half + 1 :] - total[..., :n]
    return sums


def local_scale(residual: Array, good: Mask, half: int) -> Array:
    """σ = 1.48·(mean √|r|)² over the good frames near t, radians, as `residual`.

    The mean of square roots is a standard deviation that few jumps move (1.48 makes it one for a
    normal distribution). Where few good frames are near it borrows from a window four times as
    wide, and there from the whole clip.
    """

    def scaled(mean_root: Array) -> Array:
        sigma: Array = np.maximum(1.48 * mean_root * mean_root, FLOOR)
        return sigma

    weight = good.astype(np.float64)
    root = np.sqrt(np.abs(residual)) * weight
    many, mean = _box_sum(weight, half), _box_sum(root, half)
    if many.min() >= 0.5 * half:
        return scaled(mean / many)
    overall = root.sum(-1, keepdims=True) / np.maximum(weight.sum(-1, keepdims=True), 1.0)
    wide = (_box_sum(root, 4 * half) + 2.0 * overall) / (_box_sum(weight, 4 * half) + 2.0)
    lacking = np.maximum(0.5 * half - many, 0.0)
    return scaled((mean + lacking * wide) / (many + lacking))


@dataclass(frozen=True, eq=False)
class Neighbours:
    """The two good frames before and after each frame, (chains, frames); −1 and F where none."""

    before2: Index
    before: Index
    after: Index
    after2: Index


def good_neighbours(good: Mask) -> Neighbours:
    """The nearest good frames on both sides of every frame, itself left out; (chains, frames)."""
    chains, frames = good.shape
    t = np.arange(frames)
    none = np.full((chains, 1), -1)
    last = np.maximum.accumulate(np.where(good, t, -1), axis=1)
    before = np.concatenate([none, last[:, :-1]], axis=1)
    following = np.minimum.accumulate(np.where(good, t, frames)[:, ::-1], axis=1)[:, ::-1]
    after = np.concatenate([following[:, 1:], none + frames + 1], axis=1)
    # a −1 indexes the last column, which holds −1 again; F indexes the column that holds F
    before2 = np.take_along_axis(np.concatenate([before, none], axis=1), before, axis=1)
    after2 = np.take_along_axis(np.concatenate([after, none + frames + 1], axis=1), after, axis=1)
    return Neighbours(before2, before, after, after2)


def predict(signals: Array, near: Neighbours) -> tuple[Array, Array, Array]:
    """Cubic and linear prediction (2, chains, frames), and the gap they bridge (chains, frames).

    Cubic: the Lagrange polynomial of the four neighbours. At an end: the mean of the nearest two.
    The gap is 1 for a frame between two good ones.
    """
    frames = signals.shape[-1]
    t = np.arange(frames)
    has_b, has_a = near.before >= 0, near.after < frames
    has_b2, has_a2 = near.before2 >= 0, near.after2 < frames
    s_b2, s_b, s_a, s_a2 = (
        np.take_along_axis(signals, np.clip(k, 0, frames - 1)[None], axis=2)
        for k in (near.before2, near.before, near.after, near.after2)
    )
    b, a = (t - near.before).astype(np.float64), (near.after - t).astype(np.float64)
    b2, a2 = (t - near.before2).astype(np.float64), (near.after2 - t).astype(np.float64)
    inside = has_b & has_a
    share = np.where(inside, a / (b + a), np.where(has_b, 1.0, 0.0))
    linear = share * s_b + np.where(has_a, 1.0 - share, 0.0) * s_a
    linear = np.where(has_b & ~has_a & has_b2, 0.5 * (s_b + s_b2), linear)
    linear = np.where(has_a & ~has_b & has_a2, 0.5 * (s_a + s_a2), linear)
    with np.errstate(divide="ignore", invalid="ignore"):
        cubic = (
            -(b * a * a2) / ((b2 - b) * (b2 + a) * (b2 + a2)) * s_b2
            + (b2 * a * a2) / ((b2 - b) * (b + a) * (b + a2)) * s_b
            + (b2 * b * a2) / ((b2 + a) * (b + a) * (a2 - a)) * s_a
            - (b2 * b * a) / ((b2 + a2) * (b + a2) * (a2 - a)) * s_a2
        )
    cubic = np.where(inside & has_b2 & has_a2, cubic, linear)
    gap = np.where(inside, b + a - 1.0, np.where(has_b, 2.0 * b, 2.0 * a))
    return cubic, linear, gap


def gap_growth(signals: Array, good: Mask, *, cubic: bool) -> Array:
    """σ of a prediction over gaps of 1, 3, 5, 9 frames relative to gap 1, ≥ 1; (2, chains, 4).

    Measured on the clip itself: mid-frame error of the same interpolation across wider gaps.
    """
    frames = signals.shape[-1]
    out: list[Array] = []
    for k in (1, 2, 3, 5):  # distance to the nearer neighbour: gap 2k − 1
        if frames <= 2 * k + 12:
            out.append(2.0 * out[-1] if out else np.ones(signals.shape[:2]))
            continue
        mid = slice(k + 1, frames - k - 1)
        left, right = slice(1, frames - 2 * k - 1), slice(2 * k + 1, frames - 1)
        near = signals[..., left] + signals[..., right]
        if cubic:
            far = signals[..., : frames - 2 * k - 2] + signals[..., 2 * k + 2 :]
            inner = 0.5 * (k + 1) ** 2 / (2 * k + 1)
            error = signals[..., mid] - inner * near + (inner - 0.5) * far
        else:
            error = signals[..., mid] - 0.5 * near
        usable = good[:, mid] & good[:, left] & good[:, right]
        root = (np.sqrt(np.abs(error)) * usable).sum(-1) / np.maximum(usable.sum(-1), 1)
        out.append(root * root + 0.3 * FLOOR)
    growth = np.stack(out, axis=-1)
    return np.asarray(np.maximum.accumulate(growth / growth[..., :1], axis=-1))


def growth_at(growth: Array, gap: Array) -> Array:
    """Growth of σ at each frame's gap, (2, chains, frames): log-log between the measured gaps."""
    level = np.log(growth)
    slope = np.diff(level, axis=-1) / np.diff(_GAPS)
    wide = gap > 1.0
    out = np.ones((2, *gap.shape))
    for chain in range(gap.shape[0]):
        at = np.flatnonzero(wide[chain])
        if not len(at):
            continue
        x = np.log(gap[chain, at])
        piece = np.clip(np.searchsorted(_GAPS, x, side="right") - 1, 0, 2)
        for s in range(2):
            out[s, chain, at] = np.exp(
                level[s, chain, piece] + slope[s, chain, piece] * (x - _GAPS[piece])
            )
    return out
