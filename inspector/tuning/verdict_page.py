"""A page about the user's verdicts: precision and recall at each τ, and the suggested τ."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QItemSelectionModel, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHeaderView, QStackedLayout, QWidget

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.document import Document
from inspector.tuning.tau_costs import Costs
from inspector.tuning.verdict_evidence import CLIP, Scope, VerdictEvidence
from inspector.tuning.verdict_plots import PrecisionPlot
from inspector.widgets.building import hbox, hint, tool_button, vbox
from inspector.widgets.labels import Caption, coloured_rich_text, escape_tool_tip_text, plain_text
from inspector.widgets.tables import RowModel, RowTable, TableRow
from inspector.widgets.theme import Colours
from twistcore.tuning.verdict_curve import ENOUGH_ERRORS, Suggestion, verdict_score

NARROW = 420  # width in pixels below which sentences are shortened
LOW = 260  # height in pixels above which there is room for a whole sentence
_NOTHING = tr(
    "No counter-twists have been decided yet. Accept (A) or reject (R) intervals in the list. "
    "After {n} accepted counter-twists in this clip and in the sessions of its folder, your "
    "verdicts suggest a τ.",
    n=ENOUGH_ERRORS,
)


@dataclass(frozen=True)
class ScopeLine:
    """A table row that shows a group of verdicts."""

    name: str
    texts: tuple[str, ...]
    tip: str


class ScopeModel(RowModel[ScopeLine]):
    """The table of verdict groups, with one row for each group."""

    heads = (tr("Scope"), "✓", "✗", tr("Precision"), tr("Recall"), "τ")
    head_tips = (
        tr(
            "The group of verdicts. For a chain, verdicts from all clips with this rig are counted."
        ),
        tr("Number of intervals accepted as errors"),
        tr("Number of intervals rejected as natural motion"),
        tr("The share of intervals found at the current τ that you accepted"),
        tr("The share of accepted intervals that are found at the current τ"),
        tr("The τ suggested by the verdicts"),
    )
    right = (1, 2, 3, 4, 5)

    def key(self, thing: ScopeLine) -> str:
        """Return the name of the group."""
        return thing.name

    def describe(self, thing: ScopeLine) -> TableRow:
        """Return a row's cell texts and its tool tip."""
        return TableRow(thing.texts, tips=(thing.tip,))

    def take(
        self, scopes: Sequence[Scope], tau: Mapping[str, float], label: Mapping[str, str]
    ) -> None:
        """Show groups of verdicts at the current τ.

        `tau` is the current τ in radians, keyed by chain. `label` contains the displayed name of
        each chain, keyed by its name.
        """
        self.show([_line(s, tau, label) for s in scopes])


def suggestion_of(scope: Scope) -> Suggestion | None:
    """Return the suggested τ from a group of verdicts, for its chain or for all chains."""
    if scope.chain or scope.found is None:
        return scope.suggestion
    return scope.found.common


def _line(scope: Scope, tau: Mapping[str, float], label: Mapping[str, str]) -> ScopeLine:
    score = verdict_score(scope.clips, tau, scope.chain or None)
    suggestion = suggestion_of(scope)
    name = label.get(scope.chain, scope.name)
    clips = sum(bool(c.verdicts) for c in scope.clips)
    texts = (
        name,
        str(score.errors),
        str(score.natural),
        _share(score.precision),
        _share(score.recall),
        f"{math.degrees(suggestion.tau):.2f}°" if suggestion else "–",
    )
    n = score.errors + score.natural
    tip = [tr("{whose}: {n} verdicts in {clips} clips", whose=name, n=n, clips=clips)]
    for what, share in ((tr("Precision"), score.precision), (tr("Recall"), score.recall)):
        tip.append(_between(f"{what} {_share(share)}", *_ends(share)))
    if suggestion:
        ends = (f"{math.degrees(tau):.2f}°" for tau in (suggestion.low, suggestion.high))
        tip.append(_between(tr("Suggested τ {tau}", tau=texts[-1]), *ends))
    return ScopeLine(scope.name, texts, "\n".join(tip))


def _share(share: tuple[float, float, float]) -> str:
    return "–" if math.isnan(share[0]) else f"{100 * share[0]:.0f} % ± {_half(share):.0f}"


def _half(share: tuple[float, float, float]) -> float:
    return 100 * max(share[2] - share[0], share[0] - share[1])


def _ends(share: tuple[float, float, float]) -> tuple[str, str]:
    return f"{100 * share[1]:.0f}", f"{100 * share[2]:.0f} %"


def _between(what: str, low: str, high: str) -> str:
    return tr("{what}, {low} to {high} with 90 % confidence", what=what, low=low, high=high)


def needed_verdicts_sentence(scope: Scope) -> str:
    """Return a sentence that states which verdicts are still needed to suggest a τ."""
    errors, own = scope.curve.needed
    if scope.curve.enough:
        return translate_core_sentence(scope.curve.one_sided_sentence)
    parts = []
    if errors and scope.chain:
        parts.append(
            plural(
                "{n} more accepted interval in any chain of this rig",
                "{n} more accepted intervals in any chain of this rig",
                errors,
            )
        )
    elif errors:
        parts.append(plural("{n} more accepted interval", "{n} more accepted intervals", errors))
    if own and scope.chain:  # in other groups, these are among the accepted ones
        parts.append(
            plural("{n} more verdict on this chain", "{n} more verdicts on this chain", own)
        )
    what = tr(" and ").join(parts)
    several = 2 if len(parts) > 1 else max(errors, own)
    return plural(
        "{what} is needed to suggest a τ for this group.",
        "{what} are needed to suggest a τ for this group.",
        several,
        what=what,
    )


class VerdictPage(QWidget):
    """A page with the precision, the recall and the suggested τ for a group of verdicts.

    `asked` is emitted with the new τ when the user changes τ.
    """

    asked = Signal(float, bool)  # τ of the selected chain in degrees; True during a drag
    dropped = Signal()

    def __init__(
        self, document: Document, evidence: VerdictEvidence, costs: Costs, colours: Colours
    ) -> None:
        super().__init__()
        self._document, self._evidence, self._colours = document, evidence, colours
        self._costs = costs
        self._scope = CLIP
        self._build()
        colours.changed.connect(self._show_scope)
        evidence.changed.connect(self.refresh)

    def _build(self) -> None:
        self.hint = hint(_NOTHING)
        self._pages = QStackedLayout(self)
        self._pages.addWidget(self.hint)
        content = QWidget()
        self._pages.addWidget(content)
        self.model = ScopeModel(self._colours)
        self.table = RowTable(self.model, room=5)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.table.setAccessibleName(tr("Verdicts by clip, performer, rig, folder and chain"))
        self.table.selectionModel().currentRowChanged.connect(self._choose)
        self.plot = PrecisionPlot(self._colours)
        self.plot.setAccessibleName(tr("Precision and recall against τ"))
        self.plot.setToolTip(tr("Drag the τ line, or double-click to set τ."))
        self.plot.asked.connect(self.asked)
        self.plot.dropped.connect(self.dropped)
        self.legend, self.words = Caption(), Caption(soft=True)
        self.use = tool_button(tr("Use"), "", flat=False)
        self.use.clicked.connect(self.take)
        foot = hbox((self.words, 1), self.use, spacing=6)
        parts = (self.table, 2), self.legend, (self.plot, 3), foot
        vbox(*parts, owner=content, margins=(0, 4, 0, 0), spacing=2)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """If the page is narrow and low, shorten long sentences to one line and add a tool tip."""
        super().resizeEvent(event)
        self.words.set_short(self.width() < NARROW and self.height() < LOW)
        self._show_scope()

    # -- the chosen scope ---------------------------------------------------------------------

    @property
    def scope(self) -> Scope | None:
        """The chosen group of verdicts, by default the first group."""
        present = self._evidence.present
        scopes = present.scopes if present else ()
        return next((s for s in scopes if s.name == self._scope), next(iter(scopes), None))

    def show_scope(self, name: str) -> None:
        """Show the verdicts of the group with this name."""
        self._scope = name
        self._show_scope()

    def _choose(self) -> None:
        at = self.table.currentIndex()
        if at.isValid():
            self.show_scope(self.model.things[at.row()].name)
            if (scope := self.scope) is not None and scope.chain in self._labels:
                self._document.select_chain(scope.chain)  # the τ line belongs to this chain

    def suggested(self) -> dict[str, float]:
        """Return the τ that the chosen group suggests, in radians, keyed by chain."""
        scope, data = self.scope, self._document.data
        if scope is None or data is None:
            return {}
        names = [c.name for c in data.chains]
        if scope.chain:
            own = suggestion_of(scope)
            return {scope.chain: own.tau} if own and scope.chain in names else {}
        reviewed = {name for clip in scope.clips for name in clip.reviewed}
        names = [name for name in names if name in reviewed]  # only chains with verdicts
        found = scope.found
        given = {name: found.tau(name) for name in names} if found else {}
        return {name: t for name, t in given.items() if t is not None}

    def take(self) -> None:
        """Use the suggested τ for each chain, in one undo step."""
        self._document.set_taus(self.suggested())

    # -- drawing ------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Update the table, the plots and the sentences."""
        evidence, document = self._evidence, self._document
        present = evidence.present
        scopes = present.scopes if present else ()
        any_verdict = any(clip.verdicts for scope in scopes for clip in scope.clips)
        self._pages.setCurrentIndex(int(any_verdict))
        if present is None or document.data is None or not any_verdict:
            self.hint.setText(evidence.trouble or _NOTHING)
            return
        tau = document.review.state.tau
        self.model.take([s for s in present.scopes if s.curve.counts != (0, 0)], tau, self._labels)
        stretch = QHeaderView.ResizeMode.Stretch
        self.table.horizontalHeader().setSectionResizeMode(0, stretch)
        names = [line.name for line in self.model.things]
        if self._scope not in names and names:
            self._scope = names[0]
        if self._scope in names:
            row = self.model.index(names.index(self._scope), 0)
            with QSignalBlocker(self.table.selectionModel()):
                flags = QItemSelectionModel.SelectionFlag
                self.table.selectionModel().setCurrentIndex(row, flags.ClearAndSelect | flags.Rows)
        self._show_scope()

    @property
    def _labels(self) -> Mapping[str, str]:
        data = self._document.data
        return {c.name: translate_core_sentence(c.label) for c in data.chains} if data else {}

    def show_tau(self, degrees: float, *, held: bool) -> None:
        """Show the current τ of the selected chain, in degrees, in the plot."""
        self.plot.show_tau(degrees, held=held and self.plot.tau_line.moving)

    def _show_scope(self) -> None:
        scope, theme = self.scope, self._colours.theme
        if scope is None:
            return
        suggestion = suggestion_of(scope)
        self.plot.show_curve(scope.curve, suggestion)
        injected = self._costs.curves.get(self._document.chain)
        self.plot.show_injected(injected)
        legend = [
            coloured_rich_text(tr("━ recall"), theme.after),
            coloured_rich_text(tr("━ precision"), theme.accepted),
        ]
        if injected is not None:
            legend.append(coloured_rich_text(tr("┄ FSR of injected errors"), theme.before))
        if self.width() >= NARROW:
            seen = math.degrees(scope.curve.reviewed)
            legend.append(
                coloured_rich_text(tr("╌ listed at or above {tau:.2f}°", tau=seen), theme.soft)
            )
        if suggestion is not None:
            ends = f"{math.degrees(suggestion.low):.2f}–{math.degrees(suggestion.high):.2f}°"
            legend.append(
                coloured_rich_text(
                    f"▼ {math.degrees(suggestion.tau):.2f}° ({ends})", theme.accepted
                )
            )
        self.legend.set_text(" &nbsp; ".join(legend))
        self.plot.setAccessibleDescription(plain_text(self.legend.text()))
        self.words.set_plain(self._description(scope, self._labels.get))
        tau = self.suggested()
        now = self._document.review.state.tau
        self.use.setEnabled(any(abs(now[name] - t) > 1e-6 for name, t in tau.items()))
        label = self._labels.get(scope.chain, scope.chain)
        self.use.setToolTip(
            escape_tool_tip_text(tr("Detect with the suggested τ in {chain}", chain=label))
            if label
            else tr("Detect with the suggested τ in {n} chains", n=len(tau))
        )

    def _description(self, scope: Scope, label: Callable[[str], str | None]) -> str:
        evidence = self._evidence
        if evidence.trouble:
            return evidence.trouble
        if suggestion_of(scope) is None:
            text = needed_verdicts_sentence(scope)
        elif scope.found is not None:
            text = " ".join(
                map(translate_core_sentence, scope.found.words(lambda name: label(name) or name))
            )
        else:
            text = tr(
                "This τ is only for this chain. The rows above show whether all chains can "
                "share a τ."
            )
        skipped = evidence.present.skipped if evidence.present else ()
        if skipped:
            some = "; ".join(skipped[:2]) + " …" * (len(skipped) > 2)
            text += " " + tr("Skipped: {clips}.", clips=some)
        return f"{text} {tr('Counting …')}" if evidence.running else text
