"""The runs of neighbouring chains with errors that together explain a frame best."""

from __future__ import annotations

import numpy as np

from twistcore.detection.prediction import Index
from twistcore.skeleton.rotation import Array

SAME = 1e-9  # nats; smaller differences decide nothing


def best_runs(frame: Index, first: Index, last: Index, gain: Array, lone: float) -> Index:
    """Return the indices of the runs that gain most together, in every frame.

    A run changes the joints first…last, and chosen runs share no joint. If no run gains more than
    0, the best one is chosen if it gains more than −lone. Of equally long equals the one nearer to
    the tip wins, of equals from the same joint the shortest. Arrays (runs,), gain in nats.
    """
    worth = np.flatnonzero(gain > SAME)
    together = worth[_disjoint(frame[worth], first[worth], last[worth], gain[worth])]
    rest = np.flatnonzero((gain > SAME - lone) & ~np.isin(frame, frame[worth]))
    rest = rest[np.lexsort((first[rest], (first - last)[rest], gain[rest], frame[rest]))]
    highest = np.ones(len(rest), dtype=bool)
    highest[:-1] = frame[rest[1:]] != frame[rest[:-1]]
    return np.concatenate([together, rest[highest]])


def _disjoint(frame: Index, first: Index, last: Index, gain: Array) -> list[int]:
    """Return runs with gain > 0 and no joint in common that gain most together.

    Dynamic programming, from the tips to the roots, over each group of runs that overlap.
    """
    many = last.max(initial=0) + 1
    order = np.lexsort((-last, frame * many + first))
    runs = frame[order] * many
    beyond_ = np.searchsorted(runs + first[order], runs + last[order], side="right")
    places = np.arange(1, len(order) + 1)
    ends = places[np.maximum.accumulate(beyond_) == places].tolist()
    index, gains, beyond = order.tolist(), gain[order].tolist(), beyond_.tolist()
    chosen: list[int] = []
    value = [0.0] * (len(order) + 1)  # of a group's runs from here on; 0 after it
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
