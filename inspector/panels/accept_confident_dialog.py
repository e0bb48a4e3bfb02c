"""The dialog that accepts all undecided intervals with a high confidence."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QDoubleSpinBox, QLabel, QWidget

from inspector.language import plural, tr
from inspector.session.document import Document
from inspector.widgets.building import hbox, vbox
from twistcore.review import Decision

_USUAL = 0.95


class AcceptConfidentDialog(QDialog):
    """A non-modal dialog that asks for a minimum confidence.

    It shows the number of intervals that it would accept.
    """

    def __init__(
        self, document: Document, accept: Callable[[float], None], parent: QWidget
    ) -> None:
        """Build the dialog.

        `accept` is a function that accepts all undecided intervals with at least the given
        confidence.
        """
        super().__init__(parent)
        self._document, self._accept = document, accept
        self.setWindowTitle(tr("Accept confident intervals"))
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
        label = tr("Accept undecided intervals with at least this confidence")
        self.confidence.setAccessibleName(label)
        row = hbox(label, self.confidence, None)
        vbox(row, self.count, self.buttons, owner=self)
        self.confidence.valueChanged.connect(self._refresh)
        document.intervals_changed.connect(self._refresh)
        document.confidence_changed.connect(self._refresh)
        document.opened.connect(self.reject)
        self._refresh()
        self.confidence.selectAll()

    def accept(self) -> None:
        """Accept the intervals in a single undo step, and close the dialog."""
        super().accept()
        self._accept(self.confidence.value())

    def _refresh(self) -> None:
        intervals = self._document.intervals
        undecided = sum(j.decision == Decision.UNDECIDED for j in intervals)
        at_least = self.confidence.value()
        find = self._document.automatic_ids
        ids = find(at_least) if intervals else ()
        also = find(at_least, include_open=True) if intervals else ()
        text = tr(
            "Undecided intervals that have at least this confidence: {count} of {n}.",
            count=len(ids),
            n=undecided,
        )
        if also != ids:
            left = len(also) - len(ids)
            text += " " + plural(
                "{n} more has this confidence but must be reviewed separately, because its "
                "correction is in doubt.",
                "{n} more have this confidence but must be reviewed separately, because their "
                "corrections are in doubt.",
                left,
            )
        self.count.setText(text)
        self.ok.setText(tr("Accept {count}", count=len(ids)))
        self.ok.setEnabled(bool(ids))
