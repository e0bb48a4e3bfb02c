"""Texts in the language chosen at the program's start.

The code has the English text, as in `tr("Accept {count} intervals", count=7)`. Values are inserted
by name, so that a translation may use another order. A language is one PO file, which any
translation program opens. `python -m inspector.language.extraction` updates the files from the
code.

Call `use_language` before importing modules with texts, as some build tables of texts at import.
Files never contain translated texts, only the program's English words.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from inspector.bundled import LANGUAGES, LESSONS
from twistcore.files.encoding import legible

if TYPE_CHECKING:
    import polib

SOURCE = "en"  # the language that the code is written in

CORE = "core"  # the context of twistcore's sentences

_MOST = 4000  # letters of an inserted value: laying out millions takes minutes

_language = SOURCE
_texts: dict[tuple[str, str], str] = {}
_plurals: dict[str, dict[int, str]] = {}


def codes() -> tuple[str, ...]:
    """Return the codes of the available languages."""
    return SOURCE, *sorted(file.stem for file in LANGUAGES.glob("*.po"))


@cache
def languages() -> dict[str, str]:
    """Return the available languages: code -> name in that language."""
    found = {SOURCE: "English"}
    for code in codes()[1:]:
        found[code] = _read(LANGUAGES / f"{code}.po").metadata["Language-Name"]
    return found


def wished(setting: str, of_system: Iterable[str]) -> str:
    """Return the language to use: the setting, or the first available of the system's.

    setting: a code or 'system'; of_system: codes such as 'de-AT', best first.
    """
    for name in (setting, *of_system):
        code = name.replace("_", "-").split("-")[0].lower()
        if code == SOURCE or (LANGUAGES / f"{code}.po").is_file():
            return code
    return SOURCE


def use_language(code: str) -> None:
    """Switch all texts to a language, or to English if there is no catalogue for it."""
    global _language
    file = LANGUAGES / f"{code}.po"
    _language = code if code != SOURCE and file.is_file() else SOURCE
    _texts.clear()
    _plurals.clear()
    for entry in _read(file).translated_entries() if _language != SOURCE else ():
        if entry.msgid_plural:
            _plurals[entry.msgid] = entry.msgstr_plural
        else:
            _texts[entry.msgctxt or "", entry.msgid] = entry.msgstr


def chosen_language() -> str:
    """Return the code of the present language."""
    return _language


def in_language(page: Path) -> Path:
    """Return the translation of a lesson or page; without one, the page itself."""
    own = LESSONS / _language / page.name
    return own if own.is_file() else page


def entries_of_core() -> list[tuple[str, str]]:
    """Return the forms of twistcore's sentences with their translations; none in English."""
    return [(form, text) for (meaning, form), text in _texts.items() if meaning == CORE]


def tr(text: str, /, **values: object) -> str:
    """Return a text in the chosen language, with `values` inserted by name as by `str.format`.

    Control characters in the values are made visible, as the values may come from files.
    """
    found = _texts.get(("", text), text)
    return found.format(**_legible_values(values)) if values else found


def tr_as(meaning: str, text: str, /, **values: object) -> str:
    """Return a text with several meanings, such as 'Open'; `meaning` helps the translator."""
    found = _texts.get((meaning, text), text)
    return found.format(**_legible_values(values)) if values else found


def announced(text: str, meaning: str = "") -> str:
    """Return a text that a kind of error declares in its own file, in the chosen language."""
    return _texts.get((meaning, text), text)


def plural(one: str, many: str, number: float, /, **values: object) -> str:
    """Return `one` or `many` for a number; `{n}` in them is the number, unless `n` is given."""
    values.setdefault("n", number)
    single = number == 1
    forms = _plurals.get(one)
    text = (one if single else many) if forms is None else forms[0 if single else 1]
    return text.format(**_legible_values(values))


def _legible_values(values: dict[str, object]) -> dict[str, object]:
    texts = {
        k: legible(v, lines=True, most=_MOST)
        for k, v in values.items()
        if isinstance(v, str | Path)
    }
    return values | texts


def _read(file: Path) -> polib.POFile:
    import polib  # takes a while, and English needs none

    return polib.pofile(str(file))
