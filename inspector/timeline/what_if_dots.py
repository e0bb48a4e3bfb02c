"""Dots at the playhead that show the angles of an edited frame in the plots.

A full dot shows θp, Δθp or the strength m, and a ring shows θc or Δθc. All have the colour of the
corrected pose.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from inspector.language import tr
from inspector.timeline.curves import Curves, format_padded_degrees
from inspector.timeline.dots import Dots
from inspector.timeline.layers import Scenery
from inspector.timeline.pane import Pane
from inspector.timeline.plot import Plot
from inspector.widgets.axes import degrees_to_root_scale

_SPARE = 0.12  # margin around a dot outside the visible range, as a share of the range


class WhatIfDots:
    """The dots in all plots of a timeline."""

    def __init__(
        self, panes: Mapping[str, Pane], plots: Mapping[str, Plot], scenery: Scenery
    ) -> None:
        """Create the dots. `plots` contains the description of each pane, keyed like `panes`."""
        self._plots = {key: plot for key, plot in plots.items() if plot.dots}
        self._panes = {key: panes[key] for key in self._plots}
        self.layers = {key: Dots(pane.view, scenery) for key, pane in self._panes.items()}
        self._values: dict[str, float] = {}

    def show(self, curves: Curves | None, frame: int, values: Mapping[str, float]) -> None:
        """Show the angles of an edited frame.

        `values` contains the angles in radians, keyed by name. Missing angles are not shown.
        """
        self._values = dict(curves.completed(frame, values)) if curves is not None else {}
        for key, pane in self._panes.items():
            dots = []
            plot = self._plots[key]
            for name, _, ring in plot.dots:
                if curves is not None and name in self._values:
                    degrees = plot.height(curves, name, self._values[name])
                    dots.append(
                        (float(degrees_to_root_scale(degrees)) if pane.root else degrees, ring)
                    )
            self._place(pane, self.layers[key], frame, dots)

    def title(self, key: str) -> list[tuple[str, str]]:
        """Return title parts with the values of a plot's dots, as pairs (text, colour name)."""
        parts: list[tuple[str, str]] = []
        plot = self._plots.get(key)
        for name, symbol, ring in plot.dots if plot is not None else ():
            if name in self._values:
                angle = format_padded_degrees(float(np.degrees(self._values[name]))).strip()
                first = "" if parts else f" {tr('what if')}"
                parts.append((f"  {first} {symbol} {'○' if ring else '●'} {angle}", "after"))
        return parts

    def _place(self, pane: Pane, layer: Dots, frame: int, dots: list[tuple[float, bool]]) -> None:
        if (frame, dots) == (layer.frame, layer.dots):
            return
        layer.mark(pane)
        layer.frame, layer.dots = frame, dots
        layer.mark(pane)
        heights = [height for height, _ in dots]
        pane.time.include((min(heights), max(heights)) if heights else None, _SPARE)
