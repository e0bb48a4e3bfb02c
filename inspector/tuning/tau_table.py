"""The table of τ and its cost for each chain, with the current τ and with other profiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.tuning.tau_costs import Costs
from inspector.widgets.tables import RowModel, TableRow
from inspector.widgets.theme import Colours
from twistcore.detection import DETECTORS
from twistcore.tuning import Cost, Profile
from twistcore.tuning.cost_words import (
    describe_confidence_interval,
    describe_false_alarms,
    format_alarm_count,
)
from twistcore.tuning.listed_intervals import ListCounts

_HEADS = ("τ", "FSR", tr("listed"), tr("alarms"))
_TIPS = (
    tr("Threshold of the chain"),
    tr("Share of injected error frames that are repaired at this τ, in this clip"),
    tr("Number of intervals listed at this τ, with the automatic corrections in brackets"),
    tr("False alarms: intervals listed at this τ that you rejected"),
)
_WIDTH = len(_HEADS)


@dataclass(frozen=True)
class Column:
    """A profile (τ for each chain) to compare in the table, with its displayed name."""

    name: str
    profile: Profile


@dataclass(frozen=True)
class _Line:
    """A row of the table for one chain, or for all chains if `chain` is ''."""

    chain: str
    texts: tuple[str, ...]
    tips: tuple[str, ...]


class ComparisonModel(RowModel[_Line]):
    """A table of the cost of τ, with one row for each chain and a last row for all chains.

    Each profile has four columns.
    """

    def __init__(self, document: Document, colours: Colours, costs: Costs) -> None:
        super().__init__(colours)
        self._document = document
        self._costs = costs
        self.others: tuple[Column, ...] = ()
        self._take_heads()

    def key(self, thing: _Line) -> str:
        """Return the name of the chain."""
        return thing.chain

    def describe(self, thing: _Line) -> TableRow:
        """Return a row's cell texts. Values that are equal in both profiles are dimmed."""
        sets = [thing.texts[k : k + _WIDTH] for k in range(1, len(thing.texts), _WIDTH)]
        colours: dict[int, str] = {}
        for k, column in enumerate(zip(*sets, strict=True) if len(sets) > 1 else ()):
            colour = self.theme.soft if len(set(column)) == 1 else self.theme.text
            colours |= {1 + _WIDTH * n + k: colour for n in range(len(sets))}
        return TableRow(thing.texts, colours=colours, tips=thing.tips)

    # -- content ------------------------------------------------------------------------------

    @property
    def columns(self) -> tuple[Column, ...]:
        """The profiles to show: two profiles, or the current τ and at most one profile."""
        if len(self.others) > 1 or self._document.data is None:
            return self.others
        state = self._document.review.state
        return (Column(tr("now"), Profile(state.tau, state.method)), *self.others)

    def method(self, column: Column) -> str:
        """Return the name of a profile's detector or, by default, of the current detector."""
        return column.profile.method or self._document.review.state.method

    @property
    def note(self) -> str:
        """A note that names the detector of each profile, or '' if nothing is compared."""
        notes = []
        for column in self.columns if self.others else ():
            name, by = (
                _short(column.name),
                translate_core_sentence(DETECTORS.info(self.method(column)).label),
            )
            notes.append(
                f"{name}: {by}"
                if column.profile.method
                else tr(
                    "The profile {name} does not name a detector, so its costs are measured with "
                    "{by}.",
                    name=name,
                    by=by,
                )
            )
        return " · ".join(notes)

    def set_compared(self, others: Sequence[Column]) -> None:
        """Set the profiles to compare.

        One profile is compared with the current τ, and two profiles are compared with each other.
        """
        self.others = tuple(others)
        self.reset()

    def reset(self) -> None:
        """Rebuild the table after the clip or the profiles have changed."""
        self._take_heads()
        self.reset_rows(self._lines())

    def refresh(self) -> None:
        """Update the numbers in the table."""
        self.show(self._lines())

    def _lines(self) -> Sequence[_Line]:
        data = self._document.data
        chains = data.chains_and_limbs if data else ()
        lines = [self._line(c.name, translate_core_sentence(c.label)) for c in chains]
        return [*lines, self._line("", tr("All chains"))] if lines else ()

    def _line(self, chain: str, label: str) -> _Line:
        texts, tips = [label], [""]
        for column in self.columns:
            tau = column.profile.tau.get(chain)
            texts.append("" if not chain else "–" if tau is None else f"{np.degrees(tau):.2f}°")
            tips.append("")
            known = self._cost(column, (chain,) if chain else self._costs.names)
            if known is None or np.isnan(known[0].fsr):
                texts += (_WIDTH - 1) * [self._unknown(column, chain)]
                tips += (_WIDTH - 1) * [""]
            else:
                cost, counts = known
                listed = f"{counts.listed:.0f} ({counts.automatic:.0f})"
                texts += [f"{100 * cost.fsr:.1f} %", listed, format_alarm_count(cost)]
                tips += [
                    translate_core_sentence(describe_confidence_interval(cost)),
                    "",
                    translate_core_sentence(describe_false_alarms(cost)),
                ]
        return _Line(chain, tuple(texts), tuple(tips))

    def _unknown(self, column: Column, chain: str) -> str:
        known = chain in self._costs.names and chain in column.profile.tau
        coming = self._costs.coming(self.method(column))
        return "…" if coming and (known or not chain) else "–"

    def _take_heads(self) -> None:
        """Set the column headings. If profiles are compared, the headings contain their names."""
        heads, tips = ["\n" * bool(self.others) + tr("Chain")], [""]
        for column in self.columns:
            for what, tip in zip(_HEADS, _TIPS, strict=True):
                whose = _short(column.name) if what == _HEADS[0] else ""
                heads.append(f"{whose}\n{what}" if self.others else what)
                by = translate_core_sentence(DETECTORS.info(self.method(column)).label)
                tips.append(tr("{name}: {what}, using {by}", name=column.name, what=tip, by=by))
        self.heads, self.head_tips, self.right = tuple(heads), tuple(tips), range(1, len(heads))

    def _cost(self, column: Column, chains: Sequence[str]) -> tuple[Cost, ListCounts] | None:
        """Return the combined cost of a profile's τ for some chains, or None if not measured yet.

        Chains without a τ in the profile are ignored.
        """
        tau = {name: column.profile.tau[name] for name in chains if name in column.profile.tau}
        method = self.method(column)
        if len(chains) > 1 and len(self._costs.by(method)) < len(chains):
            return None
        return self._costs.cost(method, tau)


def _short(name: str) -> str:
    return name if len(name) <= 16 else name[:15] + "…"
