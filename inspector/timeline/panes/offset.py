"""The pane of the offset that the review's intervals remove."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.timeline.curves import Curves, Title, number
from inspector.timeline.pane import CurveStyle, Pane
from inspector.timeline.plot import Plot

_LEAST = 10.0  # least range in degrees


def _draw(curves: Curves, pane: Pane) -> None:
    degrees = np.degrees(curves.offset)
    pane.set_curve("offset", degrees)
    curves.grow(pane, degrees, _LEAST)


def _describe(curves: Curves, frame: int) -> Title:
    return [(f"{tr('Offset removed')} ", "soft"), (number(curves.offset, frame), "text")]


plot = Plot(
    key="offset",
    title=tr("Offset removed"),
    place=60,
    weight=3,
    priority=60,
    axis=lambda _: tr("offset (°)"),
    draw=_draw,
    describe=_describe,
    styles=(CurveStyle("offset", "text"),),
    shade=False,
)
