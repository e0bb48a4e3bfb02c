"""'Accept the sure ones': how many it is about is seen before it is done."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QDoubleSpinBox, QLabel, QWidget

from inspector.language import tr
from inspector.session.document import Document
from inspector.widgets.building import hbox, vbox
from twistcore.review import Decision

_USUAL = 0.95


class SureOnes(QDialog):
    """A confidence, and how many undecided intervals have it; the window is not held up."""

    def __init__(
        self, document: Document, accept: Callable[[float], None], parent: QWidget
    ) -> None:
        """`accept`: accepts those of at least a confidence."""
        super().__init__(parent)
        self._document, self._accept = document, accept
        self.setWindowTitle(tr("Accept the sure ones"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.confidence = QDoubleSpinBox(minimum=0.0, maximum=1.0, singleStep=0.01, decimals=2)
        self.confidence.setValue(_USUAL)
        self.count = QLabel()
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.ok = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        asked = tr("Undecided, with a confidence of at least")
        self.confidence.setAccessibleName(asked)
        row = hbox(asked, self.confidence, None)
        vbox(row, self.count, self.buttons, owner=self)
        self.confidence.valueChanged.connect(self._refresh)
        document.intervals_changed.connect(self._refresh)
        document.confidence_changed.connect(self._refresh)
        document.opened.connect(self.reject)
        self._refresh()
        self.confidence.selectAll()

    def accept(self) -> None:
        """Accept them, in one step."""
        super().accept()
        self._accept(self.confidence.value())

    def _refresh(self) -> None:
        intervals = self._document.intervals
        undecided = sum(j.decision == Decision.UNDECIDED for j in intervals)
        at_least = self.confidence.value()
        unasked = self._document.unasked
        ids = unasked(at_least) if intervals else ()
        also = unasked(at_least, include_open=True) if intervals else ()
        told = tr("{count} of {total} undecided intervals.", count=len(ids), total=undecided)
        if also != ids:
            left = len(also) - len(ids)
            told += " " + tr("{n} more are open and wait for a look.", n=left)
        self.count.setText(told)
        self.ok.setText(tr("Accept {count}", count=len(ids)))
        self.ok.setEnabled(bool(ids))
