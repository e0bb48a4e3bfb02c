"""A level that sets in and ends softly: its course, and the one that fits best.

Captures are filled by straight lines or splines and low-passed before anybody sees them; what was
a level in the solver is then that level through a ramp or a filter. Its course has four numbers:
δ, the frames at which it sets in and ends by half, and how long that takes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from twistcore.rotation import Array

# Of courses (n, frames), with all scales so many times wider: weighted residuals (n, …).
Residuals: TypeAlias = Callable[[Array, float], Array]

STEEPEST = 0.5  # frames
_DECAY = np.pi * np.sqrt(2.0)  # a period: how fast the filtered step swings in
_AT = np.array([np.radians(2.0), 1.0, 1.0, 1.0])  # scales of the four numbers
_STEPS = 1e-3
MOST_STEPS, ENOUGH = 12, 0.05  # of the fit at one width of the scales; nats
NARROWER = 5.0  # from one width to the next


class Level(NamedTuple):
    """δ in radians; its middle of onset and of end in frames; how long they take, in frames."""

    size: float
    onset: float
    end: float
    width: float


def ramp(t: Array) -> Array:
    """From 0 at −½ to 1 at ½, evenly."""
    return np.asarray(np.minimum(np.maximum(t + 0.5, 0.0), 1.0))


def filtered(t: Array) -> Array:
    """A step at 0 through a zero-phase second-order Butterworth; t in periods of its cut-off.

    In closed form: the filter run both ways has the gain 1 / (1 + (f / cut-off)⁴).
    """
    away = _DECAY * np.abs(t)
    rest = 0.5 * np.exp(-away) * np.cos(away)
    return np.asarray(np.where(t < 0.0, rest, 1.0 - rest))


KERNELS: tuple[Callable[[Array], Array], ...] = (ramp, filtered)


def course(levels: Array, kernel: Callable[[Array], Array], frames: int) -> Array:
    """δ(t) of levels (n, 4) over so many frames, (n, frames)."""
    size, onset, end, width = levels.T[..., None]
    edges = np.array([onset, end])
    rises, falls = kernel((np.arange(frames) - edges) / np.maximum(width, STEEPEST))
    return np.asarray(size * (rises - falls))


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
    start: Level,
    kernel: Callable[[Array], Array],
    frames: int,
    residuals: Residuals,
    coarsest: float,
) -> tuple[Array, float]:
    """The course over so many frames that leaves the least, (frames,), and the sum of its squares.

    Levenberg and Marquardt's steps; the slopes of all four numbers are made with the residuals
    themselves, for many courses at once. Far from the best course every residual is at its cap and
    no step leads anywhere: so the scales are widened at first, by `coarsest`, then by less.
    """
    number: Array = np.array(start) / _AT
    wider = max(coarsest, 1.0)
    while True:
        number, course_, best = _descended(number, kernel, frames, residuals, wider)
        if wider <= 1.0:
            return course_, best
        wider = max(1.0, wider / NARROWER)


def _descended(
    number: Array,
    kernel: Callable[[Array], Array],
    frames: int,
    residuals: Residuals,
    wider: float,
) -> tuple[Array, Array, float]:
    """The four numbers, their course and what it leaves, at one width of the scales."""
    damping, best = 1e-2, np.inf
    course_ = np.zeros(frames)
    step: Array = np.zeros(len(_AT))
    curvature, down = np.zeros((len(_AT), len(_AT))), np.zeros(len(_AT))
    for _ in range(MOST_STEPS):
        tried = number + step
        here = course(tried[None] * _AT, kernel, frames)
        left = residuals(here, wider)[0]
        value = float(left @ left)
        if value < best:
            gained = best - value
            number, best, course_ = tried, value, here[0]
            damping = max(0.2 * damping, 1e-6)
            if gained < ENOUGH:
                break
            # Four courses more, only where a step is made from here.
            by = _STEPS * np.maximum(np.abs(number), 1.0)
            beside = course((number + np.diag(by)) * _AT, kernel, frames)
            slopes = (residuals(beside, wider) - left) / by[:, None]
            curvature, down = slopes @ slopes.T, slopes @ left
        else:
            damping *= 8.0
            if damping > 1e4:
                break
        damped = curvature.copy()
        damped.flat[:: len(_AT) + 1] += damping * (curvature.diagonal() + 1e-9)
        step = np.asarray(-np.linalg.solve(damped, down), dtype=np.float64)
    return number, course_, best
