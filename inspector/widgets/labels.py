"""Labels whose changing text moves nothing around them.

An ordinary label asks for a new layout with every text, and the window lays itself out and repaints
once more for each step of a drag.
"""

from __future__ import annotations

import re
from html import escape

from PySide6.QtCore import QEvent, QRect, QSize, Qt, QTimer
from PySide6.QtGui import (
    QFont,
    QPainter,
    QPaintEvent,
    QPalette,
    QResizeEvent,
    QTextDocumentFragment,
)
from PySide6.QtWidgets import QLabel, QSizePolicy, QWidget

from twistcore.files.encoding import legible

_TAG = re.compile("[<&]")
_MOST = 4000  # letters: to set millions of them takes minutes
_LARGE = 2000  # pixels: no label is larger
_ASIDE = 4  # pixels beside a line of the status bar
_STILL_MS = 400  # a line that has not changed for so long is told to screen readers


class SteadyLabel(QLabel):
    """A line of figures; it grows where they need more room and never shrinks."""

    _widest = ""

    def keep_room(self, text: str) -> None:
        """Room for such a text from the start."""
        self._widest = text
        self._grow()

    def sizeHint(self) -> QSize:
        """Room for the text, and for the widest that was told."""
        aligned, room = self.alignment().value, QRect(0, 0, _LARGE, _LARGE)
        widest = self.fontMetrics().boundingRect(room, aligned, self._widest).width()
        return super().sizeHint().expandedTo(QSize(widest, 0))

    def setText(self, text: str) -> None:
        """Show a text, in more room if it needs more."""
        if text != self.text():
            super().setText(text)
            self._grow()

    def changeEvent(self, event: QEvent) -> None:
        """Another font needs other room."""
        super().changeEvent(event)
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.StyleChange):
            self.setMinimumSize(0, 0)  # a hint is never smaller than the minimum
            self.setFixedSize(self.sizeHint())

    def _grow(self) -> None:
        wanted, has = self.sizeHint(), self.maximumSize()
        fixed = self.minimumSize() == has
        room = QSize(wanted).expandedTo(has) if fixed else wanted
        if not fixed or room != has:
            self.setFixedSize(room)


def as_rich(text: str) -> str:
    """Rich text that is seen as the plain text; nothing in it is obeyed."""
    return escape(legible(text, lines=True, most=_MOST), quote=False)


def bold(text: str) -> str:
    """Rich text in bold of plain text."""
    return f"<b>{as_rich(text)}</b>"


def as_tip(text: str) -> str:
    """Plain text as a tool tip has it; nothing in it is HTML, and nothing is obeyed.

    Qt guesses of a tool tip whether it is HTML. A word joiner, which is not seen, behind what a tag
    or the sign for '<' begins with leaves nothing to be guessed.
    """
    return _TAG.sub("\\g<0>\u2060", legible(text, lines=True, most=_MOST))


def as_entry(text: str) -> str:
    """Plain text as menus and buttons have it: no key is made of what is behind '&'."""
    return legible(text, most=_MOST).replace("&", "&&")


def capitalised(text: str) -> str:
    """Words for the middle of a sentence, to begin one with."""
    return text[:1].upper() + text[1:]


def inked(text: str, colour: str) -> str:
    """Rich text in a colour, '#rrggbb'."""
    return f"<span style='color:{colour}'>{text}</span>"


def plain_text(rich: str) -> str:
    """The words of rich text."""
    return QTextDocumentFragment.fromHtml(rich).toPlainText()


class Caption(QWidget):
    """Rich text as wide as there is room, broken into lines; it grows with them, never shrinks.

    The label in it is placed by hand: no layout, no new one with every text. Where it is short it
    is a line of plain text, and its tip tells the rest.
    """

    def __init__(self, *, soft: bool = False) -> None:
        super().__init__()
        self.label = QLabel(self, textFormat=Qt.TextFormat.RichText, wordWrap=True)
        if soft:
            self.label.setObjectName("soft")
        self._text, self._short = "", False
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setFixedHeight(self._line)

    def text(self) -> str:
        """What it says, as rich text."""
        return self._text

    def set_text(self, text: str) -> None:
        """Say something else, as rich text."""
        if text != self._text:
            self._text = text
            self._fit(self.height())

    def set_plain(self, text: str) -> None:
        """The same of plain text."""
        self.set_text(as_rich(text))

    def says(self, text: str) -> bool:
        """Whether it says this plain text."""
        return self._text == as_rich(text)

    def set_short(self, short: bool) -> None:
        """A line of plain text, or all of it."""
        if short != self._short:
            self._short = short
            self._fit(self._line)

    @property
    def _line(self) -> int:
        """Pixels of a line's height."""
        return self.fontMetrics().height() + 2

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Another width needs other lines."""
        super().resizeEvent(event)
        self._fit(self._line)

    def _fit(self, least: int) -> None:
        shown, height = self._text, self._line
        if self._short:
            whole = plain_text(self._text)
            end = Qt.TextElideMode.ElideRight
            line = self.fontMetrics().elidedText(whole, end, self.width())
            shown = escape(line)
            rest = [self._text, escape(self.toolTip()).replace("\n", "<br>")]
            told = "<p>".join(filter(None, rest))
            self.label.setToolTip(f"<qt>{told}</qt>" if line != whole else "")
        if shown != self.label.text():
            self.label.setText(shown)
        if not self._short:
            self.label.setToolTip("")
            height = max(least, self.label.heightForWidth(self.width()))
        if height != self.height():
            self.setFixedHeight(height)
        self.label.setGeometry(0, 0, self.width(), height)


class ElidedLabel(QLabel):
    """A line that makes nothing wider: where there is no room its end is left out."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def paintEvent(self, event: QPaintEvent) -> None:
        """As much of the text as there is room for."""
        painter = QPainter(self)
        end = Qt.TextElideMode.ElideRight
        text = self.fontMetrics().elidedText(self.text(), end, self.width())
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignVCenter, text)
        painter.end()


class Headline(QLabel):
    """'<b>what</b> more' in a line that makes nothing wider: where room is short more ends in …

    Rich text; without anything in bold plain text will do, where what stands for a sign of HTML in
    it is escaped.
    """

    def __init__(self) -> None:
        super().__init__(textFormat=Qt.TextFormat.RichText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def minimumSizeHint(self) -> QSize:
        """As narrow as it has to be."""
        return QSize(0, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        """As much as there is room for."""
        if self.sizeHint().width() <= self.width():
            super().paintEvent(event)
            return
        what, _, more = self.text().partition("</b>")
        painter, room = QPainter(self), self.rect()
        for part, weight in ((what, QFont.Weight.Bold), (more, QFont.Weight.Normal)):
            font = QFont(self.font())
            font.setWeight(weight)
            painter.setFont(font)
            words = QTextDocumentFragment.fromHtml(part).toPlainText()
            if part is more:
                words = f" {words.lstrip()}"
            letters = painter.fontMetrics()
            fitting = letters.elidedText(words, Qt.TextElideMode.ElideRight, room.width())
            painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, fitting)
            room.setLeft(room.left() + letters.horizontalAdvance(fitting))
        painter.end()


class ElidedLine(QWidget):
    """A line that may change many times a second: no other text asks for a new layout."""

    def __init__(self) -> None:
        super().__init__()
        self._text = ""
        self._still = QTimer(self, singleShot=True, interval=_STILL_MS)
        self._still.timeout.connect(self._tell)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def text(self) -> str:
        """What it says."""
        return self._text

    def set_text(self, text: str) -> None:
        """Say something else."""
        if text != self._text:
            self._text = text
            self.update()
            self._still.start()

    def _tell(self) -> None:
        self.setAccessibleName(self._text)

    def paintEvent(self, event: QPaintEvent) -> None:
        """As much of the text as there is room for, in the colour of secondary text."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
        room = self.rect().adjusted(_ASIDE, 0, -_ASIDE, 0)
        end = Qt.TextElideMode.ElideRight
        text = self.fontMetrics().elidedText(self._text, end, room.width())
        painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, text)
        painter.end()
