"""Buttons that show whether an error also rotated the foot, hand or next joint.

If it did, this part was 'carried along'. If not, it was 'kept'.
"""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QWidget

from inspector.language import tr, tr_as
from inspector.panels.limb_words import limb_end_heading, limb_end_in_sentence
from inspector.widgets.building import hbox, tool_button

_WORDS = {  # text and tool tip of each button, keyed by `carried`
    False: (
        tr_as("the limb's end is", "kept"),
        tr("The error did not turn the {end}: the correction keeps the {end}'s rotation (C)"),
    ),
    True: (
        tr_as("the limb's end is", "carried along"),
        tr("The error also turned the {end}: the correction turns it back (C)"),
    ),
}


class EndChoice(QWidget):
    """A label with two buttons, such as 'Foot: kept | carried along'."""

    turned = Signal()  # the user chose the other button

    def __init__(self) -> None:
        super().__init__()
        self.name = QLabel()
        self.choices = {
            carried: tool_button(word, "", flat=False) for carried, (word, _) in _WORDS.items()
        }
        for button in self.choices.values():
            button.setCheckable(True)
            button.setAutoExclusive(True)
            button.clicked.connect(self._clicked)
        self._carried = False
        hbox(self.name, 4, *self.choices.values(), owner=self, margins=(0, 0, 0, 0), spacing=0)

    def show_end(self, word: str, carried: bool) -> None:
        """Show whether the part with the name `word` was carried along.

        `word` is 'hand', 'foot', 'end' or 'next joint'.
        """
        self._carried = carried
        self.name.setText(limb_end_heading(word))
        for each, button in self.choices.items():
            button.setToolTip(_WORDS[each][1].format(end=limb_end_in_sentence(word)))
            button.setAccessibleName(f"{limb_end_heading(word)} {_WORDS[each][0]}")
        self.choices[carried].setChecked(True)

    @property
    def shown(self) -> str:
        """The text of the checked button: 'kept' or 'carried along'."""
        return _WORDS[self._carried][0]

    def _clicked(self) -> None:
        if not self.choices[self._carried].isChecked():
            self.turned.emit()
