"""What the curves of a chain and of a limb have in common: ranges, words and numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.pane import Pane
from inspector.widgets.signed_numbers import plain
from twistcore.skeleton.rotation import Array, wrap

_SMALLEST = {"theta": 20.0, "delta": 10.0, "offset": 10.0}  # degrees that a plot spans at least
_HEADROOM = 2.2  # times τ that the strength plot reaches at least
SAME = 1e-6  # radians
NOTHING: Array = np.zeros(0)


class Curves(ABC):
    """The curves of the document's selection.

    panes: the plots that mean something for it, by key what their left axes show; strength: what τ
    is compared with, degrees, (frames,); unreliable: spans of frames in which an angle says
    nothing, (spans, 2), what is written there and what a hint says of it.
    """

    panes: Mapping[str, str]
    unreliable_words: str
    unreliable_hint: str
    unreliable: NDArray[np.int64]

    def __init__(self, document: Document) -> None:
        self.document = document
        self.strength = np.degrees(document.detector.strength(document.chain))
        self._peak = float(self.strength.max(initial=0.0))
        self._ranges: dict[str, tuple[float, float]] = {}
        self._reach = (0.0, 1.0)

    @abstractmethod
    def show_clip(self, panes: Mapping[str, Pane]) -> None:
        """The curves that no decision changes, and the ranges."""

    @abstractmethod
    def show_review(self, panes: Mapping[str, Pane]) -> None:
        """The curves after correction by the review's intervals, and the offset."""

    @abstractmethod
    def titles(self, frame: int) -> dict[str, list[tuple[str, str]]]:
        """Words and the numbers at a frame, as (text, colour role), by plot."""

    def completed(self, frame: int, values: Mapping[str, float]) -> Mapping[str, float]:
        """Angles of an altered frame, radians, with those that follow from them and the clip."""
        return values

    def height(self, key: str, name: str, angle: float) -> float:
        """Degrees at which an angle of an altered frame, radians, stands in a plot; its name."""
        return float(np.degrees(angle))

    def fit_tau(self, pane: Pane, degrees: float) -> None:
        """The strength plot reaches from 0 over its peak and well over τ."""
        reach = (0.0, min(max(self._peak, _HEADROOM * degrees, 5.0), max(190.0, self._peak)))
        if reach != self._reach:
            self._reach = reach
            pane.show_values(*reach)

    def show_offset(self, pane: Pane) -> None:
        """What is taken out."""
        degrees = np.degrees(self.document.offset(self.document.chain))
        pane.set_curve("offset", degrees)
        self.grow(pane, degrees)

    def offset_title(self, frame: int) -> list[tuple[str, str]]:
        """The words over it."""
        offset = self.document.offset(self.document.chain)
        return [(f"{tr('Offset taken out')} ", "soft"), (number(offset, frame), "text")]

    def grow(self, pane: Pane, degrees: Array) -> None:
        """Widen a plot's range where a curve leaves it; it never narrows under the hand."""
        seen = degrees[np.isfinite(degrees)]
        low, high = (float(seen.min()), float(seen.max())) if len(seen) else (0.0, 0.0)
        old = self._ranges.get(pane.key)
        if old is None:
            spare = 0.5 * max(0.0, _SMALLEST[pane.key] - (high - low))
            low, high = low - spare, high + spare
        elif low >= old[0] and high <= old[1]:
            return
        else:
            low, high = min(low, old[0]), max(high, old[1])
        self._ranges[pane.key] = (low, high)
        pane.show_values(low, high)


def widened(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """One frame to either side too, where one line leaves the other."""
    wider = mask.copy()
    wider[1:] |= mask[:-1]
    wider[:-1] |= mask[1:]
    return wider


def number(angle: Array, frame: int) -> str:
    """An angle at a frame, from radians, as titles have it."""
    return in_degrees(float(np.degrees(wrap(angle[frame]))))


def in_degrees(value: float) -> str:
    """Degrees as titles have them."""
    return f"{plain(value):>7}°"
