"""A pane: a plot of the timeline with axes, curves and layers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QRectF, Qt, Signal
from PySide6.QtGui import QFontMetricsF, QMouseEvent
from PySide6.QtWidgets import QWidget

from inspector.language import tr_as
from inspector.timeline.curve_line import Line
from inspector.timeline.curve_values import thin_curve_to_pixels
from inspector.timeline.layers import BackLayer, FrontLayer, Scenery
from inspector.timeline.time_view import TimeView
from inspector.widgets.axes import TEXT_HEIGHT, FrameAxis, RootAxis, UnitAxis, degrees_to_root_scale
from inspector.widgets.canvas import Canvas
from twistcore.skeleton.rotation import Array

AXIS_WIDTH = 58
_AXIS_HEIGHT = 17
# Pixels below a plot without frame numbers; in a figure, the lowest number is never cut off
_GAP, _FIGURE_GAP = 3, 5
_WIDEST = "−180°"  # the widest number at the left axis …
_AXIS_GAPS = 8  # … and the pixels between the label, the number and the plot
_RIGHT_MARGIN = 8
# Free share of the height above the curves; the key is True for a plot with glyphs
_HEADROOM = {True: 0.14, False: 0.07}
_SMOOTH = 4_000  # maximum number of visible frames with antialiased lines
_NO_SEAMS = np.zeros(0, dtype=np.int64)
_LIT_WIDTH = 3.0


@dataclass(frozen=True)
class CurveStyle:
    """The style of a curve. `role` is the name of its colour in the theme."""

    name: str
    role: str
    dashed: bool = False


TRACKED = (  # the curves of θc and θp after tracking
    CurveStyle("c_tracked", "tracked", dashed=True),
    CurveStyle("p_tracked", "tracked"),
)
BEFORE_AND_AFTER = (  # the curves of θc and θp before and after correction
    CurveStyle("c_before", "before", dashed=True),
    CurveStyle("c_after", "after", dashed=True),
    CurveStyle("p_before", "before"),
    CurveStyle("p_after", "after"),
)


class Pane(Canvas):
    """A plot with curves. The timeline sets the values of the curves."""

    enlarged = Signal()  # the user wants to see only this pane, or all panes again
    least_part = 10.0  # smallest range of values if only a part of the values is shown

    def __init__(
        self,
        key: str,
        styles: tuple[CurveStyle, ...],
        scenery: Scenery,
        *,
        root: bool = False,
        shade: bool = True,
        glyphs: bool = False,
        unit: str = "°",
        parent: QWidget | None = None,
    ) -> None:
        self.key = key
        values = RootAxis("left") if root else UnitAxis("left")
        if isinstance(values, UnitAxis):
            values.unit = unit
        self.time = TimeView(key)
        super().__init__({"left": values, "bottom": FrameAxis("bottom")}, self.time, parent)
        self.root, self._headroom = root, _HEADROOM[glyphs]
        self._styles = styles
        self._smooth = False
        self._lit: str | None = None
        self.scenery = scenery
        self._bottom_shown = True
        self._zero = pg.InfiniteLine(pos=0.0, angle=0)
        self._zero.setZValue(-50)
        self.addItem(self._zero)
        self.curves = {s.name: Line(self.view) for s in styles}
        self.values: dict[str, tuple[Array, NDArray[np.int64]]] = {}
        for curve in self.curves.values():
            self.addItem(curve)
        self.view.sigResized.connect(self._thin_all)
        self.back = BackLayer(self.view, scenery, shade=shade, glyphs=glyphs)
        self.front = FrontLayer(self.time, scenery)
        self.set_scale()
        self.view.sigYRangeChanged.connect(lambda *_: self.touch())
        self.setMinimumHeight(40)
        scenery.colours.changed.connect(self.colour)
        self.colour()

    def refresh(self) -> None:
        """Update content that is not set by the timeline. The base class has no such content."""

    def forget(self) -> None:
        """Discard all data of the clip. Called after the clip or the detector has changed."""

    def set_scale(self) -> None:
        """Apply the scenery's scale to the text and the margins."""
        scale = self.scenery.scale
        for axis in self.axes.values():
            axis.text_height = TEXT_HEIGHT * scale + self.scenery.higher
        self.set_type(self.scenery.font())
        self.grid.setContentsMargins(0.0, self.scenery.title_height, _RIGHT_MARGIN, 0.0)
        widest = QFontMetricsF(self.scenery.font()).horizontalAdvance(_WIDEST)
        needed = self.axes["left"].text_height + widest + _AXIS_GAPS * scale
        self.axes["left"].setWidth(max(AXIS_WIDTH * scale, needed))
        self.set_bottom(shown=self._bottom_shown)

    def colour(self) -> None:
        """Apply the theme's colours."""
        theme = self.scenery.theme
        self.colour_background(theme)
        self._zero.setPen(pg.mkPen(theme.line))
        self._set_pens()
        self.touch()

    def show_title(self, title: list[tuple[str, str]]) -> None:
        """Show a title, given as pairs (text, name of a colour in the theme)."""
        if title != self.front.title:
            self.front.title = title
            self.viewport().update(0, 0, self.width(), self._title_height)

    def show_tau(self, place: float, words: str) -> None:
        """Show the label of the τ line. `place` is the position of the line on the value axis."""
        if self.front.tau != (place, words):
            self.front.tau = place, words
            if isinstance(axis := self.axes["left"], RootAxis):
                axis.keep_clear(place)
            self.touch()

    @property
    def _title_height(self) -> int:
        return math.ceil(self.scenery.title_height)

    def move_playhead(self, before: int, after: int) -> None:
        """Repaint the plot at the previous and the new frame of the playhead."""
        for frame in (before, after):
            part = QRectF(self.front.place(frame) - 3.0, 0.0, 6.0, self.view.height())
            self.viewport().update(part.translated(self.view.scenePos()).toAlignedRect())

    def _set_pens(self) -> None:
        theme = self.scenery.theme
        for style in self._styles:
            bold = self._lit is not None and style.name.startswith(self._lit)
            width = round(self.scenery.scale) * (_LIT_WIDTH if bold else 1.0)
            pen = pg.mkPen(getattr(theme, style.role), width=width)
            if style.dashed:
                pen.setDashPattern([5.0, 3.0])
            curve = self.curves[style.name]
            curve.pen, curve.smooth = pen, self._smooth

    def highlight(self, first: str | None) -> None:
        """Highlight the curves with names that begin with `first`. None removes the highlight."""
        if first != self._lit:
            self._lit = first
            self._set_pens()
            self.touch()

    def look_like(self, other: Pane) -> None:
        """Copy the highlighted curves of another pane and, if it is zoomed, its value range."""
        self.time.look_like(other.time)
        self.highlight(other._lit)

    def set_curve(self, name: str, y: Array, seams: NDArray[np.int64] = _NO_SEAMS) -> None:
        """Set the values of a curve in degrees, (frames,), with NaN for gaps.

        The line is broken after each frame in `seams`.
        """
        self.values[name] = degrees_to_root_scale(y) if self.root else y, seams
        self._thin(name)

    def _thin(self, name: str) -> None:
        """Set the points of a curve's line from its values in the visible frames.

        The downsampling of pyqtgraph is not used, because it omits points next to gaps.
        """
        y, seams = self.values[name]
        first, last = self.view.viewRange()[0]
        self.curves[name].show_points(
            *thin_curve_to_pixels(y, seams, first, last, int(self.view.width()))
        )

    def _thin_all(self, *_: object) -> None:
        for name in self.values:
            self._thin(name)

    def show_values(self, low: float, high: float) -> None:
        """Show a range of values in degrees, with a margin.

        If `low` is 0, the margin below it is smaller.
        """
        if self.root:
            low, high = float(degrees_to_root_scale(low)), float(degrees_to_root_scale(high))
        span = high - low
        foot = 0.03 if low == 0.0 else 0.07
        self.time.fit_to(low - foot * span, high + self._headroom * span)
        self.touch()

    def show_part(self, first: float, last: float, *, grow: bool = False) -> None:
        """Fit the value axis to the values between two frames instead of to all values.

        If `grow` is True, the visible range is extended if necessary, but it never shrinks.
        """
        part = self.time.part
        if self.root or (grow and part is None):
            return  # a square-root scale shows small values anyway
        frames = slice(max(0, math.ceil(first)), max(0, math.floor(last) + 1))
        seen = np.concatenate([y[frames] for y, _ in self.values.values()] or [np.zeros(0)])
        seen = seen[np.isfinite(seen)]
        if not len(seen):
            return
        low, high = float(seen.min()), float(seen.max())
        spare = 0.5 * max(0.0, self.least_part - (high - low))
        low, high = low - spare, high + spare
        span = high - low
        low, high = low - 0.07 * span, high + self._headroom * span
        if grow and part is not None:
            low, high = min(low, part[0]), max(high, part[1])
        self.time.show_part(low, high)

    def show_frames(self, first: float, last: float) -> None:
        """Show a range of frames on the time axis."""
        smooth = last - first <= _SMOOTH
        if smooth != self._smooth:
            self._smooth = smooth
            self._set_pens()
        if [first, last] != self.view.viewRange()[0]:
            self.view.setXRange(first, last, padding=0.0)
            self._thin_all()
            self.touch()

    def set_bottom(self, *, shown: bool) -> None:
        """Show or hide the frame numbers. Only the lowest plot of a column shows them."""
        axis = self.axes["bottom"]
        axis.setStyle(showValues=shown)
        scale, higher = self.scenery.scale, self.scenery.higher
        gap = _FIGURE_GAP if self.scenery.still else _GAP
        axis.setHeight(_AXIS_HEIGHT * scale + higher if shown else gap + 0.5 * higher)
        self.front.time = tr_as("axis", "frame") if shown else ""
        self._bottom_shown = shown

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Handle a double-click on the title or on the left axis.

        A double-click on the title enlarges this plot or shows all plots again. A double-click on
        the left axis shows all values.
        """
        if event.button() == Qt.MouseButton.LeftButton and self.view.width() > 0:
            if event.position().y() < self._title_height:
                self.enlarged.emit()
                return
            if self.axes["left"].sceneBoundingRect().contains(event.position()):
                self.time.fit()
                return
        super().mouseDoubleClickEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Remove the tool tip when the mouse leaves the plot."""
        self.view.setToolTip("")
        super().leaveEvent(event)
