"""The view of a plot: its visible ranges of frames and values, and its mouse events."""

from __future__ import annotations

from typing import Any, Protocol

import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt
from PySide6.QtWidgets import QGraphicsSceneWheelEvent

_NOTCH = 120.0
_ZOOM = 1.25  # zoom factor per notch of the wheel
# Smallest and largest visible range, as multiples of the range of all values
_DEEPEST, _WIDEST = 1e-3, 3.0


class Mouse(Protocol):
    """An object that handles the mouse events of a plot."""

    def wheel(self, frame: float, notches: float, *, pan: bool) -> None:
        """Zoom in time around a frame, or pan if `pan` is True."""

    def drag(self, view: TimeView, event: Any, *, pan: bool) -> None:
        """Handle one mouse event of a drag."""

    def click(self, view: TimeView, event: Any) -> None:
        """Handle a click in `view`."""

    def hover(self, view: TimeView, event: Any) -> None:
        """Handle a mouse movement without a button."""


class TimeView(pg.ViewBox):
    """The area of a plot that shows the curves and passes its mouse events to the gestures.

    The value axis shows the range set with `fit_to` until the user zooms. The timeline sets the
    range of frames.
    """

    def __init__(self, key: str) -> None:
        """Create the view. `key` is the key of the plot."""
        super().__init__(enableMenu=False, enableMouse=False, defaultPadding=0.0)
        self.key = key
        self.gestures: Mouse | None = None
        self.zoomed = False  # True if the user has zoomed the values
        self._all = (0.0, 1.0)
        self._part: tuple[float, float] | None = None  # the range shown instead of all values
        self._beyond: tuple[float, float] | None = None  # an additional temporary range

    # -- values -------------------------------------------------------------------------------

    def fit_to(self, low: float, high: float) -> None:
        """Set the full value range, and show it unless the user has zoomed or a part is shown."""
        self._all = (low, high)
        if not self.zoomed and self._part is None:
            self.fit()

    def show_part(self, low: float, high: float) -> None:
        """Show only the values from `low` to `high`, unless the user has zoomed."""
        if not self.zoomed and (low, high) != self._part:
            self._part = low, high
            self.setYRange(low, high, padding=0.0)

    @property
    def part(self) -> tuple[float, float] | None:
        """The range set by `show_part`, or None if it is not set or if the user has zoomed."""
        return None if self.zoomed else self._part

    @property
    def all_values(self) -> tuple[float, float]:
        """The range of all values, as (lowest, highest)."""
        return self._all

    def forget_zoom(self) -> None:
        """Discard the user's zoom of the values. The next `fit_to` then shows all values."""
        self.zoomed, self._part = False, None

    def fit(self) -> None:
        """Show all values, and discard the user's zoom."""
        self.forget_zoom()
        low, high = self._all
        if self._beyond is not None:
            low, high = min(low, self._beyond[0]), max(high, self._beyond[1])
        self.setYRange(low, high, padding=0.0)

    def include(self, values: tuple[float, float] | None, spare: float) -> None:
        """Extend the range temporarily to include `values`, a pair (lowest, highest).

        The extended range does not shrink until a call with None restores the normal range. `spare`
        is the margin as a share of the range. If the user has zoomed, the visible range does not
        change.
        """
        seen = self._beyond or self._all
        if values is None:
            if self._beyond is None:
                return
            self._beyond = None
        elif values[0] < min(seen[0], self._all[0]) or values[1] > max(seen[1], self._all[1]):
            low, high = min(values[0], seen[0]), max(values[1], seen[1])
            room = spare * (high - low)
            low = low - room if values[0] < seen[0] else low
            self._beyond = low, high + room if values[1] > seen[1] else high
        else:
            return
        if not self.zoomed:
            self.fit()

    def look_like(self, other: TimeView) -> None:
        """Copy the visible range of values from a view that the user has zoomed."""
        if other.zoomed:
            self._show_values(*other.viewRange()[1])

    def zoom_values(self, at: float, notches: float) -> None:
        """Zoom the value axis around the value `at`."""
        low, high = self.viewRange()[1]
        whole = self._all[1] - self._all[0]
        wanted = (high - low) * _ZOOM**-notches
        scale = min(max(wanted, _DEEPEST * whole), _WIDEST * whole) / (high - low)
        self._show_values(at - (at - low) * scale, at + (high - at) * scale)

    def pan_values(self, by: float) -> None:
        """Pan to higher (+) or lower (−) values, but never beyond the range of all values."""
        low, high = self.viewRange()[1]
        by = min(max(by, self._all[0] - high), self._all[1] - low)
        self._show_values(low + by, high + by)

    def _show_values(self, low: float, high: float) -> None:
        self.zoomed = True
        self.setYRange(low, high, padding=0.0)

    # -- the mouse ----------------------------------------------------------------------------

    def wheelEvent(self, event: QGraphicsSceneWheelEvent, axis: int | None = None) -> None:
        """Zoom in time around the mouse pointer.

        With Shift, the wheel pans in time. With Ctrl or over the left axis, it zooms the values.
        """
        event.accept()
        at = self.mapToView(self.mapFromScene(event.scenePos()))
        notches, keys = event.delta() / _NOTCH, event.modifiers()
        if axis == 1 or keys & Qt.KeyboardModifier.ControlModifier:
            self.zoom_values(float(at.y()), notches)
        elif self.gestures:
            shift = bool(keys & Qt.KeyboardModifier.ShiftModifier)
            self.gestures.wheel(float(at.x()), notches, pan=shift)

    def mouseDragEvent(self, event: Any, axis: int | None = None) -> None:
        """Pass a drag to the gestures.

        A drag on the left axis pans the values. A drag on the bottom axis pans in time.
        """
        event.accept()
        if axis == 1:
            # `pos` would be in the coordinates of the axis
            places = event.lastScenePos(), event.scenePos()
            there, here = (self.mapSceneToView(place).y() for place in places)
            self.pan_values(float(there - here))
        elif self.gestures:
            self.gestures.drag(self, event, pan=axis == 0)

    def mouseClickEvent(self, event: Any) -> None:
        """Pass a click to the gestures, except a click with the middle button."""
        if self.gestures and event.button() != Qt.MouseButton.MiddleButton:
            event.accept()
            self.gestures.click(self, event)

    def hoverEvent(self, event: Any) -> None:
        """Pass mouse movements to the gestures, so that they can set the cursor."""
        if self.gestures and not event.isExit():
            self.gestures.hover(self, event)

    def frame_at(self, position: QPointF) -> float:
        """Return the frame at a position in this view. The result may be fractional."""
        return float(self.mapToView(position).x())
