"""The message bar, which shows messages and questions on top of a widget."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QAccessible, QAccessibleEvent
from PySide6.QtWidgets import QBoxLayout, QFrame, QHBoxLayout, QLabel, QPushButton, QWidget

from inspector.language import tr, translate_core_sentence
from inspector.widgets.building import hbox, tool_button, use_secondary_text_colour
from inspector.widgets.labels import escape_tool_tip_text

_SHOWN_MS = 8000
_AROUND = 90  # pixels for margins, gaps and the close button of the bar
_LEAST = 80  # pixels for a shortened button

Answers = Sequence[tuple[str, Callable[[], object]]]


class MessageBar(QFrame):
    """A bar that shows the latest message. An error is shown until the user closes it.

    If an error replaces a question, the question appears again when the user closes the error. The
    keys Alt+1, Alt+2 and so on select an answer.
    """

    def __init__(self, over: QWidget) -> None:
        """Build the bar. `over` is the widget on top of which the bar appears."""
        super().__init__(over)
        self.setObjectName("bar")
        selectable = Qt.TextInteractionFlag.TextSelectableByMouse
        self.label = QLabel(wordWrap=True, textInteractionFlags=selectable)
        close = tool_button("✕", tr("Close this message (Esc)"))
        close.clicked.connect(self.close_message)
        self._answers = QHBoxLayout()
        self._keys = use_secondary_text_colour(QLabel())
        layout = hbox((self.label, 1), self._answers, self._keys, owner=self, margins=(10, 4, 4, 4))
        layout.addWidget(close, 0, Qt.AlignmentFlag.AlignTop)
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self.hide)
        # The question that has not been answered yet
        self._question: tuple[str, Answers] | None = None
        self.hide()

    def show_message(self, text: str, wrong: bool) -> None:
        """Show a message, which must already be in the chosen language.

        `wrong` is True if the message is an error.
        """
        text = translate_core_sentence(text)
        if self.asks and not wrong:
            return  # the bar continues to show the unanswered question
        self._show(text, wrong)
        if wrong:
            self._timer.stop()
        else:
            self._timer.start(_SHOWN_MS)

    def add_error(self, text: str) -> None:
        """Show an error. If an error is already shown, append the new one to it."""
        text = translate_core_sentence(text)
        if not (self.isVisible() and text in self.label.text()):
            self.show_message(self._after_error(text), True)

    @property
    def asks(self) -> bool:
        """True if the bar shows a question that the user has not answered."""
        return self._question is not None and bool(self._answers.count()) and self.isVisible()

    def offer(self, text: str, answers: Answers) -> None:
        """Show a message with buttons for a limited time.

        If the bar already shows an unanswered question, do nothing.
        """
        if not self.asks:
            self._question = None
            self._show(self._after_error(text), False)
            self._add(answers)
            self._timer.start(2 * _SHOWN_MS)

    def append_offer(self, text: str, answers: Answers) -> None:
        """Append a message with buttons to the current message."""
        shown = self.label.text() if self.isVisible() and not self.property("wrong") else ""
        self.offer(f"{shown} {text}".strip(), answers)

    def withdraw(self, text: str) -> None:
        """Hide the bar if it shows this text."""
        if translate_core_sentence(text) == self.label.text() and not self._answers.count():
            self.close_message()

    def ask(self, text: str, answers: Answers) -> None:
        """Show a question with buttons until the user answers or closes it."""
        self._question = (text, answers)
        self._show(self._after_error(text), False)
        self._timer.stop()
        self._add(answers)

    def _after_error(self, text: str) -> str:
        """Return `text`, preceded by the current error if an error is visible.

        As a result, the user can still read the error.
        """
        error = self.isVisible() and self.property("wrong") and not self._answers.count()
        return f"{self.label.text()} {text}" if error else text

    def _add(self, answers: Answers) -> None:
        for number, (name, slot) in enumerate(answers, 1):
            button = QPushButton(name)
            button.setToolTip(escape_tool_tip_text(f"{name} (Alt+{number})"))
            button.clicked.connect(self.clear)
            button.clicked.connect(lambda _=False, do=slot: do())
            self._answers.addWidget(button)
        self._keys.setText(", ".join(f"Alt+{k}" for k in range(1, len(answers) + 1)))
        self._stack()
        for number, button in enumerate(self.buttons(), 1):  # a new text would remove the shortcut
            button.setShortcut(f"Alt+{number}")

    def _stack(self) -> None:
        """Put the buttons one below the other, and hide their keys, if the view is too narrow.

        A button that is still too wide, such as one with a long file name, is shortened.
        """
        parts = (self.label, *self.buttons(), self._keys)
        wide = sum(part.minimumSizeHint().width() for part in parts) + _AROUND
        view = self.parentWidget()
        narrow = view is not None and wide > view.width()
        directions = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._answers.setDirection(directions[narrow])
        self._keys.setVisible(not narrow)
        if view is not None and narrow:
            room = view.width() - self.label.minimumSizeHint().width() - _AROUND
            for button in self.buttons():
                _shorten(button, max(room, _LEAST))

    def clear(self) -> None:
        """Hide the bar, and discard its question."""
        self._question = None
        self._clear()
        self.hide()

    def buttons(self) -> list[QPushButton]:
        """Return the buttons with the answers."""
        items = (self._answers.itemAt(k) for k in range(self._answers.count()))
        every = (item.widget() for item in items if item is not None)
        return [b for b in every if isinstance(b, QPushButton)]

    def close_message(self) -> None:
        """Hide the bar or, if an error has replaced a question, show the question again."""
        if self._question is not None and not self._answers.count():
            self.hide()
            self.ask(*self._question)
        else:
            self.clear()

    def _clear(self) -> None:
        self._keys.clear()
        while item := self._answers.takeAt(0):
            if widget := item.widget():
                widget.hide()
                widget.deleteLater()

    def _show(self, text: str, wrong: bool) -> None:
        self._clear()
        self.label.setText(text)
        self.setProperty("wrong", wrong)
        self.style().unpolish(self)
        self.style().polish(self)
        self.show()
        # Screen readers read an alert immediately, wherever the focus is
        if QAccessible.isActive():
            alert = QAccessibleEvent(self.label, QAccessible.Event.Alert)
            QAccessible.updateAccessibility(alert)


def _shorten(button: QPushButton, room: int) -> None:
    """Replace the middle of a button's text by '…' if the button is wider than `room` pixels."""
    too_wide = button.minimumSizeHint().width() - room
    if too_wide > 0:
        name, letters = button.text(), button.fontMetrics()
        wide = letters.horizontalAdvance(name) - too_wide
        button.setText(letters.elidedText(name, Qt.TextElideMode.ElideMiddle, wide))
        button.setAccessibleName(name)
