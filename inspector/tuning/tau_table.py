"""τ of every chain with what it costs on this clip: as it is now, and of profiles beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inspector.session.document import Document
from inspector.tuning.tau_costs import Costs
from inspector.widgets.tables import Row, RowModel
from inspector.widgets.theme import Theme
from twistcore.tuning import Profile

_HEADS = ("τ", "FSR", "alarms")
_TIPS = (
    "Threshold of the chain",
    "Share of injected error frames that are repaired at this τ, in this clip",
    "False alarms in this clip at this τ",
)


@dataclass(frozen=True)
class Column:
    """A profile and the name it is shown by."""

    name: str
    profile: Profile


@dataclass(frozen=True)
class _Line:
    """What the table says of a chain; the last line, of all chains, has no name."""

    chain: str
    texts: tuple[str, ...]


class ComparisonModel(RowModel[_Line]):
    """A row a chain, three columns a set of τ, and a last row over all chains."""

    def __init__(self, document: Document, theme: Theme, costs: Costs) -> None:
        super().__init__(theme)
        self._document = document
        self._costs = costs
        self.others: tuple[Column, ...] = ()
        self._take_heads()

    def key(self, thing: _Line) -> str:
        """The chain's name."""
        return thing.chain

    def describe(self, thing: _Line) -> Row:
        """What is the same in both sets is faint."""
        sets = [thing.texts[k : k + 3] for k in range(1, len(thing.texts), 3)]
        colours: dict[int, str] = {}
        for k, column in enumerate(zip(*sets, strict=True) if len(sets) > 1 else ()):
            colour = self.theme.soft if len(set(column)) == 1 else self.theme.text
            colours |= {1 + 3 * n + k: colour for n in range(len(sets))}
        return Row(thing.texts, colours=colours)

    # -- what it shows ------------------------------------------------------------------------

    @property
    def columns(self) -> tuple[Column, ...]:
        """The sets of τ side by side: two profiles, or the present τ and what is beside it."""
        if len(self.others) > 1 or self._document.data is None:
            return self.others
        state = self._document.review.state
        return (Column("now", Profile(state.tau, state.method)), *self.others)

    def show_beside(self, others: Sequence[Column]) -> None:
        """Other profiles beside the present τ: none, one, or two instead of it."""
        self.others = tuple(others)
        self.reset()

    def reset(self) -> None:
        """Another clip, or other sets."""
        self._take_heads()
        self.begin_anew(self._lines())

    def refresh(self) -> None:
        """Other numbers in the same rows."""
        self.show(self._lines())

    def _lines(self) -> Sequence[_Line]:
        data = self._document.data
        chains = data.chains_and_limbs if data else ()
        lines = [_Line(c.name, (c.label, *self._texts(c.name))) for c in chains]
        return [*lines, _Line("", ("All chains", *self._texts("")))] if lines else ()

    def _take_heads(self) -> None:
        """What, and above it whose where there are several."""
        heads, tips = ["\nChain" if self.others else "Chain"], [""]
        for column in self.columns:
            for what, tip in zip(_HEADS, _TIPS, strict=True):
                whose = _short(column.name) if what == _HEADS[0] else ""
                heads.append(f"{whose}\n{what}" if self.others else what)
                tips.append(f"{column.name}: {tip}")
        self.heads, self.head_tips, self.right = tuple(heads), tuple(tips), range(1, len(heads))

    def _texts(self, chain: str) -> tuple[str, ...]:
        return tuple(self._text(c, what, chain) for c in self.columns for what in range(3))

    def _text(self, column: Column, what: int, chain: str) -> str:
        if what == 0:
            tau = column.profile.tau.get(chain) if chain else None
            return f"{np.degrees(tau):.2f}°" if tau is not None else "" if not chain else "–"
        cost = self._cost(column, chain) if chain else self._total(column)
        if cost is None:
            known = chain in self._costs.names and chain in column.profile.tau
            return "…" if self._costs.running and (known or not chain) else "–"
        return f"{100 * cost[0]:.1f} %" if what == 1 else f"{cost[1]:.3g}"

    def _cost(self, column: Column, chain: str) -> tuple[float, float] | None:
        tau, curve = column.profile.tau.get(chain), self._costs.curves.get(chain)
        return curve.at(tau) if curve is not None and tau is not None else None

    def _total(self, column: Column) -> tuple[float, float] | None:
        """FSR over the error frames of all chains, and all alarms."""
        curves = self._costs.curves
        costs = [(self._cost(column, name), c.errors) for name, c in curves.items()]
        known = [(cost, errors) for cost, errors in costs if cost is not None]
        if len(known) < len(self._costs.names):
            return None
        errors = sum(e for _, e in known)
        return sum(c[0] * e for c, e in known) / max(errors, 1), sum(c[1] for c, _ in known)


def _short(name: str) -> str:
    return name if len(name) <= 16 else name[:15] + "…"
