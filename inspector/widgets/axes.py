"""The axes of the plots. Each axis shows as many round numbers as fit."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pyqtgraph as pg

from inspector.widgets.signed_numbers import format_number
from twistcore.skeleton.rotation import Array

_ROOT_TICKS = (0, 1, 5, 20, 50, 100, 180)
TEXT_HEIGHT = 13.0  # pixels of a line of text at the default font size


def degrees_to_root_scale(degrees: Array | float) -> Array:
    """Return the signed square root of an angle in degrees.

    On this scale, a τ of 5° is easy to drag even if the plot also shows a jump of 170°.
    """
    value = np.asarray(degrees, dtype=np.float64)
    scaled: Array = np.sign(value) * np.sqrt(np.abs(value))
    return scaled


def root_scale_to_degrees(value: float) -> float:
    """Return the angle, in degrees, for a value on the square-root scale."""
    return float(np.sign(value) * value * value)


def spaced_ticks(places: Iterable[float], room: float) -> list[float]:
    """Return as many of the given positions as possible with gaps of at least `room`.

    `places` contains the positions in ascending order.
    """
    chosen = [-math.inf]
    for at in places:
        if at - chosen[-1] >= room:
            chosen.append(at)
    return chosen[1:]


class Axis(pg.AxisItem):
    """An axis that passes mouse input on to the plot.

    Attributes
    ----------
    text_height
        The height of a line of text in pixels. This is the minimum distance between two numbers.
    """

    text_height = TEXT_HEIGHT

    def mouseClickEvent(self, event: Any) -> None:
        """Ignore the click, so that the plot receives it."""
        event.ignore()


class UnitAxis(Axis):
    """An axis with numbers and a unit, by default degrees."""

    unit = "°"

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """Return the tick positions, except those whose labels would be cut off at an end."""
        room = self.text_height / 2.0 * (high - low) / max(size, 1.0)
        return [
            (spacing, [v for v in values if low + room <= v <= high - room])
            for spacing, values in super().tickValues(low, high, size)
        ]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Return the tick labels with as many decimals as the spacing needs."""
        decimals = max(0, int(np.ceil(-np.log10(spacing) - 1e-9))) if spacing < 1 else 0
        return [f"{format_number(v, decimals)}{self.unit}" for v in values]


class RootAxis(Axis):
    """An axis with degrees on a signed square-root scale.

    Attributes
    ----------
    taken
        A position on this scale at which no number is shown, or None.
    """

    taken: float | None = None

    def keep_clear(self, place: float) -> None:
        """Hide the number at `place`, a position on this scale where the plot draws a label."""
        before, self.taken = self._overlapped(), place
        if self._overlapped() != before:
            self.picture = None  # the axis is drawn again at the next repaint

    def _room(self) -> float:
        low, high = (float(v) for v in self.range)
        return self.text_height * (high - low) / max(float(self.height()), 1.0)

    def _overlapped(self) -> list[float]:
        """Return the positions of the numbers that would overlap `taken`."""
        ticks = degrees_to_root_scale(np.array(_ROOT_TICKS)).tolist()
        return [t for t in ticks if self.taken is not None and abs(t - self.taken) < self._room()]

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """Return tick positions at as many round numbers of degrees as fit."""
        room = self.text_height * (high - low) / max(size, 1.0)
        chosen = spaced_ticks(degrees_to_root_scale(np.array(_ROOT_TICKS)).tolist(), room)
        ticks = {sign * at for at in chosen for sign in (1.0, -1.0)}.difference(self._overlapped())
        return [(1.0, sorted(t for t in ticks if low <= t <= high - 0.5 * room))]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Return the tick labels in degrees for positions on the square-root scale."""
        return [f"{format_number(root_scale_to_degrees(v), 0)}°" for v in values]


class FrameAxis(Axis):
    """An axis with frame numbers.

    Attributes
    ----------
    first
        The number of the first frame.
    """

    first = 0

    def tickSpacing(self, low: float, high: float, size: float) -> list[tuple[float, float]]:
        """Return tick spacings that are whole numbers of frames."""
        return [s for s in super().tickSpacing(low, high, size) if s[0] >= 1.0] or [(1.0, 0.0)]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Return the tick labels: frame numbers, counted from `first`."""
        return [format_number(v + self.first, 0) for v in values]
