"""Choose the equivalent rotation vector that continues the neighbouring frames.

A rotation by |v| about v/|v| is also a rotation by |v| + 2πk about the same axis.
"""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array, logarithm

_TURN = 2.0 * np.pi
_NONE = 1e-9  # radians; a smaller rotation has no defined axis
_MOST_TURNS = 8  # in each direction; no file has more, and the time grows with the square
_OWN = 1e-3  # weight of the distance to the file's vector, relative to the steps


def continuous_vectors(
    q: Array, own: Array, before: Array | None = None, after: Array | None = None
) -> Array:
    """Return rotation vectors of q with the smallest Σ|Δv|, in radians, (n, 4) → (n, 3).

    `own` are the file's vectors in these frames, shape (n, 3). If several paths are equally short,
    the one nearest to `own` is chosen. `before` and `after` are the vectors of the neighbouring
    frames, shape (3,), or None at an end of the clip.
    """
    short = logarithm(q)
    angle = np.linalg.norm(short, axis=1)
    # For frames without rotation, use the axis about which the file makes whole turns.
    axis = np.where(angle[:, None] > _NONE, short, own)
    size = np.linalg.norm(axis, axis=1)
    axis = axis / np.where(size > _NONE, size, 1.0)[:, None]
    edges = [v[None] for v in (before, after) if v is not None]
    most = np.linalg.norm(np.concatenate([own, *edges]), axis=1).max()
    whole = min(int(most / _TURN) + 1, _MOST_TURNS)
    turns = _TURN * np.arange(-whole, whole + 1)
    choices = short[:, None] + turns[:, None] * axis[:, None]  # (n, turns, 3)
    cost = _OWN * np.linalg.norm(choices - own[:, None], axis=2)
    if before is not None:
        cost[0] += np.linalg.norm(choices[0] - before, axis=1)
    if after is not None:
        cost[-1] += np.linalg.norm(after - choices[-1], axis=1)
    return choices[np.arange(len(q)), _cheapest(choices, cost)]


def _cheapest(choices: Array, cost: Array) -> list[int]:
    """Return the choice for each frame on the path with the lowest costs plus length (Viterbi)."""
    steps = np.linalg.norm(choices[1:, None] - choices[:-1, :, None], axis=3)  # (from, to)
    here, came = cost[0], []
    for step, own in zip(steps, cost[1:], strict=True):
        every = here[:, None] + step
        source = every.argmin(axis=0)
        here = every[source, np.arange(len(source))] + own
        came.append(source)
    path = [int(here.argmin())]
    for source in reversed(came):
        path.append(int(source[path[-1]]))
    return path[::-1]
