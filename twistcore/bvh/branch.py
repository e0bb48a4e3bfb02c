"""Which of the equivalent Euler angles to write."""

from __future__ import annotations

import numpy as np

from twistcore.rotation import Array, euler_from_quaternion, euler_with_third_held, wrap

_GIMBAL = 1e-6  # |cos φ2| below which only φ1 ± φ3 is known to half of the float's digits


def continuous_angles(
    order: str, q: Array, held_third: Array, before: Array | None, after: Array | None
) -> Array:
    """Euler angles of q, radians, on the branch that moves least.

    q: (n, 4); held_third: φ3 to keep in gimbal lock, (n,); before, after: the untouched angles
    around the run, (3,), or None at a border of the clip. Of the two solutions of every frame the
    path with the smallest Σ|Δchannel| is taken (Viterbi, both edges fixed); full turns that remain
    against `after` are put where they cost least. Returns (n, 3).
    """
    first = euler_from_quaternion(order, q)
    locked = np.cos(first[:, 1]) < _GIMBAL
    if locked.any():
        first[locked] = euler_with_third_held(order, q[locked], held_third[locked])
    second = np.stack([first[:, 0] + np.pi, np.pi - first[:, 1], first[:, 2] + np.pi], axis=1)
    if locked.any():
        second[locked] = first[locked]
    solutions = np.stack([first, second], axis=1)
    chosen = solutions[np.arange(len(q)), _cheapest_path(solutions, before, after)]
    return _unwrap(chosen, before, after)


def _cheapest_path(solutions: Array, before: Array | None, after: Array | None) -> list[int]:
    """Index 0 or 1 for every frame, by dynamic programming over wrapped steps."""
    n = len(solutions)
    step = np.abs(wrap(solutions[1:, None, :, :] - solutions[:-1, :, None, :])).sum(axis=-1)
    start = np.zeros(2) if before is None else np.abs(wrap(solutions[0] - before)).sum(axis=-1)
    finish = np.zeros(2) if after is None else np.abs(wrap(after - solutions[-1])).sum(axis=-1)
    cost0, cost1 = (float(c) for c in start)
    came: list[tuple[int, int]] = []
    for (c00, c01), (c10, c11) in step.tolist():
        to0, to1 = (cost0 + c00, cost1 + c10), (cost0 + c01, cost1 + c11)
        came.append((int(to0[1] < to0[0]), int(to1[1] < to1[0])))
        cost0, cost1 = min(to0), min(to1)
    path = [int(cost1 + finish[1] < cost0 + finish[0])]
    for back in reversed(came):
        path.append(back[path[-1]])
    assert len(path) == n
    return path[::-1]


def _unwrap(angles: Array, before: Array | None, after: Array | None) -> Array:
    """Angles by full turns continuous with `before` and, as well as can be, with `after`."""
    out = np.empty_like(angles)
    for c in range(3):
        anchor = angles[0, c] if before is None else before[c]
        steps = wrap(np.diff(angles[:, c], prepend=anchor))
        if after is None and before is None:
            out[:, c] = anchor + np.cumsum(steps)
            continue
        if before is None:
            assert after is not None
            out[:, c] = anchor + np.cumsum(steps)
            out[:, c] += after[c] - wrap(after[c] - out[-1, c]) - out[-1, c]
            continue
        if after is not None:
            last = wrap(after[c] - angles[-1, c])
            every = np.append(steps, last)
            turns = round((after[c] - before[c] - every.sum()) / (2.0 * np.pi))
            # A turn replaces a step w by w ± 2π; that is cheapest where w already leans that way's
            # opposite, at the latest at the edge itself.
            sign = 1 if turns > 0 else -1
            for k in np.argsort(every * sign, kind="stable")[: abs(turns)]:
                every[k] += sign * 2.0 * np.pi
            steps = every[:-1]
        out[:, c] = anchor + np.cumsum(steps)
    return out
