"""The tuning tab: τ of the selected chain, what it costs, and τ of all chains beside profiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum

import numpy as np
from PySide6.QtCore import QModelIndex, QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QHeaderView,
    QLabel,
    QStackedLayout,
    QTabWidget,
    QToolButton,
    QWidget,
)

from inspector.session.document import Document
from inspector.timeline.tau_line import LARGEST_TAU, SMALLEST_TAU
from inspector.tuning.confidence_page import ConfidencePage
from inspector.tuning.tau_costs import Costs
from inspector.tuning.tau_plots import CostPlot, Histogram
from inspector.tuning.tau_table import Column, ComparisonModel
from inspector.tuning.verdict_evidence import VerdictEvidence
from inspector.tuning.verdict_page import VerdictPage
from inspector.widgets.building import Wrapping, action_button, hbox, hint, vbox
from inspector.widgets.labels import Caption, inked
from inspector.widgets.later import Burst, Latest, Stale
from inspector.widgets.tables import RowTable
from inspector.widgets.theme import Theme
from twistcore.tuning import Tuned, tuned

_SHORT = {  # on buttons, which stand where it is plain what they are about
    "tau_for_chain": "Chain",
    "tau_for_segment": "Both sides",
    "tau_for_all": "All",
    "load_profile": "Load…",
    "save_profile": "Save…",
    "compare_profiles": "Compare…",
    "take_profile": "Take over",
    "close_comparison": "Close",
    "profile_to_folder": "For the folder",
}
_PROFILE_BUTTONS = (
    ("load_profile", "save_profile", "profile_to_folder"),
    ("compare_profiles", "take_profile", "close_comparison"),
)  # fmt: skip


_SAME = 0.006  # degrees: the box has two decimals
_NO_COSTS = "What τ costs is measured for chains; a limb has its automatic τ."


class Scope(StrEnum):
    """Which chains a τ is set for."""

    CHAIN = "chain"
    SEGMENT = "segment"
    ALL = "all"


class TuningPanel(QWidget):
    """Draws the document and what `costs` knows of it; asks the document for another τ."""

    def __init__(self, document: Document, theme: Theme, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self._document, self._actions, self._theme = document, actions, theme
        self.costs = Costs(document, self)
        self.evidence = VerdictEvidence(document, self)
        self.scope = Scope.CHAIN
        self._drag = 0
        self._seen = False
        self._strength, self._floor = np.zeros(0), 0.0  # of the selected chain, degrees
        self._latest = Latest(self)
        self._stale = Stale(self)
        self._stale.due.connect(self.refresh)
        self._burst = Burst(document.begin_drag, self)
        self._build(theme)
        self.set_theme(theme)
        for signal in (document.opened, document.chain_changed, document.method_changed):
            signal.connect(self._stale.mark_all)
        document.opened.connect(self.model.reset)
        document.chains_changed.connect(self.model.reset)
        document.intervals_changed.connect(self._stale.mark)
        self.costs.changed.connect(self._stale.mark_all)
        self._enable(False)

    # -- building -----------------------------------------------------------------------------

    def _build(self, theme: Theme) -> None:
        self.hint = hint("Open a clip to see what every τ costs it.")
        self._pages = QStackedLayout(self)
        self._pages.addWidget(self.hint)
        content = QWidget()
        self._pages.addWidget(content)
        self.title = QLabel()
        self.box = QDoubleSpinBox(decimals=2, prefix="τ ", suffix="°")
        self.box.setRange(SMALLEST_TAU, LARGEST_TAU)
        self.box.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self.box.setKeyboardTracking(False)
        self.box.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.box.valueChanged.connect(
            lambda degrees: self.set_tau_degrees(degrees, self._burst.drag())
        )
        scopes = [
            self._button(name) for name in ("tau_for_chain", "tau_for_segment", "tau_for_all")
        ]
        for button in scopes:
            button.setObjectName("scope")
        suggest = self._button("suggest_tau")
        whose = hbox((self.title, 1), *scopes, spacing=4)
        head = Wrapping(whose, hbox(self.box, suggest, None, spacing=4), spacing=4)
        self.tabs = QTabWidget(documentMode=True)
        self.tabs.addTab(self._curves_page(theme), "Curves")
        self.tabs.addTab(self._profiles_page(theme), "Profiles")
        self.verdicts = VerdictPage(document := self._document, self.evidence, theme)
        self.verdicts.asked.connect(self._ask)
        self.verdicts.dropped.connect(self._drop)
        self.confidence = ConfidencePage(document, self.evidence, theme)
        self.tabs.addTab(self.verdicts, "Verdicts")
        self.tabs.addTab(self.confidence, "Confidence")
        self.tabs.currentChanged.connect(self._stale.mark_all)
        self.tabs.currentChanged.connect(self._watch_verdicts)
        vbox(head, (self.tabs, 1), owner=content, margins=(8, 6, 8, 6), spacing=4)

    def _button(self, name: str) -> QToolButton:
        return action_button(self._actions[name], _SHORT.get(name, self._actions[name].text()))

    def _curves_page(self, theme: Theme) -> QWidget:
        page = QWidget()
        self.histogram, self.cost = Histogram(theme), CostPlot(theme)
        for plot, name in (
            (self.histogram, "Frames by strength"),
            (self.cost, "FSR and false alarms against τ"),
        ):
            plot.setAccessibleName(name)
            plot.setToolTip("Drag the τ line, or double click where it should be")
            plot.asked.connect(self._ask)
            plot.dropped.connect(self._drop)
        self.strength_words, self.cost_words, self.state = Caption(), Caption(), Caption(soft=True)
        plots = self.strength_words, (self.histogram, 1), self.cost_words, (self.cost, 1)
        vbox(*plots, self.state, owner=page, margins=(0, 4, 0, 0), spacing=2)
        return page

    def _profiles_page(self, theme: Theme) -> QWidget:
        page = QWidget()
        self.model = ComparisonModel(self._document, theme, self.costs)
        self.table = RowTable(self.model, room=5)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.table.clicked.connect(self._choose)
        files, beside = (
            hbox(*map(self._button, names), None, spacing=4) for names in _PROFILE_BUTTONS
        )
        vbox(
            (self.table, 1),
            Wrapping(files, beside, spacing=4),
            owner=page,
            margins=(0, 4, 0, 0),
            spacing=4,
        )
        return page

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._theme = theme
        for part in (self.model, self.histogram, self.cost, self.verdicts, self.confidence):
            part.set_theme(theme)
        self._stale.mark_all()

    # -- following the document ---------------------------------------------------------------

    def set_seen(self, seen: bool) -> None:
        """Only what is looked at is measured and drawn.

        Told by the dock: behind another tab it is not hidden in Qt's sense, only out of sight.
        """
        self._seen = seen
        self.costs.watch(seen)
        self._watch_verdicts()
        if seen:
            self._stale.mark_all()

    def _watch_verdicts(self) -> None:
        """Verdicts are counted while somebody looks at what they say."""
        pages = self.verdicts, self.confidence
        self.evidence.watch(self._seen and self.tabs.currentWidget() in pages)

    def refresh(self) -> None:
        """Draw what has changed now."""
        anything, everything = self._stale.take()
        if not (anything and self._seen):
            return
        document = self._document
        ready = document.data is not None and bool(document.chain)
        self._pages.setCurrentIndex(int(ready))
        if document.data is not None and not ready:
            self.hint.setText("No chain in this skeleton: there is no τ to tune.")
        self._enable(ready)
        if not ready:
            return
        if everything:
            self._show_chain()
            if self.model.rowCount():
                stretch = QHeaderView.ResizeMode.Stretch
                self.table.horizontalHeader().setSectionResizeMode(0, stretch)
        degrees = self._degrees()
        for plot in (self.histogram, self.cost):
            plot.show_tau(degrees, held=bool(self._drag) and plot.tau_line.moving)
        if abs(self.box.value() - degrees) > _SAME:  # else a number being typed would be lost
            with QSignalBlocker(self.box):
                self.box.setValue(degrees)
        self.verdicts.show_tau(degrees, held=bool(self._drag))
        if self.tabs.currentWidget() in (self.verdicts, self.confidence):
            self.verdicts.refresh()
        elif self.tabs.currentIndex() == 0:
            self._show_words(degrees)
        else:
            self.model.refresh()

    def _degrees(self) -> float:
        return float(np.degrees(self._document.review.state.tau[self._document.chain]))

    def _show_chain(self) -> None:
        document = self._document
        data = document.data
        assert data is not None
        chain = document.find_chain(document.chain)
        self.title.setText(f"<b>{chain.label}</b>")
        own = document.review.state.method == "paper" or document.limb is not None
        m = None if own else np.degrees(data.signals[chain.name].strength)
        self._strength = np.degrees(self._document.detector.strength(chain.name))
        self.histogram.show_strength(self._strength, m)
        self._floor = float(np.degrees(self._document.detector.automatic_tau(chain.name)))
        for plot in (self.histogram, self.cost):
            plot.show_floor(self._floor)
        self.cost.show_curve(self.costs.curves.get(chain.name))
        self.cost.setVisible(document.limb is None)
        if (row := self.model.row_of(chain.name)) is not None:
            self.table.selectRow(row)

    def _show_words(self, degrees: float) -> None:
        document, theme = self._document, self._theme
        reach = int((self._strength >= degrees).sum())
        limb = document.limb is not None
        paper = document.review.state.method == "paper" or limb
        square = inked("■", theme.before)
        what = "jump of the limb" if limb else "strength"
        words = [f"Frames by {what}  {square} {reach} of {document.frames} reach τ"]
        if not paper:
            words.append(inked("■ the paper's m(t)", theme.soft))
        # The paper's detector, and that of limbs, has a fixed τ and knows no noise.
        name = "automatic τ" if paper else "noise floor"
        words.append(inked(f"╌ {name} {self._floor:.2f}°", theme.soft))
        self.strength_words.set_text(" &nbsp; ".join(words))
        curve = self.costs.curves.get(document.chain)
        words = [inked("━ FSR", theme.after), inked("■ false alarms", theme.rejected)]
        if curve is not None:
            suggested = np.degrees(curve.suggested())
            words.append(inked(f"▼ suggested {suggested:.2f}°", theme.accepted))
        costs = "Errors put into this clip  " + " &nbsp; ".join(words)
        self.cost_words.set_text(_NO_COSTS if limb else costs)
        found = len(document.review.state.of_chain(document.chain))
        count = "1 interval" if found == 1 else f"{found} intervals"
        parts = [f"{count} at τ {degrees:.2f}°"]
        if curve is not None:
            fsr, alarms = curve.at(float(np.radians(degrees)))
            parts += [f"FSR {100 * fsr:.1f} %", f"false alarms {alarms:.3g}"]
        if not limb and (progress := self.progress()):
            parts.append(progress)
        self.state.set_text(" · ".join(parts))

    def progress(self) -> str:
        """What is being measured, or why it is not; '' when all is known."""
        if self.costs.trouble:
            return self.costs.trouble
        known, total = len(self.costs.curves), len(self.costs.names)
        if not total:
            return "no chain of this clip can be corrected"
        return f"measuring, {known} of {total} chains …" if known < total else ""

    # -- what the person does -----------------------------------------------------------------

    def set_scope(self, scope: Scope) -> None:
        """τ is set for the selected chain, its segment on both sides, or all."""
        self.scope = scope
        self._stale.mark()

    def chains_in_scope(self) -> tuple[str, ...]:
        """Names of the chains that a τ is set for."""
        data = self._document.data
        if data is None or not self._document.chain:
            return ()
        own = self._document.find_chain(self._document.chain)
        # τ of a limb is another quantity than that of a chain.
        alike = data.chains if self._document.limb is None else data.analysis.limbs
        if self.scope == Scope.ALL:
            return tuple(c.name for c in alike)
        if self.scope == Scope.SEGMENT and own.segment:
            return tuple(c.name for c in alike if c.segment == own.segment)
        return (own.name,)

    def set_tau_degrees(self, degrees: float, drag: int = 0) -> None:
        """Set τ of the chains in scope."""
        degrees = min(max(round(degrees, 2), SMALLEST_TAU), LARGEST_TAU)
        tau = float(np.radians(degrees))
        self._document.set_taus(dict.fromkeys(self.chains_in_scope(), tau), drag)

    def _ask(self, degrees: float, dragging: bool) -> None:
        if dragging and not self._drag:
            self._drag = self._document.begin_drag()
        drag = self._drag if dragging else 0
        self._latest.ask(lambda: self.set_tau_degrees(degrees, drag))

    def _drop(self) -> None:
        self._latest.flush()
        self._drag = 0
        self._stale.mark()

    def suggest(self) -> None:
        """τ of the chains in scope: what each one's own curve speaks for; one step."""
        curves = self.costs.curves
        tau = {n: curves[n].suggested() for n in self.chains_in_scope() if n in curves}
        self._document.set_taus(tau)

    def tuned(self) -> dict[str, Tuned]:
        """The present τ of every chain, with what it costs as far as that is known."""
        data = self._document.data
        if data is None:
            return {}
        out = {}
        for name, tau in self._document.review.state.tau.items():
            if curve := self.costs.curves.get(name):
                out[name] = tuned(curve, tau)
            else:
                floor = float(np.degrees(self._document.detector.automatic_tau(name)))
                out[name] = Tuned(float(np.degrees(tau)), floor, np.nan, np.nan)
        return out

    def show_beside(self, others: Sequence[Column]) -> None:
        """Other profiles in the table: none, one beside the present τ, or two instead of it."""
        self.model.show_beside(others)
        self.tabs.setCurrentIndex(1)
        self._stale.mark_all()

    def _choose(self, index: QModelIndex) -> None:
        if name := self.model.things[index.row()].chain:
            self._document.select_chain(name)

    def _enable(self, ready: bool) -> None:
        wanted = [n for n in self.chains_in_scope() if n in self.costs.names]
        known = all(n in self.costs.curves for n in wanted)
        self._actions["suggest_tau"].setEnabled(ready and bool(wanted) and known)
        for name in ("take_profile", "close_comparison"):
            self._actions[name].setEnabled(bool(self.model.others))
