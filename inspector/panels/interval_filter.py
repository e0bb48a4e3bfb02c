"""The filter of the interval table: by decision, kind, chain, confidence or search words."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QComboBox, QLineEdit, QWidget

from inspector.language import tr, tr_as, translate_declared_text
from inspector.widgets.building import hbox
from twistcore.detection import Kind
from twistcore.review import Judged

ALL, OF_CHAIN = "All", "This chain"
_OF_KIND = {kind.info.label: kind for kind in Kind}
FILTERS = {  # name of the filter, and its text in the list
    ALL: tr_as("intervals", "All"),
    "Undecided": tr_as("intervals", "Undecided"),
    "Accepted": tr_as("intervals", "Accepted"),
    "Rejected": tr_as("intervals", "Rejected"),
    OF_CHAIN: tr("This chain"),
    **{label: translate_declared_text(label) for label in _OF_KIND},
}
_ANY = tr_as("filter", "Any confidence")
_CONFIDENCES = (_ANY, "≥ 0.95", "≥ 0.50", "< 0.95", "< 0.50")
_COMPARED: dict[str, Callable[[float, float], bool]] = {
    "≥": operator.ge,
    ">": operator.gt,
    "≤": operator.le,
    "<": operator.lt,
}
_BOUND = re.compile(r"([<>]=?|[≤≥])\s*(\d*[.,]?\d+)")


@dataclass(frozen=True)
class IntervalFilter:
    """A filter of the interval table.

    Attributes
    ----------
    chosen
        One of FILTERS.
    bounds
        Limits of the confidence, such as ('≥', 0.9).
    words
        Words that must all occur in the searchable text of an interval.
    """

    chosen: str = ALL
    bounds: tuple[tuple[str, float], ...] = ()
    words: tuple[str, ...] = ()

    @staticmethod
    def read(chosen: str, confidence: str, typed: str) -> IntervalFilter:
        """Return the filter for the user's input.

        In the search line, a text such as '>0.9' sets a limit for the confidence.

        Parameters
        ----------
        chosen
            One of FILTERS.
        confidence
            The selected text in the list of confidences.
        typed
            The text in the search line.
        """
        bounds = tuple(
            (sign.replace(">=", "≥").replace("<=", "≤"), float(number.replace(",", ".")))
            for sign, number in _BOUND.findall(f"{confidence} {typed}")
        )
        return IntervalFilter(chosen, bounds, tuple(_BOUND.sub(" ", typed).casefold().split()))

    def admits(self, judged: Judged, of_chain: bool, text_of: Callable[[Judged], str]) -> bool:
        """Return True if an interval passes the filter.

        `of_chain` is True if the interval is an error of the selected chain. `text_of` is a
        function that returns the searchable text of an interval.
        """
        if self.chosen == OF_CHAIN:
            if not of_chain:
                return False
        elif self.chosen in _OF_KIND:
            if judged.interval.kind != _OF_KIND[self.chosen]:
                return False
        elif self.chosen not in (ALL, judged.decision.value.capitalize()):
            return False
        if self.bounds:
            sure = judged.interval.confidence
            if sure is None or not all(_COMPARED[sign](sure, b) for sign, b in self.bounds):
                return False
        if self.words:
            text = text_of(judged).casefold()
            return all(word in text for word in self.words)
        return True


class FilterLine(QWidget):
    """The input fields of the filter: lists of filters and confidences, and a search line."""

    changed = Signal()
    left = Signal()  # Enter or Esc was pressed, so the keys belong to the review again

    def __init__(self) -> None:
        super().__init__()
        self.choice, self.confidence = QComboBox(), QComboBox()
        for name, words in FILTERS.items():
            self.choice.addItem(words, name)
        self.confidence.addItems(_CONFIDENCES)
        for box, tip in (
            (self.choice, tr("Listed intervals")),
            (self.confidence, tr("Confidence of the listed intervals")),
        ):
            box.setToolTip(tip)
            box.setAccessibleName(tip)
            box.setMinimumWidth(60)  # shrinks first in a narrow panel
            box.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            box.currentTextChanged.connect(self._take)
        self.search = _SearchLine()
        self.search.textChanged.connect(self._take)
        self.search.left.connect(self.left)
        parts = self.choice, self.confidence, (self.search, 1)
        hbox(*parts, owner=self, margins=(0, 0, 0, 0), spacing=4)
        self.current = IntervalFilter()

    def list_all(self) -> Callable[[], None]:
        """Clear the filter, and return a function that restores it."""
        before = self.choice.currentIndex(), self.confidence.currentIndex(), self.search.text()
        self._set(0, 0, "")
        return lambda: self._set(*before)

    def _set(self, choice: int, confidence: int, typed: str) -> None:
        self.choice.setCurrentIndex(choice)
        self.confidence.setCurrentIndex(confidence)
        self.search.setText(typed)

    def _take(self) -> None:
        confidence, typed = self.confidence.currentText(), self.search.text()
        chosen = IntervalFilter.read(self.choice.currentData(), confidence, typed)
        if chosen != self.current:
            self.current = chosen
            self.changed.emit()


class _SearchLine(QLineEdit):
    """The search line. Enter and Esc end the input, and Esc also clears the text."""

    left = Signal()

    def __init__(self) -> None:
        super().__init__(placeholderText=tr("Search"), clearButtonEnabled=True)
        self.setAccessibleName(tr("Search the intervals"))
        self.setMinimumWidth(48)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus | Qt.FocusPolicy.TabFocus)
        tip = tr(
            "Search for words in the chain, joints, kind, decision, note or reason.\nTo "
            "search by confidence, type for example >0.9 or <0.5. Press Esc to list all "
            "intervals again."
        )
        self.setToolTip(tip)
        self.setAccessibleDescription(tip)

    def event(self, event: QEvent) -> bool:
        """Handle Enter and Esc, so that they do not act as shortcuts of the window."""
        if isinstance(event, QKeyEvent) and event.key() in _ENDS:
            if event.type() == QEvent.Type.ShortcutOverride:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress:
                if event.key() == Qt.Key.Key_Escape:
                    self.clear()
                self.left.emit()
                return True
        return super().event(event)


_ENDS = (Qt.Key.Key_Escape, Qt.Key.Key_Return, Qt.Key.Key_Enter)
