"""The base class for the curves of chains and limbs, and the number formats of titles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from inspector.session.document import Document
from inspector.timeline.pane import Pane
from inspector.widgets.signed_numbers import format_number
from twistcore.skeleton.rotation import Array, wrap

Title = list[tuple[str, str]]  # the text above a plot: pairs (text, name of a colour in the theme)
_HEADROOM = 2.2  # smallest range of the strength plot, as a multiple of τ
SAME = 1e-6  # radians; curves with a smaller difference are equal
NOTHING: Array = np.zeros(0)


class Curves(ABC):
    """The curves of the chain or limb that is selected in the document.

    Attributes
    ----------
    strength
        The signal that is compared with τ, in degrees, (frames,).
    unreliable
        The frames [start, stop) in which the angle is unreliable, (spans, 2).
    unreliable_words
        The text that plots show in these spans.
    unreliable_hint
        The tool tip of these spans.
    """

    unreliable_words: str
    unreliable_hint: str
    unreliable: NDArray[np.int64]

    def __init__(self, document: Document) -> None:
        self.document = document
        self.strength = np.degrees(document.detector.strength(document.chain))
        self._peak = float(self.strength.max(initial=0.0))
        self._ranges: dict[str, tuple[float, float]] = {}
        self._reach = (0.0, 1.0)

    @property
    def offset(self) -> Array:
        """The offset that the review's corrections remove, in radians, (frames,)."""
        return self.document.offset(self.document.chain)

    @abstractmethod
    def follow_review(self) -> None:
        """Update the values after correction from the review's intervals."""

    def completed(self, frame: int, values: Mapping[str, float]) -> Mapping[str, float]:
        """Return the edited angles of a frame, together with the angles that depend on them.

        The angles are in radians, keyed by name.
        """
        return values

    def fit_tau(self, pane: Pane, degrees: float) -> None:
        """Set the value range of the strength plot for a τ in degrees.

        The range extends from 0 to the highest peak, or higher if necessary to leave space above τ.
        """
        reach = (0.0, min(max(self._peak, _HEADROOM * degrees, 5.0), max(190.0, self._peak)))
        if reach != self._reach:
            self._reach = reach
            pane.show_values(*reach)

    def grow(self, pane: Pane, degrees: Array, least: float) -> None:
        """Extend the value range of a plot to include a curve. The range never shrinks.

        `degrees` are the values of the curve. `least` is the minimum size of the initial range in
        degrees.
        """
        seen = degrees[np.isfinite(degrees)]
        low, high = (float(seen.min()), float(seen.max())) if len(seen) else (0.0, 0.0)
        old = self._ranges.get(pane.key)
        if old is None:
            spare = 0.5 * max(0.0, least - (high - low))
            low, high = low - spare, high + spare
        elif low >= old[0] and high <= old[1]:
            return
        else:
            low, high = min(low, old[0]), max(high, old[1])
        self._ranges[pane.key] = (low, high)
        pane.show_values(low, high)


def widened(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the mask, extended by one frame before and after each True frame."""
    wider = mask.copy()
    wider[1:] |= mask[:-1]
    wider[:-1] |= mask[1:]
    return wider


def format_angle_at_frame(angle: Array, frame: int) -> str:
    """Format the angle at a frame in degrees. `angle` is in radians, (frames,)."""
    return format_padded_degrees(float(np.degrees(wrap(angle[frame]))))


def format_padded_degrees(value: float) -> str:
    """Format an angle in degrees, padded to align the numbers in titles."""
    return f"{format_number(value):>7}°"
