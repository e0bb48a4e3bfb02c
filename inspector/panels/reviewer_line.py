"""The line that asks for the reviewer's name after the first decision without a name."""

from __future__ import annotations

from PySide6.QtWidgets import QFrame, QLineEdit

from inspector.language import tr, tr_as
from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.widgets.building import hbox, tool_button


class ReviewerLine(QFrame):
    """A line with a field for the reviewer's name.

    Enter saves the name, which then also applies to earlier decisions. The field does not get the
    focus when it appears, so the keys that accept or reject intervals still work until the user
    clicks on the field.
    """

    def __init__(self, document: Document, settings: Settings) -> None:
        super().__init__()
        self.setObjectName("bar")
        self._document, self._settings = document, settings
        self.name = QLineEdit(placeholderText=tr("Your name"))
        self.name.setAccessibleName(tr("Your name"))
        self.name.setToolTip(tr("The name is saved with your decisions, including earlier ones"))
        self.name.setMaximumWidth(260)
        # Tool buttons, because the style makes push buttons at least 80 pixels wide.
        tip = tr("Save this name with your decisions (Enter)")
        self.keep = tool_button(tr_as("the name", "Keep"), tip, flat=False)
        tip = tr("Do not ask again. You can enter a name in the preferences later.")
        self.never = tool_button(tr("No name"), tip, flat=False)
        row = tr("Who is reviewing?"), (self.name, 9), self.keep, self.never, None
        hbox(*row, owner=self, margins=(10, 3, 4, 3))
        self.name.returnPressed.connect(self._keep)
        self.keep.clicked.connect(self._keep)
        self.never.clicked.connect(self._done)
        document.unsigned.connect(self._ask)
        document.intervals_changed.connect(self._hide_if_named)
        self.hide()

    def _ask(self) -> None:
        if not self._settings.reviewer_asked and self.isHidden():
            self.show()  # without the focus, because the next key is usually another decision

    def _hide_if_named(self) -> None:
        """Hide the line if the user has entered the name elsewhere."""
        if self._document.reviewer and not self.isHidden():
            self._done()

    def _keep(self) -> None:
        if name := self.name.text().strip():
            self._settings.reviewer = name
            self._document.sign(name)
            self._done()

    def _done(self) -> None:
        self._settings.reviewer_asked = True
        self.hide()
