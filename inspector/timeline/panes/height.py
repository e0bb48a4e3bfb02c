"""The pane for the distance of a limb's middle joint from the line between the limb's ends."""

from __future__ import annotations

from inspector.language import tr, translate_core_sentence
from inspector.timeline.curves import Curves, Title
from inspector.timeline.limb_curves import LimbCurves
from inspector.timeline.pane import CurveStyle, Pane
from inspector.timeline.plot import Plot
from inspector.widgets.labels import capitalised


def _axis(curves: Curves) -> str:
    return tr("distance (%)") if isinstance(curves, LimbCurves) else ""


def _draw_clip(curves: Curves, pane: Pane) -> None:
    assert isinstance(curves, LimbCurves)
    pane.set_curve("height", curves.height)
    pane.show_values(0.0, max(10.0, float(curves.height.max(initial=0.0))))


def _describe(curves: Curves, frame: int) -> Title:
    assert isinstance(curves, LimbCurves)
    joint = capitalised(translate_core_sentence(curves.limb.middle_word))
    return [
        (f"{tr('{joint} distance', joint=joint)} ", "soft"),
        (f"{curves.height[frame]:5.1f}", "text"),
        (tr(" % of the limb's length"), "soft"),
    ]


plot = Plot(
    key="height",
    title=tr("Distance of the middle joint from the line between the limb's ends"),
    place=30,
    weight=3,
    priority=50,
    axis=_axis,
    draw_clip=_draw_clip,
    describe=_describe,
    styles=(CurveStyle("height", "text"),),
    unit=" %",
)
