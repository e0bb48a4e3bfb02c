"""The pane for Δθp and Δθc, the changes of a chain's angles from frame to frame."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.timeline.chain_curves import ANGLES, ChainCurves
from inspector.timeline.curves import SAME, Curves, Title, widened
from inspector.timeline.pane import BEFORE_AND_AFTER, Pane
from inspector.timeline.plot import Plot

_LEAST = 10.0  # smallest range in degrees


def _axis(curves: Curves) -> str:
    return "Δθ (°)" if isinstance(curves, ChainCurves) else ""


def _draw_clip(curves: Curves, pane: Pane) -> None:
    assert isinstance(curves, ChainCurves)
    for _, name in ANGLES:
        y = np.degrees(getattr(curves.before, f"d{name}"))
        curves.grow(pane, y, _LEAST)
        curves.grow(pane, -y, _LEAST)


def _draw(curves: Curves, pane: Pane) -> None:
    assert isinstance(curves, ChainCurves)
    for k, name in ANGLES:
        was, now = getattr(curves.before, f"d{name}"), getattr(curves.after, f"d{name}")
        pane.set_curve(f"{k}_after", np.degrees(now))
        apart = widened(np.abs(was - now) > SAME)
        pane.set_curve(f"{k}_before", np.degrees(np.where(apart, was, np.nan)))


def _describe(curves: Curves, frame: int) -> Title:
    assert isinstance(curves, ChainCurves)
    words, scale = (f"{tr('Per frame')} ", "soft"), (tr("√ scale"), "soft")
    return [words, *curves.both_angles("d", frame), scale]


plot = Plot(
    key="delta",
    title=tr("Per frame: Δθp and Δθc"),
    place=20,
    weight=3,
    priority=40,
    axis=_axis,
    draw=_draw,
    draw_clip=_draw_clip,
    describe=_describe,
    styles=BEFORE_AND_AFTER,
    root=True,
    in_exercise=True,
    dots=(("dtheta_p", "Δθp", False), ("dtheta_c", "Δθc", True)),
)
