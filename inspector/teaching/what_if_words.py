"""A sentence or two on what is to be seen in the taught frame, each true of its numbers."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.teaching.equation_table import LEAST, NEAR_STRAIGHT, NEAR_SWING
from inspector.teaching.taught_frame import FrameNumbers, reliable
from inspector.widgets.signed_numbers import plain, signed
from twistcore.analysis.decomposition import UNDEFINED, Decomposition, WhatIf

_HINT = tr("The frame as captured. Move a slider: what if …? Nothing of it reaches the review.")
_TIP = np.radians(1.0)  # the nudge whose effect is told
_HALF_TURN = np.radians(120.0)  # a twist beyond which wrapping may turn a sign over


def words(numbers: FrameNumbers, what_if: WhatIf, stage: float | None = None) -> tuple[str, str]:
    """What is to be seen, and the theme's role for it."""
    d = numbers.frame
    if stage is not None:
        return _on_its_way(d, stage), "soft"
    if text := _singular(d):
        return text, "warning"
    if what_if.applied:
        return _applied(numbers), "soft"
    if numbers.is_event:
        return _event(numbers, what_if), "tau"
    return _no_event(numbers, what_if), "soft"


def theta_per_tip(alpha: float) -> float:
    """By how much θp changes when w is tipped sideways by 1° at a swing near 180°, radians."""
    return float(2.0 * np.arctan2(_TIP, np.pi - alpha))


def azimuth_per_tip(reliability: float) -> float:
    """By how much v⊥ turns when v is tipped sideways by 1° in a limb nearly straight, radians."""
    return float(np.arctan2(_TIP, np.arcsin(min(reliability, 1.0))))


def _on_its_way(d: Decomposition, stage: float) -> str:
    if stage <= 1.0:
        return tr(
            "First the swing: {share} of it, α = {alpha}. It takes a to w.",
            share=_share(stage),
            alpha=_whole(d.alpha),
        )
    return tr(
        "Then the twist: {share} of it, θp = {theta}. It rolls the bone about itself: w, n and α "
        "stay.",
        share=_share(stage - 1.0),
        theta=_tenths(d.theta_p),
    )


def _singular(d: Decomposition) -> str:
    """Words on the angles that are undefined, or nearly so."""
    turned, straight = d.swing_reliability < NEAR_SWING, d.azimuth_reliability < NEAR_STRAIGHT
    lies = tr("is straight") if d.bend < np.pi / 2.0 else tr("is folded flat")
    if turned and straight:
        return tr(
            "Both singularities: θp is {theta}, Δθc {azimuth}. A nudge of 1° turns n and v⊥ by 5° "
            "or more.",
            theta=_state(d.swing_reliability),
            azimuth=_state(d.azimuth_reliability),
        )
    if not d.swing_is_one:
        return tr(
            "Singularity of θp: w points against a, θp is undefined. One pose has many (n, θp), "
            "none better than another. Nudge, and there is one."
        )
    if turned:
        return tr(
            "Singularity of θp near: w points almost against a ({reliable}). Tipped sideways by "
            "1°, θp would change by {angle}.",
            reliable=reliable(d.swing_reliability),
            angle=_whole(theta_per_tip(d.alpha)),
        )
    if d.azimuth_reliability <= UNDEFINED:
        return tr(
            "Singularity of θc: the limb {lies}, v⊥ has no direction, Δθc is undefined, and so is "
            "m. Nudge, and there is one.",
            lies=lies,
        )
    if straight:
        return tr(
            "Singularity of θc near: the limb almost {lies} ({reliable}). Tipped sideways by 1°, "
            "v⊥ would turn by {angle}.",
            lies=lies,
            reliable=reliable(d.azimuth_reliability),
            angle=_whole(azimuth_per_tip(d.azimuth_reliability)),
        )
    if not d.dtheta_p_is_defined:
        return tr(
            "θp was undefined in the frame before, so Δθp, the product and m are undefined here."
        )
    if not d.dtheta_c_is_defined:
        return tr(
            "The limb was straight in the frame before, so Δθc, the product and m are undefined."
        )
    return ""


def _applied(numbers: FrameNumbers) -> str:
    c = numbers.correction
    told = {
        "share": _share(c.applied),
        "whole": _tenths(c.whole),
        "before": _tenths(c.before.strength),
        "now": _tenths(numbers.frame.strength),
    }
    if numbers.own:
        return tr(
            "{share} of the interval’s {whole} is off P’s twist: m was {before}, is {now}. C turns "
            "back as far (15) and stands as it stood (14).",
            **told,
        )
    return tr(
        "{share} of offset(t) = {whole} is off P’s twist: m was {before}, is {now}. C turns back "
        "as far (15) and stands as it stood (14).",
        **told,
    )


def _event(numbers: FrameNumbers, what_if: WhatIf) -> str:
    d, c = numbers.frame, numbers.correction
    passed = f"m = {_tenths(d.strength)} ≥ τ = {_tenths(c.tau)}"
    if what_if.counter and what_if == WhatIf(twist=what_if.twist, counter=True) and what_if.twist:
        return tr(
            "P and C twist against each other, {passed}. Only P has turned; C and G stand as "
            "captured: a twist error.",
            passed=passed,
        )
    return tr(
        "Opposed, {passed}: an event, and err = {err} goes into offset(t). An edge of an error, or "
        "motion as lively as one.",
        passed=passed,
        err=_signed(c.err),
    )


def _no_event(numbers: FrameNumbers, what_if: WhatIf) -> str:
    d, c = numbers.frame, numbers.correction
    small = f"m = {plain(np.degrees(d.strength), 2)}° < τ = {_tenths(c.tau)}"
    if what_if.counter and min(abs(d.dtheta_p), abs(d.dtheta_c)) > _HALF_TURN:
        return tr(
            "C turns back as far, yet Δθp and Δθc have one sign: near ±180° wrapping turns one "
            "over. The paper’s test is blind to this error."
        )
    if what_if == WhatIf(twist=what_if.twist) and what_if.twist:
        if d.strength >= LEAST:
            return tr(
                "A pure twist: w, n, α and Δθc stay. Δθp·Δθc < 0 by the child’s own small motion "
                "({small}): that is why there is a τ.",
                small=small,
            )
        return tr(
            "A pure twist: θp changes; w, n and α stay. The child goes along, so Δθc stays too: a "
            "real movement, no error."
        )
    if d.strength >= LEAST:
        return tr(
            "Opposed, but {small}: no event. Natural motion often makes small opposed changes; "
            "that is why there is a τ.",
            small=small,
        )
    kept = WhatIf(swing=what_if.swing, toward=what_if.toward, counter=what_if.counter)
    if what_if.changes and what_if == kept:
        return tr("Another swing with the same twist: w and q_swing change; θp, v and Δθc stay.")
    if what_if.changes and what_if == WhatIf(bend=what_if.bend, counter=what_if.counter):
        return tr("Another bend of the child: v changes, v⊥ keeps its direction; P and Δθc stay.")
    return tr("No event: {small}.", small=small) if what_if.changes else _HINT


def _state(reliability: float) -> str:
    return tr("undefined") if reliability <= UNDEFINED else reliable(reliability)


def _share(x: float) -> str:
    return f"{plain(100.0 * x, 0)} %"


def _whole(angle: float) -> str:
    return f"{plain(np.degrees(angle), 0)}°"


def _tenths(angle: float) -> str:
    return f"{plain(np.degrees(angle))}°"


def _signed(angle: float) -> str:
    return f"{signed(np.degrees(angle))}°"
