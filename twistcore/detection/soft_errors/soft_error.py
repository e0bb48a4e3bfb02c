"""A soft error: a twist error that begins and ends gradually instead of with a jump.

The signals are the twist increments x of the parent P and y of the child C of a chain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

SEEN = float(np.radians(0.05))  # a smaller offset is ignored
# In an error, both joints rotate. If the smaller rotation is below the share SHOWN_IN_BOTH of the
# larger one, only one joint moved. This is decided where the error is steepest, because a soft
# onset is lost in natural motion, and only if the steps of the error are larger than the natural
# jitter by the factor CLEAR.
SHOWN_IN_BOTH, CLEAR = 0.35, 30.0
# The other joint rotates back if its changes of pace cancel at least the share TURNED_BACK of the
# silent joint's, or if the sum of both rotations is at most LEFT_OVER times its own rotation.
TURNED_BACK, LEFT_OVER = 0.5, 1.5
AROUND = 8  # number of frames on either side that show the natural motion
LEAST_BEHIND = 2.0  # an error at an end of the clip must be shorter than the rest by this factor


@dataclass(frozen=True, eq=False)
class SoftError:
    """A twist error that begins and ends gradually, from frame `start` on.

    Attributes
    ----------
    row
        The row of the chain whose parent has the error.
    offset
        The error in each frame, radians, shape (frames,).
    gain
        The log-likelihood ratio of the error over natural motion, in nats.
    sigma
        The standard deviation of the correction, radians.
    followed
        The fraction of the error by which the child rotates back.
    unsure
        True if the error is reported but not corrected.
    silent
        True if the error appears at a joint that never twists elsewhere in the clip.
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
        """The frame after the error's last frame."""
        return self.start + len(self.offset)

    def trimmed(self) -> SoftError:
        """Return the error without frames at both ends in which it is negligible."""
        seen = np.flatnonzero(np.abs(self.offset) > SEEN)
        if not len(seen):
            return self
        first, last = int(seen[0]), int(seen[-1]) + 1
        return replace(self, start=self.start + first, offset=self.offset[first:last])


def mark_error_if_unsure(
    error: SoftError, x: Array, y: Array, cut: NDArray[np.bool_], side: int = 0, *, last: bool
) -> SoftError:
    """Return a soft error, marked as unsure if it should not be corrected.

    An error is unsure if only one joint moved, or if the frames outside the error may be wrong
    instead.

    Parameters
    ----------
    error
        The error.
    x, y
        The captured twist increments of the error's chain, shape (frames,).
    cut
        Mask of the clip's cuts, shape (frames,).
    side
        1 if the parent is silent (never twists elsewhere), −1 if the child is silent, 0 if neither
        is.
    last
        True if no other chain begins at the child. An error that only the child shows may then
        belong to a joint below it.
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
    """Return True if the chain's other joint rotates back when a silent joint rotates.

    The rotations are compared in frames [start, stop). If the silent joint was only at rest, the
    other joint does not rotate back. `own` and `other` contain the twist increments of the silent
    joint and of the other joint. If these increments do not cancel, their changes from frame to
    frame are compared.
    """
    at = slice(max(start, 1), stop + 1)
    if np.abs(own + other)[at].sum() <= LEFT_OVER * np.abs(other)[at].sum():
        return True
    changes, others = (np.diff(v[max(at.start - 1, 0) : at.stop + 1]) for v in (own, other))
    return bool(-(changes @ others) >= TURNED_BACK * (changes @ changes))


def _shown_in_both(error: SoftError, x: Array, y: Array, if_unclear: bool) -> bool:
    """Return True if both joints of the chain rotate in an error, or `if_unclear` if unknown."""
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
