"""Which of the equivalent Euler angles to write."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.bvh.turns import least_with_turns
from twistcore.compiled import loops
from twistcore.kernels import path_back, path_costs
from twistcore.rotation import Array, euler_from_quaternion, euler_with_third_held, wrap

_GIMBAL = 1e-6  # |cos φ2| below which only φ1 ± φ3 is known to half of the float's digits


def continuous_angles(
    order: str, q: Array, held_third: Array, before: Array | None, after: Array | None
) -> Array:
    """Euler angles of q, radians, on the branch that moves least.

    q: (n, 4); held_third: φ3 to keep in gimbal lock, (n,); before, after: the untouched angles
    around the run, (3,), or None at a border of the clip. Of the two solutions of every frame and
    their full turns, the path with the smallest Σ|Δchannel| is taken, both edges fixed. Returns
    (n, 3).
    """
    first = euler_from_quaternion(order, q)
    locked = np.cos(first[:, 1]) < _GIMBAL
    if locked.any():
        first[locked] = euler_with_third_held(order, q[locked], held_third[locked])
    second = np.stack([first[:, 0] + np.pi, np.pi - first[:, 1], first[:, 2] + np.pi], axis=1)
    if locked.any():
        second[locked] = first[locked]
    solutions = np.stack([first, second], axis=1)
    path = _cheapest_path(solutions, before, after)
    out = _unwrapped(solutions[np.arange(len(q)), path], before, after)
    if before is None or after is None or (np.abs(after - out[-1]) <= np.pi + 1e-9).all():
        return out  # every step is the shortest there is, so no path can be shorter
    return least_with_turns(solutions, out, before, after)


def angle_jumps(angles: Array, before: Array | None, after: Array | None) -> list[tuple[int, int]]:
    """(row, channel) of every step of more than half a turn; row n is the step to `after`."""
    n = len(angles)
    rows = [angles if before is None else np.vstack([before, angles])]
    every = np.vstack([*rows, after]) if after is not None else rows[0]
    large = np.abs(np.diff(every, axis=0)) > np.pi + 1e-6
    shift = 1 if before is None else 0
    return [(min(int(r) + shift, n), int(c)) for r, c in np.argwhere(large)]


def _cheapest_path(
    solutions: Array, before: Array | None, after: Array | None
) -> NDArray[np.int64]:
    """Index 0 or 1 for every frame: the smallest sum of wrapped steps (Viterbi)."""
    n = len(solutions)
    step = np.abs(wrap(solutions[1:, None, :, :] - solutions[:-1, :, None, :])).sum(axis=-1)
    start = np.zeros(2) if before is None else np.abs(wrap(solutions[0] - before)).sum(axis=-1)
    finish = np.zeros(2) if after is None else np.abs(wrap(after - solutions[-1])).sum(axis=-1)
    # Only the difference of the two costs matters: ahead[t] = cost of solution 1 − of solution 0.
    ahead = np.empty(n)
    ahead[0] = start[1] - start[0]
    costs = np.ascontiguousarray(step.reshape(n - 1, 4).T)
    came = np.empty((2, n), dtype=np.bool_)
    path = np.empty(n, dtype=np.int64)
    compiled = loops()
    if compiled:
        compiled.path_costs(costs, ahead)
    else:  # lists: Python goes through them several times faster than through arrays
        listed = ahead.tolist()
        path_costs(costs.tolist(), listed)
        ahead[:] = listed
    came[0, 1:] = ahead[:-1] + costs[2] < costs[0]
    came[1, 1:] = ahead[:-1] + costs[3] < costs[1]
    last = int(ahead[-1] + finish[1] < finish[0])
    if compiled:
        compiled.path_back(came, path, last)
    else:
        states = path.tolist()
        path_back(came.tolist(), states, last)
        path[:] = states
    return path


def _unwrapped(angles: Array, before: Array | None, after: Array | None) -> Array:
    """Angles by full turns continuous with `before`, or else with `after`."""
    anchor = angles[0] if before is None else before
    out = anchor + np.cumsum(wrap(np.diff(angles, axis=0, prepend=anchor[None])), axis=0)
    if before is None and after is not None:
        out += after - wrap(after - out[-1]) - out[-1]
    unwound: Array = out
    return unwound
