"""Fit a softened level: a constant error that begins and ends gradually.

Gaps in captures are filled with straight lines or splines, and captures are low-pass filtered
before they are published. A constant error of the solver then begins and ends with a ramp or with a
filtered step. Four numbers describe its course over time: the error δ, the frames in the middle of
the first and of the last transition, and the duration of a transition.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from twistcore.detection.soft_errors.departures import Values
from twistcore.skeleton.rotation import Array

# A function for the shape of a transition from 0 to 1 around time 0.
Kernel: TypeAlias = Callable[[Array], Array]
# A linear function that returns the departures (n, …) of courses (n, frames).
Departures: TypeAlias = Callable[[Array], Values]
# A function that returns the weighted residuals (n, …) after the removal of courses with given
# departures (n, …), and the derivatives of the residuals with respect to the departures. The second
# argument contains the factors by which the scales are widened, (n, 1).
Residuals: TypeAlias = Callable[[Values, Array], tuple[Values, Values]]

STEEPEST = 0.5  # shortest duration of a transition in frames
_DECAY = np.pi * np.sqrt(2.0)  # decay of the filtered step per period
FAR = 4.0  # periods from a filtered step after which it has its final value
_AT = np.array([np.radians(2.0), 1.0, 1.0, 1.0])  # units of the four numbers in the fit
_STEPS = 1e-3  # relative change of a number for its derivative
# Maximum number of steps before the scales are narrowed, and the smallest gain of a step in nats.
MOST_STEPS, ENOUGH = 12, 0.05
ROUGHLY = 0.5  # smallest gain of a step while the scales are widened, in nats
HOPELESS = 5.0  # a fit is abandoned if it needs more than this many of its last gains to be best
NARROWER = 5.0  # factor by which the scales are narrowed


class Level(NamedTuple):
    """The four numbers that describe a softened level.

    Attributes
    ----------
    size
        δ in radians.
    onset, end
        The frames in the middle of the first and the last transition.
    width
        The duration of a transition, in frames.
    """

    size: float
    onset: float
    end: float
    width: float


def linear_unit_ramp(t: Array) -> Array:
    """Return a linear transition from 0 at t = −½ to 1 at t = ½."""
    return np.asarray(np.minimum(np.maximum(t + 0.5, 0.0), 1.0))


def butterworth_filtered_unit_step(t: Array) -> Array:
    """Return a unit step at t = 0 after a second-order Butterworth filter in both directions.

    `t` is in periods of the cut-off frequency. The step has a closed form, because the gain of the
    filter at a frequency f is 1 / (1 + (f / cut-off)⁴). More than FAR periods from the step, the
    difference from 0 or 1 is below 1e-8 and is ignored.
    """
    away = np.abs(t)
    out = np.array(t >= 0.0, dtype=np.float64)
    near = np.asarray(away < FAR)
    decay = _DECAY * away[near]
    rest = 0.5 * np.exp(-decay) * np.cos(decay)
    out[near] = np.where(t[near] < 0.0, rest, 1.0 - rest)
    return out


KERNELS: tuple[Kernel, ...] = (linear_unit_ramp, butterworth_filtered_unit_step)


def softened_level_curves(levels: Array, kernel: Kernel, frames: int) -> Array:
    """Return the values of n softened levels in each frame, in radians, (n, frames).

    `levels` contains the four numbers of each :class:`Level`, shape (n, 4), and `kernel` is the
    shape of the transitions.
    """
    size, onset, end, width = levels.T[..., None]
    edges = np.array([onset, end])
    rises, falls = kernel((np.arange(frames) - edges) / np.maximum(width, STEEPEST))
    return np.asarray(size * (rises - falls))


def guess_softened_level(offset: Array) -> Level | None:
    """Return a softened level that resembles an offset, or None if the offset is 0 or short.

    `offset` is in radians, shape (frames,).
    """
    size = np.abs(offset)
    top = int(size.argmax())
    if size[top] <= 0.0 or len(offset) < 3:
        return None
    half = np.flatnonzero(size > 0.5 * size[top])
    low, high = (np.flatnonzero(size > share * size[top]) for share in (0.2, 0.8))
    width = 0.5 * ((high[0] - low[0]) + (low[-1] - high[-1])) / 0.6
    return Level(float(offset[top]), half[0] - 0.5, half[-1] + 0.5, max(width, 2.0))


def fit_softened_levels(
    starts: Sequence[tuple[Level, Kernel, float]],
    frames: int,
    departures: Departures,
    residuals: Residuals,
) -> list[tuple[Array, float]]:
    """Fit a softened level from each start. Return its course and the sum of squared residuals.

    Each start consists of a level, a kernel and the factor `coarsest`, by which the scales are
    widened at first. A course contains the level's value in each frame, radians, shape (frames,).

    The fit uses Levenberg-Marquardt steps, for all starts together. The derivatives of the courses
    with respect to the four numbers are computed numerically. Far from the best course, all
    residuals have their largest value, and no step improves the fit. The scales are therefore
    widened at first and then narrowed step by step. A fit that is far behind the best one is
    abandoned.
    """
    descents = [_Descent(*start, frames) for start in starts]
    going = descents
    while going:
        tried = np.array([d.number + d.step for d in going])
        here = _courses(tried, going, frames)
        left, changes = residuals(departures(here), np.array([[d.wider] for d in going]))
        values = np.einsum("mn,mn->m", left, left).tolist()
        further = [k for k, d in enumerate(going) if d.accept(tried[k], here[k], values[k])]
        if further:
            _measure_slopes(
                [going[k] for k in further], departures, left[further], changes[further]
            )
        leader = min((d.best for d in descents if d.wider <= 1.0), default=np.inf)
        going = [d for d in going if not (d.is_done() or d.is_behind(leader))]
        if going:
            damped = np.array([d.damped() for d in going])
            steps = np.linalg.solve(damped, np.array([d.down for d in going])[..., None])
            for d, step in zip(going, steps[..., 0], strict=True):
                d.step = -step if d.begun else d.step
    return [(d.course, d.best) for d in descents]


class _Descent:
    """The state of fitting one softened level.

    `number` contains the four numbers of the level in units of `_AT`.
    """

    def __init__(self, start: Level, kernel: Kernel, coarsest: float, frames: int) -> None:
        self.frames = frames
        self.kernel, self.wider = kernel, max(coarsest, 1.0)
        self.number: Array = np.array(start) / _AT
        self._begin()

    def _begin(self) -> None:
        """Begin or restart the fit of a level with the current scales."""
        self.left_steps, self.damping = MOST_STEPS, 1e-2
        self.best = self.gained = np.inf
        self.course: Array = np.zeros(self.frames)
        self.step: Array = np.zeros(len(_AT))
        self.curvature, self.down = np.zeros((len(_AT), len(_AT))), np.zeros(len(_AT))
        self.begun = self.ended = False

    def accept(self, number: Array, course: Array, left: float) -> bool:
        """Accept new numbers of the level if they lower the sum of the squared residuals.

        `course` is the course of the level with the new numbers, and `left` is the sum. Return True
        if the fit continues from the new numbers, so that the derivatives at these numbers are
        needed.
        """
        self.begun = True
        self.left_steps -= 1
        if left < self.best:
            self.gained = gained = self.best - left
            self.number, self.best, self.course = number, left, course
            self.damping = max(0.2 * self.damping, 1e-6)
            self.ended = gained < (ENOUGH if self.wider <= 1.0 else ROUGHLY) or not self.left_steps
            return not self.ended
        self.damping *= 8.0
        self.ended = self.damping > 1e4 or not self.left_steps
        return False

    def is_done(self) -> bool:
        """Return True if the fit has ended with the original scales.

        If the fit has ended with widened scales, narrow the scales and restart it.
        """
        if self.ended and self.wider > 1.0:
            self.wider = max(1.0, self.wider / NARROWER)
            self._begin()
        return self.ended

    def is_behind(self, leader: float) -> bool:
        """Return True if the fit is unlikely to reach `leader`, the best value of all fits."""
        return self.wider <= 1.0 and self.best - leader > HOPELESS * self.gained

    def damped(self) -> Array:
        """Return the damped curvature matrix for the next step.

        Before the first step, the matrix is the identity.
        """
        if not self.begun:
            return np.eye(len(_AT))
        damped = self.curvature.copy()
        damped.flat[:: len(_AT) + 1] += self.damping * (self.curvature.diagonal() + 1e-9)
        return damped


def _courses(numbers: Array, of: Sequence[_Descent], frames: int) -> Array:
    """Return the values of softened levels in each frame, in radians, (n, frames).

    `numbers` contains the four numbers of each level in units of `_AT`, shape (n, 4), and `of`
    contains the fit of each level, which specifies the kernel.
    """
    out = np.empty((len(numbers), frames))
    kernels = [d.kernel for d in of]
    for kernel in dict.fromkeys(kernels):
        at = [k for k, own in enumerate(kernels) if own is kernel]
        out[at] = softened_level_curves(numbers[at] * _AT, kernel, frames)
    return out


def _measure_slopes(
    of: Sequence[_Descent], departures: Departures, left: Values, changes: Values
) -> None:
    """Compute numerically the derivatives that each fit needs for its next step.

    `left` contains the residuals of each fit, and `changes` their derivatives with respect to the
    departures, both (n, …). The results are stored in the fits.
    """
    many = len(_AT)
    numbers = np.array([d.number for d in of])
    by = _STEPS * np.maximum(np.abs(numbers), 1.0)
    moved = (numbers[:, None] + by[:, None] * np.eye(many)).reshape(-1, many)
    here = np.array([d.course for d in of])
    courses = _courses(moved, [d for d in of for _ in range(many)], here.shape[1])
    courses -= np.repeat(here, many, axis=0)
    courses /= by.reshape(-1, 1)
    slopes = departures(courses).reshape(len(of), many, -1) * changes[:, None]
    curvature = np.asarray(slopes @ slopes.swapaxes(1, 2), dtype=np.float64)
    down = np.asarray(slopes @ left[..., None], dtype=np.float64)[..., 0]
    for k, d in enumerate(of):
        d.curvature, d.down = curvature[k], down[k]
