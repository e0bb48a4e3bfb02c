"""Texts about the cost of τ, differences in cost, and intervals without a verdict."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from inspector.language import plural, tr, translate_core_sentence
from inspector.tuning.tau_costs import Costs
from inspector.tuning.wishes import Wishes
from inspector.widgets.signed_numbers import format_signed_number
from twistcore.tuning import TauCurve
from twistcore.tuning.cost_words import describe_confidence_interval, format_repaired_share

_SAME = 0.006  # degrees; texts have two decimals


def tau_cost_texts(costs: Costs, method: str, chain: str, tau: float) -> tuple[list[str], str]:
    """Return a list of texts about the cost of τ for a chain, and a tool tip.

    The texts state the number of listed intervals, the share of repaired errors (FSR) and the
    number of false alarms. If the chain has not been measured, the list is empty. `tau` is in
    radians.
    """
    if (known := costs.cost(method, {chain: tau})) is None:
        return [], ""
    cost, counts = known
    listed = tr(
        "τ {tau:.2f}°: {listed:.0f} listed, {automatic:.0f} automatic",
        tau=np.degrees(tau),
        listed=counts.listed,
        automatic=counts.automatic,
    )
    alarms = plural("{n} false alarm", "{n} false alarms", round(cost.alarms))
    return [listed, f"FSR {format_repaired_share(cost)}", alarms], translate_core_sentence(
        describe_confidence_interval(cost)
    )


def suggestion_text(
    wishes: Wishes, curve: TauCurve, present: float, gain: Callable[[float, float], str]
) -> str:
    """Return a text with the suggested τ and its advantage over the current τ.

    `present` is the current τ in radians. If no τ is better, the text shows which range of τ has
    the same cost. `gain` returns a text about the difference in cost between two values of τ in
    radians.
    """
    suggested = wishes.suggested(curve, present)
    if suggested != present:
        tau = tr("suggested {tau:.2f}°", tau=np.degrees(suggested))
        return f"{tau} ({gain(present, suggested)})"
    low, high = np.degrees(wishes.plateau(curve, present))
    if high - low < _SAME:
        return tr("{tau:.2f}° is best: no change", tau=np.degrees(present))
    return tr("{low:.2f}–{high:.2f}° cost the same: no change", low=low, high=high)


def cost_change_text(costs: Costs, method: str, chain: str, before: float, now: float) -> str:
    """Return a text about the change in a chain's cost if its τ changes from `before` to `now`.

    Both values of τ are in radians.
    """
    old, new = (costs.cost(method, {chain: tau}) for tau in (before, now))
    curve = costs.by(method).get(chain)
    if old is None or new is None or curve is None:
        return ""
    parts, points = [], format_signed_number(100.0 * (new[0].fsr - old[0].fsr))
    if points != format_signed_number(0.0):
        parts.append(tr("{points} points", points=points))
    if alarms := round(new[0].alarms - old[0].alarms):
        count = format_signed_number(alarms, 0)
        parts.append(
            plural("{count} false alarm", "{count} false alarms", abs(alarms), count=count)
        )
    if unjudged := curve.unjudged_at(now) - curve.unjudged_at(before):
        parts.append(
            plural(
                "{count} unjudged correction",
                "{count} unjudged corrections",
                abs(unjudged),
                count=format_signed_number(unjudged, 0),
            )
        )
    return ", ".join(parts) or tr("same cost")


def unjudged_intervals_text(costs: Costs, chain: str, tau: float) -> str:
    """Return a text about the intervals without a verdict that affect a chain's cost, or ''.

    Some of them are counted as errors; others are counted as false alarms at the threshold `tau` in
    radians.
    """
    capture, curve = costs.capture, costs.curves.get(chain)
    sure = sum(name == chain for name, _, _ in capture.presumed) if capture else 0
    unjudged = curve.unjudged_at(tau) if curve is not None else 0
    words = []
    if sure:
        words.append(
            plural(
                "{n} confident interval counts as an error until you judge it",
                "{n} confident intervals count as errors until you judge them",
                sure,
            )
        )
    if unjudged:
        words.append(
            plural(
                "{n} unjudged correction counts as a false alarm until you judge it",
                "{n} unjudged corrections count as false alarms until you judge them",
                unjudged,
            )
        )
    return " · ".join(words)
