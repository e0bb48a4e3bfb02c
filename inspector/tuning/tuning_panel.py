"""The tuning tab: a field for τ, and pages about costs, profiles and verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QLabel,
    QStackedLayout,
    QTabWidget,
    QToolButton,
    QWidget,
)

from inspector.language import tr, tr_as, translate_core_sentence
from inspector.session.document import BLIND, Document
from inspector.timeline.tau_line import LARGEST_TAU, SMALLEST_TAU
from inspector.tuning.confidence_page import ConfidencePage
from inspector.tuning.curves_page import CurvesPage
from inspector.tuning.kinds_page import KindsPage
from inspector.tuning.profiles_page import ProfilesPage
from inspector.tuning.suggestion_page import SuggestionPage
from inspector.tuning.tau_costs import Costs
from inspector.tuning.tau_plots import TauPlot
from inspector.tuning.verdict_evidence import VerdictEvidence
from inspector.tuning.verdict_page import VerdictPage
from inspector.tuning.wishes import Wishes
from inspector.widgets.building import Wrapping, action_button, hbox, hint, vbox
from inspector.widgets.labels import bold
from inspector.widgets.later import Burst, Latest, RedrawRequests
from inspector.widgets.theme import Colours
from twistcore.tuning import Tuned, tau_with_cost

_SHORT = {  # short texts for the buttons
    "tau_for_chain": tr("Chain"),
    "tau_for_segment": tr("Both sides"),
    "tau_for_all": tr_as("chains", "All"),
}
_SAME = 0.006  # degrees; the field has two decimals


class Scope(StrEnum):
    """The chains for which the tuning tab sets τ."""

    CHAIN = "chain"
    SEGMENT = "segment"
    ALL = "all"


class TuningPanel(QWidget):
    """The panel of the tuning tab, which shows and sets τ."""

    def __init__(
        self,
        document: Document,
        colours: Colours,
        actions: Mapping[str, QAction],
        wishes: Wishes,
        evidence: VerdictEvidence,
    ) -> None:
        super().__init__()
        self._document, self._actions = document, actions
        self.wishes, self.evidence = wishes, evidence
        self.costs = Costs(document, self.wishes, self)
        self.scope = Scope.CHAIN
        self._drag = 0
        # The τ at the beginning of a drag, in radians, keyed by chain
        self._before: dict[str, float] = {}
        self._seen = False
        self._latest = Latest(self)
        self._stale = RedrawRequests(self)
        self._stale.due.connect(self.refresh)
        self._burst = Burst(document.begin_drag, self)
        self._build(colours)
        colours.changed.connect(self._stale.mark_all)
        self._stale.mark_all()
        for signal in (document.opened, document.chain_changed, document.method_changed):
            signal.connect(self._stale.mark_all)
        document.opened.connect(self._give_up)
        document.opened.connect(self._watch)
        for signal in (document.opened, document.chains_changed, document.method_changed):
            signal.connect(self.profiles.model.reset)
        document.intervals_changed.connect(self._stale.mark)
        self.costs.changed.connect(self._stale.mark_all)
        self.wishes.changed.connect(self._stale.mark_all)
        self._enable(False)
        if document.data is not None:
            self.profiles.model.reset()

    # -- building -----------------------------------------------------------------------------

    def _build(self, colours: Colours) -> None:
        self.hint = hint(tr("Open a clip to see the cost of every τ."))
        self._pages = QStackedLayout(self)
        self._pages.addWidget(self.hint)
        content = QWidget()
        self._pages.addWidget(content)
        self.title = QLabel(textFormat=Qt.TextFormat.RichText)
        self.box = QDoubleSpinBox(decimals=2, prefix="τ ", suffix="°")
        self.box.setRange(SMALLEST_TAU, LARGEST_TAU)
        self.box.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self.box.setAccessibleName(tr("τ of the chosen chains"))
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
        known = self._document, colours, self.costs, self.wishes, self._actions
        self.curves, self.profiles = CurvesPage(*known), ProfilesPage(*known)
        self.suggestion = SuggestionPage(self._document, self.costs, self.wishes, self._actions)
        self.curves.asked.connect(self._ask)
        self.curves.dropped.connect(self._drop)
        self.profiles.chosen.connect(self._document.select_chain)
        self.profiles.called.connect(self._look_at_profiles)
        self.tabs = QTabWidget(documentMode=True)
        self.tabs.setAccessibleName(tr("Tuning pages"))
        self.tabs.addTab(self.curves, tr("Curves"))
        self.tabs.addTab(self.profiles, tr("Profiles"))
        self.tabs.addTab(self.suggestion, tr("Suggestion"))
        self.verdicts = VerdictPage(self._document, self.evidence, self.costs, colours)
        self.verdicts.asked.connect(self._ask)
        self.verdicts.dropped.connect(self._drop)
        self.confidence = ConfidencePage(self._document, self.evidence, colours)
        self.kinds = KindsPage(self._document, self.evidence, colours)
        self.tabs.addTab(self.verdicts, tr("Verdicts"))
        self.tabs.addTab(self.kinds, tr("Kinds"))
        last = self.tabs.addTab(
            self.confidence, tr("Conf.")
        )  # short words, to fit into a window of 1024 pixels
        self.tabs.setTabToolTip(last, tr("Confidence, learned from verdicts"))
        self.tabs.currentChanged.connect(self._stale.mark_all)
        self.tabs.currentChanged.connect(self._watch_verdicts)
        vbox(head, (self.tabs, 1), owner=content, margins=(8, 6, 8, 6), spacing=4)

    def _button(self, name: str) -> QToolButton:
        return action_button(self._actions[name], _SHORT.get(name, self._actions[name].text()))

    # -- following the document ---------------------------------------------------------------

    def set_seen(self, seen: bool) -> None:
        """Begin measuring and drawing when the tab becomes visible, or stop if `seen` is False."""
        self._seen = seen
        self._watch()
        if seen:
            self._stale.mark_all()

    @property
    def _blind(self) -> bool:
        """True in an exercise, where strength, cost and recall would reveal the errors."""
        return self._document.data is not None and self._document.data.blind

    def _watch(self) -> None:
        self.costs.watch(self._seen and not self._blind)
        self._watch_verdicts()

    def _watch_verdicts(self) -> None:
        """Begin counting verdicts if a page that shows them is visible, or stop if not."""
        looked_at = self.tabs.currentWidget() in (self.verdicts, self.kinds, self.confidence)
        self.evidence.watch(self._seen and looked_at and not self._blind)

    def refresh(self) -> None:
        """Update the panel after changes to the document."""
        anything, everything = self._stale.take()
        if not (anything and self._seen):
            return
        document = self._document
        ready = document.data is not None and bool(document.chain) and not self._blind
        self._pages.setCurrentIndex(int(ready))
        if document.data is not None and not ready:
            none = tr("This skeleton has no chains, so there is no τ to tune.")
            self.hint.setText(BLIND if self._blind else none)
        self._enable(ready)
        if not ready:
            return
        if everything:
            self.title.setText(
                bold(translate_core_sentence(document.find_chain(document.chain).label))
            )
            self.curves.show_chain()
        degrees = self._degrees()
        self.curves.show_tau(degrees, held=bool(self._drag))
        if abs(self.box.value() - degrees) > _SAME:  # keep a number that the user is typing
            with QSignalBlocker(self.box):
                self.box.setValue(degrees)
        self.verdicts.show_tau(degrees, held=bool(self._drag))
        page = self.tabs.currentWidget()
        if page is self.curves:
            self.curves.show_words(degrees, self._before.get(document.chain))
        elif page is self.profiles:
            self.profiles.refresh()
            self.profiles.show_chain(document.chain)
        elif page is self.suggestion:
            self.suggestion.refresh()
        elif page is self.verdicts:
            self.verdicts.refresh()

    def _degrees(self) -> float:
        return float(np.degrees(self._document.review.state.tau[self._document.chain]))

    # -- input --------------------------------------------------------------------------------

    def set_scope(self, scope: Scope) -> None:
        """Choose the chains for which the panel sets τ.

        The choices are the selected chain, the same segment on both sides of the body, or all
        chains.
        """
        self.scope = scope
        self._stale.mark()

    def chains_in_scope(self) -> tuple[str, ...]:
        """Return the names of the chains for which the panel sets τ."""
        data = self._document.data
        if data is None or not self._document.chain:
            return ()
        own = self._document.find_chain(self._document.chain)
        # τ means something else for limbs and twist bones than for chains.
        alike = [c for c in data.chains_and_limbs if type(c) is type(own)]
        if self.scope == Scope.ALL:
            return tuple(c.name for c in alike)
        if self.scope == Scope.SEGMENT and own.segment:
            return tuple(c.name for c in alike if c.segment == own.segment)
        return (own.name,)

    def set_tau_degrees(self, degrees: float, drag: int = 0) -> None:
        """Set τ, in degrees, for the chains in scope.

        Changes with the same `drag` are one undo step.
        """
        degrees = min(max(round(degrees, 2), SMALLEST_TAU), LARGEST_TAU)
        tau = float(np.radians(degrees))
        self._document.set_taus(dict.fromkeys(self.chains_in_scope(), tau), drag)

    def _ask(self, degrees: float, dragging: bool) -> None:
        if dragging and not self._drag:
            self._drag = self._document.begin_drag()
            self._before = dict(self._document.review.state.tau)
        drag = self._drag if dragging else 0
        self._latest.ask(lambda: self.set_tau_degrees(degrees, drag))

    def _give_up(self) -> None:
        """Cancel a drag because the clip was closed."""
        self._latest.forget()
        self._drag, self._before = 0, {}
        for plot in self.findChildren(TauPlot):
            plot.tau_line.stop_dragging()

    def _drop(self) -> None:
        self._latest.flush()
        self._drag, self._before = 0, {}
        self._stale.mark()

    def suggest(self) -> None:
        """Set the suggested τ for every chain in scope, in one undo step.

        The τ of a chain is changed only if this reduces its cost.
        """
        curves, present = self.costs.curves, self._document.review.state.tau
        names = [name for name in self.chains_in_scope() if name in curves]
        tau = {name: self.wishes.suggested(curves[name], present[name]) for name in names}
        if gains := {name: t for name, t in tau.items() if t != present[name]}:
            self._document.set_taus(gains)
        elif tau:
            unchanged = tr("No other τ has a lower cost, so nothing was changed.")
            self._document.message.emit(unchanged, False)

    def tuned(self) -> dict[str, Tuned]:
        """Return the current τ of every chain, with its cost if the cost has been measured."""
        data = self._document.data
        if data is None:
            return {}
        out = {}
        for name, tau in self._document.review.state.tau.items():
            if curve := self.costs.curves.get(name):
                out[name] = tau_with_cost(curve, tau)
            else:
                out[name] = Tuned(float(np.degrees(tau)), np.nan, np.nan, np.nan)
        return out

    def _look_at_profiles(self) -> None:
        self.tabs.setCurrentWidget(self.profiles)
        self._stale.mark_all()

    def _enable(self, ready: bool) -> None:
        wanted = [n for n in self.chains_in_scope() if n in self.costs.names]
        known = all(n in self.costs.curves for n in wanted)
        self._actions["suggest_tau"].setEnabled(ready and bool(wanted) and known)
