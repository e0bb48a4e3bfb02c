"""Axes of the plots: round numbers where there is room for them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pyqtgraph as pg

from inspector.widgets.signed_numbers import plain
from twistcore.skeleton.rotation import Array

_ROOT_TICKS = (0, 1, 5, 20, 50, 100, 180)
_TICK_ROOM = 13.0  # pixels between two labels of the root scale, in type of the usual size


def root_scale(degrees: Array | float) -> Array:
    """Signed square root: a τ of 5° stays readable and draggable beside a jump of 170°."""
    value = np.asarray(degrees, dtype=np.float64)
    scaled: Array = np.sign(value) * np.sqrt(np.abs(value))
    return scaled


def from_root_scale(value: float) -> float:
    """Degrees of a place on the root scale."""
    return float(np.sign(value) * value * value)


def spaced_ticks(places: Iterable[float], room: float) -> list[float]:
    """As many of the rising places as find room beside each other."""
    chosen = [-math.inf]
    for at in places:
        if at - chosen[-1] >= room:
            chosen.append(at)
    return chosen[1:]


class Axis(pg.AxisItem):
    """An axis that leaves the mouse to the plot; scale: of its type."""

    type_scale = 1.0

    def mouseClickEvent(self, event: Any) -> None:
        """A click beside the plot means nothing."""
        event.ignore()


class UnitAxis(Axis):
    """Numbers with their unit, degrees if nothing else is said."""

    unit = "°"

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """None so near an end that its label would be cut."""
        room = self.type_scale * _TICK_ROOM / 2.0 * (high - low) / max(size, 1.0)
        return [
            (spacing, [v for v in values if low + room <= v <= high - room])
            for spacing, values in super().tickValues(low, high, size)
        ]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """As many decimals as the spacing needs."""
        decimals = max(0, int(np.ceil(-np.log10(spacing) - 1e-9))) if spacing < 1 else 0
        return [f"{plain(v, decimals)}{self.unit}" for v in values]


class RootAxis(Axis):
    """Degrees on a signed square root scale; `taken`: a place where something else stands."""

    taken: float | None = None

    def keep_clear(self, place: float) -> None:
        """No number where something else stands, a place on this scale."""
        before, self.taken = self._under(), place
        if self._under() != before:
            self.picture = None  # drawn anew with the next repaint

    def _room(self) -> float:
        low, high = (float(v) for v in self.range)
        return self.type_scale * _TICK_ROOM * (high - low) / max(float(self.height()), 1.0)

    def _under(self) -> list[float]:
        """The places of numbers that would stand there."""
        ticks = root_scale(np.array(_ROOT_TICKS)).tolist()
        return [t for t in ticks if self.taken is not None and abs(t - self.taken) < self._room()]

    def tickValues(self, low: float, high: float, size: float) -> list[tuple[float, list[float]]]:
        """Round degrees, as many as find room."""
        room = self.type_scale * _TICK_ROOM * (high - low) / max(size, 1.0)
        chosen = spaced_ticks(root_scale(np.array(_ROOT_TICKS)).tolist(), room)
        ticks = {sign * at for at in chosen for sign in (1.0, -1.0)}.difference(self._under())
        return [(1.0, sorted(t for t in ticks if low <= t <= high - 0.5 * room))]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """The degrees that a place stands for."""
        return [f"{plain(from_root_scale(v), 0)}°" for v in values]


class FrameAxis(Axis):
    """Whole frames only, counted from `first`."""

    first = 0

    def tickSpacing(self, low: float, high: float, size: float) -> list[tuple[float, float]]:
        """No fractions of a frame."""
        return [s for s in super().tickSpacing(low, high, size) if s[0] >= 1.0] or [(1.0, 0.0)]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Integers."""
        return [plain(v + self.first, 0) for v in values]
