"""Prepare angles for drawing as curves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array, wrap

# Least ‖v⊥‖/‖v‖ at which the azimuth is reliable; v is the child's bone, v⊥ its part perpendicular
# to the parent's bone
RELIABLE = 0.2
_BINS, _BLUR = 72, np.radians(25.0)
_MOVES = np.radians(90.0)  # a larger rotation between two frames is a jump


def circular_mean_angle(angle: Array) -> float:
    """Return the circular mean of an angle, (frames,), in radians, or 0 if there are no frames."""
    return float(np.angle(np.exp(1j * angle).sum())) if len(angle) else 0.0


def wrap_degrees_about(angle: Array, centre: float) -> tuple[Array, NDArray[np.int64]]:
    """Wrap an angle to within 180° of `centre`. Return it in degrees, (frames,), with its seams.

    `angle` and `centre` are in radians. A seam is a frame after which the angle wraps around from
    one end of this range to the other. Lines are broken at seams, but not at real jumps.
    """
    y = np.degrees(centre + wrap(angle - centre))
    return y, np.flatnonzero(np.abs(np.diff(y)) > 180.0)


def rarest_angle(angle: Array) -> float:
    """Return the angle at which the given angles, (n,), are sparsest, in radians in (−2π, 0].

    A curve that is broken at this angle still shows jumps of 180°.
    """
    count, _ = np.histogram(wrap(angle), _BINS, (-np.pi, np.pi))
    near = np.minimum(np.arange(_BINS), _BINS - np.arange(_BINS)) * 2.0 * np.pi / _BINS
    weight = np.exp(-0.5 * (near / _BLUR) ** 2)
    seen = np.fft.irfft(np.fft.rfft(count) * np.fft.rfft(weight), _BINS)
    turn = 2.0 * np.pi
    return float((int(np.argmin(seen)) + 0.5) / _BINS * turn - np.pi) % turn - turn


def wrap_degrees_above(angle: Array, seam: float) -> tuple[Array, NDArray[np.int64]]:
    """Wrap an angle to the 360° above `seam`. Return it in degrees, (frames,), with its seams.

    `angle` and `seam` are in radians. Seams are defined as in :func:`wrap_degrees_about`, but a
    jump of more than 90° is not a seam, so it is drawn.
    """
    y, _ = wrap_degrees_about(angle, seam + np.pi)
    across = (np.abs(np.diff(y)) > 180.0) & (np.abs(wrap(np.diff(angle))) < _MOVES)
    return y, np.flatnonzero(across)


def thin_curve_to_pixels(
    y: Array, seams: NDArray[np.int64], first: float, last: float, pixels: int
) -> tuple[Array, Array]:
    """Return x and y of a line through the visible frames, with NaN where the line is broken.

    `y` has a value for each frame, or NaN in a gap. If there are many more frames than pixels, the
    result has only the lowest and the highest value at each pixel. In this case, NaN is ignored, so
    short pieces between gaps stay visible.
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
    start -= start % step  # bins must not move with the view, which would flicker
    bins = -(-(stop - start) // step)
    block = y[start : start + bins * step]
    if len(block) < bins * step:
        block = np.concatenate([block, np.full(bins * step - len(block), np.nan)])
    # Each row has one frame of every pixel, so that numpy compares whole rows: eight times as fast.
    block = np.ascontiguousarray(block.reshape(bins, step).T)
    ends = np.stack([np.fmin.reduce(block), np.fmax.reduce(block)], axis=1)
    at = (seams + 1 - start) // step
    ends[at[(at >= 0) & (at < bins)]] = np.nan
    x = start + step * (np.arange(bins, dtype=np.float64) + 0.5) - 0.5
    return np.repeat(x, 2), ends.ravel()


def unreliable_spans(reliability: Array, least: float = RELIABLE) -> NDArray[np.int64]:
    """Return the frames [start, stop) in which the reliability is below `least`, (spans, 2)."""
    low = np.concatenate([[False], reliability < least, [False]])
    return np.flatnonzero(np.diff(low)).reshape(-1, 2)
