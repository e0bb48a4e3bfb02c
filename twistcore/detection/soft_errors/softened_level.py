"""A level that sets in and ends softly: its course, and the one that fits best.

Captures are filled by straight lines or splines and low-passed before anybody sees them; what was
a level in the solver is then that level through a ramp or a filter. Its course has four numbers:
δ, the frames at which it sets in and ends by half, and how long that takes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import butter, sosfiltfilt

from twistcore.rotation import Array

Residuals: TypeAlias = Callable[[Array], Array]  # courses (n, frames) → weighted residuals (n, …)

STEEPEST = 0.5  # frames
_FILTERED = 2000  # frames of the tabulated step response, at a cut-off of 1/100 of a frame
_PERIOD = 100.0
_AT = np.array([np.radians(2.0), 1.0, 1.0, 1.0])  # scales of the four numbers
_STEPS = 1e-3
MOST_STEPS = 12


class Level(NamedTuple):
    """δ in radians; its middle of onset and of end in frames; how long they take, in frames."""

    size: float
    onset: float
    end: float
    width: float


@cache
def _step_response() -> tuple[Array, Array]:
    """Of a zero-phase second-order Butterworth: periods of the cut-off, and the response."""
    step = np.zeros(2 * _FILTERED)
    step[_FILTERED:] = 1.0
    response = sosfiltfilt(butter(2, 2.0 / _PERIOD, output="sos"), step)
    return (np.arange(2 * _FILTERED) + 0.5 - _FILTERED) / _PERIOD, response


def ramp(t: Array) -> Array:
    """From 0 at −½ to 1 at ½, evenly."""
    return np.asarray(np.clip(t + 0.5, 0.0, 1.0))


def filtered(t: Array) -> Array:
    """A step at 0 through a zero-phase second-order Butterworth; t in periods of its cut-off."""
    at, response = _step_response()
    return np.asarray(np.interp(t, at, response))


KERNELS: tuple[Callable[[Array], Array], ...] = (ramp, filtered)


def course(levels: Array, kernel: Callable[[Array], Array], frames: int) -> Array:
    """δ(t) of levels (n, 4) over so many frames, (n, frames)."""
    size, onset, end, width = levels.T[..., None]
    t, width = np.arange(frames), np.maximum(width, STEEPEST)
    return np.asarray(size * (kernel((t - onset) / width) - kernel((t - end) / width)))


def guess(offset: Array) -> Level | None:
    """A level like an offset of any course, (frames,); None where it hardly rises."""
    size = np.abs(offset)
    top = int(size.argmax())
    if size[top] <= 0.0 or len(offset) < 3:
        return None
    half = np.flatnonzero(size > 0.5 * size[top])
    low, high = (np.flatnonzero(size > share * size[top]) for share in (0.2, 0.8))
    width = 0.5 * ((high[0] - low[0]) + (low[-1] - high[-1])) / 0.6
    return Level(float(offset[top]), half[0] - 0.5, half[-1] + 0.5, max(width, 2.0))


def fitted(
    start: Level, kernel: Callable[[Array], Array], frames: int, residuals: Residuals
) -> Array:
    """The course over so many frames that leaves the least residuals, (frames,)."""

    def of(scaled: Array) -> Array:
        return residuals(course((scaled * _AT)[None], kernel, frames))[0]

    def slopes(scaled: Array) -> Array:
        """All numbers one step on at once: the residuals are made for many courses together."""
        steps = _STEPS * np.maximum(np.abs(scaled), 1.0)
        moved = np.vstack([scaled, scaled + np.diag(steps)])
        all_ = residuals(course(moved * _AT, kernel, frames))
        return np.asarray(((all_[1:] - all_[0]) / steps[:, None]).T)

    found = least_squares(of, np.array(start) / _AT, jac=slopes, max_nfev=MOST_STEPS, x_scale="jac")
    return course((found.x * _AT)[None], kernel, frames)[0]
