"""The pages of docs/ inside the program: every link leads somewhere, every picture is there."""

import re

import pytest
from PySide6.QtCore import QUrl
from PySide6.QtGui import QImage, QTextDocument

from inspector.bundled import DOCS
from inspector.widgets.guide_page import GuidePage
from inspector.widgets.theme import LIGHT

PAGES = sorted(path.name for path in DOCS.glob("*.md"))


@pytest.fixture
def guide(qtbot, window):
    page = GuidePage(window, LIGHT)
    page.resize(900, 700)
    page.show()
    qtbot.wait(20)
    yield page
    page.close()


@pytest.mark.parametrize("name", PAGES)
def test_links_and_pictures_of_a_page_are_found(guide, name):
    text = (DOCS / name).read_text("utf-8")
    guide.browser.go(name)
    room = guide.browser.viewport().width()
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text):
        image = guide.browser.loadResource(
            QTextDocument.ResourceType.ImageResource.value, QUrl(picture)
        )
        assert isinstance(image, QImage)
        assert not image.isNull()
        assert image.deviceIndependentSize().width() <= room, picture
    for link in re.findall(r"(?<!!)\[[^]]*\]\(([^)]+)\)", text):
        if link.startswith("http"):
            continue
        guide.browser.go(name)
        guide.browser.verticalScrollBar().setValue(0)
        url = guide.browser.source().resolved(QUrl(link))
        guide.browser.anchorClicked.emit(url)
        file, _, heading = link.partition("#")
        assert guide.browser.source().fileName() == (file or name).rpartition("/")[2], link
        if heading:
            assert guide.browser.shown_heading == heading, link


def test_what_is_not_installed_is_said_in_a_sentence(window, tmp_path):
    page = GuidePage(window, LIGHT, tmp_path)
    assert page.browser.toPlainText() == "This page is not installed: guide.md"
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
    assert guide.found.text() == "not on this page"
