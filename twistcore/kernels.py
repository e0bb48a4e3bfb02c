"""Loops that numba compiles, see :mod:`twistcore.compiled`; nothing here imports it.

Every one gives the same bits as the numpy code beside its caller: the same operations in the same
order, or results that are exact. Indices into bytes are unsigned, so that none is looked at twice
for being negative.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence

import numpy as np
from numpy.typing import NDArray

from twistcore.rotation import Array

_Bytes = NDArray[np.uint8]
_Integers = NDArray[np.int64]

_ONE, _NONE = np.uint64(1), np.uint64(0)


def find_tokens(x: _Bytes, wanted: _Integers, found: _Integers) -> None:
    """Start, end and decimals of the tokens with these numbers, ascending from 0; fills (n, 3).

    Decimals are the digits behind the point, an exponent left out.
    """
    n, i = np.uint64(len(x)), _NONE
    token = 0
    for k in range(len(wanted)):
        while True:
            while i < n and x[i] <= 32:
                i += _ONE
            if token == wanted[k]:
                break
            while i < n and x[i] > 32:
                i += _ONE
            token += 1
        found[k, 0] = i
        decimals, counting = 0, False
        while i < n and x[i] > 32:
            if x[i] == 46:
                counting = True
            elif x[i] | 32 == 101:
                counting = False
            elif counting:
                decimals += 1
            i += _ONE
        found[k, 1], found[k, 2] = i, decimals
        token += 1


def path_costs(steps: Sequence[Sequence[float]], ahead: MutableSequence[float]) -> None:
    """Viterbi over two states: ahead[t] = cost of state 1 − of state 0; ahead[0] is given.

    steps: the costs of 0→0, 0→1, 1→0 and 1→1 from t to t + 1, shape (4, n − 1).
    """
    stay0, leave0, leave1, stay1 = steps[0], steps[1], steps[2], steps[3]
    d = ahead[0]
    for t in range(len(stay0)):
        to0, to1 = d + leave1[t], d + stay1[t]
        d = (to1 if to1 < leave0[t] else leave0[t]) - (to0 if to0 < stay0[t] else stay0[t])
        ahead[t + 1] = d


def path_back(came: Sequence[Sequence[bool]], path: MutableSequence[int], last: int) -> None:
    """The states of the cheapest path; came: whether the best way to 0, to 1 at t is from 1."""
    came0, came1 = came[0], came[1]
    path[-1] = here = last
    for t in range(len(path) - 1, 0, -1):
        here = int(came1[t]) if here else int(came0[t])
        path[t - 1] = here


def compose(cos: Array, sin: Array, columns: _Integers, axes: _Integers, out: Array) -> None:
    """Rotations from half angles (frames, columns) into `out` (frames, joints, 4).

    columns, axes: (joints, channels) of every joint's rotation channels in order; −1 behind them.
    """
    part = np.empty(4)
    for t in range(len(out)):
        for joint in range(len(columns)):
            part[0], part[1], part[2], part[3] = 1.0, 0.0, 0.0, 0.0
            for k in range(columns.shape[1]):
                column, axis = columns[joint, k], axes[joint, k]
                if column < 0:
                    break
                c, s = cos[t, column], sin[t, column]
                o, j, m = 1 + axis, 1 + (axis + 1) % 3, 1 + (axis + 2) % 3
                if k == 0:
                    part[0], part[o] = c, s
                    continue
                w, x, y, z = part[0], part[o], part[j], part[m]
                part[0], part[o] = w * c - x * s, x * c + w * s
                part[j], part[m] = y * c + z * s, z * c - y * s
            out[t, joint] = part


def descend(q: Array, p: Array, parents: _Integers) -> None:
    """Local into global, in place; q: (frames, joints, 4), p: (frames, joints, 3)."""
    for t in range(len(q)):
        for joint in range(len(parents)):
            above = parents[joint]
            if above < 0:
                continue
            aw, ax, ay, az = q[t, above, 0], q[t, above, 1], q[t, above, 2], q[t, above, 3]
            bw, bx, by, bz = q[t, joint, 0], q[t, joint, 1], q[t, joint, 2], q[t, joint, 3]
            q[t, joint, 0] = aw * bw - ax * bx - ay * by - az * bz
            q[t, joint, 1] = aw * bx + ax * bw + ay * bz - az * by
            q[t, joint, 2] = aw * by - ax * bz + ay * bw + az * bx
            q[t, joint, 3] = aw * bz + ax * by - ay * bx + az * bw
            px, py, pz = p[t, joint, 0], p[t, joint, 1], p[t, joint, 2]
            tx, ty, tz = ay * pz - az * py, az * px - ax * pz, ax * py - ay * px
            tx, ty, tz = tx + tx, ty + ty, tz + tz
            p[t, joint, 0] = p[t, above, 0] + (px + aw * tx + (ay * tz - az * ty))
            p[t, joint, 1] = p[t, above, 1] + (py + aw * ty + (az * tx - ax * tz))
            p[t, joint, 2] = p[t, above, 2] + (pz + aw * tz + (ax * ty - ay * tx))
