"""Whether the end of a flipped limb is kept or turned along: two words, one of them checked."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QWidget

from inspector.language import tr, tr_as
from inspector.panels.limb_words import end_as_heading, end_in_words
from inspector.widgets.building import hbox, tool_button

_WORDS = {  # of what is carried or not: the word and what it does
    False: (
        tr_as("the limb's end is", "kept"),
        tr("The {end} keeps its rotation in the correction (C)"),
    ),
    True: (
        tr_as("the limb's end is", "turned along"),
        tr("The {end} turned along with the limb, and is turned back with it (C)"),
    ),
}


class EndChoice(QWidget):
    """'Foot: kept | turned along'."""

    turned = Signal()  # the other one is wanted

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
        self.keep_room(True)  # what is below stays where it is

    def keep_room(self, keep: bool) -> None:
        """Whether its room stays empty while it is hidden."""
        policy = self.sizePolicy()
        policy.setRetainSizeWhenHidden(keep)
        self.setSizePolicy(policy)

    def show_end(self, word: str, carried: bool) -> None:
        """What became of the end, a 'foot' or a 'hand'."""
        self._carried = carried
        self.name.setText(end_as_heading(word))
        for each, button in self.choices.items():
            button.setToolTip(_WORDS[each][1].format(end=end_in_words(word)))
            button.setAccessibleName(f"{end_as_heading(word)} {_WORDS[each][0]}")
        self.choices[carried].setChecked(True)

    @property
    def shown(self) -> str:
        """The word that is checked: 'kept' or 'turned along'."""
        return _WORDS[self._carried][0]

    def _clicked(self) -> None:
        if not self.choices[self._carried].isChecked():
            self.turned.emit()
