"""What a pane of the time line is: its words, its place, what it draws, what it says of a frame.

A pane is one object of :class:`Plot`, named `plot`, in a file of its own in `panes/`. All files of
that folder are found by themselves.
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
    """A pane of the time line.

    title: in the menu of plots, and for those who hear it; place: a smaller one is higher up;
    weight: its share of the height; priority: where room is short, a smaller one is kept longer;
    at_first: shown until a person chooses; styles: its curves; root: degrees on a root scale;
    shade: frames are marked in which an angle means nothing; glyphs: with the signs of verdicts;
    unit: behind the numbers of its axis; dots: what a what-if adds, as the value's name, its symbol
    and whether it is a ring; takes_tau: the line of τ is in it; no_limb: said where it is asked for
    and a limb is selected, which it cannot show.

    axis: the words at its left axis for a selection, '' where it means nothing for it; draw: what
    a decision may change; draw_clip: what none changes; describe: the words and numbers above it at
    a frame; height: degrees at which an altered angle, by its name, is; gestures: what the mouse
    does in it; build: makes the widget, by default an empty pane with these styles.
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
    build: Callable[[Document, Scenery, QWidget], Pane] | None = None

    def pane(self, document: Document, scenery: Scenery, parent: QWidget) -> Pane:
        """Return a widget for it, with nothing drawn yet."""
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
    """Return every pane of the folder `panes`, by key, from top to bottom."""
    names = [found.name for found in pkgutil.iter_modules(panes.__path__)]
    every: list[Plot] = [import_module(f"{panes.__name__}.{name}").plot for name in names]
    return {plot.key: plot for plot in sorted(every, key=lambda plot: plot.place)}
