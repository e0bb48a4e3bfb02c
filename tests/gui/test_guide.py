"""The pages of docs/ inside the program: every link leads somewhere, every picture is there."""

import re

import pytest
from PySide6.QtCore import QUrl
from PySide6.QtGui import QImage, QTextDocument, QTextTable

from inspector.bundled import DOCS
from inspector.widgets.guide_page import GuidePage
from inspector.widgets.theme import LIGHT, Colours
from tests.tiers import parametrize

PAGES = sorted(path.name for path in DOCS.glob("*.md"))


@pytest.fixture
def guide(qtbot, window):
    page = GuidePage(window, Colours(LIGHT))
    page.resize(900, 700)
    page.show()
    qtbot.wait(20)
    yield page
    page.close()


@pytest.mark.thorough
def test_every_picture_of_every_page_is_found(guide):
    room = guide.browser.viewport().width()
    for name in PAGES:
        guide.browser.go(name)
        for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", (DOCS / name).read_text("utf-8")):
            image = guide.browser.loadResource(
                QTextDocument.ResourceType.ImageResource.value, QUrl(picture)
            )
            assert isinstance(image, QImage), (name, picture)
            assert not image.isNull(), (name, picture)
            assert image.deviceIndependentSize().width() <= room, (name, picture)


@pytest.mark.thorough
def test_every_link_of_every_page_leads_to_its_heading(guide):
    """Each place is gone to once, however many links lead there: to show a page takes a while."""
    followed = set()
    for name in PAGES:
        guide.browser.go(name)
        page = guide.browser.source()
        for link in re.findall(r"(?<!!)\[[^]]*\]\(([^)]+)\)", (DOCS / name).read_text("utf-8")):
            url = page.resolved(QUrl(link))
            if link.startswith("http") or url in followed:
                continue
            followed.add(url)
            guide.browser.anchorClicked.emit(url)
            file, _, heading = link.partition("#")
            wanted = (file or name).rpartition("/")[2]
            assert guide.browser.source().fileName() == wanted, (name, link)
            assert not heading or guide.browser.shown_heading == heading, (name, link)


def test_tables_and_examples_are_shown_as_such(guide):
    guide.browser.go("tables/limits-cost.csv")
    frames = guide.browser.document().rootFrame().childFrames()
    (table,) = [frame for frame in frames if isinstance(frame, QTextTable)]
    assert (table.columns(), table.cellAt(0, 0).firstCursorPosition().block().text()) == (
        2,
        "measurement",
    )
    guide.browser.go("examples/info.json")
    example = (DOCS / "examples" / "info.json").read_text("utf-8")
    assert guide.browser.toPlainText().split() == example.split()


@pytest.mark.thorough
def test_what_is_not_installed_is_said_in_a_sentence(window, tmp_path):
    page = GuidePage(window, Colours(LIGHT), tmp_path)
    assert page.browser.toPlainText() == "The page guide.md is not installed."
    page.close()


def test_back_and_forward_and_a_search(qtbot, guide):
    assert not guide.back.isEnabled()
    guide.browser.go("teaching.md")
    assert guide.back.isEnabled()
    guide.back.click()
    assert guide.browser.source().fileName() == "guide.md"
    guide.forward.click()
    assert guide.browser.source().fileName() == "teaching.md"
    guide.line.setText("twist")
    first = guide.browser.textCursor().position()
    guide.line.returnPressed.emit()
    assert guide.browser.textCursor().position() > first
    guide.line.setText("no such words")
    assert guide.found.text() == "no match"


@parametrize("words", ["lone jump", "joint jump"])
def test_the_search_reaches_the_section_of_a_kind_of_error(guide, words):
    guide.browser.go("teaching.md")
    guide.line.setText(words)
    assert guide.found.text() == "not on this page; press Enter to search the other pages"
    guide.line.returnPressed.emit()
    assert not guide.found.text()
    assert guide.browser.source().fileName() == "method.md"
    cursor = guide.browser.textCursor()
    assert cursor.block().blockFormat().headingLevel()
    assert cursor.selectedText().casefold() == words
