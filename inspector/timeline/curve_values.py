"""The numbers behind the curves: angles ready to be drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array, wrap

RELIABLE = 0.2  # ‖v⊥‖/‖v‖ below which the azimuth is shaded
_BINS, _BLUR = 72, np.radians(25.0)
_MOVES = np.radians(90.0)  # what turns further in a frame has jumped


def centre_of(angle: Array) -> float:
    """The direction round which an angle stays most of the time, radians; (frames,) -> number."""
    return float(np.angle(np.exp(1j * angle).sum())) if len(angle) else 0.0


def degrees_about(angle: Array, centre: float) -> tuple[Array, NDArray[np.int64]]:
    """An angle in degrees within half a turn of `centre`, (frames,), and its seams.

    A seam is a frame behind which it leaves on one side and comes in on the other. The line is
    broken there: a full turn is no movement and must not look like one. Real jumps are drawn.
    """
    y = np.degrees(centre + wrap(angle - centre))
    return y, np.flatnonzero(np.abs(np.diff(y)) > 180.0)


def rarest(angle: Array) -> float:
    """The direction that an angle is most seldom near, radians in (−2π, 0]; (n,) -> number.

    There a line can be broken without a jump of half a turn losing its other side.
    """
    count, _ = np.histogram(wrap(angle), _BINS, (-np.pi, np.pi))
    near = np.minimum(np.arange(_BINS), _BINS - np.arange(_BINS)) * 2.0 * np.pi / _BINS
    weight = np.exp(-0.5 * (near / _BLUR) ** 2)
    seen = np.fft.irfft(np.fft.rfft(count) * np.fft.rfft(weight), _BINS)
    turn = 2.0 * np.pi
    return float((int(np.argmin(seen)) + 0.5) / _BINS * turn - np.pi) % turn - turn


def above(angle: Array, seam: float) -> tuple[Array, NDArray[np.int64]]:
    """An angle in degrees in the turn that begins at `seam`, (frames,), and its seams.

    A seam is a frame behind which it moves across: as :func:`degrees_about`, but a jump of half a
    turn, which has no shorter way, is drawn.
    """
    y, _ = degrees_about(angle, seam + np.pi)
    across = (np.abs(np.diff(y)) > 180.0) & (np.abs(wrap(np.diff(angle))) < _MOVES)
    return y, np.flatnonzero(across)


def thinned(
    y: Array, seams: NDArray[np.int64], first: float, last: float, pixels: int
) -> tuple[Array, Array]:
    """Points of a line over the frames in view: all of them, or the extremes of each pixel.

    y: a value a frame, NaN where nothing is drawn; the extremes pass NaN over, so that a short
    piece between gaps is still seen from afar. Returns x and y with NaN where the line is broken.
    """
    start, stop = max(0, int(first) - 1), min(len(y), int(last) + 3)
    step = (stop - start) // max(1, pixels)
    if step < 3:
        x: Array = np.arange(start, stop, dtype=np.float64)
        out = y[start:stop]
        here = seams[(seams >= start) & (seams < stop - 1)]
        if len(here):
            x = np.insert(x, here - start + 1, here + 0.5)
            out = np.insert(out, here - start + 1, np.nan)
        return x, out
    start -= start % step  # bins stay where they are while the view moves: no shimmer
    bins = -(-(stop - start) // step)
    block = y[start : start + bins * step]
    if len(block) < bins * step:
        block = np.concatenate([block, np.full(bins * step - len(block), np.nan)])
    # A row a frame of every pixel: numpy compares whole rows at once, eight times as fast.
    block = np.ascontiguousarray(block.reshape(bins, step).T)
    ends = np.stack([np.fmin.reduce(block), np.fmax.reduce(block)], axis=1)
    at = (seams + 1 - start) // step
    ends[at[(at >= 0) & (at < bins)]] = np.nan
    x = start + step * (np.arange(bins, dtype=np.float64) + 0.5) - 0.5
    return np.repeat(x, 2), ends.ravel()


def unreliable_spans(reliability: Array, least: float = RELIABLE) -> NDArray[np.int64]:
    """Half-open spans [start, stop) in which an angle says nothing, integers, (spans, 2).

    reliability: of the azimuth, or whatever else is to be `least` or more, (frames,).
    """
    low = np.concatenate([[False], reliability < least, [False]])
    return np.flatnonzero(np.diff(low)).reshape(-1, 2)
