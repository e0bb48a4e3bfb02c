"""The learned-confidence page, which shows its reliability and has buttons to use and save it."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QCheckBox, QLabel, QLineEdit, QStackedLayout, QWidget

from inspector.language import tr, tr_as, translate_core_sentence
from inspector.session.document import Document
from inspector.tuning.remembered_profiles import save_learned_profile
from inspector.tuning.verdict_evidence import CLIP, FOLDER, RIG, VerdictEvidence
from inspector.tuning.verdict_page import LOW, NARROW
from inspector.tuning.verdict_plots import ReliabilityPlot
from inspector.widgets.building import Wrapping, hbox, hint, tool_button, vbox
from inspector.widgets.labels import (
    Caption,
    capitalised,
    coloured_rich_text,
    escape_tool_tip_text,
    plain_text,
)
from inspector.widgets.theme import Colours
from twistcore.detection import DETECTORS
from twistcore.tuning.learned_confidence import ENOUGH
from twistcore.tuning.learned_profile import LearnedProfile

_NOTHING = tr(
    "Nothing has been learned yet. The confidence is learned from your verdicts in this clip "
    "and in the sessions of its folder. Decide on at least {n} listed intervals.",
    n=ENOUGH,
)


class ConfidencePage(QWidget):
    """The page about the confidence that was learned from the user's verdicts.

    The confidence is learned for the performer of the clip or, if there is none, for its rig.
    """

    def __init__(self, document: Document, evidence: VerdictEvidence, colours: Colours) -> None:
        super().__init__()
        self._document, self._evidence, self._colours = document, evidence, colours
        self._build()
        colours.changed.connect(self.refresh)
        for signal in (evidence.changed, document.confidence_changed, document.opened):
            signal.connect(self.refresh)
        self.refresh()

    def _build(self) -> None:
        self.hint = hint(_NOTHING)
        self._pages = QStackedLayout(self)
        self.plot = ReliabilityPlot(self._colours)
        self.plot.setAccessibleName(tr("Share of accepted intervals at each confidence level"))
        self.plot.setToolTip(
            tr(
                "Horizontal axis: the confidence of the intervals. Vertical axis: the share of "
                "these intervals that you accepted.\n"
                "On the dashed line, the confidence equals the accepted share."
            )
        )
        self.legend, self.words = Caption(), Caption(soft=True)
        self.use = QCheckBox(tr("Use learned confidence"))
        self.use.setToolTip(
            tr(
                "Use the learned confidence in the list, in filters and in 'Accept confident "
                "intervals'.\n"
                "Sessions and exports keep the detector's own confidence."
            )
        )
        self.use.toggled.connect(self._use)
        self.performer = QLineEdit(placeholderText=tr_as("performer", "unknown"))
        self.performer.setAccessibleName(tr("Performer"))
        self.performer.setToolTip(
            tr(
                "The performer of this clip. Verdicts are also counted separately for each "
                "performer."
            )
        )
        self.performer.setMaximumWidth(110)
        self.performer.editingFinished.connect(self._name)
        self.remember = tool_button(tr("Remember"), "", flat=False)
        self.remember.clicked.connect(self.keep)
        self.figure = QWidget()
        figure = self.legend, (self.plot, 1), self.words
        vbox(*figure, owner=self.figure, margins=(0, 0, 0, 0), spacing=2)
        learning = QWidget()
        self._pages.addWidget(learning)
        whose = Wrapping(
            hbox(self.use, None, spacing=4),
            hbox(QLabel(tr("Performer")), self.performer, self.remember, None, spacing=4),
            spacing=6,
        )
        parts = (self.hint, 1), (self.figure, 1), whose
        vbox(*parts, owner=learning, margins=(0, 4, 0, 0), spacing=2)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """If the page is narrow and low, shorten long sentences to one line and add a tool tip."""
        super().resizeEvent(event)
        self.words.set_short(self.width() < NARROW and self.height() < LOW)

    # -- the learned profile ------------------------------------------------------------------

    @property
    def learnt(self) -> tuple[str, LearnedProfile | None]:
        """The name of a group of clips and the profile learned from them, or ('', None).

        The group is the clips of this performer with this rig or, if they have no profile, all
        clips with this rig.
        """
        present = self._evidence.present
        for scope in present.scopes if present else ():
            if scope.name in (CLIP, FOLDER) or scope.chain:
                continue
            found = present.learnt.get(scope.name) if present else None
            if found is not None and (found.profile.confidence or scope.name == RIG):
                return scope.name, found
        return "", None

    def _use(self, on: bool) -> None:
        _, found = self.learnt
        self._document.use_learned(found.profile.confidence if on and found else None)

    def _name(self) -> None:
        data, performers = self._document.data, self._evidence.performers
        name = self.performer.text().strip()
        if data is None or name == performers.of(data.clip.path):
            return
        try:
            performers.name(data.clip.path, name)
        except OSError as error:
            why = translate_core_sentence(error.strerror)
            self._document.message.emit(tr("The name was not saved ({why}).", why=why), True)
        self._evidence.count_again()

    def keep(self) -> None:
        """Save the learned τ and confidence as the profile of this rig or performer."""
        whose, found = self.learnt
        data = self._document.data
        if found is None or data is None:
            return
        try:
            path = save_learned_profile(found, data.clip.path.parent.name)
        except OSError as error:
            why = translate_core_sentence(error.strerror)
            self._document.message.emit(tr("The profile was not saved ({why}).", why=why), True)
            return
        message = tr(
            "The profile ({whose}) was saved as {name}. It is offered when you open a "
            "similar clip.",
            whose=whose,
            name=path.name,
        )
        self._document.message.emit(message, False)

    # -- drawing ------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Update the page after a change to the document or the verdicts."""
        document, evidence = self._document, self._evidence
        data = document.data
        if data is None:
            return
        whose, found = self.learnt
        known = found is not None and found.before is not None
        self.hint.setVisible(not known)
        self.figure.setVisible(known)
        detector = DETECTORS.info(document.review.state.method)
        none = tr(
            "{detector} has no confidence, so there is nothing to learn.",
            detector=capitalised(translate_core_sentence(detector.label)),
        )
        self.hint.setText(evidence.trouble or (_NOTHING if detector.has_confidence else none))
        self.use.setEnabled(known or document.learned is not None)
        with QSignalBlocker(self.use):
            self.use.setChecked(document.learned is not None)
        if not self.performer.hasFocus():
            self.performer.setText(evidence.performers.of(data.clip.path))
        borrowed = document.borrowed  # verdicts on a sample are not saved in a profile
        self.remember.setEnabled(found is not None and borrowed is None)
        self.remember.setToolTip(
            borrowed.why
            if borrowed
            else escape_tool_tip_text(
                tr(
                    "Remember τ and the learned confidence ({whose}), and offer them for "
                    "similar clips",
                    whose=whose,
                )
            )
            if found
            else tr("Available after you accept at least 10 intervals")
        )
        if known and found is not None:
            self._show(whose, found)

    def _show(self, whose: str, found: LearnedProfile) -> None:
        theme = self._colours.theme
        assert found.before is not None
        assert found.after is not None
        self.plot.show_reliability(found.before, found.after)
        before, after = 100 * found.before.error, 100 * found.after.error
        own = tr("■ the detector's confidence is off by {points:.1f} points", points=before)
        learned = tr("● the learned confidence by {points:.1f}", points=after)
        self.legend.set_text(
            f"{coloured_rich_text(own, theme.before)} &nbsp; "
            f"{coloured_rich_text(learned, theme.after)}"
        )
        self.plot.setAccessibleDescription(plain_text(self.legend.text()))
        confidence = found.profile.confidence
        assert confidence is not None
        used = self._document.learned
        stale = used is not None and used != confidence
        message = tr(
            "{whose}: learned from {accepted} accepted and {rejected} rejected intervals. Each "
            "dot's confidence was learned without that dot's intervals.",
            whose=whose,
            accepted=confidence.accepted,
            rejected=confidence.rejected,
        )
        again = tr(
            "The confidence in use is out of date. Untick 'Use learned confidence' and tick it "
            "again to update the confidence."
        )
        self.words.set_plain(f"{message} {again}" if stale else message)
