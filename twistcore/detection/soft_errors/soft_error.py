"""An error that sets in softly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SEEN = float(np.radians(0.05))  # an offset below is none
# Both joints turn in an error. Where one turns by less than this share of the other, and that is
# clear beside what it does by nature, one joint moved alone. It is looked for where the error is
# steepest; a soft onset is lost in natural motion.
SHOWN_IN_BOTH, CLEAR = 0.35, 30.0
# Of what a silent joint turns the other one turns at least so much back, where it is steep; and
# of what that one turns no more than this is left with the error undone.
TURNED_BACK, LEFT_OVER = 0.5, 1.5
AROUND = 8  # frames around that tell natural motion
LEAST_BEHIND = 2.0  # times as long as an error at an end of the clip must all else be


@dataclass(frozen=True, eq=False)
class SoftError:
    """Twist error of P of the chain in `row`, from frame `start` on, (frames,), radians.

    gain: nats against natural motion; sigma: of its repair, radians; followed: the share of it by
    which C turns back; unsure: to be shown only; silent: a joint that is silent elsewhere tells it.
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
        """The frame behind it."""
        return self.start + len(self.offset)

    def trimmed(self) -> SoftError:
        """The same without frames at its ends in which it is none."""
        seen = np.flatnonzero(np.abs(self.offset) > SEEN)
        if not len(seen):
            return self
        first, last = int(seen[0]), int(seen[-1]) + 1
        return replace(self, start=self.start + first, offset=self.offset[first:last])


def judged(
    error: SoftError, x: Array, y: Array, cut: NDArray[np.bool_], side: int = 0, *, last: bool
) -> SoftError:
    """The error, unsure where one joint moved alone, or where either side may be the wrong one.

    x, y: increments of its chain as captured, (frames,); cut: where a clip is cut; side: 1 where a
    silent P tells it, −1 where a silent C does, 0 where neither; last: no chain goes on from C, so
    that a C that tells it by itself may tell of an error beyond.
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
    """Whether the other joint turns back what a silent one turns in [start, stop).

    A joint that only rested turns by itself, and the other knows nothing of it: neither with what
    it turns in all, nor, where that is lost in natural motion, with the changes of its pace.
    """
    at = slice(max(start, 1), stop + 1)
    if np.abs(own + other)[at].sum() <= LEFT_OVER * np.abs(other)[at].sum():
        return True
    changes, others = (np.diff(v[max(at.start - 1, 0) : at.stop + 1]) for v in (own, other))
    return bool(-(changes @ others) >= TURNED_BACK * (changes @ changes))


def _shown_in_both(error: SoftError, x: Array, y: Array, if_unclear: bool) -> bool:
    """Whether x turns with the error and y against it; `if_unclear` where it cannot be told."""
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
