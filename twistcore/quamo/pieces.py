"""Split a clip at its cuts, across which motion must not be smoothed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cuts import find_cuts
from twistcore.skeleton.motion import Motion


def capture_start_frames_after(motion: Motion, first: int) -> NDArray[np.int64]:
    """Return the frames after `first` at which a new capture begins, in ascending order.

    These are the frames from :func:`find_cuts <twistcore.detection.cuts.find_cuts>`, which include
    a rest pose at the end.
    """
    return first + 1 + np.flatnonzero(find_cuts(motion)[first + 1 :])


def frame_ranges_between_cuts(motion: Motion, first: int) -> tuple[tuple[int, int], ...]:
    """Split a motion at its cuts, and return the frames [start, stop) of each capture.

    Frames before `first` are ignored. Most clips have only one capture. A single frame next to a
    cut is not a capture, and neither is a rest pose that is held until the end of the clip.
    """
    borders = [first, *capture_start_frames_after(motion, first).tolist(), motion.frames]
    found = list(pairwise(borders))
    if len(found) == 1:
        return tuple(found)
    if _held(motion.sliced(*found[-1])):
        found.pop()
    return tuple((start, stop) for start, stop in found if stop - start > 1)


def _held(part: Motion) -> bool:
    return not any((x[1:] != x[:-1]).any() for x in (part.rotations, part.positions))
