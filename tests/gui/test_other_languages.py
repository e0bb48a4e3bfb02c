"""Lessons and their web pages in other languages than English: complete, and the same lessons."""

import ast
import inspect
import json
import re
from collections import Counter

import polib
import pytest
from PySide6.QtQml import QJSEngine

from inspector import language
from inspector.bundled import ASSETS, EXERCISE_PAGE, LANGUAGES, LESSONS
from inspector.language import texts_of_script, tr, use_language
from inspector.lessons import page_export, web_page
from inspector.lessons.exercise_texts import exercise_page
from inspector.lessons.lesson_file import read_lesson
from inspector.lessons.lesson_text import formulas
from inspector.teaching import what_if_words
from tests.gui.test_tour import ALL, TRANSLATED
from tests.gui.untranslated import code_texts

PAGE = ASSETS / "lesson_page"
NUMBER = re.compile(r"\d+(?:\.\d+)?")
EMPHASISED = re.compile(r"\*{1,2}([^*]+)\*{1,2}")
CODES = [code for code in language.languages() if code != "en"]


@pytest.fixture(params=CODES)
def chosen(request):
    use_language(request.param)
    yield request.param
    use_language("en")


def named(path):
    return f"{path.parent.name}-{path.stem}"


def test_every_lesson_is_in_every_language():
    wanted = {path.name for path in ALL} | {EXERCISE_PAGE.name}
    for code in CODES:
        assert {path.name for path in (LESSONS / code).iterdir()} == wanted


@pytest.mark.parametrize("path", TRANSLATED, ids=named)
def test_its_pages_stand_where_the_english_ones_do(path):
    pages, own = read_lesson(LESSONS / path.name).pages, read_lesson(path).pages
    assert [(p.place, p.done) for p in own] == [(p.place, p.done) for p in pages]
    for page, translated in zip(pages, own, strict=True):
        assert translated.title != page.title
        assert translated.body != page.body
        assert set(formulas(translated.body)) == set(formulas(page.body)), translated.title
        told = [Counter(NUMBER.findall(f"{p.body} {p.task}")) for p in (page, translated)]
        assert told[0] == told[1], translated.title


@pytest.mark.parametrize("path", TRANSLATED, ids=named)
def test_it_names_what_to_press_as_the_window_does(path):
    use_language(path.parent.name)
    try:
        pages = read_lesson(LESSONS / path.name).pages
        for page, own in zip(pages, read_lesson(path).pages, strict=True):
            emphasised = set(EMPHASISED.findall(own.task))
            for name in EMPHASISED.findall(page.task):
                assert tr(name) in emphasised, own.title
    finally:
        use_language("en")


def test_the_exercise_names_what_to_press_as_the_window_does(chosen):
    title, body, task = exercise_page()
    assert title == tr("Exercise")
    for name in ("Judge", "Find"):
        assert f"**{tr(name)}**" in body
    assert f"*{language.tr_as('button', 'Score')}*" in task


@pytest.mark.parametrize(
    ("german", "english"),
    [
        (r"\bRollen?\b", r"\brole"),  # of a joint's name; a roll is a Rollung
        (r"\bBild(er|ern|es|s)?\b", r"image|picture"),  # a frame is a Frame
        (r"\bVeröffentlichung\b", r"publi"),  # the paper is the Artikel
        (r"Geben Sie die Datei (?!an)", "Enter"),
    ],
)
def test_a_word_of_german_means_one_thing(german, english):
    for entry in polib.pofile(str(LANGUAGES / "de.po")):
        for text in (entry.msgstr, *entry.msgstr_plural.values()):
            assert not re.search(german, text) or re.search(english, entry.msgid, re.I), text
    for path in (LESSONS / "de").iterdir():
        assert not re.search(german, path.read_text("utf-8")), path.name


# -- a lesson as a web page -----------------------------------------------------------------------


def test_the_page_says_what_the_tab_says():
    """Both take the words from one entry of a catalogue, or they would drift apart."""
    source = ast.parse(inspect.getsource(what_if_words))
    calls = [node for node in ast.walk(source) if isinstance(node, ast.Call)]
    own = {c.args[0].value for c in calls if isinstance(c.func, ast.Name) and c.func.id == "tr"}
    script = {text for _, text in texts_of_script((PAGE / "words.js").read_text("utf-8"))}
    assert script < own
    assert [text for text in own - script if "interval" not in text] == []


@pytest.mark.thorough
def test_no_sentence_of_the_page_is_outside_the_catalogues():
    known = {(meaning, text) for meaning, text, _ in code_texts()}
    for script in PAGE.iterdir():
        source = script.read_text("utf-8")
        found = list(texts_of_script(source))
        assert set(found) <= known
        assert len(found) == len(re.findall(r"\btr(?:_as)?\((?!text|meaning)", source)), script.name


def test_a_page_is_in_the_language_of_the_program(chosen):
    lesson = read_lesson(language.translated_page_path(LESSONS / "3-1-definition.md"))
    text = web_page.page_text(lesson)
    assert f'<html lang="{chosen}">' in text
    for said in ("Child counter-twists", "Twist parent", "Reset view", "Back"):
        assert f">{tr(said)}<" in text
        assert f">{said}<" not in text
    data = json.loads(re.search(r'id="lesson-data">(.*?)</script>', text, re.S)[1])
    catalogue = {(e.msgid, e.msgstr) for e in polib.pofile(str(LANGUAGES / f"{chosen}.po"))}
    assert catalogue.issuperset(data["words"].items())
    assert data["words"]["yes"] == tr("yes")


def test_an_english_page_takes_no_words_along():
    text = web_page.page_text(read_lesson(LESSONS / "3-1-definition.md"))
    assert '<html lang="en">' in text
    assert '"words":{}' in text


def test_a_script_puts_values_in_by_name(qapp):
    engine = QJSEngine()
    engine.evaluate((PAGE / "language.js").read_text("utf-8"))
    engine.evaluate('Language.use({ "{a} of {b}": "{b}: {a}" })')
    assert engine.evaluate('Language.tr("{a} of {b}", { a: 0, b: "{a}" })').toString() == "{a}: 0"
    assert engine.evaluate('Language.tr("{a} or {b}", { a: 1, b: 2 })').toString() == "1 or 2"


def test_a_folder_of_translated_lessons_is_offered(chosen, monkeypatch, qapp):
    asked = {}
    monkeypatch.setattr(page_export, "ask_files", lambda *_, **how: asked.update(how))
    page_export.PageExport(None, lambda *_: None).ask(None)
    assert asked["folder"] == LESSONS / chosen
