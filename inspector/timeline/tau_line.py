"""The τ line in the strength plot. The user drags it to set τ for the selected chain."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal

from inspector.session.document import Document
from inspector.timeline.drag_escape import DragEscape
from inspector.timeline.pane import Pane
from inspector.widgets.axes import degrees_to_root_scale, root_scale_to_degrees
from inspector.widgets.canvas import TauLine
from inspector.widgets.later import Latest
from inspector.widgets.theme import Colours, Theme

SMALLEST_TAU, LARGEST_TAU = 0.1, 180.0  # degrees


class ChainTauLine(TauLine):
    """A line at the τ of the selected chain, on a square-root scale.

    Each drag is one undo step. Esc cancels a drag.
    """

    dropped = Signal()

    def __init__(self, document: Document, plot: Pane, colours: Colours) -> None:
        super().__init__(angle=0)
        self._plot, self.words = plot, ""
        self._document = document
        self._drag = 0
        self._latest = Latest(self)
        self._escape = DragEscape(document, self.cancel, self)
        self.setZValue(30)
        self.setCursor(Qt.CursorShape.SizeVerCursor)
        plot.addItem(self)
        self.changed.connect(self._update_label)
        colours.follow(self._colour)
        self.setBounds([float(degrees_to_root_scale(d)) for d in (SMALLEST_TAU, LARGEST_TAU)])
        self.sigDragged.connect(self._dragged)
        self.sigPositionChangeFinished.connect(self._drop)
        document.opened.connect(self._give_up)

    def _colour(self, theme: Theme) -> None:
        colour_tau(self, theme)

    @property
    def held(self) -> bool:
        """True while the line is being dragged."""
        return bool(self._drag)

    def show_tau(self, degrees: float) -> None:
        """Move the line to τ, unless the user is dragging it."""
        self.words = tau_line_label(degrees)
        place = float(degrees_to_root_scale(degrees))
        if not self.held and self.value() != place:
            self.setValue(place)
        self._update_label()

    def _update_label(self) -> None:
        self._plot.show_tau(self.value(), self.words)
        self._plot.touch()  # the line is thicker while the mouse is over it

    def _dragged(self) -> None:
        if not self._drag:
            self._drag = self._document.begin_drag()
            self._escape.begin()
        place = self.value()
        self._latest.ask(lambda: set_tau_at(self._document, place, self._drag))

    def cancel(self) -> None:
        """Cancel the current drag, and undo its changes."""
        self._give_up()
        self._escape.undo()
        self.dropped.emit()

    def _give_up(self) -> None:
        """Stop a drag without undoing its changes, for example when the clip is closed."""
        self._escape.end()
        self._latest.forget()
        self._drag = 0
        self.stop_dragging()

    def _drop(self) -> None:
        self._escape.end()
        self._latest.flush()
        self._drag = 0
        self.dropped.emit()


def set_tau_at(document: Document, place: float, drag: int = 0) -> None:
    """Set τ of the selected chain from a position on the square-root scale.

    All changes with the same `drag` number are one undo step.
    """
    set_tau_degrees(document, tau_from_position(place), drag)


def tau_from_position(place: float) -> float:
    """Return the value of τ, in degrees, at a position on the square-root scale."""
    return round(root_scale_to_degrees(place), 1)


def set_tau_degrees(document: Document, degrees: float, drag: int = 0) -> None:
    """Set τ of the selected chain in degrees, limited to the allowed range."""
    degrees = min(max(degrees, SMALLEST_TAU), LARGEST_TAU)
    document.set_tau(float(np.radians(degrees)), document.chain, drag)


def tau_line_label(degrees: float) -> str:
    """Return the label of a τ line, such as 'τ 12.0°'."""
    return f"τ {degrees:.1f}°"


def colour_tau(line: pg.InfiniteLine, theme: Theme) -> None:
    """Set the colours of a τ line."""
    line.setPen(pg.mkPen(theme.tau, width=1.6))
    line.setHoverPen(pg.mkPen(theme.tau, width=3.0))
