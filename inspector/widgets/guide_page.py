"""The window with the guide: the pages in docs/ with links, pictures, history and search."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, QSize, Qt, QTimer, QUrl
from PySide6.QtGui import (
    QDesktopServices,
    QImage,
    QKeySequence,
    QPalette,
    QResizeEvent,
    QShortcut,
    QTextCursor,
    QTextDocument,
    QTextFrameFormat,
    QTextTable,
)
from PySide6.QtWidgets import QLineEdit, QTextBrowser, QWidget

from inspector.bundled import DOCS
from inspector.language import tr
from inspector.widgets.building import hbox, hint, tool_button, vbox
from inspector.widgets.icons import SIDE, icon
from inspector.widgets.theme import Colours, Theme
from twistcore.files.ordinary import real_path

FIRST = "guide.md"
_TOPICS = (
    (tr("Guide"), FIRST),
    (tr("Start"), "start.md"),
    (tr("Keys"), "shortcuts.md"),
    (tr("Teaching"), "teaching.md"),
    (tr("Method"), "method.md"),
    (tr("Limits"), "limits.md"),
)
_MARGIN = 24  # pixels around a page
_MARKS = re.compile(r"[*_`]|\]\([^)]*\)|\[")  # emphasis, code and links in Markdown
_SETTLE_MS = 150  # time without resizing after which pictures are fitted
_PICTURES = (".png", ".svg", ".gif")  # only the first frame of an animation is shown
_SOLID = QTextFrameFormat.BorderStyle.BorderStyle_Solid
_Type = QTextDocument.ResourceType


class GuidePage(QWidget):
    """The window that shows the guide, with buttons for its main pages and a search field."""

    def __init__(self, owner: QWidget, colours: Colours, docs: Path = DOCS) -> None:
        super().__init__(owner, Qt.WindowType.Window)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Guide – Twist Inspector"))
        self.browser = Pages(docs)
        self.browser.setAccessibleName(tr("Page of the guide"))
        self.back = tool_button(tr("Back"), tr("Back (Alt+←)"))
        self.forward = tool_button(tr("Forward"), tr("Forward (Alt+→)"))
        find = tr("Find in the guide (Ctrl+F)")
        self.line = QLineEdit(placeholderText=find, clearButtonEnabled=True)
        self.line.setAccessibleName(find)
        self.line.setMinimumWidth(220)
        self.found = hint()
        self.found.setWordWrap(False)
        topics = []
        for word, file in _TOPICS:
            button = tool_button(word, f"docs/{file}")
            button.clicked.connect(lambda _=False, f=file: self.browser.go(f))
            topics.append(button)
        bar = hbox(
            self.back, self.forward, 10, *topics, None, self.found, self.line,
            margins=(8, 6, 8, 6), spacing=4,
        )  # fmt: skip
        vbox(bar, (self.browser, 1), owner=self, margins=(0, 0, 0, 0), spacing=0)
        for button, slot, ready in (
            (self.back, self.browser.backward, self.browser.backwardAvailable),
            (self.forward, self.browser.forward, self.browser.forwardAvailable),
        ):
            button.setEnabled(False)
            button.setIconSize(QSize(SIDE, SIDE))
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.clicked.connect(slot)
            ready.connect(button.setEnabled)
        self.line.textChanged.connect(self._find_typed)
        self.line.returnPressed.connect(self._find_next)
        for keys, act in (
            ("Ctrl+F", self.line.setFocus),
            ("Esc", self._leave),
            ("Alt+Left", self.browser.backward),
            ("Alt+Right", self.browser.forward),
        ):
            QShortcut(QKeySequence(keys), self).activated.connect(act)
        colours.follow(self._colour)
        room = self.screen().availableSize()
        self.resize(min(900, room.width() - 40), min(820, room.height() - 60))
        self.browser.go(FIRST)
        self.browser.setFocus()

    def _colour(self, theme: Theme) -> None:
        self.back.setIcon(icon("back", theme))
        self.forward.setIcon(icon("forward", theme))

    def _find_typed(self) -> None:
        """Search again from the start of the current match. Called when the search text changes."""
        cursor = self.browser.textCursor()
        cursor.setPosition(cursor.selectionStart())
        self._find(cursor)

    def _find_next(self) -> None:
        """Move to the next match. After the last match on a page, go to the next page with one."""
        words, cursor = self.line.text(), self.browser.textCursor()
        if words and self.browser.document().find(words, cursor).isNull():
            self.browser.go_to_page_with(words)
            cursor = self.browser.textCursor()
        self._find(cursor)

    def _find(self, behind: QTextCursor) -> None:
        """Move to the next match on this page or, after the last match, to the first one.

        The search starts at `behind`. If there is no match on the page, show a hint.
        """
        words, document = self.line.text(), self.browser.document()
        place = document.find(words, behind)
        if place.isNull():
            place = document.find(words, 0)
        missed = bool(words) and place.isNull()
        other = missed and bool(self.browser.pages_with(words))
        text = (
            tr("not on this page; press Enter to search the other pages")
            if other
            else tr("no match")
        )
        self.found.setText(text if missed else "")
        if not place.isNull():
            self.browser.setTextCursor(place)
            self.browser.ensureCursorVisible()

    def _leave(self) -> None:
        """Clear the search or, if it is empty, close the guide. Called when Esc is pressed."""
        if self.line.hasFocus() and self.line.text():
            self.line.clear()
        else:
            self.close()


class MarkdownPage(QTextBrowser):
    """A viewer for Markdown. Its tables have faint lines between the rows instead of a grid."""

    def soften_tables(self) -> None:
        """Replace the grid in the tables of the current page with faint lines."""
        line = self.palette().color(QPalette.ColorRole.Mid)
        whole = QTextCursor(self.document())
        whole.beginEditBlock()  # One block, because every cell would cause a new layout of the page
        for frame in self.document().rootFrame().childFrames():
            if isinstance(frame, QTextTable):
                looks = frame.format()
                looks.setBorder(0)
                frame.setFormat(looks)
                for row in range(frame.rows()):
                    for column in range(frame.columns()):
                        cell = frame.cellAt(row, column)
                        under = cell.format().toTableCellFormat()
                        under.setBottomBorder(1)
                        under.setBottomBorderStyle(_SOLID)
                        under.setBottomBorderBrush(line)
                        cell.setFormat(under)
        whole.endEditBlock()

    def changeEvent(self, event: QEvent) -> None:
        """Update the table lines after a theme change."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self.soften_tables()


class Pages(MarkdownPage):
    """A viewer for the Markdown files in a folder. Wide pictures are scaled to the page."""

    def __init__(self, docs: Path) -> None:
        super().__init__()
        self._docs = docs
        self.document().setDocumentMargin(_MARGIN)
        # The scroll bar is always visible. The layout would not take account of a scroll bar that
        # appears later, so pictures would be too wide.
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        self.shown_heading = ""  # the heading of the last followed link
        self.setOpenLinks(False)
        self.anchorClicked.connect(self._follow)
        self._settled = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._settled.timeout.connect(self._reload)

    def go(self, file: str) -> None:
        """Show a page, given its file name."""
        self._follow(QUrl.fromLocalFile(str(self._docs / file)))

    def pages_with(self, words: str) -> list[str]:
        """Return the names of the pages that contain a phrase.

        Pages with the phrase in a heading come first.
        """
        found = []
        for path in self._docs.glob("*.md"):
            text = _MARKS.sub("", path.read_text("utf-8")).casefold()
            if words.casefold() in " ".join(text.split()):
                headings = [line for line in text.splitlines() if line.startswith("#")]
                found.append((not any(words.casefold() in h for h in headings), path.name))
        return [name for _, name in sorted(found)]

    def go_to_page_with(self, words: str) -> None:
        """Show the next page that contains a phrase, or the first one after the last.

        If a heading on the page contains the phrase, move to the heading.
        """
        names, now = self.pages_with(words), self.source().fileName()
        if not names:
            return
        self.go(names[(names.index(now) + 1) % len(names) if now in names else 0])
        self.moveCursor(QTextCursor.MoveOperation.Start)
        block = self.document().begin()
        while block.isValid():
            if block.blockFormat().headingLevel() and words.casefold() in block.text().casefold():
                self.setTextCursor(QTextCursor(block))
                return
            block = block.next()

    def _follow(self, url: QUrl) -> None:
        """Open a link to a page or to a heading, or open a web address in the web browser."""
        if not url.isLocalFile():
            QDesktopServices.openUrl(url)
            return
        heading = url.fragment()
        url.setFragment("")
        path = real_path(Path(url.toLocalFile()))
        if not path.is_file():
            self.setMarkdown(tr("The page {name} is not installed.", name=path.name))
            return
        if url != self.source():
            self.setSource(url, _Type.MarkdownResource)
        if heading:
            self._show_heading(heading)

    def _show_heading(self, slug: str) -> None:
        block = self.document().begin()
        while block.isValid():
            if block.blockFormat().headingLevel() and _slug(block.text()) == slug:
                top = self.document().documentLayout().blockBoundingRect(block).top()
                self.verticalScrollBar().setValue(round(top))
                self.shown_heading = slug
                return
            block = block.next()

    def _reload(self) -> None:
        """Load the page again to fit its pictures to the new width."""
        bar = self.verticalScrollBar()
        share = bar.value() / max(bar.maximum(), 1)
        self.reload()
        bar.setValue(round(share * bar.maximum()))

    # -- Qt -----------------------------------------------------------------------------------

    def doSetSource(self, name: QUrl | str, kind: _Type = _Type.UnknownResource) -> None:
        """Load a page, and replace the grid in its tables with faint lines."""
        super().doSetSource(name, kind)
        self.soften_tables()

    def loadResource(self, kind: int, name: QUrl | str) -> Any:
        """Load a page, a table, a code example or a picture. Scale wide pictures to the page."""
        url = QUrl(name)
        if as_markdown := _MARKDOWN.get(Path(url.path()).suffix):
            return as_markdown(Path(self.source().resolved(url).toLocalFile()))
        if Path(url.path()).suffix not in _PICTURES:
            return super().loadResource(kind, url)
        if kind != _Type.ImageResource.value:  # a link to a picture; show the picture as a page
            return f"![]({url.fileName()})"
        picture = QImage(self.source().resolved(url).toLocalFile())
        ratio = self.devicePixelRatioF()
        room = round(ratio * max(self.viewport().width() - 2 * _MARGIN, 100))
        if picture.width() > room:
            picture = picture.scaledToWidth(room, Qt.TransformationMode.SmoothTransformation)
        picture.setDevicePixelRatio(ratio)
        return picture

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit the pictures to the page when the user has finished resizing."""
        super().resizeEvent(event)
        if event.oldSize().width() not in (-1, event.size().width()):
            self._settled.start()


def _table(path: Path) -> str:
    """Return a CSV file as a Markdown table."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = [[cell.replace("|", r"\|") for cell in row] for row in csv.reader(file)]
    rows.insert(1, ["---"] * len(rows[0]))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _code(path: Path) -> str:
    """Return a text file as a Markdown code block."""
    return f"```\n{path.read_text('utf-8')}\n```"


_MARKDOWN = {".csv": _table, ".json": _code, ".jsonl": _code, ".toml": _code}


def _slug(heading: str) -> str:
    """Return the anchor that links use for a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
