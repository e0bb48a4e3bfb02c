"""A lesson's texts come from anybody: they open no file, and nothing in them is HTML."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QImage, QTextDocument

from inspector.lessons.guide_card import GuideCard
from inspector.lessons.page_texts import Formulas, markdown_html
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


BAD = (
    r"\ ", "{" * 3000, r"\sqrt{" * 60 + "x" + "}" * 60, r"\hspace{" + "9" * 900 + "}",
    "x" * 20_000, r"\nothing", "x^{" * 300,
)  # fmt: skip


@pytest.mark.parametrize("bad", BAD, ids=lambda tex: tex[:8])
def test_a_formula_that_cannot_be_typeset_is_shown_as_tex(bad, card, qtbot):
    """It neither ends the program nor costs the other formulas of its page."""
    typesetter = card._typesetter
    card.show_page("Title", f"so ${bad}$ and $x^2$", "")
    qtbot.waitUntil(lambda: typesetter.done, timeout=30_000)
    assert typesetter.formula("x^2") is not None
    assert typesetter.formula(bad) is None
    assert not typesetter.trouble
    assert "could not be typeset" in typesetter.left_out
    assert len(typesetter.left_out) < 200
    assert bad.strip("\\ {")[:6] in card.body.toPlainText()
    typesetter.start(["y^2"])
    qtbot.waitUntil(lambda: typesetter.has(["y^2"]), timeout=30_000)
    assert not typesetter.left_out


@pytest.mark.parametrize("bad", BAD, ids=lambda tex: tex[:8])
def test_a_web_page_shows_it_as_tex_too(bad):
    html = markdown_html(f"so ${bad}$ and $x^2$", Formulas([bad]))
    assert html.count("<svg") == 1
    assert "<code>$" in html
