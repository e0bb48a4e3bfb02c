"""An interval in which a parent's twist is wrong, and its child's makes up for it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from twistcore.rotation import Array, wrap


@dataclass(frozen=True, eq=False)
class Interval:
    """Frames [start, stop) of a chain with the twist error of P in each.

    chain: its name; offset: radians, shape (stop − start,), what is taken out of P's twist;
    confidence: 0…1, or None where the detector has none; open: it may be the other side of the
    clip that is wrong, so it is not applied unasked; residual: what is left of the offset behind
    the closing edge, radians; explain: tells why it was found, asked only where a person looks.
    """

    chain: str
    start: int
    stop: int
    offset: Array
    confidence: float | None = None
    open: bool = False
    residual: float = 0.0
    explain: Callable[[], dict[str, Any]] | None = None

    def __repr__(self) -> str:
        sure = "" if self.confidence is None else f", confidence {self.confidence:.2f}"
        turn = f"{math.degrees(self.delta):+.1f}°{sure}{', open' if self.open else ''}"
        return f"<Interval {self.chain} {self.start}–{self.stop}: {turn}>"

    @property
    def evidence(self) -> dict[str, Any] | None:
        """Why it was found, by name: numbers, texts and lists, as JSON has them; angles in °."""
        return self.explain() if self.explain else None

    def __getstate__(self) -> dict[str, Any]:
        """Sent to another process it takes its evidence along, not the analysis that tells it."""
        evidence = self.evidence
        return {**vars(self), "explain": evidence and partial(dict, evidence)}

    @property
    def frames(self) -> int:
        """Length in frames."""
        return self.stop - self.start

    @property
    def delta(self) -> float:
        """One number for the interval: the circular median of the offset, radians in (−π, π]."""
        return circular_median(self.offset)

    def with_offset(self, start: int, offset: Array) -> Interval:
        """The same interval over other frames and offsets."""
        return replace(self, start=start, stop=start + len(offset), offset=offset)


def circular_median(angles: Array) -> float:
    """Median of angles that may straddle ±π, radians in (−π, π]; (n,) -> number, 0 for none."""
    if len(angles) == 0:
        return 0.0
    centre = np.angle(np.exp(1j * angles).sum()) if len(angles) > 1 else angles[0]
    return float(wrap(centre + np.median(wrap(angles - centre))))
