"""The shortest way through equivalent Euler angles where full turns are left over.

Between fixed angles on both sides a channel may have to go round once more than its shortest steps
do: because it was corrected through ±180°, say. Where that costs least depends on the branch, so
branch and turns are chosen together.
"""

from __future__ import annotations

import numpy as np

from twistcore.rotation import Array

_TURN = 2.0 * np.pi
_MOST_TURNS = 2  # more are put at the far edge; no joint winds up further within one correction


def least_with_turns(solutions: Array, near: Array, before: Array, after: Array) -> Array:
    """The path from `before` to `after` with the smallest Σ|Δchannel|, radians, shape (n, 3).

    solutions: the two of every frame, (n, 2, 3), each free by full turns; near: a path of
    solutions from `before` on without any step beyond half a turn, (n, 3). Exact by dynamic
    programming over (solution, full turns of each channel beside `near`), up to 2 turns.
    """
    # Each solution by full turns as near to the path as can be: turn 0.
    base = solutions + _TURN * np.round((near[:, None] - solutions) / _TURN)
    left = np.clip(np.round((after - near[-1]) / _TURN), -_MOST_TURNS, _MOST_TURNS)
    turns = [np.arange(min(t, 0) - 1, max(t, 0) + 2) * _TURN for t in left]
    grids = [base[:, :, c, None] + turns[c] for c in range(3)]  # (n, 2, turns of the channel)
    cost = sum(
        np.expand_dims(np.abs(grid[0] - before[c]), _others(c)) for c, grid in enumerate(grids)
    )
    assert isinstance(cost, np.ndarray)
    came = []
    for t in range(1, len(base)):
        cost, back = _advance(cost, [(grid[t - 1], grid[t]) for grid in grids])
        came.append(back)
    cost = cost + sum(
        np.expand_dims(np.abs(after[c] - grid[-1]), _others(c)) for c, grid in enumerate(grids)
    )
    at = tuple(int(i) for i in np.unravel_index(int(np.argmin(cost)), cost.shape))
    path = [at]
    for back in reversed(came):
        at = _previous(at, back)
        path.append(at)
    return np.array(
        [
            [grids[c][t, state[0], state[1 + c]] for c in range(3)]
            for t, state in enumerate(reversed(path))
        ]
    )


def _others(channel: int) -> tuple[int, ...]:
    """The axes to insert so that (2, turns) broadcasts over (2, turns, turns, turns)."""
    return tuple(1 + c for c in range(3) if c != channel)


def _advance(cost: Array, steps: list[tuple[Array, Array]]) -> tuple[Array, list[Array]]:
    """Cheapest cost of every state (solution, turns ×3) a frame later, and where it came from.

    The channels are gone through one after another: |Δ| is a sum over them, so that each needs its
    own turns and the two solutions only.
    """
    back: list[Array] = []
    now = np.broadcast_to(cost[:, None], (2, *cost.shape))  # (from, to, turns ×3)
    for c, (old, new) in enumerate(steps):
        # (from, to, old turns, new turns)
        step = np.abs(new[None, :, None, :] - old[:, None, :, None])
        moved = np.moveaxis(now, 2 + c, -1)  # (from, to, two others, old turns)
        every = moved[..., None] + step[:, :, None, None]
        choice = every.argmin(axis=-2)
        now = np.moveaxis(every.min(axis=-2), -1, 2 + c)
        back.append(np.moveaxis(choice, -1, 2 + c).astype(np.int8))
    back.append(now.argmin(axis=0).astype(np.int8))
    return now.min(axis=0), back


def _previous(at: tuple[int, ...], back: list[Array]) -> tuple[int, ...]:
    to, turns = at[0], list(at[1:])
    source = int(back[3][at])
    for c in (2, 1, 0):
        turns[c] = int(back[c][(source, to, *turns)])
    return (source, *turns)
