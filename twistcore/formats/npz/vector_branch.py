"""Choose among equivalent rotation vectors, so that vectors are continuous over time.

A rotation by |v| about v/|v| is also a rotation by |v| + 2πk about the same axis.
"""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array, logarithm

_TURN = 2.0 * np.pi
_NONE = 1e-9  # radians; the axis of a smaller rotation is undefined
_MOST_TURNS = 8  # maximum number of full turns in each direction; no file has more
_OWN = 1e-3  # weight of the distance to the file's vector, relative to the steps


def continuous_npz_rotation_vectors(
    q: Array, own: Array, before: Array | None = None, after: Array | None = None
) -> Array:
    """Return the equivalent rotation vectors that change least over time, radians, (n, 3).

    The path with the smallest Σ|Δv| is chosen. If several paths are equally short, the path nearest
    to the file's vectors is chosen.

    Parameters
    ----------
    q
        Rotations, shape (n, 4).
    own
        The file's vectors in these frames, shape (n, 3).
    before, after
        Vectors of the frames before and after, shape (3,), or None at an end of the clip.
    """
    short = logarithm(q)
    angle = np.linalg.norm(short, axis=1)
    # In frames without rotation, use the axis of the file's vector, which may be a full turn.
    axis = np.where(angle[:, None] > _NONE, short, own)
    size = np.linalg.norm(axis, axis=1)
    axis = axis / np.where(size > _NONE, size, 1.0)[:, None]
    edges = [v[None] for v in (before, after) if v is not None]
    most = np.linalg.norm(np.concatenate([own, *edges]), axis=1).max()
    farthest = _most_turns(short, axis, own if before is None else before[None])
    if after is not None:
        farthest = max(farthest, _most_turns(short[::-1], axis[::-1], after[None]))
    whole = min(max(int(most / _TURN), farthest) + 1, _MOST_TURNS)
    turns = _TURN * np.arange(-whole, whole + 1)
    choices = short[:, None] + turns[:, None] * axis[:, None]  # (n, turns, 3)
    cost = _OWN * np.linalg.norm(choices - own[:, None], axis=2)
    if before is not None:
        cost[0] += np.linalg.norm(choices[0] - before, axis=1)
    if after is not None:
        cost[-1] += np.linalg.norm(after - choices[-1], axis=1)
    return choices[np.arange(len(q)), _cheapest(choices, cost)]


def _most_turns(short: Array, axis: Array, start: Array) -> int:
    """Return the most full turns of the vectors that continue from a start, without a sign.

    Parameters
    ----------
    short
        The shortest rotation vectors, radians, shape (n, 3).
    axis
        The unit vectors along them, shape (n, 3).
    start
        The vector before the first one, or several of which only the first is used, shape (…, 3).
    """
    most, near = 0, start[0]
    for vector, along in zip(short, axis, strict=True):
        turns = round(float((near - vector) @ along) / _TURN)
        near = vector + turns * _TURN * along
        most = max(most, abs(turns))
    return most


def _cheapest(choices: Array, cost: Array) -> list[int]:
    """Return the index of the choice in each frame on the path with the lowest total cost.

    The total is the sum of the steps between frames and of `cost`. The path is found with the
    Viterbi algorithm.

    Parameters
    ----------
    choices
        The possible vectors, shape (n, turns, 3).
    cost
        The additional cost of each choice, shape (n, turns).
    """
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
