"""A first guess for an interval made by hand."""

from __future__ import annotations

import numpy as np

from twistcore.detection import Interval
from twistcore.review.model import constant, off_line
from twistcore.rotation import Array
from twistcore.signals import TwistSignals

_REACH = 0.5  # seconds to either side in which the edges are looked for
_HALF = 0.05  # seconds to either side where there are none
_FAINT = np.radians(1.0)


def proposed_interval(chain: str, signals: TwistSignals, frame: int, fps: float) -> Interval:
    """An interval round a frame: between the strongest counter-rotations before and behind it.

    Where there is none of 1° or more, 0.1 s around the frame. Its offset is the level of θp
    inside against the line between its two neighbours outside.
    """
    frames = len(signals.theta_p)
    reach, half = max(2, round(_REACH * fps)), max(1, round(_HALF * fps))
    first, last = max(1, frame - reach), min(frames, frame + reach + 1)
    start = _strongest(signals.strength, first, frame + 1)
    stop = _strongest(signals.strength, max(frame, start) + 1, last)
    if start < 0:
        start = max(0, (stop if stop >= 0 else frame + half + 1) - 2 * half - 1)
        start = min(start, frame)
    if stop < 0:
        stop = min(frames, max(frame + 1, start + 2 * half + 1))
    level = float(np.median(off_line(signals.theta_p, start, stop)))
    return constant(chain, start, stop, level)


def _strongest(strength: Array, first: int, last: int) -> int:
    if last <= first:
        return -1
    at = first + int(np.argmax(strength[first:last]))
    return at if strength[at] >= _FAINT else -1
