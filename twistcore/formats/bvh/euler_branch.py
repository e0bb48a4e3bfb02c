"""Choose among equivalent Euler angles, so that written angles are continuous.

Two sets of angles, called *solutions* here, give the same rotation, and full turns can be added to
every angle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import (
    Array,
    euler_from_quaternion,
    euler_with_third_held,
    geodesic_angle,
    quaternion_from_euler,
    wrap,
)

_GIMBAL = 1e-6  # gimbal lock: at a smaller |cos φ2|, only φ1 ± φ3 is determined
_LOCKED = 1e-7  # the same for angles in a file, which are exact or have at least 5 decimals
_JUMP = 90.0  # degrees; if all channels step by less, no equivalent angles are nearer
_TURN = 2.0 * np.pi
# Maximum number of full turns to distribute over the frames; no correction needs more.
_MOST_TURNS = 2
# The smallest weight of a frame in the choice of solutions, and the tolerance for angles that
# differ by half a turn. The value is far above rounding errors and far below real differences.
_LEAST_WEIGHT = 1e-6


def continuous_euler_angles(
    order: str, q: Array, own: Array, before: Array | None, after: Array | None
) -> Array:
    """Return the equivalent Euler angles that change least from frame to frame, radians, (n, 3).

    Of the possible paths between the fixed angles at both ends, the one with the smallest Σ|Δangle|
    is chosen. Without fixed angles, a path is always as long as the path with the opposite solution
    in every frame. In this case, the distance to the file's angles is added to the sum. Its weight
    is cos θ in a frame whose rotation differs from the file's by θ < 90°.

    Parameters
    ----------
    order
        The axes, such as 'ZYX'.
    q
        Rotations in the frames to write, shape (n, 4).
    own
        The file's angles in these frames, shape (n, 3). In gimbal lock, their φ3 is kept.
    before, after
        The unchanged angles before and after these frames, shape (3,), or None at an end of the
        clip.
    """
    first, locked = _principal(order, q, own[:, 2])
    second = np.stack([first[:, 0] + np.pi, np.pi - first[:, 1], first[:, 2] + np.pi], axis=1)
    if locked.any():
        second[locked] = first[locked]
    solutions = np.stack([first, second], axis=1)
    if before is None and after is None:
        weight = _near_own(order, q, own)
        extra = weight[:, None] * _distance(solutions, own[:, None])
        path = _cheapest_path(solutions, None, None, extra)
        chosen = _unwrapped(solutions[np.arange(len(q)), path], None, None)
        return chosen + _turns_to(own, chosen, weight)
    path = _cheapest_path(solutions, before, after)
    out = _unwrapped(solutions[np.arange(len(q)), path], before, after)
    if before is None or after is None or (np.abs(after - out[-1]) <= np.pi + 1e-9).all():
        return out  # every step is as short as possible, so no path is shorter
    return _least_with_turns(solutions, out, before, after)


def _principal(order: str, q: Array, third: Array | None) -> tuple[Array, NDArray[np.bool_]]:
    """Return the solution with φ2 in ±90° for each frame, and a mask of frames in gimbal lock.

    The solutions are in radians, (n, 3). In gimbal lock, φ3 is copied from `third`, (n,). If
    `third` is None, it is copied from the last frame before the lock.
    """
    first = euler_from_quaternion(order, q)
    locked = np.cos(first[:, 1]) < _GIMBAL
    if locked.any():
        free = np.maximum.accumulate(np.where(locked, 0, np.arange(len(q))))
        held = first[free, 2] if third is None else third
        first[locked] = euler_with_third_held(order, q[locked], held[locked])
    return first, locked


def continuous_euler_angles_in_order(order: str, q: Array) -> Array:
    """Return the Euler angles of q in the given order, degrees, (n, 3), without avoidable jumps."""
    return unwrapped_euler_angles(order, np.degrees(_principal(order, q, None)[0]))


def nearest_euler_angles(order: str, q: Array, near: Array) -> Array:
    """Return the Euler angles of q that are nearest to the angles `near`, degrees, (n, 3)."""
    first = np.degrees(_principal(order, q, np.radians(near[:, 2]))[0])
    solutions = np.stack([first, _chosen(first, np.zeros(3), True)])
    solutions += 360.0 * np.round((near - solutions) / 360.0)
    best = np.abs(solutions - near).sum(axis=-1).argmin(axis=0)
    nearest: Array = solutions[best, np.arange(len(q))]
    return nearest


def euler_jump_rows_and_channels(
    angles: Array, before: Array | None, after: Array | None
) -> list[tuple[int, int]]:
    """Return (row, channel) of each step of more than half a turn. Angles are in radians.

    Row k is the step to row k of `angles`, and row len(angles) is the step to `after`.
    """
    n = len(angles)
    rows = [angles if before is None else np.vstack([before, angles])]
    every = np.vstack([*rows, after]) if after is not None else rows[0]
    large = np.abs(np.diff(every, axis=0)) > np.pi + 1e-6
    shift = 1 if before is None else 0
    return [(min(int(r) + shift, n), int(c)) for r, c in np.argwhere(large)]


def _distance(angles: Array, others: Array) -> Array:
    """Return the sum of |Δangle| over the last axis, with angles wrapped, in radians."""
    far: Array = np.abs(wrap(angles - others)).sum(axis=-1)
    return far


def _cheapest_path(
    solutions: Array, before: Array | None, after: Array | None, extra: Array | None = None
) -> NDArray[np.int64]:
    """Return the solution of each frame, 0 or 1, on the path with the smallest sum of steps.

    The path is found with the Viterbi algorithm.

    Parameters
    ----------
    solutions
        Both solutions in each frame, radians, shape (n, 2, 3). Full turns do not matter.
    before, after
        The fixed angles before and after the path, shape (3,), or None.
    extra
        An additional cost of each solution, shape (n, 2).
    """
    n = len(solutions)
    step = _distance(solutions[1:, None], solutions[:-1, :, None])
    start = np.zeros(2) if before is None else _distance(solutions[0], before)
    finish = np.zeros(2) if after is None else _distance(after, solutions[-1])
    if extra is not None:
        start, step = start + extra[0], step + extra[1:, None]
    # Only the difference between the costs matters: `ahead` is the cost of solution 1 minus the
    # cost of solution 0.
    ahead = float(start[1] - start[0])
    came = []  # for solutions 0 and 1, True if the best path comes from solution 1
    # Python iterates over lists several times faster than over arrays.
    for stay0, leave0, leave1, stay1 in step.reshape(n - 1, 4).tolist():
        to0, to1 = ahead + leave1, ahead + stay1
        came.append((to0 < stay0, to1 < leave0))
        ahead = (to1 if to1 < leave0 else leave0) - (to0 if to0 < stay0 else stay0)
    here = bool(ahead + finish[1] < finish[0])
    path = [here]
    for best in reversed(came):
        here = best[here]
        path.append(here)
    return np.array(path[::-1], dtype=np.int64)


def _unwrapped(angles: Array, before: Array | None, after: Array | None) -> Array:
    """Add full turns so that the angles continue from `before`.

    If `before` is None, the angles end near `after`.
    """
    anchor = angles[0] if before is None else before
    out = anchor + np.cumsum(wrap(np.diff(angles, axis=0, prepend=anchor[None])), axis=0)
    if before is None and after is not None:
        out += after - wrap(after - out[-1]) - out[-1]
    unwound: Array = out
    return unwound


# -- joints that are rewritten in every frame ------------------------------------------------------
#
# If a joint is rewritten in every frame, only the file's angles decide between two equally smooth
# curves. Frames whose rotation is close to the file's have the greatest weight, and frames with a
# large correction have almost none.


def _near_own(order: str, q: Array, own: Array) -> Array:
    """Return the weight of the file's angles in each frame, (n,), above 0 and at most 1.

    The weight is highest where the rotations q are close to the file's.
    """
    turned = geodesic_angle(quaternion_from_euler(order, own), q)
    weight: Array = np.maximum(np.cos(turned), _LEAST_WEIGHT)
    return weight


def _turns_to(own: Array, angles: Array, weight: Array) -> Array:
    """Return the full turns to add to each channel so that it is nearest to `own`, radians, (3,).

    The same turns are added in every frame.
    """
    off = np.sort((own - angles)[weight >= weight.max() / 2], axis=0)
    # The median is used because, where `own` wraps, the majority of the frames should decide.
    turns: Array = _TURN * np.ceil(off[len(off) // 2] / _TURN - 0.5 - _LEAST_WEIGHT)
    return turns


# -- remaining full turns -------------------------------------------------------------------------
#
# Between fixed angles at both ends, a channel may need one full turn more than its shortest steps,
# for example after a correction through ±180°. The best frame for this turn depends on the
# solutions, so solutions and turns are chosen together.


def _least_with_turns(solutions: Array, near: Array, before: Array, after: Array) -> Array:
    """Return the path from `before` to `after` with the smallest Σ|Δangle|, radians, (n, 3).

    The path is found by dynamic programming over the solution and the full turns of each channel
    relative to `near`. The result is exact for up to 2 turns.

    Parameters
    ----------
    solutions
        Both solutions in each frame, up to full turns, shape (n, 2, 3).
    near
        A path that begins at `before` and has no steps above half a turn, shape (n, 3).
    before, after
        The fixed angles before and after the path, shape (3,).
    """
    # Turns are counted from the angle nearest to the path. If two angles are equally near, at half
    # a turn on both sides, the count may be off by one, so one more turn in each direction is
    # included.
    base = solutions + _TURN * np.round((near[:, None] - solutions) / _TURN)
    left = np.clip(np.round((after - near[-1]) / _TURN), -_MOST_TURNS, _MOST_TURNS)
    turns = [np.arange(min(t, 0) - 2, max(t, 0) + 3) * _TURN for t in left]
    # (frames, solutions, turns) of each channel.
    grids = [base[:, :, c, None] + turns[c] for c in range(3)]
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
    """Return the axes that contain the turns of the other two channels in an array of states.

    The array of states has the shape (solutions, turns, turns, turns). If these axes are inserted
    into an array (solutions, turns) for one channel, the two arrays broadcast.
    """
    return tuple(1 + c for c in range(3) if c != channel)


def _advance(cost: Array, steps: list[tuple[Array, Array]]) -> tuple[Array, list[Array]]:
    """Return the lowest cost of every state in the next frame, and the states before it.

    A state is a solution with the turns of its three channels. Since |Δ| is a sum over channels,
    the channels are processed one after another. Each step depends only on the channel's turns and
    on the two solutions.
    """
    back: list[Array] = []
    now = np.broadcast_to(cost[:, None], (2, *cost.shape))  # (from, to, turns of 3 channels)
    for c, (old, new) in enumerate(steps):
        # The shape is (from, to, old turns, new turns).
        step = np.abs(new[None, :, None, :] - old[:, None, :, None])
        moved = np.moveaxis(now, 2 + c, -1)  # (from, to, turns of 2 other channels, old turns)
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


# -- steps in the angles of a file -----------------------------------------------------------------


def unwrapped_euler_angles(order: str, angles: Array) -> Array:
    """Replace angles with equivalent ones without avoidable jumps, in degrees, (n, channels).

    Where a channel steps by more than 90°, the equivalent angles nearest to the previous frame are
    chosen. They may have additional full turns. If the three axes differ, they may be the other
    solution with the same rotation, and in gimbal lock, they may divide the rotation differently
    between the outer angles. The choice is kept until the next such step. Angles without such steps
    stay bit-for-bit equal.
    """
    out, paired = angles.copy(), len(order) == 3 and len(set(order)) == 3
    steps = (np.abs(np.diff(angles, axis=0)) > _JUMP).any(axis=1)
    if not steps.any():
        return out
    lock = np.zeros(len(angles), dtype=np.int64)  # sign of sin φ2 in gimbal lock, 0 in other frames
    if paired:
        middle = np.radians(angles[:, 1])
        lock = np.where(np.abs(np.cos(middle)) < _LOCKED, np.sign(np.sin(middle)), 0).astype(int)
        if order not in "XYZXY":
            lock = -lock
    choice = np.zeros(angles.shape[1]), False
    start = 0
    for frame in (np.flatnonzero(steps | (lock[:-1] != 0)) + 1).tolist():
        out[start:frame] = _chosen(angles[start:frame], *choice)
        before, start = out[frame - 1], frame
        free = lock[frame] or (choice[0] == np.round(choice[0] / 360.0) * 360.0).all()
        if free and (np.abs(_chosen(angles[frame], *choice) - before) <= _JUMP).all():
            continue
        choice = _nearest(angles[frame], before, int(lock[frame]), paired)
    out[start:] = _chosen(angles[start:], *choice)
    return out


def _chosen(angles: Array, shift: Array, other: bool) -> Array:
    """Return `angles`, (…, k), or the other solution if `other`, plus `shift`, in degrees."""
    if other:
        angles = np.stack(
            [angles[..., 0] + 180.0, 180.0 - angles[..., 1], angles[..., 2] + 180.0], -1
        )
    return angles + shift if shift.any() else angles


def _nearest(angles: Array, before: Array, lock: int, paired: bool) -> tuple[Array, bool]:
    """Return the arguments `shift` and `other` of `_chosen` that bring angles nearest to `before`.

    `lock` is the sign of sin φ2 in gimbal lock, or 0. `paired` is True if there is another
    solution.
    """
    if lock:  # only φ1 ± φ3 is determined
        off = before - angles
        both = off[0] + lock * off[2]
        turn = 360.0 * round(both / 360.0)
        part = 0.5 * (off[0] - lock * off[2] + turn)
        return np.array([part, 360.0 * round(off[1] / 360.0), lock * (turn - part)]), False
    found = []
    for other in (False, True)[: 1 + paired]:
        off = before - _chosen(angles, np.zeros(len(angles)), other)
        turns = 360.0 * np.round(off / 360.0)
        found.append((float(np.abs(off - turns).sum()), other, turns))
    _, other, turns = min(found, key=lambda one: one[0])
    return turns, other
