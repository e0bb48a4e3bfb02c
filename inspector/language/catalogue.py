"""Translate texts to the language that is chosen when the program starts.

The code contains the English text, as in `tr("Accept {count} intervals", count=7)`. Values are
inserted by name, so that a translation can put them in a different order. Each language is one PO
file, which can be opened with any translation program. `python -m inspector.language.extraction`
updates these files from the code.

Call `use_language` before importing modules with texts, because some of them build tables of texts
when they are imported. Files written by the program contain only English texts.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from inspector.bundled import LANGUAGES, LESSONS
from twistcore.files.encoding import escape_control_characters

if TYPE_CHECKING:
    import polib

SOURCE = "en"  # the language of the texts in the code

CORE = "core"  # the context of sentences from twistcore

_MOST = 4000  # maximum length of an inserted value, because the layout of very long texts is slow

_language = SOURCE
_texts: dict[tuple[str, str], str] = {}
_plurals: dict[str, dict[int, str]] = {}


def language_codes() -> tuple[str, ...]:
    """Return the codes of the available languages."""
    return SOURCE, *sorted(file.stem for file in LANGUAGES.glob("*.po"))


@cache
def languages() -> dict[str, str]:
    """Return the native names of the available languages, such as 'Deutsch', keyed by code."""
    found = {SOURCE: "English"}
    for code in language_codes()[1:]:
        found[code] = _read(LANGUAGES / f"{code}.po").metadata.get("Language-Name", code)
    return found


def language_to_use(setting: str, of_system: Iterable[str]) -> str:
    """Return the code of the language to use.

    This is the language in `setting` if it is available. If `setting` is 'system' or not available,
    it is the first available language in `of_system`, a list of codes such as 'de-AT' in order of
    preference. If none is available, the language is English.
    """
    for name in (setting, *of_system):
        code = name.replace("_", "-").split("-")[0].lower()
        if code == SOURCE or (LANGUAGES / f"{code}.po").is_file():
            return code
    return SOURCE


def use_language(code: str) -> None:
    """Switch all texts to a language, or to English if its catalogue is missing or damaged."""
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
    """Return the code of the current language."""
    return _language


def translated_page_path(page: Path) -> Path:
    """Return the path of a page's translation, or of the page itself if there is no translation."""
    own = LESSONS / _language / page.name
    return own if own.is_file() else page


def core_translations() -> list[tuple[str, str]]:
    """Return (template, translation) pairs for the sentences of twistcore.

    The list is empty if the current language is English.
    """
    return [(form, text) for (meaning, form), text in _texts.items() if meaning == CORE]


def tr(text: str, /, **values: object) -> str:
    """Translate a text, and insert `values` by name as in `str.format`.

    Control characters in the values are escaped, because the values may come from files.
    """
    return _filled(_texts.get(("", text), text), text, values)


def tr_as(meaning: str, text: str, /, **values: object) -> str:
    """Translate a text that has several meanings, such as 'Open', distinguished by `meaning`."""
    return _filled(_texts.get((meaning, text), text), text, values)


def translate_declared_text(text: str) -> str:
    """Translate a text, such as a label, that a kind of error or a detector declares."""
    return _texts.get(("", text), text)


def plural(one: str, many: str, number: float, /, **values: object) -> str:
    """Translate the singular `one` if `number` is 1, or the plural `many` if not.

    `{n}` in the text is replaced by `number`, unless `values` contains an n.
    """
    values.setdefault("n", number)
    single = number == 1
    forms = _plurals.get(one)
    text = one if single else many
    found = text if forms is None else forms.get(0 if single else 1, text)
    return _filled(found, text, values)


def _filled(found: str, text: str, values: dict[str, object]) -> str:
    """Insert the values into the translation or, if that is damaged, into the English text.

    `found` is the translation, and `text` is the English text.
    """
    if not values:
        return found
    values = _legible_values(values)
    try:
        return found.format(**values)
    except (LookupError, ValueError, AttributeError, TypeError):
        return text.format(**values)


def _legible_values(values: dict[str, object]) -> dict[str, object]:
    texts = {
        k: escape_control_characters(v, lines=True, most=_MOST)
        for k, v in values.items()
        if isinstance(v, str | Path)
    }
    return values | texts


def _read(file: Path) -> polib.POFile:
    """Read a catalogue. If the file is damaged, return an empty catalogue."""
    import polib  # imported only if needed, since English has no catalogue

    try:
        return polib.pofile(str(file), encoding="utf-8")
    except (OSError, ValueError, LookupError):
        return polib.POFile()
