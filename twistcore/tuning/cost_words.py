"""Describe the cost of a τ and the uncertainty of this cost in words."""

from __future__ import annotations

import math

from twistcore.tuning.tau_curve import Cost


def format_repaired_share(cost: Cost, digits: int = 1, unit: str = " %") -> str:
    """Return the FSR with its confidence limits as text, such as '93.1 % (86–97)'.

    FSR is the share of injected error frames that are repaired. If there are no errors, the result
    is '–'.
    """
    if math.isnan(cost.fsr):
        return "–"
    said = f"{100.0 * cost.fsr:.{digits}f}{unit}"
    if math.isnan(cost.low):
        return said
    return f"{said} ({100.0 * cost.low:.0f}–{100.0 * cost.high:.0f})"


def format_alarm_count(cost: Cost) -> str:
    """Return the number of false alarms as text, or '–' if no frame was examined."""
    return f"{cost.alarms:.3g}" if cost.minutes else "–"


def describe_confidence_interval(cost: Cost) -> str:
    """Return a sentence about the confidence interval of the FSR (the share of repaired frames)."""
    if math.isnan(cost.low):
        return "No error could be injected."
    low, high = 100.0 * cost.low, 100.0 * cost.high
    return (
        f"The share of repaired error frames (FSR) is between {low:.0f} and {high:.0f} % "
        "(95 % confidence, from the injected errors). More repetitions narrow this range."
    )


def describe_false_alarms(cost: Cost) -> str:
    """Return a sentence about the number of false alarms to expect in similar clips."""
    if not cost.minutes:
        return "No frame was examined."
    low, high = cost.rate_band
    return (
        f"{cost.alarms:.3g} in {60.0 * cost.minutes:.1f} s. Clips like this one have between "
        f"{low:.3g} and {high:.3g} per minute (95 % confidence)."
    )
