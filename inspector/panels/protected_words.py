"""Describe the side effects of a correction in a sentence and in a table of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from inspector.language import tr, translate_core_sentence
from inspector.widgets.signed_numbers import format_number
from twistcore.analysis.correction.protected_measures import (
    ENDS,
    HINGE,
    PATH,
    ROLL,
    TURNS,
    ProtectedMeasure,
)

_NAMES: Mapping[str, tuple[str, str]] = {  # name and unit of each protected measure
    HINGE: (tr("sideways bend"), "°"),
    TURNS: (tr("impossibly fast turns"), tr(" frames")),
    ROLL: (tr("peak roll speed of the next joint"), tr("° per frame")),
    PATH: (tr("path of the middle joint"), tr(" % of the limb's length")),
    ENDS: (tr("displacement of hands and feet"), tr(" % of the height")),
}


def worsened_measures_sentence(measures: Sequence[ProtectedMeasure]) -> str:
    """Return a sentence about the measures that the correction makes worse, or ''."""
    worse = [translate_core_sentence(m.doubt) for m in measures if m.worse]
    return tr("Side effects of the correction: {what}.", what=", ".join(worse)) if worse else ""


def protected_measures_table(measures: Sequence[ProtectedMeasure]) -> str:
    """Return a table with one line per measure: its value before and after the correction."""
    return "\n".join(map(_line, measures))


def _line(measure: ProtectedMeasure) -> str:
    name, unit = _NAMES[measure.name]
    digits = 0 if measure.name == TURNS else 1
    line = tr(
        "{joint}, {name}: {before} → {after}{unit}",
        joint=measure.joint,
        name=name,
        before=format_number(measure.before, digits),
        after=format_number(measure.after, digits),
        unit=unit,
    )
    return tr("{line} (worse)", line=line) if measure.worse else line
