"""Whose verdicts there are, and what precision and recall they give the present τ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from inspector.tuning.verdict_evidence import Scope
from inspector.widgets.tables import Row, RowModel
from twistcore.tuning.verdict_curve import Suggestion, score


@dataclass(frozen=True)
class ScopeLine:
    """A scope as it is shown."""

    name: str
    texts: tuple[str, ...]
    tip: str


class ScopeModel(RowModel[ScopeLine]):
    """A row a scope."""

    heads = ("Verdicts of", "✓", "✗", "Precision", "Recall", "τ")
    head_tips = (
        "Whose intervals; of a chain, in all clips of this rig",
        "Accepted: errors",
        "Rejected: natural motion",
        "Of what is found at the present τ, the share that was accepted",
        "Of what was accepted, the share that is found at the present τ",
        "The τ that the verdicts speak for",
    )
    right = (1, 2, 3, 4, 5)

    def key(self, thing: ScopeLine) -> str:
        """Its name."""
        return thing.name

    def describe(self, thing: ScopeLine) -> Row:
        """What is short in it is said in the tip."""
        return Row(thing.texts, tips=(thing.tip,))

    def take(
        self, scopes: Sequence[Scope], tau: Mapping[str, float], label: Mapping[str, str]
    ) -> None:
        """Scopes at the present τ, radians by chain; label: what chains are called."""
        self.show([_line(s, tau, label) for s in scopes])


def suggestion_of(scope: Scope) -> Suggestion | None:
    """What a scope suggests: for its chain, or for all chains together."""
    if scope.chain or scope.found is None:
        return scope.suggestion
    return scope.found.common


def _line(scope: Scope, tau: Mapping[str, float], label: Mapping[str, str]) -> ScopeLine:
    told = score(scope.clips, tau, scope.chain or None)
    suggestion = suggestion_of(scope)
    name = label.get(scope.chain, scope.name)
    clips = sum(bool(c.verdicts) for c in scope.clips)
    texts = (
        name,
        str(told.errors),
        str(told.natural),
        _share(told.precision),
        _share(told.recall),
        f"{math.degrees(suggestion.tau):.2f}°" if suggestion else "–",
    )
    tip = [f"{name}: {told.errors + told.natural} verdicts in {clips} clips"]
    for what, share in (("Precision", told.precision), ("Recall", told.recall)):
        tip.append(f"{what} {_share(share)}, between {_ends(share)} with a certainty of 90 %")
    if suggestion:
        ends = f"{math.degrees(suggestion.low):.2f}° and {math.degrees(suggestion.high):.2f}°"
        tip.append(f"Suggested τ {texts[-1]}, between {ends} with a certainty of 90 %")
    return ScopeLine(scope.name, texts, "\n".join(tip))


def _share(share: tuple[float, float, float]) -> str:
    return "–" if math.isnan(share[0]) else f"{100 * share[0]:.0f} % ± {_half(share):.0f}"


def _half(share: tuple[float, float, float]) -> float:
    return 100 * max(share[2] - share[0], share[0] - share[1])


def _ends(share: tuple[float, float, float]) -> str:
    return f"{100 * share[1]:.0f} and {100 * share[2]:.0f} %"
