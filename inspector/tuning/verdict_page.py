"""The page of what was decided: precision and recall of τ, and the τ that this speaks for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QItemSelectionModel, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHeaderView, QStackedLayout, QWidget

from inspector.session.document import Document
from inspector.tuning.verdict_evidence import CLIP, Scope, VerdictEvidence
from inspector.tuning.verdict_plots import PrecisionPlot
from inspector.widgets.building import hbox, hint, tool_button, vbox
from inspector.widgets.labels import Caption, inked
from inspector.widgets.tables import Row, RowModel, RowTable
from inspector.widgets.theme import Theme
from twistcore.tuning.verdict_curve import ENOUGH_ERRORS, Suggestion, score

NARROW = 420  # pixels of a page's width
_NOTHING = (
    "Nothing is decided yet. Accept (A) or reject (R) intervals in the list: from "
    f"{ENOUGH_ERRORS} accepted ones on, in this clip and in sessions beside its folder's other "
    "clips, your verdicts suggest a τ."
)


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


def needed_words(scope: Scope) -> str:
    """What has to be decided before a scope suggests a τ."""
    errors, own = scope.curve.needed
    parts = []
    if errors:
        where = ", of any chain of this rig," if scope.chain else ""
        parts.append(f"{errors} more accepted interval{'s' * (errors > 1)}{where}")
    if own and scope.chain:  # elsewhere these are among the accepted ones
        parts.append(f"{own} more verdict{'s' * (own > 1)} on this chain")
    are = "are" if len(parts) > 1 or max(errors, own) > 1 else "is"
    return f"{' and '.join(parts)} {are} needed here for a τ."


class VerdictPage(QWidget):
    """Draws the evidence for the present τ; asks the document for another."""

    asked = Signal(float, bool)  # degrees for the selected chain; True while a drag goes on
    dropped = Signal()

    def __init__(self, document: Document, evidence: VerdictEvidence, theme: Theme) -> None:
        super().__init__()
        self._document, self._evidence, self._theme = document, evidence, theme
        self._scope = CLIP
        self._build(theme)
        evidence.changed.connect(self.refresh)

    def _build(self, theme: Theme) -> None:
        self.hint = hint(_NOTHING)
        self._pages = QStackedLayout(self)
        self._pages.addWidget(self.hint)
        content = QWidget()
        self._pages.addWidget(content)
        self.model = ScopeModel(theme)
        self.table = RowTable(self.model, room=5)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.table.setAccessibleName("Verdicts by clip, performer, rig, folder and chain")
        self.table.selectionModel().currentRowChanged.connect(self._choose)
        self.plot = PrecisionPlot(theme)
        self.plot.setAccessibleName("Precision and recall against τ")
        self.plot.setToolTip("Drag the τ line, or double click where it should be")
        self.plot.asked.connect(self.asked)
        self.plot.dropped.connect(self.dropped)
        self.legend, self.words = Caption(), Caption(soft=True)
        self.use = tool_button("Use", "", flat=False)
        self.use.clicked.connect(self.take)
        told = hbox((self.words, 1), self.use, spacing=6)
        parts = (self.table, 2), self.legend, (self.plot, 3), told
        vbox(*parts, owner=content, margins=(0, 4, 0, 0), spacing=2)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Where room is short, sentences are a line whose tip tells the rest."""
        super().resizeEvent(event)
        self.words.set_short(self.width() < NARROW)
        self._show_scope()

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._theme = theme
        self.model.set_theme(theme)
        self.plot.set_theme(theme)
        self._show_scope()

    # -- what is chosen -----------------------------------------------------------------------

    @property
    def scope(self) -> Scope | None:
        """Whose verdicts are shown."""
        present = self._evidence.present
        scopes = present.scopes if present else ()
        return next((s for s in scopes if s.name == self._scope), next(iter(scopes), None))

    def show_scope(self, name: str) -> None:
        """Show the verdicts of a row."""
        self._scope = name
        self._show_scope()

    def _choose(self) -> None:
        at = self.table.currentIndex()
        if at.isValid():
            self.show_scope(self.model.things[at.row()].name)
            if (scope := self.scope) is not None and scope.chain in self._labels:
                self._document.select_chain(scope.chain)  # whose τ the line is

    def suggested(self) -> dict[str, float]:
        """τ by chain, radians, that the scope shown suggests for chains of the clip."""
        scope, data = self.scope, self._document.data
        if scope is None or data is None:
            return {}
        names = [c.name for c in data.chains]
        if scope.chain:
            own = suggestion_of(scope)
            return {scope.chain: own.tau} if own and scope.chain in names else {}
        found = scope.found
        given = {name: found.tau(name) for name in names} if found else {}
        return {name: t for name, t in given.items() if t is not None}

    def take(self) -> None:
        """Detect with the τ that is suggested: one step."""
        self._document.set_taus(self.suggested())

    # -- drawing ------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Draw what is known now."""
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
        return {c.name: c.label for c in data.chains} if data else {}

    def show_tau(self, degrees: float, *, held: bool) -> None:
        """The present τ of the selected chain."""
        self.plot.show_tau(degrees, held=held and self.plot.tau_line.moving)

    def _show_scope(self) -> None:
        scope, theme = self.scope, self._theme
        if scope is None:
            return
        suggestion = suggestion_of(scope)
        self.plot.show_curve(scope.curve, suggestion)
        legend = [
            inked("━ recall", theme.after),
            inked("━ precision", theme.accepted),
        ]
        if self.width() >= NARROW:
            seen = math.degrees(scope.curve.reviewed)
            legend.append(inked(f"╌ listed from {seen:.2f}°", theme.soft))
        if suggestion is not None:
            ends = f"{math.degrees(suggestion.low):.2f}–{math.degrees(suggestion.high):.2f}°"
            legend.append(inked(f"▼ {math.degrees(suggestion.tau):.2f}° ({ends})", theme.accepted))
        self.legend.set_text(" &nbsp; ".join(legend))
        self.words.set_text(self._said(scope, self._labels.get))
        tau = self.suggested()
        now = self._document.review.state.tau
        self.use.setEnabled(any(abs(now[name] - t) > 1e-6 for name, t in tau.items()))
        label = self._labels.get(scope.chain, scope.chain)
        self.use.setToolTip(
            f"Detect with the suggested τ in {label or f'{len(tau)} chains'}, one step"
        )

    def _said(self, scope: Scope, label: Callable[[str], str | None]) -> str:
        evidence = self._evidence
        if evidence.trouble:
            return evidence.trouble
        if suggestion_of(scope) is None:
            told = needed_words(scope)
        elif scope.found is not None:
            told = " ".join(scope.found.words(lambda name: label(name) or name))
        else:
            told = "What this chain alone suggests; the rows above say if all may share one."
        skipped = evidence.present.skipped if evidence.present else ()
        if skipped:
            told += f" Left out: {'; '.join(skipped[:2])}{' …' if len(skipped) > 2 else ''}."
        return told + (" Counting …" if evidence.running else "")
