"""Joints that do not twist at all: there the whole twist is the error, at any pace.

A rig may give a joint no freedom to twist, as an elbow; then its level stands still wherever there
is no error. Standing still while the other joint of the chain moves tells it from one that rests.
"""

from __future__ import annotations

import numpy as np

from twistcore.detection.prediction import FLOOR, Mask
from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.surprise import Surprise
from twistcore.rotation import Array

STILL = float(
    np.radians(3e-4)
)  # a frame: a silent joint's text has six decimals, or stays the same
STANDS = float(np.radians(0.1))  # how far a level that stands may be off
LEAST_STILL = 0.08  # of the frames in which the other joint moves
# Of equal parts of a clip, those in which it stands still at all: a joint that only rests for a
# while does so in one or two.
PARTS, LEAST_PARTS = 8, 4
LEAST_STANDING = 0.03  # of all frames, at the level of most: images of other errors shift it
MOVES, FEWEST = float(np.radians(0.05)), 20  # a frame, and so many frames of it
SMALLEST = float(np.radians(1.5))  # what is off by less all the time is not asked for
MOST = 200  # errors a limb
MOSTLY = 0.5  # of all frames still: no gap is as long
ANSWERED = 1.25  # of what the other joint turns, that may be left of it with the error undone
LEFT = 0.3  # of what silent joints turn, that an explanation may leave


def standing_level(increments: Array, other: Array) -> Array | None:
    """How far the level is off where it stands, radians, (frames,); None if it does not stand.

    increments, other: of a joint and of the other one of its chain, radians, (frames,).
    """
    moving = np.abs(other) > MOVES
    still = np.abs(increments) < STILL
    if moving.sum() < FEWEST or still[moving].mean() < LEAST_STILL:
        return None
    parts = [part.any() for part in np.array_split(still & moving, PARTS)]
    if sum(parts) < LEAST_PARTS:
        return None
    level = np.cumsum(increments)
    order = np.sort(level)
    within = np.searchsorted(order, order + STANDS, side="right") - np.arange(len(order))
    densest = int(within.argmax())
    if within[densest] < LEAST_STANDING * len(level):
        return None
    base = np.median(order[densest : densest + int(within[densest])])
    return np.asarray(level - base)


def silent_sides(surprise: Surprise) -> dict[int, int]:
    """Of the chains with a silent joint, by row: 1 where it is P, −1 where it is C.

    A chain in which the image of a neighbour's error would show counts only if that one has a
    silent joint too: or there were nobody to tell the two apart.
    """
    many = surprise.limbs.count
    still: dict[tuple[int, int], float] = {}
    for row in range(surprise.rows):
        for side, own, other in _both_ways(surprise, row):
            if standing_level(own, other) is not None:
                still[row, side] = float((np.abs(own) < STILL).mean())
    answered = {at for at in still if _answered(*_both_ways(surprise, at[0])[at[1] < 0][1:])}
    found: dict[int, int] = {}
    for (row, side), share in still.items():
        # The same joint as the chain beside sees it.
        seen = {(row, side), (row - side * many, -side)} & answered
        if (seen or share >= MOSTLY) and share >= still.get((row, -side), 0.0):
            found[row] = side
    return {
        row: side
        for row, side in found.items()
        if (beside := row - side * many) in found or not 0 <= beside < surprise.rows
    }


def _both_ways(surprise: Surprise, row: int) -> tuple[tuple[int, Array, Array], ...]:
    """Side, the joint that may be silent there, and the other one, of a chain."""
    x, y = surprise.x[row], surprise.y[row]
    return (1, x, y), (-1, y, x)


def _answered(own: Array, other: Array) -> bool:
    """Whether what a joint turns beside standing still is answered by the other joint.

    Where a joint was held over gaps it stands still too, but what it turns elsewhere is its own.
    """
    turns = np.abs(own) >= STILL
    return bool(np.abs(own + other)[turns].sum() <= ANSWERED * np.abs(other)[turns].sum())


def silent_level(surprise: Surprise, row: int, side: int) -> Array | None:
    """The twist error of P that a silent joint of a chain shows, radians, (frames,)."""
    x, y = surprise.x[row], surprise.y[row]
    level = standing_level(x, y) if side > 0 else standing_level(y, x)
    return None if level is None else side * level


def silent_errors(surprise: Surprise, sides: dict[int, int]) -> list[SoftError]:
    """Errors that silent joints of a limb show, taken out one after the other.

    sides: of the silent rows. Where several are off together, one may be the image of the other:
    it is the one without which the least is left.
    """
    found: list[SoftError] = []
    done: Mask = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    for _ in range(MOST):
        rivals = []
        for row, side in sides.items():
            level = silent_level(surprise, row, side)
            if level is None:
                continue
            for start, stop in off_runs(np.where(done[row], 0.0, level)):
                offset = level[start:stop]
                share = _left(surprise, sides, SoftError(row, start, offset, 0.0, STANDS))
                rivals.append((share, start, row, offset))
        if not rivals:
            break
        share, start, row, offset = min(rivals, key=lambda r: r[:3])
        if share > LEFT:
            break
        stop = start + len(offset)
        _take_out(surprise, row, start, offset)
        done[row, start:stop] = True
        found.append(SoftError(row, start, offset, float(len(offset)), STANDS))
    return found


def _left(surprise: Surprise, sides: dict[int, int], error: SoftError) -> float:
    """Share of what silent joints turn around an error that is left without it."""
    before = _turned(surprise, sides, error)
    _take_out(surprise, error.row, error.start, error.offset)
    left = _turned(surprise, sides, error)
    _take_out(surprise, error.row, error.start, -error.offset)
    return left / max(before, FLOOR)


def _turned(surprise: Surprise, sides: dict[int, int], error: SoftError) -> float:
    at = slice(max(error.start, 1), error.stop + 1)
    rows = [r for r in surprise.beside(error.row) if r in sides]
    silent = [surprise.x[r, at] if sides[r] > 0 else surprise.y[r, at] for r in rows]
    return float(sum(np.abs(v).sum() for v in silent))


def _take_out(surprise: Surprise, row: int, start: int, offset: Array) -> None:
    surprise.take_out(row, start, offset)
    surprise.look_again(row, start, start + len(offset))


def off_runs(level: Array) -> list[tuple[int, int]]:
    """Frames [start, stop) in which a level is off, where it is by as much as is asked for."""
    off = np.flatnonzero(np.abs(level) > STANDS)
    if not len(off):
        return []
    runs = np.split(off, np.flatnonzero(np.diff(off) > 1) + 1)
    spans = [(max(int(r[0]) - 2, 0), min(int(r[-1]) + 3, len(level))) for r in runs]
    return [(a, b) for a, b in spans if np.abs(level[a:b]).max() > SMALLEST]
