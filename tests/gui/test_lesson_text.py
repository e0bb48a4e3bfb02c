"""A lesson's texts come from anybody: they open no file, and nothing in them is HTML."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QImage, QTextDocument

from inspector.lessons.guide_card import GuideCard
from inspector.widgets.theme import LIGHT, Colours
from inspector.widgets.typeset import Typesetter

LOUD = QColor("#ff00ff")


@pytest.fixture
def card(qtbot):
    card = GuideCard(Typesetter(), Colours(LIGHT))
    qtbot.addWidget(card)
    card.resize(400, 400)
    card.show()
    qtbot.waitExposed(card)
    return card


@pytest.fixture
def picture(tmp_path, monkeypatch):
    """A file beside which the program was started."""
    image = QImage(80, 80, QImage.Format.Format_RGB32)
    image.fill(LOUD)
    assert image.save(str(tmp_path / "secret.png"))
    monkeypatch.chdir(tmp_path)
    return tmp_path / "secret.png"


def loud(card):
    """Pixels of the card in the colour of the file's picture."""
    shot = card.grab().toImage()
    places = [(x, y) for x in range(0, shot.width(), 4) for y in range(0, shot.height(), 4)]
    return sum(shot.pixelColor(*place) == LOUD for place in places)


@pytest.mark.parametrize(
    "text",
    ["![x]({})", "![x](file://{})", "![x](secret.png)", '<img src="{}">', 'Text <img src="{}"> so'],
)
def test_a_text_opens_no_file(card, picture, text):
    text = text.format(picture)
    card.show_page(text, text, text)
    assert loud(card) == 0
    opened = card.body.document().resource(QTextDocument.ResourceType.ImageResource, str(picture))
    assert QImage(opened).width() <= 1


def test_html_stands_there_as_text(card):
    html = "<b>bold</b> &amp; <a href='x'>link</a>"
    card.show_page(html, html, f"*Press* **this** {html}")
    assert (card.title.text(), card.title.textFormat()) == (html, Qt.TextFormat.PlainText)
    assert "<b>bold</b>" in card.body.toPlainText()
    document = QTextDocument()
    document.setHtml(card.task.text())
    assert card.task.textFormat() == Qt.TextFormat.RichText
    assert document.toPlainText() == f"▸ Press this {html}"
