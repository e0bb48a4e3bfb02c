"""The card that leads through the tour and the exercise: a page, what to do, whether it is done."""

from __future__ import annotations

from PySide6.QtCore import QUrl, Signal
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QPushButton,
    QTextBrowser,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from inspector.teaching.guide_pages import Page
from inspector.widgets.theme import Theme


class GuideCard(QWidget):
    """Shows a page and its state; who leads gives it its buttons."""

    linked = Signal(str)  # a link in the text was clicked: its address

    def __init__(self) -> None:
        super().__init__()
        self._theme: Theme | None = None
        self._done = False
        self._task = ""
        self.title = QLabel()
        self.title.setWordWrap(True)
        self.body = QTextBrowser()
        self.body.setOpenLinks(False)
        self.body.setFrameShape(QTextBrowser.Shape.NoFrame)
        self.body.anchorClicked.connect(self._clicked)
        self.task = QLabel()
        self.task.setWordWrap(True)
        self.controls = QHBoxLayout()
        self.controls.setSpacing(6)
        head = QHBoxLayout()
        head.addWidget(self.title, 1)
        self._leave = QHBoxLayout()
        head.addLayout(self._leave)
        self._buttons = QHBoxLayout()
        self._buttons.setSpacing(4)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(10, 8, 10, 10)
        layout.setSpacing(6)
        layout.addLayout(head)
        layout.addWidget(self.body, 1)
        layout.addWidget(self.task)
        layout.addLayout(self.controls)
        layout.addLayout(self._buttons)
        self.setMinimumHeight(240)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._theme = theme
        self.title.setStyleSheet("font-weight: 600; font-size: 14px")
        self.body.setStyleSheet(f"background: {theme.window}; color: {theme.text}")
        self.set_done(self._done)

    def show_page(self, page: Page, heading: str = "") -> None:
        """Another page; `heading`: before its title."""
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
        self.set_done(self._done)

    def set_done(self, done: bool) -> None:
        """Whether what was to be done is done."""
        self._done = done
        theme = self._theme
        if theme is None:
            return
        colour, mark = (theme.accepted, "✓") if done else (theme.accent, "▸")
        self.task.setText(f"{mark} {_plain(self._task)}")
        self.task.setStyleSheet(f"color: {colour}")

    @property
    def done(self) -> bool:
        """Whether what was to be done is done."""
        return self._done

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

    def _clicked(self, address: QUrl) -> None:
        self.linked.emit(address.toString())


def leave_button(what: str) -> QToolButton:
    """The button that ends a tour or an exercise: small, in the card's head."""
    button = QToolButton()
    button.setText("End")
    button.setToolTip(f"End {what}; your own clip comes back as it was")
    return button


def _plain(markdown: str) -> str:
    """Emphasis as rich text: a label knows no Markdown beside other text."""
    out, bold = "", True
    for k, part in enumerate(markdown.split("**")):
        bold = k % 2 == 1
        inner = "".join(f"<i>{p}</i>" if n % 2 else p for n, p in enumerate(part.split("*")))
        out += f"<b>{inner}</b>" if bold else inner
    return out
