"""The quantity that shows why an interval is listed, as a curve over the clip with its limit.

A kind of error names the function that computes it in :attr:`KindInfo.quantity`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import KindSearch
from twistcore.detection.guarded import one_sentence
from twistcore.detection.interval import Interval
from twistcore.errors import TwistError
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notation import DistinctFrames, without_held
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

ENDS = 4  # frames at both ends of a clip in which no step is looked for


@dataclass(frozen=True, eq=False)
class Quantity:
    """The curve that shows why an interval is listed.

    Attributes
    ----------
    label
        The name of the quantity, with the joint.
    values
        Shape (frames,), NaN where the quantity is undefined.
    limit
        The value beyond which an interval is listed, shape (frames,); None if there is no limit.
    size
        The number of the interval that is listed, in the same unit.
    unit
        The unit after a number, with a space if one belongs there.
    """

    label: str
    values: Array
    limit: Array | None = None
    size: float | None = None
    unit: str = "°"


CurveOf = Callable[[KindSearch, Interval], Quantity | None]


def quantity_of(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the curve of an interval; None if its kind declares none, or if it has none here.

    Raises TwistError if the kind's function cannot be loaded, fails, or returns a curve of the
    wrong length.
    """
    module, _, name = interval.kind.info.quantity.partition(":")
    if not module:
        return None
    with one_sentence(f"the curve of the kind {interval.kind.value!r} failed"):
        curve_of: CurveOf = getattr(import_module(module), name)
        found = curve_of(search, interval)
        expected = (search.motion.frames,)
        for curve in (found.values, found.limit) if found is not None else ():
            if curve is not None and np.shape(curve) != expected:
                raise TwistError(f"expected {expected[0]} values, found {np.shape(curve)}")
    return found


@dataclass(frozen=True, eq=False)
class OwnFrames:
    """A motion without held frames, and the way from its frames to the frames of the clip.

    Attributes
    ----------
    motion
        The motion without held frames, or the motion itself if there are none.
    at
        The frame of `motion` that each frame of the clip shows, shape (frames of the clip,).
    """

    motion: Motion
    at: NDArray[np.intp]

    @classmethod
    def of(cls, motion: Motion, held: DistinctFrames | None = None) -> OwnFrames:
        """Return the distinct frames of a motion; `held`: other frames that determine it."""
        held = held or without_held(motion)
        frames = np.arange(motion.frames)
        if held is None:
            return cls(motion, frames)
        if held.even:  # a frame between two keys belongs to the change into the second one
            at = np.searchsorted(held.first, frames, side="left")
        else:
            at = np.searchsorted(held.first, frames, side="right") - 1
        return cls(held.motion, np.clip(at, 0, len(held.first) - 1))

    def span(self, interval: Interval) -> tuple[int, int]:
        """Return the frames [start, stop) of `motion` that an interval of the clip contains."""
        inside = self.at[interval.start : interval.stop]
        return int(inside[0]), int(inside[-1]) + 1

    def examined(
        self, values: Array, interval: Interval, *, around: int = 0, ends: int = 0
    ) -> Array:
        """Return values of `motion` in the clip's frames, NaN where no search looks for errors.

        These are the frames at most `around` frames from a cut, and the given number of frames at
        both ends of the clip, except for frames of the interval.
        """
        cut, frames = find_cuts(self.motion), self.motion.frames
        left_out = cut.copy()
        for k in range(1, around + 1):
            left_out[:-k] |= cut[k:]
            left_out[k:] |= cut[:-k]
        left_out[: ends + 1] = left_out[frames - ends :] = True
        left_out[slice(*self.span(interval))] = False
        return np.where(left_out, np.nan, values)[self.at]

    def level(self, value: float) -> Array:
        """Return a constant curve over the clip."""
        return np.full(len(self.at), value)
