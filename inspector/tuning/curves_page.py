"""The page about the selected chain, with a histogram of its strength and the cost of τ."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.document import BLIND, Document
from inspector.tuning.bar_frames import BarFrames
from inspector.tuning.cost_plot import CostPlot
from inspector.tuning.strength_histogram import Histogram
from inspector.tuning.tau_costs import Costs
from inspector.tuning.tau_words import (
    cost_change_text,
    suggestion_text,
    tau_cost_texts,
    unjudged_intervals_text,
)
from inspector.tuning.wishes import Wishes
from inspector.widgets.building import action_button, hbox, vbox
from inspector.widgets.labels import Caption, coloured_rich_text, plain_text
from inspector.widgets.theme import Colours
from twistcore.detection import DETECTORS
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb

_NO_COSTS = tr(
    "The cost of τ is measured for chains only. Limbs and twist bones use their automatic τ."
)


class CurvesPage(QWidget):
    """Two plots over τ with captions: the histogram of the strength, and the cost of τ.

    When the user changes τ, `asked` is emitted with the new τ in degrees, and a flag that is True
    during a drag.
    """

    asked = Signal(float, bool)
    dropped = Signal()

    def __init__(
        self,
        document: Document,
        colours: Colours,
        costs: Costs,
        wishes: Wishes,
        actions: Mapping[str, QAction],
    ) -> None:
        super().__init__()
        self._document, self._costs, self._wishes, self._colours = document, costs, wishes, colours
        # The strength in each frame and the automatic τ of the selected chain, in degrees.
        self._strength, self._floor = np.zeros(0), 0.0
        self._counted: NDArray[np.bool_] = np.zeros(0, dtype=bool)
        self.bars = BarFrames(document)
        self.histogram, self.cost = Histogram(colours), CostPlot(colours)
        for plot, name in (
            (self.histogram, tr("Frames by strength")),
            (self.cost, tr("FSR and false alarms against τ")),
        ):
            plot.setAccessibleName(name)
            plot.asked.connect(self._ask)
            plot.dropped.connect(self.dropped)
        tau = tr("Drag the τ line, or double-click to set τ.")
        self.cost.setToolTip(tau)
        self.histogram.setToolTip(f"{tr('Click a bar to go to its frames.')} {tau}")
        self.histogram.picked.connect(self._pick)
        document.frame_changed.connect(self._show_place)
        document.numbering_changed.connect(self._show_place)
        self.strength_words, self.cost_words, self.state = Caption(), Caption(), Caption(soft=True)
        self.presumed = Caption(soft=True)
        steps = [action_button(actions[name], short) for name, short in _STEPS.items()]
        for button in steps:
            button.setAutoRaise(True)
        vbox(
            hbox((self.strength_words, 1), *steps, spacing=0),
            (self.histogram, 1),
            self.cost_words,
            (self.cost, 1),
            self.state,
            self.presumed,
            owner=self,
            margins=(0, 4, 0, 0),
            spacing=2,
        )

    # -- content ------------------------------------------------------------------------------

    def show_chain(self) -> None:
        """Show the strength and the cost of the selected chain."""
        document, data = self._document, self._document.data
        assert data is not None
        name = document.chain
        own = document.limb is not None or DETECTORS.info(document.method).is_m
        m = None if own else np.degrees(data.signals[name].strength)
        counted = self._frames_that_count()
        strength = np.degrees(document.detector.strength(name))
        same = np.array_equal(strength, self._strength) and np.array_equal(counted, self._counted)
        self._strength, self._counted = strength, counted
        self.histogram.show_strength(strength[counted], None if m is None else m[counted])
        if not same:
            self.bars.take(strength, counted)
        self._floor = float(np.degrees(document.detector.automatic_tau(name)))
        for plot in (self.histogram, self.cost):
            plot.show_floor(self._floor)
        self.cost.show_curve(self._costs.curves.get(name))
        self.cost.setVisible(self._has_costs)
        self._show_place()

    def _frames_that_count(self) -> NDArray[np.bool_]:
        """Return a mask, (frames,), that is True for the frames that tuning uses."""
        counted = np.ones(self._document.frames, dtype=bool)
        if (capture := self._costs.capture) is not None:
            counted[: capture.first] = counted[capture.stop :] = False
        for start, stop in self._document.review.state.left_out:
            counted[start:stop] = False
        return counted

    def show_tau(self, degrees: float, *, held: bool) -> None:
        """Move the τ line in both plots, except in a plot where the user is dragging it."""
        for plot in (self.histogram, self.cost):
            plot.show_tau(degrees, held=held and plot.tau_line.moving)

    def show_words(self, degrees: float, before: float | None = None) -> None:
        """Update the captions above the plots and the lines of text below the plots.

        `before` is τ at the beginning of a drag, in radians, or None if τ is not being dragged.
        """
        self.strength_words.set_text(self._strength_text(degrees))
        left = int((~self._counted).sum())
        out = plural(
            "{n} frame is left out (see the Suggestion page)",
            "{n} frames are left out (see the Suggestion page)",
            left,
        )
        self.strength_words.setToolTip(out if left else "")
        document = self._document
        tau = document.review.state.tau[document.chain]
        present = tau if before is None else before
        curve = self._costs.curves.get(document.chain)
        if curve is not None:
            self.cost.show_suggestion(curve, self._wishes.suggested(curve, present))
        self.cost_words.set_text(self._cost_text(present) if self._has_costs else _NO_COSTS)
        parts, tip = tau_cost_texts(self._costs, document.method, document.chain, tau)
        if parts and before is not None:
            parts.insert(0, self._difference(before, tau))
        elif not parts:
            found = len(document.review.state.of_chain(document.chain))
            at = plural(
                "{n} interval at τ {tau:.2f}°", "{n} intervals at τ {tau:.2f}°", found, tau=degrees
            )
            parts = [at]
        self.state.setToolTip(tip)
        words = unjudged_intervals_text(self._costs, document.chain, tau)
        self.presumed.set_plain(words)
        self.presumed.setVisible(bool(words))
        if self._has_costs and (progress := self.progress()):
            parts.append(progress)
        self.state.set_plain(" · ".join(parts))
        self.histogram.setAccessibleDescription(plain_text(self.strength_words.text()))
        self.cost.setAccessibleDescription(plain_text(self.state.text()))

    def _strength_text(self, degrees: float) -> str:
        document, theme = self._document, self._colours.theme
        reach = int((self._strength[self._counted] >= degrees).sum())
        limb = document.limb is not None
        info = DETECTORS.info(document.method)
        square = coloured_rich_text("■", theme.before)
        frames = int(self._counted.sum())
        what = tr("Frames by limb jump") if limb else tr("Frames by strength")
        reached = tr("{square} {reach} of {n} frames reach τ", square=square, reach=reach, n=frames)
        words = [f"{what}  {reached}"]
        if not (limb or info.is_m):
            words.append(_inked(tr("■ the paper's m(t)"), theme.soft))
        name = (
            tr("automatic τ") if limb else translate_core_sentence(info.tau)
        )  # the same for all limbs
        words.append(_inked(f"╌ {name} {self._floor:.2f}°", theme.soft))
        return "  ".join(words)

    def _cost_text(self, present: float) -> str:
        theme = self._colours.theme
        words = [_inked("━ FSR", theme.after), _inked(tr("■ false alarms"), theme.rejected)]
        if (curve := self._costs.curves.get(self._document.chain)) is not None:
            text = suggestion_text(self._wishes, curve, present, self._difference)
            words.append(_inked(f"▼ {text}", theme.accepted))
        return "  ".join([tr("Errors injected into this clip"), *words])

    def _difference(self, before: float, now: float) -> str:
        document = self._document
        return cost_change_text(self._costs, document.method, document.chain, before, now)

    @property
    def _has_costs(self) -> bool:
        """True if the cost of τ is defined, which is not the case for limbs and twist bones."""
        document = self._document
        if document.data is None or not document.chain:
            return True
        return not isinstance(document.find_chain(document.chain), Limb | Helper)

    def progress(self) -> str:
        """Return a text about the progress or failure of the measurement, or '' when complete."""
        costs = self._costs
        if costs.trouble:
            return costs.trouble
        known, total = len(costs.curves), len(costs.names)
        if not total:
            return tr("No chain in this clip can be corrected.")
        coming = tr("measuring chains: {known} of {total} …", known=known, total=total)
        return coming if known < total else ""

    # -- frames of a bar ----------------------------------------------------------------------

    def next_bar(self) -> None:
        """Go to the first frame in the next bar of the strength histogram."""
        if self._may_reveal():
            self.bars.next_bar()
            self._show_place()

    def next_in_bar(self) -> None:
        """Go to the next frame in the current bar of the strength histogram."""
        if self._may_reveal():
            self.bars.next_in_bar()
            self._show_place()

    def _may_reveal(self) -> bool:
        """Return True if the user may go to the frames of a bar.

        In an exercise, show a message and return False, because the bar with the largest strength
        would reveal the errors.
        """
        if (data := self._document.data) is not None and data.blind:
            self._document.message.emit(BLIND, False)
            return False
        return True

    def _pick(self, bar: int) -> None:
        self.bars.next_frame(bar)
        self._show_place()

    def _ask(self, degrees: float, dragging: bool) -> None:
        if not dragging and self.sender() is self.histogram:
            self.bars.back()  # undo the first click of the double-click
            self._show_place()
        self.asked.emit(degrees, dragging)

    def _show_place(self, *_: object) -> None:
        words = self.bars.words
        if not words:
            self.bars.chosen = None
        self.histogram.show_choice(self.bars.chosen, words)


def _inked(text: str, colour: str) -> str:
    """Return coloured, non-breaking rich text, followed by a gap."""
    return coloured_rich_text(text.replace(" ", "&nbsp;"), colour) + " &nbsp;"


_STEPS = {"next_bar": tr("Bar ▸"), "next_in_bar": tr("Frame ▸")}
