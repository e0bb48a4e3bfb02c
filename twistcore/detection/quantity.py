"""Curves that show why an interval is listed, such as the flexion of a knee, with their limits.

The function that computes the curve for a kind of error is named in :attr:`KindInfo.quantity`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import KindSearch
from twistcore.detection.guarded import exceptions_as_twist_error
from twistcore.detection.interval import Interval
from twistcore.errors import TwistError
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notation import DistinctFrames, without_repeated_frames
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

ENDS = 4  # number of frames at each end of a clip in which steps are not searched for


@dataclass(frozen=True, eq=False)
class Quantity:
    """The curve that shows why an interval is listed.

    Attributes
    ----------
    label
        The title of the curve: the quantity and the joint.
    values
        The quantity in each frame, shape (frames,), NaN where it is undefined.
    limit
        The value beyond which an interval is listed, shape (frames,); None if there is no limit.
    size
        The size of the interval as shown in tables, in the same unit; None if there is none.
    unit
        The unit to append to a number, with a leading space if needed.
    """

    label: str
    values: Array
    limit: Array | None = None
    size: float | None = None
    unit: str = "°"


CurveOf = Callable[[KindSearch, Interval], Quantity | None]


def evidence_curve_of_interval(search: KindSearch, interval: Interval) -> Quantity | None:
    """Return the curve that shows why an interval is listed, or None if there is no such curve.

    Raises TwistError if the kind's function for the curve cannot be loaded, fails, or returns a
    curve of the wrong length.
    """
    module, _, name = interval.kind.info.quantity.partition(":")
    if not module:
        return None
    with exceptions_as_twist_error(
        f"the curve for the error kind {interval.kind.value!r} cannot be computed"
    ):
        curve_of: CurveOf = getattr(import_module(module), name)
        found = curve_of(search, interval)
        expected = (search.motion.frames,)
        for curve in (found.values, found.limit) if found is not None else ():
            if curve is not None and np.shape(curve) != expected:
                raise TwistError(f"expected {expected[0]} values, found {np.shape(curve)}")
    return found


@dataclass(frozen=True, eq=False)
class OwnFrames:
    """A motion without its held (repeated) frames, and a map from the clip's frames to its frames.

    Attributes
    ----------
    motion
        The motion without held frames, or the motion itself if there are none.
    at
        For each frame of the clip, the index of the corresponding frame of `motion`, shape (frames
        of the clip,).
    """

    motion: Motion
    at: NDArray[np.intp]

    @classmethod
    def of(cls, motion: Motion, held: DistinctFrames | None = None) -> OwnFrames:
        """Return a motion without its held frames.

        `held` contains the frames to keep. By default, these are all frames that do not repeat the
        previous frame.
        """
        held = held or without_repeated_frames(motion)
        frames = np.arange(motion.frames)
        if held is None:
            return cls(motion, frames)
        if held.even:  # a frame between two keys belongs to the change to the second key
            at = np.searchsorted(held.first, frames, side="left")
        else:
            at = np.searchsorted(held.first, frames, side="right") - 1
        return cls(held.motion, np.clip(at, 0, len(held.first) - 1))

    def span(self, interval: Interval) -> tuple[int, int]:
        """Return the frames [start, stop) of `motion` that correspond to an interval."""
        inside = self.at[interval.start : interval.stop]
        return int(inside[0]), int(inside[-1]) + 1

    def examined(
        self, values: Array, interval: Interval, *, around: int = 0, ends: int = 0
    ) -> Array:
        """Expand values per frame of `motion` to the clip's frames, with NaN in ignored frames.

        The first and last `ends` frames of the clip and the frames at most `around` frames from a
        cut are ignored. Frames of the interval never become NaN.
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
        """Return a curve with a constant value in all frames of the clip."""
        return np.full(len(self.at), value)
