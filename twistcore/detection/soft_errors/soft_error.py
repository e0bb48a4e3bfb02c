"""An error that sets in softly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SEEN = float(np.radians(0.05))  # a smaller offset counts as none
# Both joints turn in an error. If one turns by less than this share of the other, and that is clear
# relative to its natural motion, one joint moved alone. This is checked where the error is
# steepest, because a soft onset is lost in natural motion.
SHOWN_IN_BOTH, CLEAR = 0.35, 30.0
# The other joint turns back at least this share of a silent joint's turn where it is steep; and at
# most this share of the other joint's turn remains after the correction.
TURNED_BACK, LEFT_OVER = 0.5, 1.5
AROUND = 8  # frames nearby that show natural motion
LEAST_BEHIND = 2.0  # an error at an end of the clip must be so many times shorter than the rest


@dataclass(frozen=True, eq=False)
class SoftError:
    """Twist error of P of the chain in `row`, from frame `start` on, (frames,), radians.

    gain: nats against natural motion; sigma: of its correction, radians; followed: the share of it
    by which C turns back; unsure: True if it is only shown; silent: True if a joint that is silent
    elsewhere shows it.
    """

    row: int
    start: int
    offset: Array
    gain: float
    sigma: float
    followed: float = 1.0
    unsure: bool = False
    silent: bool = False

    @property
    def stop(self) -> int:
        """The frame after the last."""
        return self.start + len(self.offset)

    def trimmed(self) -> SoftError:
        """Return the error without frames at its ends in which it is negligible."""
        seen = np.flatnonzero(np.abs(self.offset) > SEEN)
        if not len(seen):
            return self
        first, last = int(seen[0]), int(seen[-1]) + 1
        return replace(self, start=self.start + first, offset=self.offset[first:last])


def judged(
    error: SoftError, x: Array, y: Array, cut: NDArray[np.bool_], side: int = 0, *, last: bool
) -> SoftError:
    """Return the error, unsure if one joint moved alone, or if either side may be the wrong one.

    x, y: increments of its chain as captured, (frames,); cut: cuts of the clip; side: 1 if a silent
    P shows it, −1 if a silent C does, 0 if neither; last: True if no chain continues from C, so
    that a C that shows it alone may show an error further down.
    """
    frames = len(x)
    at_end = error.start == 0 or error.stop == frames
    at_end = at_end or bool(cut[[error.start, min(error.stop, frames - 1)]].any())
    either = at_end and LEAST_BEHIND * len(error.offset) > frames - len(error.offset)
    alone = not _shown_in_both(error, x, y, not (last and side < 0))
    if side and not alone:
        own, other = (x, y) if side > 0 else (y, x)
        alone = not _answered(own, other, error.start, error.stop)
    return replace(error, unsure=either or alone)


def _answered(own: Array, other: Array, start: int, stop: int) -> bool:
    """True if the other joint turns back the turn of a silent joint in [start, stop).

    A joint that only rested turns by itself, and the other does not respond: neither with its whole
    turn nor, if that is lost in natural motion, with the changes of its pace.
    """
    at = slice(max(start, 1), stop + 1)
    if np.abs(own + other)[at].sum() <= LEFT_OVER * np.abs(other)[at].sum():
        return True
    changes, others = (np.diff(v[max(at.start - 1, 0) : at.stop + 1]) for v in (own, other))
    return bool(-(changes @ others) >= TURNED_BACK * (changes @ changes))


def _shown_in_both(error: SoftError, x: Array, y: Array, if_unclear: bool) -> bool:
    """True if x turns with the error and y against it; `if_unclear` if that cannot be decided."""
    course = np.zeros(len(x) + 1)
    course[error.start : error.stop] = error.offset
    steps = np.diff(course, prepend=course[0])[: len(x)]
    steepest = int(np.abs(steps[1:]).argmax()) + 1
    low, high = max(steepest - AROUND, 1), min(steepest + AROUND + 1, len(x))
    edge = slice(max(steepest - 1, 1), steepest + 2)
    turned = []
    for own in (x, y):
        natural = own - steps if own is x else own + steps
        by_nature = median(natural[low:high])
        unrest = median(np.abs(natural[low:high] - by_nature))
        if abs(steps[edge].sum()) < CLEAR * max(unrest, SEEN):
            return if_unclear
        turned.append(abs(float(own[edge].sum()) - by_nature * len(own[edge])))
    return min(turned) >= SHOWN_IN_BOTH * max(turned)
