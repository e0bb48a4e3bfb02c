"""Show the text of a lesson page, which is Markdown with TeX formulas between $…$."""

from __future__ import annotations

import re

from PySide6.QtCore import QPointF, Qt, QUrl
from PySide6.QtGui import (
    QColor,
    QImage,
    QPainter,
    QTextBlock,
    QTextCharFormat,
    QTextCursor,
    QTextDocument,
)
from PySide6.QtWidgets import QTextBrowser

from inspector.language import tr
from inspector.widgets.theme import Colours, Theme
from inspector.widgets.typeset import EM, Typesetter

_TEX = re.compile(r"(?<![\\$])\$([^$\n]+)\$(?!\$)")
_SIZE = 0.95  # size of a formula relative to the font's height
_FEATURES = QTextDocument.MarkdownFeature
_MARKDOWN = _FEATURES.MarkdownDialectGitHub | _FEATURES.MarkdownNoHTML


def formulas(markdown: str) -> tuple[str, ...]:
    """Return the TeX formulas in a text in order, without duplicates."""
    return tuple(dict.fromkeys(_TEX.findall(markdown)))


class LessonText(QTextBrowser):
    """A text view for Markdown. Formulas appear as TeX source until they are typeset."""

    def __init__(self, typesetter: Typesetter, colours: Colours) -> None:
        super().__init__(openLinks=False)
        self._typesetter = typesetter
        self._markdown, self._ink = "", "#000000"
        self._pictures: dict[str, QImage] = {}
        self.setFrameShape(QTextBrowser.Shape.NoFrame)
        typesetter.ready.connect(self._render)
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        self._ink = theme.text
        self.setStyleSheet(f"background: {theme.window}; color: {theme.text}")
        self._render()

    def set_size(self, pixels: int) -> None:
        """Set the font size in pixels. The size of formulas follows the size of the text."""
        font = self.font()
        # In points, by which Qt sets the distance of paragraphs
        font.setPointSizeF(72.0 * pixels / self.logicalDpiY())
        self.setFont(font)
        self._render()

    def show_markdown(self, text: str) -> None:
        """Show a Markdown text, scrolled to its beginning."""
        self._markdown = text
        if wanted := formulas(text):
            self._typesetter.start(wanted)
        self._render()
        self.verticalScrollBar().setValue(0)

    def _render(self) -> None:
        known: dict[str, str] = {}

        def image(found: re.Match[str]) -> str:
            if self._typesetter.formula(found[1]) is None:
                return f"*{found[1]}*"
            address = known.setdefault(found[1], f"tex:{len(known)}")
            return f"![{tr('formula')}]({address})"  # Qt drops an image without alternative text

        markdown = _TEX.sub(image, self._markdown)
        self._pictures = {address: self._picture(tex) for tex, address in known.items()}
        self.document().setMarkdown(markdown, _MARKDOWN)
        self._lower_images()

    def loadResource(self, kind: int, name: QUrl | str) -> object:
        """Return the image of a formula. Qt calls this method after every change to the text.

        For any other address, return an empty image. If no image were returned, Qt would try to
        open a file with this address, and would block if the file is a pipe.
        """
        address = name.toString() if isinstance(name, QUrl) else name
        return self._pictures.get(address, _nothing())

    def _picture(self, tex: str) -> QImage:
        """Return an image of a formula. Its baseline is one font descent above the lower edge."""
        formula = self._typesetter.formula(tex)
        assert formula is not None
        metrics, ratio = self.fontMetrics(), self.devicePixelRatioF()
        scale = _SIZE * metrics.height() / EM
        width = formula.box.width() * scale + 2.0
        above = max(-formula.box.top() * scale, float(metrics.ascent())) + 1.0
        high = above + metrics.descent() + 1
        picture = QImage(round(width * ratio), round(high * ratio), QImage.Format.Format_ARGB32)
        picture.setDevicePixelRatio(ratio)
        picture.fill(Qt.GlobalColor.transparent)
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(QPointF(1.0, above))
        painter.scale(scale, scale)
        painter.translate(-formula.box.left(), 0.0)
        painter.fillPath(formula.path, QColor(self._ink))
        painter.end()
        return picture

    def _lower_images(self) -> None:
        """Align the baselines of formulas with the text. By default, Qt places images higher."""
        lowered = QTextCharFormat()
        lowered.setVerticalAlignment(QTextCharFormat.VerticalAlignment.AlignBaseline)
        block = self.document().begin()
        while block.isValid():
            for start, length in _images(block):
                cursor = QTextCursor(self.document())
                cursor.setPosition(start)
                cursor.setPosition(start + length, QTextCursor.MoveMode.KeepAnchor)
                cursor.mergeCharFormat(lowered)
            block = block.next()


def _nothing() -> QImage:
    """Return a transparent image of one pixel."""
    picture = QImage(1, 1, QImage.Format.Format_ARGB32)
    picture.fill(Qt.GlobalColor.transparent)
    return picture


def _images(block: QTextBlock) -> list[tuple[int, int]]:
    """Return the position and the length of each image in a block of text."""
    out, at = [], block.begin()
    while not at.atEnd():
        fragment = at.fragment()
        if fragment.charFormat().isImageFormat():
            out.append((fragment.position(), fragment.length()))
        at += 1
    return out
