"""The description of a pane: its labels, its position, and the functions that draw it.

Each file in `panes/` defines one pane: a :class:`Plot`, stored in the variable `plot`. All files in
that folder are found automatically.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module

import numpy as np
from PySide6.QtWidgets import QWidget

from inspector.session.document import Document
from inspector.timeline import panes
from inspector.timeline.curves import Curves, Title
from inspector.timeline.gestures import Gestures
from inspector.timeline.layers import Scenery
from inspector.timeline.pane import CurveStyle, Pane


def _in_degrees(_: Curves, __: str, angle: float) -> float:
    return float(np.degrees(angle))


@dataclass(frozen=True, kw_only=True)
class Plot:
    """The description of a pane of the timeline.

    Attributes
    ----------
    key
        The name of the pane's file in `panes/`.
    title
        The name in the plot menu and for screen readers.
    place
        The position. Panes are sorted by this number from top to bottom.
    weight
        The height of the pane relative to other panes.
    priority
        If there is not enough space, panes with larger numbers are hidden first.
    axis
        A function that returns the label of the left axis, or '' if the pane does not apply to the
        selection.
    draw
        A function that draws the curves that depend on decisions.
    draw_clip
        A function that draws the curves that do not depend on decisions.
    describe
        A function that returns the title at a frame.
    height
        A function that returns the value, in degrees, at which to draw an edited angle.
    at_first
        True if the pane is visible by default.
    styles
        The styles of the curves.
    root
        True to draw degrees on a square-root scale.
    shade
        True to shade frames in which the angle is unreliable.
    glyphs
        True to draw the symbols of decisions on the intervals.
    unit
        The unit that follows the numbers on the axis.
    dots
        The angles of an edited frame that are drawn as dots: (name, symbol, True for a ring).
    takes_tau
        True if the pane shows the τ line.
    no_limb
        The message to show if a limb is selected and the pane cannot show limbs.
    gestures
        The class of the mouse gestures.
    in_exercise
        True if the pane is shown in an exercise. It must not reveal the errors.
    build
        A function that builds the widget. By default, the widget is an empty pane with the styles.
    """

    key: str
    title: str
    place: int
    weight: int
    priority: int
    axis: Callable[[Curves], str]
    draw: Callable[[Curves, Pane], None] = lambda _, __: None
    draw_clip: Callable[[Curves, Pane], None] = lambda _, __: None
    describe: Callable[[Curves, int], Title] = lambda _, __: []
    height: Callable[[Curves, str, float], float] = _in_degrees
    at_first: bool = True
    styles: tuple[CurveStyle, ...] = ()
    root: bool = False
    shade: bool = True
    glyphs: bool = False
    unit: str = "°"
    dots: tuple[tuple[str, str, bool], ...] = ()
    takes_tau: bool = False
    no_limb: str = ""
    gestures: type[Gestures] = Gestures
    in_exercise: bool = False
    build: Callable[[Document, Scenery, QWidget], Pane] | None = None

    def pane(self, document: Document, scenery: Scenery, parent: QWidget) -> Pane:
        """Return a new, empty widget for the pane."""
        if self.build is not None:
            return self.build(document, scenery, parent)
        return Pane(
            self.key,
            self.styles,
            scenery,
            root=self.root,
            shade=self.shade,
            glyphs=self.glyphs,
            unit=self.unit,
            parent=parent,
        )


@cache
def plots() -> Mapping[str, Plot]:
    """Return the panes in the folder `panes` from top to bottom, keyed by file name."""
    names = [found.name for found in pkgutil.iter_modules(panes.__path__)]
    every: list[Plot] = [import_module(f"{panes.__name__}.{name}").plot for name in names]
    return {plot.key: plot for plot in sorted(every, key=lambda plot: plot.place)}
