"""Languages: the catalogues are whole, the window speaks one language, and every widget a name."""

import ast
import json
import os
import re
import shutil
import string
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import pytest

from inspector.language import (
    language_codes,
    language_to_use,
    plural,
    tr,
    translate_core_sentence,
    use_language,
)
from tests.conftest import ASSETS
from tests.gui import forked, untranslated
from tests.gui.untranslated import assert_translated, code_texts, waits
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains

ROOT = Path(__file__).parents[2]
SCRIPT = Path(__file__).with_name("said_texts.py")
OTHERS = [code for code in language_codes() if code != "en"]
# Words that are the same in German, or nobody translates: names, units, terms of the field.
SAME = set(
    re.findall(
        r"\w+",
        """
        twist swing offset clip clips interval frame frames azimut azimuth detektor detektoren index
        name video film start stop fokus export pause test median position profil symbol text
        system quaternion markdown blender html json toml xml csv png svg bvh amc npz gif mp4 fps
        fsr tpr auc roc hmm tau sin cos log exp max min rad inspector quamo twistcore batch
        choi jang kim sens sci technol mocap cmu edu nsf eia deutsch english esc azim format hand
        swivel dpi recall person
        """,
    )
)

MARKED = re.compile(r"\b(?:tr|tr_as|plural)\(")
ELSEWHERE = ("web_page.py",)  # its texts are those of a script, which is looked through itself


entries = untranslated.catalogue


@pytest.fixture
def german():
    use_language("de")
    yield
    use_language("en")


# -- catalogues -----------------------------------------------------------------------------------


@pytest.mark.parametrize("code", OTHERS)
def test_a_catalogue_has_every_text_of_the_code_translated_and_no_other(code):
    assert_translated(code)


@pytest.mark.thorough
def test_a_text_that_waits_for_its_translation_is_a_warning_and_with_ci_an_error(monkeypatch):
    texts = [("", "Nobody translated {n} of this.", ""), *code_texts()]
    monkeypatch.setattr(untranslated, "code_texts", lambda: texts)
    clear = untranslated.untranslated.cache_clear, untranslated._forms.cache_clear
    for forget in clear:
        forget()
    try:
        monkeypatch.setattr(untranslated, "ERROR", False)
        with pytest.warns(UserWarning, match="1 texts .*Nobody translated"):
            assert_translated("de")
        assert untranslated.waits("de", "Nobody translated 7 of this.")
        assert not untranslated.waits("de", "Somebody translated 7 of this.")
        monkeypatch.setattr(untranslated, "ERROR", True)
        assert not untranslated.waits("de", "Nobody translated 7 of this.")
        with pytest.raises(AssertionError, match="Nobody translated"):
            assert_translated("de")
    finally:
        for forget in clear:
            forget()


def translations(entry):
    return list(entry.msgstr_plural.values()) if entry.msgid_plural else [entry.msgstr]


def holes(text):
    """What is put into a text, with how it is written."""
    return sorted((name, form) for _, name, form, _ in string.Formatter().parse(text) if name)


@pytest.mark.parametrize("code", OTHERS)
def test_a_translation_has_the_places_of_its_text(code):
    for entry in entries(code).translated_entries():
        # A hole may go twice where the other language needs it, or where the plural says one.
        wanted = set(holes(entry.msgid)) | set(holes(entry.msgid_plural))
        for said in translations(entry):
            assert set(holes(said)) <= wanted, entry.msgid
        assert set(holes(translations(entry)[-1])) == wanted, entry.msgid


@pytest.mark.parametrize("code", OTHERS)
def test_a_translation_keeps_spaces_at_the_ends_and_marks_of_letters(code):
    for entry in entries(code).translated_entries():
        for said in translations(entry):
            ends = [text[: len(text) - len(text.lstrip())] for text in (entry.msgid, said)]
            assert ends[0] == ends[1], entry.msgid
            assert entry.msgid.endswith(" ") == said.endswith(" "), entry.msgid
            assert ("&" in entry.msgid) == ("&" in said), entry.msgid


@pytest.mark.parametrize("code", OTHERS)
def test_no_english_is_left_in_a_catalogue(code):
    left = [e.msgid for e in entries(code) if e.msgid in translations(e) and english(e.msgid)]
    assert left == []


@pytest.mark.thorough
def test_every_text_that_is_marked_is_extracted():
    """A text that is computed is none that a translator meets."""
    known = {text for key in code_texts() for text in key[1:]}
    lost = []
    for module in sorted((ROOT / "inspector").rglob("*.py")):
        source = module.read_text("utf-8")
        for node in ast.walk(ast.parse(source)) if MARKED.search(source) else ():
            name = getattr(node.func, "id", "") if isinstance(node, ast.Call) else ""
            place = {"tr": (0,), "tr_as": (1,), "plural": (0, 1)}.get(name, ())
            if module.parent.name == "language" or module.name in ELSEWHERE:
                continue
            texts = [node.args[k] for k in place]
            if any(not isinstance(t, ast.Constant) or t.value not in known for t in texts):
                lost.append(f"{module.relative_to(ROOT)}:{node.lineno}")
    assert lost == []


# -- the choice -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("setting", "system", "used"),
    [
        ("de", ["en-GB"], "de"),
        ("en", ["de-AT"], "en"),
        ("system", ["de-Latn-AT", "de-AT"], "de"),
        ("system", ["fr-FR", "de_DE", "en"], "de"),
        ("system", ["fr", "C"], "en"),
        ("../de", [], "en"),
        ("klingon", ["de"], "de"),
    ],
)
def test_the_language_set_goes_before_those_of_the_system(setting, system, used):
    assert language_to_use(setting, system) == used


def test_english_stands_where_a_language_has_nothing(german):
    assert tr("Nobody ever says this.") == "Nobody ever says this."
    assert plural("{n} interval", "{n} intervals", 1) == "1 Intervall"
    assert plural("{n} interval", "{n} intervals", 3) == "3 Intervalle"
    assert (
        translate_core_sentence("Nobody says this about 3 frames.")
        == "Nobody says this about 3 frames."
    )


@pytest.mark.usefixtures("german")
def test_the_teaching_tab_names_a_chain_as_the_lists_do(at_forearm):
    at_forearm.taught.set_active(True)
    at_forearm.teaching.refresh()
    texts = at_forearm.teaching.title.text(), at_forearm.teaching.gizmo.legend()
    assert all("Unterarm links" in text for text in texts), texts


def test_a_language_that_there_is_not_is_refused(tmp_path):
    said = "twist-inspector: --language fr: expected one of en, de or system.\n"
    assert start("--language", "fr") == (2, said)


@pytest.mark.thorough
def test_a_damaged_file_of_settings_is_told_in_the_language(tmp_path):
    settings = tmp_path / "settings.json"
    settings.write_text('{"language": "de", "step": 0}')
    picture = tmp_path / "empty.png"
    code, said = start("--screenshot", picture, TWIST_INSPECTOR_SETTINGS=str(settings))
    assert code == 0, said
    assert "Die Einstellungen step waren beschädigt" in said
    assert [f.name for f in tmp_path.glob("*.damaged*")] == ["settings.json.damaged"]


def start(*words, **environment):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "LC_ALL": "C", **environment}
    return forked.run(["-m", "inspector", *words], environment, errors=subprocess.STDOUT)


# -- the whole window -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """What the whole window says in English and in German."""

    def one(code):
        clip = shutil.copy(ASSETS / "walk_injected.bvh", tmp_path_factory.mktemp(code))
        done = subprocess.run(  # not forked: some texts are translated when they are imported
            [sys.executable, str(SCRIPT), code, clip],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    with ThreadPoolExecutor() as both:  # each waits for half its time
        return dict(zip(("en", "de"), both.map(one, ("en", "de")), strict=True))


@pytest.mark.thorough
def test_no_text_of_the_window_is_one_that_is_translated(said):
    known = {e.msgid: e.msgstr for e in entries("de") if e.translated() and not e.msgctxt}
    texts = {t: where for t, where in said["de"]["texts"].items() if known.get(t, t) != t}
    found = {t: where for t, where in texts.items() if english(t) and t not in in_german()}
    assert {t: where for t, where in found.items() if not waits("de", t)} == {}


@pytest.mark.thorough
def test_no_english_words_stand_in_both_windows(said):
    both = said["en"]["texts"].keys() & said["de"]["texts"].keys() - in_german()
    found = [t for t in sorted(both) if english(t) and not waits("de", t)]
    assert {t: said["de"]["texts"][t] for t in found} == {}


def in_german():
    """Translations: some are words of English, too, with another meaning, such as 'Kind'."""
    return {text for entry in entries("de") for text in translations(entry)}


@pytest.mark.thorough
@pytest.mark.parametrize("code", ["en", "de"])
def test_a_screen_reader_has_a_name_for_all_that_the_keyboard_reaches(said, code):
    assert said[code]["unnamed"] == {}


@cache
def names():
    """What joints and chains of the clip are called, and a word of BVH; the longest first."""
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    chains = [c.label for c in find_chains(motion)]
    return sorted({*motion.skeleton.names, *chains, "Frame Time"}, key=len, reverse=True)


def english(text):
    """Its words that may be English: no names of joints, files, formulas; none that are `SAME`."""
    for name in names():
        text = text.replace(name, " ")
    text = re.sub(r"<[^>]*>|\{[^}]*\}|`[^`]*`|\S*[/\\.@_]\w\S*|\\\w+", " ", text)
    words = re.findall(r"[^\W\d_]{3,}", text)
    return [w for w in words if w.lower() not in SAME and not re.search(r"[a-z][A-Z]", w)]
