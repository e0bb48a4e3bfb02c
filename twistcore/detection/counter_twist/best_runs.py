"""Choose the runs (neighbouring chains that all have an error) that explain each frame best."""

from __future__ import annotations

import numpy as np

from twistcore.detection.prediction import Index
from twistcore.skeleton.rotation import Array

SAME = 1e-9  # nats; smaller differences are ignored


def best_runs(frame: Index, first: Index, last: Index, gain: Array, lone: float) -> Index:
    """Return the indices of the runs of chains with the highest total gain in each frame.

    A run is a series of neighbouring chains that all have an error. No joint may belong to two
    chosen runs. Among several runs with equal gain, the shortest is chosen, and among equally short
    runs the one nearer to the tip of the limb.

    Parameters
    ----------
    frame
        The frame of each run, shape (runs,).
    first, last
        The first and the last joint that each run changes, shape (runs,).
    gain
        The gain of each run in nats, shape (runs,).
    lone
        If no run in a frame has a gain above 0, the best run is chosen if its gain exceeds −lone.
    """
    worth = np.flatnonzero(gain > SAME)
    together = worth[_disjoint(frame[worth], first[worth], last[worth], gain[worth])]
    rest = np.flatnonzero((gain > SAME - lone) & ~np.isin(frame, frame[worth]))
    rest = rest[np.lexsort((first[rest], (first - last)[rest], gain[rest], frame[rest]))]
    highest = np.ones(len(rest), dtype=bool)
    highest[:-1] = frame[rest[1:]] != frame[rest[:-1]]
    return np.concatenate([together, rest[highest]])


def _disjoint(frame: Index, first: Index, last: Index, gain: Array) -> list[int]:
    """Return the indices of runs that share no joint and have the highest total gain.

    Each group of overlapping runs is solved by dynamic programming, from the tip of the limb to its
    root. All gains must be above 0.
    """
    many = last.max(initial=0) + 1
    order = np.lexsort((-last, frame * many + first))
    runs = frame[order] * many
    beyond_ = np.searchsorted(runs + first[order], runs + last[order], side="right")
    places = np.arange(1, len(order) + 1)
    ends = places[np.maximum.accumulate(beyond_) == places].tolist()
    index, gains, beyond = order.tolist(), gain[order].tolist(), beyond_.tolist()
    chosen: list[int] = []
    value = [0.0] * (len(order) + 1)  # highest value of the group's runs from here on
    taken = [False] * len(order)
    begin = 0
    for end in ends:
        for k in range(end - 1, begin - 1, -1):
            with_it = gains[k] + value[beyond[k]]
            taken[k] = with_it > value[k + 1] + SAME
            value[k] = with_it if taken[k] else value[k + 1]
        k = begin
        while k < end:
            if taken[k]:
                chosen.append(index[k])
            k = beyond[k] if taken[k] else k + 1
        begin = end
    return chosen
