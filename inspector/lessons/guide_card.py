"""The card that shows a page of a lesson or exercise with its task."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontInfo
from PySide6.QtWidgets import QApplication, QHBoxLayout, QLabel, QPushButton, QToolButton, QWidget

from inspector.language import tr, tr_as
from inspector.lessons.lesson_text import LessonText
from inspector.widgets.building import hbox, tool_button, vbox
from inspector.widgets.theme import Colours
from inspector.widgets.typeset import Typesetter

_TITLE = 1.1  # font size of the title, relative to the text
_READABLE = 24  # pixels; text of this size is readable from the last row of a room

# Colours in the theme for a result, with the smallest share of right answers for each.
_ROLES = (1.0, "accepted"), (0.5, "undecided"), (0.0, "rejected")


class GuideCard(QWidget):
    """A card with a page of a lesson or exercise, its task, and buttons.

    The card also shows whether the task is done.
    """

    linked = Signal(str)  # with the address of a clicked link

    def __init__(self, typesetter: Typesetter, colours: Colours) -> None:
        super().__init__()
        self._colours = colours
        self._typesetter = typesetter
        self.done = False  # True if the task is done
        self._task, self._mark, self._role = "", "▸", "accent"
        self.title, self.task = QLabel(wordWrap=True), QLabel(wordWrap=True)
        self.title.setTextFormat(Qt.TextFormat.PlainText)
        self.task.setTextFormat(Qt.TextFormat.RichText)
        self.body = LessonText(typesetter, colours)
        self.body.setAccessibleName(tr("Text of the page"))
        self.body.anchorClicked.connect(lambda at: self.linked.emit(at.toString()))
        self.controls, self._buttons, self._leave = hbox(spacing=6), hbox(spacing=4), QHBoxLayout()
        head = hbox((self.title, 1), self._leave)
        content = head, (self.body, 1), self.task, self.controls, self._buttons
        vbox(*content, owner=self, margins=(10, 8, 10, 10), spacing=6)
        self.setMinimumHeight(240)
        self.set_scale(1.0)
        colours.changed.connect(self._colour)

    def _colour(self) -> None:
        self._show_task(self._mark)

    def set_scale(self, scale: float) -> None:
        """Scale the text; 1 is the normal size, and larger values are for a lecture hall."""
        normal = QFontInfo(QApplication.font()).pixelSize()
        self._size = max(round(normal * scale), _READABLE) if scale > 1.0 else normal
        title = round(_TITLE * self._size)
        self.title.setStyleSheet(f"font-weight: 600; font-size: {title}px")
        self.body.set_size(self._size)
        self._show_task(self._mark)

    def prepare(self, formulas: Sequence[str]) -> None:
        """Start typesetting formulas before the pages that contain them are shown."""
        self._typesetter.start(formulas)

    def show_page(self, title: str, body: str, task: str) -> None:
        """Show a page. `body` and `task` are Markdown."""
        self.title.setText(title)
        self.body.show_markdown(body)
        self._task = task
        self.set_done(False)

    def show_text(self, markdown: str) -> None:
        """Replace the text of the page, which is Markdown."""
        self.body.show_markdown(markdown)

    def set_task(self, text: str) -> None:
        """Show the task, a sentence that may contain Markdown emphasis."""
        self._task = text
        self.set_done(self.done)

    def set_done(self, done: bool) -> None:
        """Mark the task as done, or as open if `done` is False."""
        self.done, self._role = done, "accepted" if done else "accent"
        self._show_task("✓" if done else "▸")

    def set_result(self, text: str, share: float) -> None:
        """Show a result instead of the task.

        The colour depends on `share`, the share of right answers, 0…1.
        """
        self._task, self.done = text, True
        self._role = next(role for least, role in _ROLES if share >= least)
        self._show_task("✓" if share == 1.0 else "✗")

    def _show_task(self, mark: str) -> None:
        self._mark, colour = mark, getattr(self._colours.theme, self._role)
        self.task.setVisible(bool(self._task))
        self.task.setText(f"{mark} {_plain(self._task)}")
        self.task.setStyleSheet(f"color: {colour}; font-size: {self._size}px")

    def set_buttons(
        self, buttons: list[QPushButton], controls: list[QWidget], leave: QToolButton
    ) -> None:
        """Replace the buttons of the card.

        `buttons` are in a row at the bottom, `controls` in the row above, and `leave` is at the
        top.
        """
        rows = (self._buttons, buttons), (self.controls, controls), (self._leave, [leave])
        for row, wanted in rows:
            while item := row.takeAt(0):
                if widget := item.widget():
                    widget.hide()  # a visible widget without a parent would become a window
            for widget in wanted:
                row.addWidget(widget)
                widget.show()


def leave_button(tip: str) -> QToolButton:
    """Return the button, at the top of the card, that ends the lesson or exercise."""
    return tool_button(tr_as("button", "End"), tip, flat=False)


def _plain(markdown: str) -> str:
    """Convert text with Markdown emphasis to rich text. HTML in the text is escaped."""
    bold = re.sub(r"\*\*(.*?)\*\*", r"<b>\1</b>", escape(markdown, quote=False))
    return re.sub(r"\*(.*?)\*", r"<i>\1</i>", bold)
