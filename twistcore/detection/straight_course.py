"""The error of a straight limb's twist as a course over time [MATH.md §4].

Where C's bone keeps to P's no position tells how a twist is split between them. What is known of
the error δ is then that P's own twist X − δ and C's, Y + δ, run on smoothly (x, y: increments,
X, Y: their sums), that δ is 0 where the limb is bent, that it seldom changes, and, of a hinge that
holds on straight limbs too, the side to which C's bone leaves P's. δ is what explains it best.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from twistcore.rotation import Array, wrap

ROUNDS = 12  # of weights: δ then changes only where it must
SELDOM, STEP = 0.05, float(np.radians(12.0))  # price of a change of δ, and its size a second
SETTLES = 0.25  # seconds in which a twist of its own comes to rest where nothing tells it
LEAST_SCALE = float(np.radians(0.02))  # of the change of an increment from frame to frame
STRAIGHT_NOISE = float(np.radians(0.3))  # of a hinge's direction, at least, at a right angle


@dataclass(frozen=True, eq=False)
class Observed:
    """What is known of a limb frame by frame, radians, each (frames,).

    x, y: twist increments of P and C about P's bone, without errors that are known; bend: of C's
    bone off P's; azimuth: how far to the side of the clip's hinge C's bone stands, or None where
    that tells nothing; spread: of that in the bent limb.
    """

    x: Array
    y: Array
    bend: Array
    azimuth: Array | None
    spread: float


def course(seen: Observed, start: int, stop: int, low: int, high: int, fps: float) -> Array:
    """δ in frames [start, stop), radians; 0 in those beside it within the segment [low, high).

    At the segment's ends it is free: nothing is known of what was before.
    """
    rows, targets = _smooth(seen, start, stop, low, high, fps)
    delta = _solved(rows, targets, np.zeros((stop - start, 2)), start > low, stop < high, fps)
    if seen.azimuth is None:
        return delta
    side = -seen.azimuth[start:stop]
    side = delta + wrap(2.0 * (side - delta)) / 2.0  # a limb bent backward stands opposite
    noise = max(STRAIGHT_NOISE, 0.5 * seen.spread) / np.maximum(np.sin(seen.bend[start:stop]), 1e-3)
    pull = np.stack([1.0 / noise**2, side / noise**2], axis=1)
    return _solved(rows, targets, pull, start > low, stop < high, fps)


def scale_of(increments: Array) -> float:
    """How much an increment differs from the one before, as a rule; radians."""
    return max(LEAST_SCALE, 1.4826 * float(np.median(np.abs(np.diff(increments[2:])))))


def _smooth(
    seen: Observed, start: int, stop: int, low: int, high: int, fps: float
) -> tuple[list[tuple[NDArray[np.int64], Array]], list[Array]]:
    """Rows (columns of δ, factors) and what they should come to, for both signals.

    Columns run over δ from two frames before `start` to two behind `stop`, −1 where it is 0.
    """
    rows, targets = [], []
    at = np.arange(max(start - 1, low + 1), min(stop + 1, high - 1))
    inside = np.stack([at - 1, at, at + 1], axis=1)
    column = np.where((inside >= start) & (inside < stop), inside - start, -1)
    steps = np.arange(max(start, low + 1), min(stop + 1, high))
    beside = np.stack([steps - 1, steps], axis=1)
    step_column = np.where((beside >= start) & (beside < stop), beside - start, -1)
    for signal, sign in ((seen.x, 1.0), (seen.y, -1.0)):
        scale = scale_of(signal)
        first = at > low + 1 if low == 0 else at > low  # frame `low` has no increment
        bends = (signal[at + 1] - signal[at])[first] / scale
        rows.append((column[first], sign * np.array([1.0, -2.0, 1.0]) / scale))
        targets.append(bends)
        rest = scale * SETTLES * fps
        rows.append((step_column, sign * np.array([-1.0, 1.0]) / rest))
        targets.append(signal[steps] / rest)
    return rows, targets


def _solved(
    rows: list[tuple[NDArray[np.int64], Array]],
    targets: list[Array],
    pull: Array,
    begins: bool,
    ends: bool,
    fps: float,
) -> Array:
    """The least squares δ, weighted anew so that it seldom changes."""
    n = len(pull)
    band, right = np.zeros((3, n)), pull[:, 1].copy()
    band[2] += pull[:, 0] + 1e-9
    for (columns, factors), target in zip(rows, targets, strict=True):
        for i in range(len(factors)):
            own = columns[:, i] >= 0
            np.add.at(right, columns[own, i], factors[i] * target[own])
            for j in range(i, len(factors)):
                both = own & (columns[:, j] >= 0)
                np.add.at(band[2 - (j - i)], columns[both, j], factors[i] * factors[j])
    step = STEP / fps
    delta = np.zeros(n)
    weight = np.full(n + 1, SELDOM / step / np.radians(2.0))
    for _ in range(ROUNDS):
        whole = band.copy()
        inner = weight[1:-1]
        whole[2, :-1] += inner
        whole[2, 1:] += inner
        whole[1, 1:] -= inner
        whole[2, 0] += weight[0] * begins
        whole[2, -1] += weight[-1] * ends
        now = solveh_banded(whole[-min(3, n) :], right)
        changes = np.diff(now, prepend=0.0, append=0.0)
        weight = 2.0 * SELDOM / (changes**2 + step**2)
        if np.abs(now - delta).max() < 1e-5:
            return np.asarray(now)
        delta = now
    return np.asarray(delta)
