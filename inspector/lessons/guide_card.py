"""The card that leads through the tour and the exercise: a page, what to do, whether it is done.

The texts are Markdown files in assets/tour, one a page, to be translated.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QTextBrowser, QToolButton, QWidget

from inspector.bundled import PAGES
from inspector.widgets.building import hbox, tool_button, vbox
from inspector.widgets.theme import Theme


class Page(NamedTuple):
    """title: the heading; body: Markdown; task: what is to be done, the quoted last paragraph."""

    title: str
    body: str
    task: str


def read_page(name: str) -> Page:
    """A page by its file's name without suffix."""
    text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    head, _, rest = text.partition("\n")
    body, _, task = rest.rpartition("\n> ")
    return Page(head.removeprefix("# ").strip(), body.strip(), task.replace("\n> ", " ").strip())


class GuideCard(QWidget):
    """Shows a page and its state; who leads gives it its buttons."""

    linked = Signal(str)  # a link in the text was clicked: its address

    def __init__(self) -> None:
        super().__init__()
        self._theme: Theme | None = None
        self.done = False  # whether what was to be done is done
        self._task = ""
        self.title, self.task = QLabel(wordWrap=True), QLabel(wordWrap=True)
        self.body = QTextBrowser(openLinks=False)
        self.body.setFrameShape(QTextBrowser.Shape.NoFrame)
        self.body.anchorClicked.connect(lambda at: self.linked.emit(at.toString()))
        self.controls, self._buttons, self._leave = hbox(spacing=6), hbox(spacing=4), QHBoxLayout()
        head = hbox((self.title, 1), self._leave)
        content = head, (self.body, 1), self.task, self.controls, self._buttons
        vbox(*content, owner=self, margins=(10, 8, 10, 10), spacing=6)
        self.setMinimumHeight(240)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._theme = theme
        self.title.setStyleSheet("font-weight: 600; font-size: 14px")
        self.body.setStyleSheet(f"background: {theme.window}; color: {theme.text}")
        self.set_done(self.done)

    def show_page(self, name: str, heading: str = "") -> None:
        """Another page, by its file's name; `heading`: before its title."""
        page = read_page(name)
        self.title.setText(f"{heading}{page.title}")
        self.body.setMarkdown(page.body)
        self._task = page.task
        self.set_done(False)

    def show_text(self, markdown: str) -> None:
        """Another text under the same title."""
        self.body.setMarkdown(markdown)

    def set_task(self, text: str) -> None:
        """What is to be done now, Markdown's emphasis allowed."""
        self._task = text
        self.set_done(self.done)

    def set_done(self, done: bool) -> None:
        """Whether what was to be done is done."""
        self.done = done
        theme = self._theme
        if theme is None:
            return
        colour, mark = (theme.accepted, "✓") if done else (theme.accent, "▸")
        self.task.setText(f"{mark} {_plain(self._task)}")
        self.task.setStyleSheet(f"color: {colour}")

    def set_buttons(
        self, buttons: list[QPushButton], controls: list[QWidget], leave: QToolButton
    ) -> None:
        """The leader's buttons in a row, controls in a row above, and what ends it in the head."""
        rows = (self._buttons, buttons), (self.controls, controls), (self._leave, [leave])
        for row, wanted in rows:
            while item := row.takeAt(0):
                if widget := item.widget():
                    widget.setParent(None)
            for widget in wanted:
                row.addWidget(widget)
                widget.show()


def leave_button(what: str) -> QToolButton:
    """The button that ends a tour or an exercise: small, in the card's head."""
    return tool_button("End", f"End {what}; your own clip comes back as it was", flat=False)


def _plain(markdown: str) -> str:
    """Emphasis as rich text: a label knows no Markdown beside other text."""
    bold = re.sub(r"\*\*(.*?)\*\*", r"<b>\1</b>", markdown)
    return re.sub(r"\*(.*?)\*", r"<i>\1</i>", bold)
