"""The pane for the offset that the review's intervals remove."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.timeline.chain_curves import ChainCurves
from inspector.timeline.curve_values import wrap_degrees_about
from inspector.timeline.curves import NOTHING, Curves, Title, format_angle_at_frame
from inspector.timeline.pane import CurveStyle, Pane
from inspector.timeline.plot import Plot

_LEAST = 10.0  # smallest range in degrees


def _draw(curves: Curves, pane: Pane) -> None:
    degrees = np.degrees(curves.offset)
    pane.set_curve("offset", degrees)
    curves.grow(pane, degrees, _LEAST)
    running = curves.running if isinstance(curves, ChainCurves) else NOTHING
    y, seams = wrap_degrees_about(running, 0.0)
    pane.set_curve("running", y, seams)
    if len(y):
        curves.grow(pane, y, _LEAST)


def _describe(curves: Curves, frame: int) -> Title:
    title = [
        (f"{tr('Offset removed')} ", "soft"),
        (format_angle_at_frame(curves.offset, frame), "text"),
    ]
    if isinstance(curves, ChainCurves) and len(curves.running):
        title.append(("   " + tr("paper's offset ╌"), "soft"))
        title.append((format_angle_at_frame(curves.running, frame), "soft"))
    return title


plot = Plot(
    key="offset",
    title=tr("Offset removed"),
    place=60,
    weight=3,
    priority=60,
    axis=lambda _: tr("offset (°)"),
    draw=_draw,
    describe=_describe,
    # The function offset(t) of the paper is drawn dimmed below the offset that the review removes.
    styles=(CurveStyle("running", "soft", dashed=True), CurveStyle("offset", "text")),
    shade=False,
)
