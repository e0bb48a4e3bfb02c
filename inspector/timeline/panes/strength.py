"""The pane for the strength that is compared with τ: for a limb, the jumps of its swivel."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.timeline.chain_curves import ChainCurves
from inspector.timeline.curves import NOTHING, SAME, Curves, Title, format_padded_degrees, widened
from inspector.timeline.limb_curves import LimbCurves
from inspector.timeline.pane import CurveStyle, Pane
from inspector.timeline.plot import Plot
from twistcore.detection.soft_onset import is_soft_error
from twistcore.skeleton.rotation import Array


def _axis(curves: Curves) -> str:
    return "Δφ (°)" if isinstance(curves, LimbCurves) else tr("strength (°)")


def _draw_clip(curves: Curves, pane: Pane) -> None:
    pane.set_curve("strength", curves.strength)
    pane.set_curve("after", NOTHING)
    if isinstance(curves, ChainCurves):
        m = np.degrees(curves.before.strength)
        pane.set_curve("m", np.full_like(m, np.nan) if curves.is_m else m)
    else:
        pane.set_curve("m", NOTHING)


def _draw(curves: Curves, pane: Pane) -> None:
    pane.set_curve("soft", _soft_size(curves))
    if isinstance(curves, LimbCurves):
        size = np.degrees(np.abs(curves.departures))
        apart = widened(np.abs(size - curves.strength) > np.degrees(SAME))
        pane.set_curve("after", np.where(apart, size, np.nan))


def _soft_size(curves: Curves) -> Array:
    """Return the offset |δ| of soft errors in degrees, with NaN in all other frames, (frames,).

    A soft error begins and ends gradually, without a jump. Its strength, which is compared with τ,
    is the maximum of |δ|.
    """
    size = np.full(curves.document.frames, np.nan)
    for judged in curves.document.review.state.of_chain(curves.document.chain):
        if is_soft_error(interval := judged.interval):
            size[interval.start : interval.stop] = np.degrees(np.abs(interval.offset))
    return size


def _soft_title(curves: Curves, frame: int) -> Title:
    """Return title parts with |δ| of a soft error at a frame and its maximum, or []."""
    for judged in curves.document.review.state.of_chain(curves.document.chain):
        interval = judged.interval
        if interval.start <= frame < interval.stop and is_soft_error(interval):
            now, top = np.degrees([abs(interval.offset[frame - interval.start]), interval.largest])
            of = {
                "now": format_padded_degrees(now).strip(),
                "top": format_padded_degrees(abs(top)).strip(),
            }
            words = tr("soft |δ| ╌ {now}; its maximum {top} is compared with τ", **of)
            return [(f"   {words}", "text")]
    return []


def _describe(curves: Curves, frame: int) -> Title:
    own, scale = (
        format_padded_degrees(float(curves.strength[frame])),
        (f"   {tr('√ scale')}", "soft"),
    )
    if isinstance(curves, LimbCurves):
        after = format_padded_degrees(float(np.degrees(np.abs(curves.departures[frame]))))
        words: Title = [(f"{tr('Jump per frame')} ", "soft"), ("Δφ", "text")]
        return [*words, (own, "before"), (after, "after"), scale]
    assert isinstance(curves, ChainCurves)
    strength = (f"{tr('Strength')} ", "soft")
    if curves.is_m:
        return [strength, ("m", "text"), (own, "before"), scale]
    if soft := _soft_title(curves, frame):
        return [strength, (own, "before"), *soft, scale]
    m = format_padded_degrees(float(np.degrees(curves.before.strength[frame])))
    return [strength, (own, "before"), ("   " + tr("paper's m ╌"), "soft"), (m, "soft"), scale]


plot = Plot(
    key="strength",
    title=tr("Strength and τ"),
    place=40,
    weight=4,
    priority=10,
    axis=_axis,
    draw=_draw,
    draw_clip=_draw_clip,
    describe=_describe,
    # The function m(t) of the paper is drawn dimmed below the strength of another detector, for
    # comparison. A limb has a second curve after correction. In a soft interval, τ is compared with
    # the maximum of |δ|.
    styles=(
        CurveStyle("m", "soft", dashed=True),
        CurveStyle("after", "after"),
        CurveStyle("soft", "text", dashed=True),
        CurveStyle("strength", "before"),
    ),
    root=True,
    dots=(("strength", "m", False),),
    takes_tau=True,
)
