"""The pane for the twist θp and the azimuth θc of a chain, or for the swivel φ of a limb."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.timeline.chain_curves import ANGLES, ChainCurves
from inspector.timeline.curve_values import wrap_degrees_about, wrap_degrees_above
from inspector.timeline.curves import NOTHING, SAME, Curves, Title, format_angle_at_frame, widened
from inspector.timeline.limb_curves import LimbCurves
from inspector.timeline.pane import BEFORE_AND_AFTER, TRACKED, Pane
from inspector.timeline.plot import Plot
from twistcore.skeleton.rotation import wrap

_LEAST = 20.0  # smallest range in degrees


def _axis(curves: Curves) -> str:
    return "φ (°)" if isinstance(curves, LimbCurves) else "θ (°)"


def _draw_clip(curves: Curves, pane: Pane) -> None:
    if isinstance(curves, LimbCurves):
        for name in ("c_before", "c_after", "c_tracked", "p_tracked"):
            pane.set_curve(name, NOTHING)
        y, _ = wrap_degrees_above(curves.swivel.angle, curves.seam)
        curves.grow(pane, y, _LEAST)
    elif isinstance(curves, ChainCurves):
        for k, name in ANGLES:
            y, _ = wrap_degrees_about(getattr(curves.before, name), curves.centres[k])
            curves.grow(pane, y, _LEAST)


def _draw(curves: Curves, pane: Pane) -> None:
    if isinstance(curves, LimbCurves):
        was, now = curves.swivel.angle, curves.after
        y, seams = wrap_degrees_above(now, curves.seam)
        pane.set_curve("p_after", y, seams)
        curves.grow(pane, y, _LEAST)
        y, seams = wrap_degrees_above(was, curves.seam)
        apart = widened(np.abs(wrap(was - now)) > SAME)
        pane.set_curve("p_before", np.where(apart, y, np.nan), seams)
    elif isinstance(curves, ChainCurves):
        for k, name in ANGLES:
            was, now = getattr(curves.before, name), getattr(curves.after, name)
            y, seams = wrap_degrees_about(now, curves.centres[k])
            pane.set_curve(f"{k}_after", y, seams)
            curves.grow(pane, y, _LEAST)
            # Draw the captured curve only where it differs, because overlaid lines would mix their
            # colours.
            apart = widened(np.abs(wrap(was - now)) > SAME)
            y, seams = wrap_degrees_about(np.where(apart, was, np.nan), curves.centres[k])
            pane.set_curve(f"{k}_before", y, seams)
            if curves.tracked is None:
                pane.set_curve(f"{k}_tracked", NOTHING)
                continue
            then = getattr(curves.tracked, name)
            apart = widened(np.abs(wrap(then - now)) > SAME)
            y, seams = wrap_degrees_about(np.where(apart, then, np.nan), curves.centres[k])
            pane.set_curve(f"{k}_tracked", y, seams)


def _describe(curves: Curves, frame: int) -> Title:
    legend: Title = [(f"{tr('━ before')} ", "before"), (tr("━ after"), "after")]
    if isinstance(curves, LimbCurves):
        return [
            (f"{tr('Swivel')} ", "soft"),
            ("φ", "text"),
            (format_angle_at_frame(curves.swivel.angle, frame), "before"),
            (format_angle_at_frame(curves.after, frame), "after"),
            ("   ", "soft"),
            *legend,
        ]
    assert isinstance(curves, ChainCurves)
    tracked = (f"{tr('━ tracked')} ", "tracked")
    first = (f"{tr('Twist')} ", "soft") if curves.tracked is None else tracked
    return [first, *curves.both_angles("", frame), *legend]


def _height(curves: Curves, name: str, angle: float) -> float:
    """Return an angle in degrees, wrapped to the same range as its curve.

    The range of a chain's curve is 180° on either side of its circular mean.
    """
    if not isinstance(curves, ChainCurves):
        return float(np.degrees(angle))
    y, _ = wrap_degrees_about(np.array([angle]), curves.centres[name[-1]])
    return float(y[0])


plot = Plot(
    key="theta",
    title=tr("Twist θp and azimuth θc, or a limb's swivel φ"),
    place=10,
    weight=4,
    priority=30,
    axis=_axis,
    draw=_draw,
    draw_clip=_draw_clip,
    describe=_describe,
    height=_height,
    styles=(*BEFORE_AND_AFTER, *TRACKED),
    glyphs=True,
    dots=(("theta_p", "θp", False), ("theta_c", "θc", True)),
)
