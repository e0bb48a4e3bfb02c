"""Texts in the language that was chosen when the program started.

A text stands in the code in English, in `tr("Accept {count} intervals", count=7)`; what depends on
data goes in by name, so that a translation may order it otherwise. A language is one PO file, which
any translator's program opens. `python -m inspector.language.extraction` brings the files up to the
texts in the code.

`use_language` comes before what makes texts is imported: a table of texts at a module's top is then
in the right language, too. Nothing here is stored: files keep the program's own English words.
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

_MOST = 4000  # letters of what is put in: to set millions of them takes minutes

_language = SOURCE
_texts: dict[tuple[str, str], str] = {}
_plurals: dict[str, dict[int, str]] = {}


def codes() -> tuple[str, ...]:
    """Codes of what can be chosen."""
    return SOURCE, *sorted(file.stem for file in LANGUAGES.glob("*.po"))


@cache
def languages() -> dict[str, str]:
    """What can be chosen: its code -> its name in itself."""
    found = {SOURCE: "English"}
    for code in codes()[1:]:
        found[code] = _read(LANGUAGES / f"{code}.po").metadata["Language-Name"]
    return found


def wished(setting: str, of_system: Iterable[str]) -> str:
    """The language to use: the one set, else the first of the system's that there is.

    setting: a code or 'system'; of_system: such as 'de-AT', best first.
    """
    for name in (setting, *of_system):
        code = name.replace("_", "-").split("-")[0].lower()
        if code == SOURCE or (LANGUAGES / f"{code}.po").is_file():
            return code
    return SOURCE


def use_language(code: str) -> None:
    """Have texts in a language from now on; one that there is not is English."""
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
    """The code of the language that texts are in."""
    return _language


def in_language(page: Path) -> Path:
    """A lesson or page that comes with the program in the chosen language, if it is translated."""
    own = LESSONS / _language / page.name
    return own if own.is_file() else page


def entries_of_core() -> list[tuple[str, str]]:
    """Forms of twistcore's sentences and their translations; none in English."""
    return [(form, text) for (meaning, form), text in _texts.items() if meaning == CORE]


def tr(text: str, /, **values: object) -> str:
    """A text in the chosen language, `values` put in by name as `str.format` does.

    What texts among them have somebody else may have written: nothing in it is obeyed, all is seen.
    """
    found = _texts.get(("", text), text)
    return found.format(**_seen(values)) if values else found


def tr_as(meaning: str, text: str, /, **values: object) -> str:
    """A text that has several meanings, such as 'Open': `meaning` tells a translator which."""
    found = _texts.get((meaning, text), text)
    return found.format(**_seen(values)) if values else found


def announced(text: str, meaning: str = "") -> str:
    """A text that a kind of error announces in its own file, in the chosen language."""
    return _texts.get((meaning, text), text)


def plural(one: str, many: str, number: float, /, **values: object) -> str:
    """`one` or `many` as `number` wants it; `{n}` in them is the number unless `n` is given."""
    values.setdefault("n", number)
    single = number == 1
    forms = _plurals.get(one)
    text = (one if single else many) if forms is None else forms[0 if single else 1]
    return text.format(**_seen(values))


def _seen(values: dict[str, object]) -> dict[str, object]:
    texts = {
        k: legible(v, lines=True, most=_MOST)
        for k, v in values.items()
        if isinstance(v, str | Path)
    }
    return values | texts


def _read(file: Path) -> polib.POFile:
    import polib  # takes a while, and English needs none

    return polib.pofile(str(file))
