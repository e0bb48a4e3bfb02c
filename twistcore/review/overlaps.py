"""Find pairs of overlapping intervals that may describe the same error."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence

from twistcore.detection import Interval


def overlapping_interval_pairs(
    first: Sequence[Interval], second: Sequence[Interval]
) -> Iterator[tuple[int, int, int]]:
    """Yield (−overlap, k, n) for each pair of overlapping intervals that may be the same error.

    The overlap is a number of frames, k is the index in `first`, and n is the index in `second`.
    Sorting the results puts the largest overlaps first. The time is nearly linear in the number of
    intervals.
    """
    by_start = sorted(range(len(second)), key=lambda n: second[n].start)
    starts = [second[n].start for n in by_start]
    longest = max((i.frames for i in second), default=0)
    for k, interval in enumerate(first):
        start, stop = interval.start, interval.stop
        for at in range(bisect_left(starts, start - longest), bisect_left(starts, stop)):
            n = by_start[at]
            common = min(stop, second[n].stop) - max(start, second[n].start)
            if common > 0 and second[n].may_be_same(interval):
                yield -common, k, n
