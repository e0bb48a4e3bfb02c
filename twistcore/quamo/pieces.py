"""Split a clip at its cuts into captures: two-way methods must not look across a cut."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cuts import find_cuts
from twistcore.skeleton.motion import Motion


def cuts_behind(motion: Motion, first: int) -> NDArray[np.int64]:
    """Return frames after `first` that start something new: cuts, and a rest pose at the end.

    :func:`find_cuts <twistcore.detection.cuts.find_cuts>`, ascending.
    """
    return first + 1 + np.flatnonzero(find_cuts(motion)[first + 1 :])


def pieces(motion: Motion, first: int) -> tuple[tuple[int, int], ...]:
    """Return the captures [start, stop) in order, from frame `first` on; usually there is one.

    A single frame next to a cut is not a capture, nor is a rest pose held to the clip's end.
    """
    borders = [first, *cuts_behind(motion, first).tolist(), motion.frames]
    found = list(pairwise(borders))
    if len(found) == 1:
        return tuple(found)
    if _held(motion.sliced(*found[-1])):
        found.pop()
    return tuple((start, stop) for start, stop in found if stop - start > 1)


def _held(part: Motion) -> bool:
    return not any((x[1:] != x[:-1]).any() for x in (part.rotations, part.positions))
