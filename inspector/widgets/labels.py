"""Labels with text that can change without moving other widgets.

An ordinary label requests a new layout whenever its text changes. Each step of a drag would
therefore cause an additional layout and repaint of the window.
"""

from __future__ import annotations

import re
from html import escape

from PySide6.QtCore import QEvent, QRect, QSize, Qt, QTimer
from PySide6.QtGui import (
    QFont,
    QFontMetrics,
    QPainter,
    QPaintEvent,
    QPalette,
    QResizeEvent,
    QTextDocumentFragment,
)
from PySide6.QtWidgets import QLabel, QSizePolicy, QWidget

from inspector.widgets.text_forms import form_that_fits
from twistcore.files.encoding import escape_control_characters

_TAG = re.compile("[<&]")
_MOST = 4000  # maximum number of letters, because the layout of millions takes minutes
_LARGE = 2000  # pixels: larger than any label
_ASIDE = 4  # pixels left and right of a line in the status bar
_STILL_MS = 400  # a line that has not changed for this time is passed to screen readers


class SteadyLabel(QLabel):
    """A label that grows if its text needs more space, but never shrinks."""

    _widest = ""

    def keep_room(self, text: str) -> None:
        """Reserve enough space for `text`, even while the label shows a shorter text."""
        self._widest = text
        self._grow()

    def sizeHint(self) -> QSize:
        """Return the size of the text, or the reserved size if that is wider."""
        aligned, room = self.alignment().value, QRect(0, 0, _LARGE, _LARGE)
        widest = self.fontMetrics().boundingRect(room, aligned, self._widest).width()
        return super().sizeHint().expandedTo(QSize(widest, 0))

    def setText(self, text: str) -> None:
        """Show the given text, growing if it needs more space."""
        if text != self.text():
            super().setText(text)
            self._grow()

    def changeEvent(self, event: QEvent) -> None:
        """Recompute the size after a font change."""
        super().changeEvent(event)
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.StyleChange):
            self.setMinimumSize(0, 0)  # allow the size hint to become smaller
            self.setFixedSize(self.sizeHint())

    def _grow(self) -> None:
        needed, has = self.sizeHint(), self.maximumSize()
        fixed = self.minimumSize() == has
        room = QSize(needed).expandedTo(has) if fixed else needed
        if not fixed or room != has:
            self.setFixedSize(room)


def plain_to_rich_text(text: str) -> str:
    """Convert plain text to rich text. Markup characters in the text are escaped."""
    return escape(escape_control_characters(text, lines=True, most=_MOST), quote=False)


def bold(text: str) -> str:
    """Convert plain text to bold rich text."""
    return f"<b>{plain_to_rich_text(text)}</b>"


def escape_tool_tip_text(text: str) -> str:
    """Convert plain text for use in a tool tip, so that Qt does not interpret it as HTML.

    Qt guesses whether the text of a tool tip is HTML. An invisible word joiner after each '<' and
    '&' prevents a wrong guess.
    """
    return _TAG.sub("\\g<0>\u2060", escape_control_characters(text, lines=True, most=_MOST))


def escape_menu_text(text: str) -> str:
    """Convert plain text for use in a menu or button: escape '&', which would mark a mnemonic."""
    return escape_control_characters(text, most=_MOST).replace("&", "&&")


def capitalised(text: str) -> str:
    """Return the text with a capital first letter."""
    return text[:1].upper() + text[1:]


def coloured_rich_text(text: str, colour: str) -> str:
    """Return the text as rich text in the given colour, '#rrggbb'."""
    return f"<span style='color:{colour}'>{text}</span>"


def plain_text(rich: str) -> str:
    """Convert rich text to plain text."""
    return QTextDocumentFragment.fromHtml(rich).toPlainText()


class Caption(QWidget):
    """A paragraph of rich text that reserves the height of its longest text so far.

    The class positions its inner label without a layout, so a new text does not request a new
    layout. A short caption shows one line of plain text, and its tool tip shows the whole text.
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
        """Return the rich text."""
        return self._text

    def set_text(self, text: str) -> None:
        """Show the given rich text."""
        if text != self._text:
            self._text = text
            self._fit(self.height())

    def set_plain(self, text: str) -> None:
        """Show the given plain text. Markup characters in the text are escaped."""
        self.set_text(plain_to_rich_text(text))

    def says(self, text: str) -> bool:
        """Return True if the caption shows this plain text."""
        return self._text == plain_to_rich_text(text)

    def set_short(self, short: bool) -> None:
        """Set whether to show one line of plain text instead of the whole text."""
        if short != self._short:
            self._short = short
            self._fit(self._line)

    @property
    def _line(self) -> int:
        """The height of a line of text in pixels."""
        return self.fontMetrics().height() + 2

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Rewrap the text for the new width."""
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
            tip = "<p>".join(filter(None, rest))
            self.label.setToolTip(f"<qt>{tip}</qt>" if line != whole else "")
        if shown != self.label.text():
            self.label.setText(shown)
        if not self._short:
            self.label.setToolTip("")
            height = max(least, self.label.heightForWidth(self.width()))
        if height != self.height():
            self.setFixedHeight(height)
        self.label.setGeometry(0, 0, self.width(), height)


class ElidedLabel(QLabel):
    """A line of text that never widens its parent. A text that does not fit ends with '…'."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint as much of the text as fits."""
        painter = QPainter(self)
        end = Qt.TextElideMode.ElideRight
        text = self.fontMetrics().elidedText(self.text(), end, self.width())
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignVCenter, text)
        painter.end()


class Headline(QLabel):
    """A line of rich text that never widens its parent, such as '<b>name</b> details'.

    A text that does not fit is replaced by a shorter form, if there is one that fits. If not, it
    ends with '…', unless the label wraps its words. Markup characters in the text must be escaped.
    """

    def __init__(self) -> None:
        super().__init__(textFormat=Qt.TextFormat.RichText)
        self._shorter: tuple[str, ...] = ()
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def set_forms(self, text: str, *shorter: str) -> None:
        """Show the given text, with shorter forms of it for a narrow line."""
        self.setText(text)
        self._shorter = shorter
        self.update()

    def setText(self, text: str) -> None:
        """Show a text that has no shorter form."""
        self._shorter = ()
        super().setText(text)

    @property
    def least_width(self) -> int:
        """The width, in pixels, of the shortest form of the text."""
        return self._width(self._shorter[-1] if self._shorter else self.text())

    def minimumSizeHint(self) -> QSize:
        """Return a minimum width of 0, so that the line can be made arbitrarily narrow."""
        return QSize(0, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint as much of the text as fits."""
        if self.wordWrap() or self.sizeHint().width() <= self.width():
            super().paintEvent(event)
            return
        painter, room = QPainter(self), self.rect()
        for words, font in self._parts(self._form):
            painter.setFont(font)
            letters = painter.fontMetrics()
            fitting = letters.elidedText(words, Qt.TextElideMode.ElideRight, room.width())
            painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, fitting)
            room.setLeft(room.left() + letters.horizontalAdvance(fitting))
        painter.end()

    @property
    def shown(self) -> str:
        """The rich text that is painted if the label does not wrap its words, without '…'."""
        return self.text() if self.sizeHint().width() <= self.width() else self._form

    @property
    def _form(self) -> str:
        """The first shorter form that fits or, if none fits, the shortest form."""
        return form_that_fits(self._shorter or (self.text(),), self._width, self.width())

    def _width(self, text: str) -> int:
        return sum(QFontMetrics(f).horizontalAdvance(words) for words, f in self._parts(text))

    def _parts(self, text: str) -> list[tuple[str, QFont]]:
        """Return the bold words and the rest of a text, and the font of each part."""
        what, _, more = text.partition("</b>")
        parts = []
        for part, weight in ((what, QFont.Weight.Bold), (more, QFont.Weight.Normal)):
            font = QFont(self.font())
            font.setWeight(weight)
            words = plain_text(part)
            parts.append((f" {words.lstrip()}" if part is more and words else words, font))
        return parts


class ElidedLine(QWidget):
    """A line of text that can change many times per second without a new layout of the window."""

    def __init__(self) -> None:
        super().__init__()
        self._text = ""
        self._still = QTimer(self, singleShot=True, interval=_STILL_MS)
        self._still.timeout.connect(self._name)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def text(self) -> str:
        """Return the text."""
        return self._text

    def set_text(self, text: str) -> None:
        """Show the given text."""
        if text != self._text:
            self._text = text
            self.update()
            self._still.start()

    def _name(self) -> None:
        self.setAccessibleName(self._text)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint as much of the text as fits, in the colour of secondary text."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
        room = self.rect().adjusted(_ASIDE, 0, -_ASIDE, 0)
        end = Qt.TextElideMode.ElideRight
        text = self.fontMetrics().elidedText(self._text, end, room.width())
        painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, text)
        painter.end()
