"""Find jumps of a limb: sudden rotations about the line from its first joint to its end.

A sharp jump occurs in one frame, and a soft jump takes several frames. The *departure* in a frame
is the rotation about the line since the previous frame minus the median of nearby frames.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from twistcore.detection.prediction import Index, Mask
from twistcore.skeleton.medians import medians
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

NEAR = 4  # number of frames on either side whose median is the natural motion of the limb
_SCALE_SECONDS = 0.2  # time on either side in which the natural size of departures is measured
_LEAST_SCALE = float(np.radians(1.0))
_SOFT_SECONDS = 0.15  # maximum duration of a soft jump
_SOFT_TURN = np.radians([75.0, 190.0])  # smallest and largest angle of a soft jump
_SOFT_PACES = np.radians([1200.0, 600.0, 300.0])  # per second; each is tried as the minimum pace
# The natural jitter of the middle joint, and its smallest distance from the line for which the
# resulting rotation is computed. Both are shares of the limb's length.
_UNREST, _STRAIGHT = 0.006, 0.04
# Smallest jump that may be the other edge of a flip: an angle, and a multiple of the limb's scale.
_WEAK, _WEAK_SCALES = np.radians(25.0), 4.0
SHARP = float(np.radians(40.0))  # a larger rotation in a frame is not part of a soft jump


@dataclass(frozen=True)
class Jump:
    """A sudden rotation of a limb in frames [start, stop).

    The limb rotates about the line from its first joint to its end.

    Attributes
    ----------
    turns
        The rotation of the limb in each frame of the jump, radians.
    scale
        The natural magnitude of the limb's departures near the jump, radians.
    step
        The movement of the limb's end in the jump minus its usual movement nearby, as a fraction of
        the limb's length.
    sharp
        True for a jump in one frame, False for a jump over several frames.
    leads
        True if the jump is at least τ and needs an explanation. False if it is smaller and can only
        be an edge of a flip with another edge of at least τ.
    """

    start: int
    stop: int
    turns: tuple[float, ...]
    scale: float = 0.0
    step: float = 0.0
    sharp: bool = True
    leads: bool = True

    @property
    def turn(self) -> float:
        """The rotation of the limb in the whole jump, in radians."""
        return sum(self.turns)


def rotations_minus_nearby_median(turns: Array) -> Array:
    """Return a limb's departures: its rotations minus the median of nearby frames, in radians.

    `turns` contains the rotations about the limb's line since the previous frame, in radians,
    (frames,). The median excludes the frame itself and frame 0, which has no previous frame.
    """
    return wrap(turns - median_around(turns))


def median_around(values: Array, frames: Index | slice = slice(None)) -> Array:
    """Return the median of the values near each of the given frames, by default near every frame.

    The median excludes the given frame itself and frame 0.
    """
    padded = np.full(len(values) + 2 * NEAR, np.nan)
    padded[NEAR:-NEAR] = values
    padded[: NEAR + 1] = np.nan
    windows = sliding_window_view(padded, 2 * NEAR + 1)[frames].copy()
    windows[:, NEAR] = np.nan
    return _median(windows)


def _median(windows: Array) -> Array:
    """Return the median of each row, ignoring NaN, or 0 for a row that contains only NaN."""
    ordered = np.sort(windows, axis=1)  # NaN last
    count = np.isfinite(ordered).sum(axis=1)
    rows, middle = np.arange(len(ordered)), np.maximum(count - 1, 0)
    low, high = ordered[rows, middle // 2], ordered[rows, (middle + 1) // 2]
    return np.where(count > 0, 0.5 * (low + high), 0.0)


def natural_departure_scale(departures: Array, height: Array, fps: float, frames: Index) -> Array:
    """Return the natural magnitude of a limb's departures near given frames, in radians, (n,).

    `departures` contains the departures (see :func:`rotations_minus_nearby_median`) in radians,
    (frames,). `height` contains the distance of the middle joint from the line between the limb's
    ends, as a fraction of the limb's length, (frames,). The smaller this distance is, the farther
    the same jitter rotates the limb about the line.
    """
    half = max(NEAR, round(_SCALE_SECONDS * fps))
    padded = np.pad(np.abs(departures), half, mode="symmetric")
    own = 1.4826 * medians(sliding_window_view(padded, 2 * half + 1)[frames])
    least = np.maximum(_LEAST_SCALE, _UNREST / np.maximum(height[frames], _STRAIGHT))
    scales: Array = np.maximum(own, least)
    return scales


def sharp_jumps(
    departures: Array,
    scale_at: Callable[[Index], Array],
    steps_at: Callable[[Index], Array],
    tau: float,
) -> list[Jump]:
    """Return the single-frame jumps, whose departures are at least τ radians or unusually large.

    `departures` contains the departures (see :func:`rotations_minus_nearby_median`) in radians,
    (frames,). `scale_at` and `steps_at` are functions that return the natural magnitude of the
    departures and the movement of the limb's end at given frames.
    """
    size = np.abs(departures)
    at = np.flatnonzero(size >= min(tau, _WEAK))
    scales = scale_at(at)
    kept = (size[at] >= tau) | (size[at] >= np.maximum(_WEAK, _WEAK_SCALES * scales))
    at, scales = at[kept], scales[kept]
    return [
        Jump(t, t + 1, (float(departures[t]),), own, step, leads=bool(size[t] >= tau))
        for t, own, step in zip(at.tolist(), scales.tolist(), steps_at(at).tolist(), strict=True)
    ]


def soft_jumps(turns: Array, sharp: Mask, fps: float) -> list[Jump]:
    """Return the jumps over several frames: fast rotations in one direction, as large as a flip.

    `turns` contains the rotations in radians, (frames,). `sharp` is the mask of the frames with
    sharp jumps, which cannot be part of a soft jump.
    """
    found = set()
    for pace in _SOFT_PACES / fps:
        moving = (np.abs(turns) > pace) & ~sharp
        sign = np.where(moving, np.sign(turns), 0.0)
        borders = np.flatnonzero(np.diff(sign, prepend=0.0, append=0.0))
        for start, stop in zip(borders[:-1].tolist(), borders[1:].tolist(), strict=True):
            whole = abs(float(turns[start:stop].sum()))
            brief = 2 <= stop - start <= _SOFT_SECONDS * fps
            if sign[start] and brief and _SOFT_TURN[0] <= whole <= _SOFT_TURN[1]:
                found.add((start, stop))
    return [
        Jump(a, b, tuple(turns[a:b].tolist()), sharp=False, leads=False) for a, b in sorted(found)
    ]
