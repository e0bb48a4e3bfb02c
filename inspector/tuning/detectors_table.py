"""The detectors table, with the suggested τ, the automatic τ and their costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.tuning.tau_costs import Costs
from inspector.tuning.wishes import Wishes
from inspector.widgets.tables import RowModel, TableRow
from inspector.widgets.theme import Colours
from twistcore.detection import DETECTORS
from twistcore.tuning import TauCurve
from twistcore.tuning.cost_words import (
    describe_confidence_interval,
    describe_false_alarms,
    format_alarm_count,
    format_repaired_share,
)

_KINDS = ("suggested", "automatic")
_AUTOMATIC = f"    {tr('automatic τ')}"
_AT = dict(zip(_KINDS, (tr("At the suggested τ"), tr("At the automatic τ")), strict=True))
_HEADS = ("τ", "FSR %", tr("alarms"))
_TIPS = (
    tr("τ of the chain"),
    tr(
        "Share of injected error frames that are repaired, with its confidence interval over the "
        "repetitions"
    ),
    tr("False alarms: intervals listed at this τ that you rejected"),
)


@dataclass(frozen=True)
class _Line:
    """A row of the table: the suggested or the automatic τ of one chain.

    If `chain` is '', the row shows the values for all chains together.
    """

    chain: str
    kind: str
    texts: tuple[str, ...]
    tips: tuple[str, ...]


class DetectorsModel(RowModel[_Line]):
    """The table of the costs of all detectors.

    The table has two rows for each chain, and two rows for all chains together.

    The first row of each pair shows the suggested τ, and the second row the automatic τ.
    """

    def __init__(self, document: Document, colours: Colours, costs: Costs, wishes: Wishes) -> None:
        super().__init__(colours)
        self._document, self._costs, self._wishes = document, costs, wishes
        infos = DETECTORS.infos()
        self.methods = tuple(info.name for info in infos)
        whose = [translate_core_sentence(info.column) for info in infos]
        self.heads = "\n" + tr("Chain"), *(f"{w}\n{what}" for w in whose for what in _HEADS)
        self.head_tips = (
            "",
            *(f"{tip}: {translate_core_sentence(i.label)}" for i in infos for tip in _TIPS),
        )
        self.right = range(1, len(self.heads))

    def key(self, thing: _Line) -> tuple[str, str]:
        """Return a row's key: its chain, and whether it shows the suggested or the automatic τ."""
        return thing.chain, thing.kind

    def describe(self, thing: _Line) -> TableRow:
        """Return a row's cell texts. Rows with the automatic τ are dimmed."""
        soft = thing.kind == _KINDS[1]
        colours = dict.fromkeys(range(len(thing.texts)), self.theme.soft) if soft else {}
        return TableRow(thing.texts, colours=colours, tips=thing.tips)

    def refresh(self) -> None:
        """Update the numbers in the table."""
        data = self._document.data
        names = {c.name: translate_core_sentence(c.label) for c in data.chains} if data else {}
        chains = [(name, label) for name, label in names.items() if name in self._costs.names]
        if not chains:
            self.show(())
            return
        lines = [*chains, ("", tr("All chains"))]
        self.show([self._line(*c, kind) for c in lines for kind in _KINDS])

    def _line(self, chain: str, label: str, kind: str) -> _Line:
        texts, tips = [label if kind == _KINDS[0] else _AUTOMATIC], [_AT[kind]]
        for method in self.methods:
            curves = self._costs.by(method)
            measured = {k: self._tau(c, kind) for k, c in curves.items() if chain in ("", k)}
            there = 1 if chain else len(self._costs.names)
            known = self._costs.cost(method, measured) if len(measured) == there else None
            cost = known[0] if known else None
            tau_text = f"{np.degrees(measured[chain]):.2f}°" if chain in measured else ""
            if cost is None:
                unknown = "…" if self._costs.coming(method) else "–"
                texts += [unknown if chain else "", unknown, unknown]
                tips += 3 * [""]
            else:
                texts += [
                    tau_text,
                    format_repaired_share(cost, 0, unit=""),
                    format_alarm_count(cost),
                ]
                tips += [
                    "",
                    translate_core_sentence(describe_confidence_interval(cost)),
                    translate_core_sentence(describe_false_alarms(cost)),
                ]
        return _Line(chain, kind, tuple(texts), tuple(tips))

    def _tau(self, curve: TauCurve, kind: str) -> float:
        return self._wishes.suggested(curve) if kind == _KINDS[0] else curve.automatic


def first_row_of_chain(lines: Sequence[_Line], chain: str) -> int | None:
    """Return the index of the first row of a chain, or None if the table does not list it."""
    return next((k for k, line in enumerate(lines) if line.chain == chain), None)
