"""Integer counts and sums, whose totals do not depend on the machine or the order of clips."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from twistcore.skeleton.rotation import Array
from twistcore.synthesis import SUCCESS

WORSE = 0.5  # degrees; an error is worse if it grows by more
MICRO = 1_000_000  # angles are summed in millionths of a degree


@dataclass(frozen=True)
class Tally:
    """Counts and sums over any number of passes, each of which injects errors into one target.

    Angles are in millionths of a degree, and squares of angles in millionths of a square degree. A
    *pair* is a joint in a frame.

    Attributes
    ----------
    passes
        Number of passes.
    frames
        Number of error frames.
    before, after, before_squared, after_squared
        Sums of the errors in these frames, and of their squares, before and after the correction.
    repaired, worse
        Number of error frames that are repaired, and of error frames in which the error grows by
        more than half a degree.
    pairs
        Number of clean pairs (pairs without an error) of all chains.
    damaged, damage
        Number of clean pairs that the method changes by more than 1°, but not in the clean clip,
        and the sum of these changes.
    natural, natural_change
        Number of pairs that the method changes in the same way in the clean clip, and the sum of
        these changes.
    target_pairs, target_damaged
        `pairs` and `damaged`, counted only in the joints of the target.
    truths, found, matched
        Number of true intervals, of detections, and of detections that match a true interval.
    alarms
        Number of detections in the clean clip.
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
        """Return the numbers, in the order of the fields."""
        return tuple(vars(self).values())


@dataclass(frozen=True, order=True)
class Key:
    """The protocol, the method and the kind of chain to which a tally applies.

    Attributes
    ----------
    protocol, method
        Names of protocol and method.
    side, segment
        Side and segment of the target chain.
    audited
        True if the target chain has no natural event.
    """

    protocol: str
    method: str
    side: str
    segment: str
    audited: bool


Tallies: TypeAlias = dict[Key, Tally]


def add_tallies(total: Tallies, more: Mapping[Key, Tally]) -> None:
    """Add the tallies in `more` to the tallies in `total` with the same keys, in place."""
    for key, tally in more.items():
        total[key] = total[key] + tally if key in total else tally


def tally_error_angles(before: Array, after: Array) -> Tally:
    """Return a tally of the error frames of a chain.

    `before` and `after` are the angles of the error before and after the correction, radians in [0,
    π], shape (error frames,).
    """
    b, a = np.degrees(before), np.degrees(after)
    return Tally(
        frames=len(b),
        before=in_millionths(b.sum()),
        after=in_millionths(a.sum()),
        before_squared=in_millionths((b * b).sum()),
        after_squared=in_millionths((a * a).sum()),
        repaired=int((a <= SUCCESS * b).sum()),
        worse=int((a > b + WORSE).sum()),
    )


def in_millionths(value: float) -> int:
    """Convert a value to millionths, rounded to an integer."""
    return round(float(value) * MICRO)
