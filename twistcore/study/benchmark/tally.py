"""Counts and sums as integers, so that results do not depend on the order or the machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from twistcore.skeleton.rotation import Array
from twistcore.synthesis import SUCCESS

WORSE = 0.5  # degrees
MICRO = 1_000_000  # angles are summed in millionths of a degree


@dataclass(frozen=True)
class Tally:
    """Counts and sums over any number of passes. Angles are in µ°, their squares in µ°².

    Attributes
    ----------
    frames
        Number of error frames. The next fields are sums of their error before and after, and the
        numbers of frames that are corrected and that become worse by more than half a degree.
    pairs
        Clean (joint, frame) pairs of all chains.
    damaged
        Pairs that the method changes by more than 1°, unlike in the clean clip.
    damage
        Sum of the changes of damaged pairs.
    natural, natural_change
        Number of pairs that the method changes in the same way in the clean clip, and the sum of
        these changes.
    target_pairs, target_damaged
        `pairs` and `damaged` for the two joints of the injected chain only.
    truths, found, matched
        Numbers of true, found and matched intervals.
    alarms
        Number of intervals found in the clean clip.
    """

    passes: int = 0
    frames: int = 0
    before: int = 0
    after: int = 0
    before_squared: int = 0
    after_squared: int = 0
    repaired: int = 0
    worse: int = 0
    pairs: int = 0
    damaged: int = 0
    damage: int = 0
    natural: int = 0
    natural_change: int = 0
    target_pairs: int = 0
    target_damaged: int = 0
    truths: int = 0
    found: int = 0
    matched: int = 0
    alarms: int = 0

    def __add__(self, other: Tally) -> Tally:
        return Tally(*(a + b for a, b in zip(self.values(), other.values(), strict=True)))

    def values(self) -> tuple[int, ...]:
        """Return the numbers of the tally, in the order of the fields."""
        return tuple(vars(self).values())


@dataclass(frozen=True, order=True)
class Key:
    """The key of a tally. `audited` is True if the target chain has no natural event."""

    protocol: str
    method: str
    side: str
    segment: str
    audited: bool


Tallies: TypeAlias = dict[Key, Tally]


def add_tallies(total: Tallies, more: Mapping[Key, Tally]) -> None:
    """Add `more` to `total` in place."""
    for key, tally in more.items():
        total[key] = total[key] + tally if key in total else tally


def error_tally(before: Array, after: Array) -> Tally:
    """Count the error frames of one chain.

    `before` and `after` are the angles of the error in each error frame, radians in [0, π], shape
    (error frames,).
    """
    b, a = np.degrees(before), np.degrees(after)
    return Tally(
        frames=len(b),
        before=micro(b.sum()),
        after=micro(a.sum()),
        before_squared=micro((b * b).sum()),
        after_squared=micro((a * a).sum()),
        repaired=int((a <= SUCCESS * b).sum()),
        worse=int((a > b + WORSE).sum()),
    )


def micro(value: float) -> int:
    """Return a value in millionths, rounded."""
    return round(float(value) * MICRO)
