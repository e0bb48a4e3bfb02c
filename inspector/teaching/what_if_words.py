"""Sentences about the frame that the teaching tab shows."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.teaching.equation_table import LEAST, NEAR_STRAIGHT, NEAR_SWING
from inspector.teaching.taught_frame import FrameNumbers, reliability_text
from inspector.widgets.signed_numbers import format_number, format_signed_number
from twistcore.analysis.decomposition import UNDEFINED, Decomposition, WhatIf

_HINT = tr("The frame as captured. Move a slider to alter it. The review does not change.")
_TIP = np.radians(1.0)  # the nudge whose effect is described
_HALF_TURN = np.radians(120.0)  # beyond this twist, wrapping may change a sign


def what_if_comment(
    numbers: FrameNumbers, what_if: WhatIf, stage: float | None = None
) -> tuple[str, str]:
    """Return a text about the frame, and the name of the text's colour in the theme.

    `stage` is a stage of the animation from 0 to 2, or None.
    """
    d = numbers.frame
    if stage is not None:
        return _stage_sentence(d, stage), "soft"
    if text := _singular(d):
        return text, "warning"
    if what_if.applied:
        return _applied(numbers), "soft"
    if numbers.is_event:
        return _event(numbers, what_if), "tau"
    return _no_event(numbers, what_if), "soft"


def theta_change_per_tilt(alpha: float) -> float:
    """Return the change of θp, in radians, if w is tilted sideways by 1° near a swing of 180°.

    w is the direction of the parent's bone, and `alpha` is the angle of the swing in radians.
    """
    return float(2.0 * np.arctan2(_TIP, np.pi - alpha))


def azimuth_change_per_tilt(reliability: float) -> float:
    """Return the rotation of v⊥, in radians, if v is tilted by 1° in a nearly straight limb.

    v is the direction of the child's bone, and v⊥ is its component perpendicular to the parent's
    bone. `reliability` is the reliability of the azimuth, 0…1.
    """
    return float(np.arctan2(_TIP, np.arcsin(min(reliability, 1.0))))


def _stage_sentence(d: Decomposition, stage: float) -> str:
    if stage <= 1.0:
        return tr(
            "{share} of the swing, α = {alpha}. The swing takes a to w.",
            share=_share(stage),
            alpha=_whole(d.alpha),
        )
    return tr(
        "The swing and {share} of the twist, θp = {theta}. The twist rolls the bone about its "
        "own axis: w, n and α do not change.",
        share=_share(stage - 1.0),
        theta=_tenths(d.theta_p),
    )


def _singular(d: Decomposition) -> str:
    """Return a warning about undefined or unreliable angles, or ''."""
    turned, straight = d.swing_reliability < NEAR_SWING, d.azimuth_reliability < NEAR_STRAIGHT
    shape = tr("straight") if d.bend < np.pi / 2.0 else tr("folded flat")
    if turned and straight:
        return tr(
            "Both angles are singular: θp is {theta}, Δθc is {azimuth}. A nudge of 1° turns n and "
            "v⊥ by 5° or more.",
            theta=_state(d.swing_reliability),
            azimuth=_state(d.azimuth_reliability),
        )
    if not d.swing_is_one:
        return tr(
            "θp is undefined because w points opposite to a. Many pairs (n, θp) give this pose. A "
            "nudge makes θp unique."
        )
    if turned:
        return tr(
            "θp is nearly singular: w points almost opposite to a ({reliable}). Tipping w "
            "sideways by 1° would change θp by {angle}.",
            reliable=reliability_text(d.swing_reliability),
            angle=_whole(theta_change_per_tilt(d.alpha)),
        )
    if d.azimuth_reliability <= UNDEFINED:
        return tr(
            "Δθc and m are undefined: the limb is {shape}, so v⊥ has no direction. A nudge gives "
            "it one.",
            shape=shape,
        )
    if straight:
        return tr(
            "Δθc is nearly singular: the limb is nearly {shape} ({reliable}). Tipping v sideways "
            "by 1° would turn v⊥ by {angle}.",
            shape=shape,
            reliable=reliability_text(d.azimuth_reliability),
            angle=_whole(azimuth_change_per_tilt(d.azimuth_reliability)),
        )
    if not d.dtheta_p_is_defined:
        return tr(
            "θp was undefined in the previous frame, so Δθp, the product and m are undefined here."
        )
    if not d.dtheta_c_is_defined:
        return tr(
            "The limb was straight in the previous frame, so Δθc, the product and m are undefined "
            "here."
        )
    return ""


def _applied(numbers: FrameNumbers) -> str:
    c = numbers.correction
    fields = {
        "share": _share(c.applied),
        "whole": _tenths(c.whole),
        "before": _tenths(c.before.strength),
        "now": _tenths(numbers.frame.strength),
    }
    if numbers.own:
        return tr(
            "{share} of the interval’s offset {whole} is removed: m was {before}, now {now}. C "
            "counter-rotates by the same angle (Eq. 15) and keeps its orientation (Eq. 14).",
            **fields,
        )
    return tr(
        "{share} of offset(t) = {whole} is removed: m was {before}, now {now}. C counter-rotates "
        "by the same angle (Eq. 15) and keeps its orientation (Eq. 14).",
        **fields,
    )


def _event(numbers: FrameNumbers, what_if: WhatIf) -> str:
    d, c = numbers.frame, numbers.correction
    passed = f"m = {_tenths(d.strength)} ≥ τ = {_tenths(c.tau)}"
    if what_if.counter and what_if == WhatIf(twist=what_if.twist, counter=True) and what_if.twist:
        return tr(
            "P and C twist against each other, {passed}: a twist error. Only P has turned; C and "
            "G are as captured.",
            passed=passed,
        )
    return tr(
        "Opposite signs and {passed}: an event. err = {err} is added to offset(t). Such an event "
        "is the edge of an error or a very fast movement.",
        passed=passed,
        err=_signed(c.err),
    )


def _no_event(numbers: FrameNumbers, what_if: WhatIf) -> str:
    d, c = numbers.frame, numbers.correction
    small = f"m = {format_number(np.degrees(d.strength), 2)}° < τ = {_tenths(c.tau)}"
    if what_if.counter and min(abs(d.dtheta_p), abs(d.dtheta_c)) > _HALF_TURN:
        return tr(
            "C counter-rotates by the same angle, but wrapping at ±180° gives Δθp and Δθc the same "
            "sign. The paper’s test misses this error."
        )
    if what_if == WhatIf(twist=what_if.twist) and what_if.twist:
        if d.strength >= LEAST:
            return tr(
                "A pure twist: w, n, α and Δθc do not change. Δθp·Δθc < 0 comes from a small "
                "motion of the child itself ({small}), so a threshold τ is needed.",
                small=small,
            )
        return tr(
            "A pure twist: θp changes; w, n and α do not. The child turns with the parent, so "
            "Δθc does not change either. This is a real movement, not an error."
        )
    if d.strength >= LEAST:
        return tr(
            "Opposite signs, but {small}: no event. Natural motion often has small opposite "
            "changes. This is why there is a threshold τ.",
            small=small,
        )
    kept = WhatIf(swing=what_if.swing, toward=what_if.toward, counter=what_if.counter)
    if what_if.changes and what_if == kept:
        return tr(
            "A different swing with the same twist: w and q_swing change; θp, v and Δθc do not."
        )
    if what_if.changes and what_if == WhatIf(bend=what_if.bend, counter=what_if.counter):
        return tr(
            "The child is bent differently: v changes; the direction of v⊥, P and Δθc do not."
        )
    return tr("This change is not an event: {small}.", small=small) if what_if.changes else _HINT


def _state(reliability: float) -> str:
    return tr("undefined") if reliability <= UNDEFINED else reliability_text(reliability)


def _share(x: float) -> str:
    return f"{format_number(100.0 * x, 0)} %"


def _whole(angle: float) -> str:
    return f"{format_number(np.degrees(angle), 0)}°"


def _tenths(angle: float) -> str:
    return f"{format_number(np.degrees(angle))}°"


def _signed(angle: float) -> str:
    return f"{format_signed_number(np.degrees(angle))}°"
