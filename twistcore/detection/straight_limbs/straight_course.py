"""Compute the twist error of a straight limb over time [Method].

While the bone of a child C is in line with the bone of its parent P, joint positions do not show
how a twist is divided between P and C. Three properties of the twist error δ are still known.
First, the twists X − δ of P and Y + δ of C are smooth, where X and Y are the sums of the twist
increments x and y. Second, δ is 0 where the limb is bent. Third, δ seldom changes. The curve δ(t)
that best satisfies these conditions is computed by iteratively reweighted least squares.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array

# Equations: the indices of their unknowns (n, k), the factors of the k unknowns, and the right-hand
# sides (n,).
Rows: TypeAlias = tuple[NDArray[np.int64], Array, Array]

ROUNDS = 12  # maximum number of rounds of reweighting
SELDOM, STEP = 0.05, float(np.radians(12.0))  # cost of a change of δ; smallest change per second
SETTLES = 0.25  # seconds after which a twist comes to rest if nothing else determines it
LEAST_SCALE = float(np.radians(0.02))  # smallest scale of the difference of successive increments
ROUNDED = 0.71  # σ of this difference due to rounding, in rounding steps of the angles
SAME = 1e-5  # radians: the iteration stops if δ changes less


def error_course(
    increments: tuple[Array, Array],
    scales: tuple[float, float],
    start: int,
    stop: int,
    low: int,
    high: int,
    fps: float,
) -> Array:
    """Return the twist error δ in frames [start, stop), in radians.

    In the rest of the segment [low, high), δ is 0. If the frames begin or end at a border of the
    segment, δ may have any value at this border, because the motion beyond it is unknown.

    Parameters
    ----------
    increments
        The twist increments x of the parent and y of the child, radians, each of shape (frames,).
    scales
        The scales of x and y from :func:`twist_increment_change_scale`.
    start, stop
        The frames in which the limb is straight.
    low, high
        The frames of the segment between two cuts.
    fps
        The frame rate.
    """
    rows = _smooth(increments, scales, start, stop, low, high, fps)
    n = stop - start
    band, right = np.zeros((3, n)), np.zeros(n)
    band[2] = 1e-9
    for columns, factors, given in rows:
        for i, factor in enumerate(factors.tolist()):
            own = columns[:, i] >= 0
            np.add.at(right, columns[own, i], factor * given[own])
            for j in range(i, len(factors)):
                both = own & (columns[:, j] >= 0)
                np.add.at(band[2 + i - j], columns[both, j], factor * factors[j])
    return _seldom_changing(band, right, start > low, stop < high, STEP / fps)


def twist_increment_change_scale(increments: Array, step: float = 0.0) -> float:
    """Return the usual difference between successive increments, in radians.

    `step` is the rounding step of the angles in the file, in radians. It determines the smallest
    possible result.
    """
    bends = np.abs(np.diff(increments[2:]))
    least = max(LEAST_SCALE, ROUNDED * step)
    return max(least, 1.4826 * median(bends)) if len(bends) else least


def _smooth(
    increments: tuple[Array, Array],
    scales: tuple[float, float],
    start: int,
    stop: int,
    low: int,
    high: int,
    fps: float,
) -> list[Rows]:
    """Return least-squares equations that make the twists of parent and child smooth and slow.

    The unknowns are the values of δ. The parameters have the same meaning as in
    :func:`error_course`. The increment to the first frame of the segment is not used, because it
    crosses a cut.
    """
    rows = []
    at = np.arange(max(start - 1, low + 2), min(stop + 1, high)) - 1
    of_bends = _columns(at[:, None] + np.arange(3) - 1, start, stop)
    step = np.arange(max(start, low + 1), min(stop + 1, high))
    of_steps = _columns(step[:, None] + np.arange(2) - 1, start, stop)
    for signal, scale, sign in zip(increments, scales, (1.0, -1.0), strict=True):
        bend = sign * np.array([1.0, -2.0, 1.0]) / scale
        rows.append((of_bends, bend, (signal[at + 1] - signal[at]) / scale))
        rest = scale * SETTLES * fps
        rows.append((of_steps, sign * np.array([-1.0, 1.0]) / rest, signal[step] / rest))
    return rows


def _columns(frames: NDArray[np.int64], start: int, stop: int) -> NDArray[np.int64]:
    """Return the index of the unknown δ of each frame, or −1 for frames in which δ is known."""
    return np.where((frames >= start) & (frames < stop), frames - start, -1)


def _seldom_changing(band: Array, right: Array, begins: bool, ends: bool, step: float) -> Array:
    """Solve the equations with weights that make δ change either by a large amount or not at all.

    Parameters
    ----------
    band
        The upper diagonals of the normal equations, the main diagonal last, shape (3, n).
    right
        The right-hand side of the normal equations, shape (n,).
    begins, ends
        True if δ is 0 before the first frame and after the last frame, respectively.
    step
        The smallest significant change of δ, radians per frame.

    Returns
    -------
    ndarray, shape (n,)
        The values of δ, radians.
    """
    from scipy.linalg import solveh_banded  # slow to load, and few clips need it

    delta = np.zeros(len(right))
    weight = np.full(len(right) + 1, SELDOM / step**2)
    weight[[0, -1]] *= [begins, ends]
    for _ in range(ROUNDS):
        weighted = band.copy()
        weighted[2] += weight[:-1] + weight[1:]
        weighted[1, 1:] -= weight[1:-1]
        now = np.asarray(solveh_banded(weighted[-min(3, len(right)) :], right))
        if np.abs(now - delta).max() < SAME:
            return now
        delta = now
        changes = np.diff(delta, prepend=0.0, append=0.0)
        weight = 2.0 * SELDOM / (changes**2 + step**2)
        weight[[0, -1]] *= [begins, ends]
    return delta
