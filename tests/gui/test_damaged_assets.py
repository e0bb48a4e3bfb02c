"""Catalogues and icons that are damaged: the program has English texts or empty icons instead."""

import random
import re

import pytest

from inspector import bundled
from inspector.language import catalogue
from inspector.widgets import icons
from inspector.widgets.theme import LIGHT
from tests.fuzz.json_damage import damage_bytes
from tests.hostile_texts import hostile_texts

TRIALS = 100
SAID = re.compile(r'^msgid "(.+)"$', re.MULTILINE)


@pytest.fixture
def languages(tmp_path, monkeypatch):
    """An empty folder of catalogues, and the language that was in use afterwards."""
    before = catalogue.chosen_language()
    with monkeypatch.context() as patched:
        patched.setattr(catalogue, "LANGUAGES", tmp_path)
        catalogue.languages.cache_clear()
        yield tmp_path
    catalogue.languages.cache_clear()
    catalogue.use_language(before)


def some_entries():
    """The head of the German catalogue and its texts with values."""
    head, *entries = (bundled.LANGUAGES / "de.po").read_text("utf-8").split("\n\n")
    return "\n\n".join([head, *(e for e in entries if "{" in e and "msgctxt" not in e)][:150])


def say_all(whole):
    """Each text with its values, as the window says it."""
    for text in SAID.findall(whole):
        values = dict.fromkeys(re.findall(r"\{(\w+)[^}]*\}", text), 3)
        english = text.format(**values)
        assert isinstance(catalogue.tr(text, **values), str)
        assert english
        assert isinstance(catalogue.plural(text, text, 1, **values), str)
        assert isinstance(catalogue.plural(text, text, 3, **values), str)


def test_a_damaged_catalogue_has_the_texts_that_are_left(languages):
    whole, rng, left = some_entries(), random.Random(7), 0
    for _ in range(TRIALS):
        (languages / "de.po").write_bytes(damage_bytes(whole.encode(), rng))
        catalogue.languages.cache_clear()
        assert "de" in catalogue.languages()
        catalogue.use_language("de")
        say_all(whole)
        left += bool(catalogue._texts)
    assert 0 < left < TRIALS


def test_hostile_translations_say_nothing_but_themselves(languages):
    for text in (*hostile_texts(), "{count.__class__}", "{0}", "{", "{count!x}", "{count:%}"):
        catalogue.use_language("en")
        (languages / "de.po").write_text("", "utf-8")
        catalogue.use_language("de")
        catalogue._texts["", "Accept {count} intervals"] = text
        catalogue._plurals["{n} interval"] = {0: text}
        assert catalogue.tr("Accept {count} intervals", count=7)
        assert catalogue.plural("{n} interval", "{n} intervals", 1)
        assert catalogue.plural("{n} interval", "{n} intervals", 3) == "3 intervals"


@pytest.mark.parametrize("name", ["accept", "program"])
def test_a_damaged_icon_is_empty_or_drawn_in_part(qapp, name, tmp_path, monkeypatch):
    whole, rng = (bundled.ICONS / f"{name}.svg").read_bytes(), random.Random(7)
    monkeypatch.setattr(icons, "ICONS", tmp_path)
    for _ in range(TRIALS):
        (tmp_path / f"{name}.svg").write_bytes(damage_bytes(whole, rng))
        made = icons.program_icon() if name == "program" else icons.icon(name, LIGHT)
        assert not made.isNull()
