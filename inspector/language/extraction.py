"""Bring the catalogues up to the texts in the code: `python -m inspector.language.extraction`.

New texts come in untranslated, those that are no more go; translations stay as they are.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import polib

from inspector.bundled import ASSETS, LANGUAGES
from inspector.language.catalogue import CORE
from inspector.language.script_texts import texts_of_script

_ROOT = Path(__file__).resolve().parents[2]
_TEXTS = {"tr": slice(0, 1), "plural": slice(0, 2), "tr_as": slice(1, 2)}  # of a call's arguments
# Rooms of twistcore whose sentences the window shows; what is said only by commands is not here.
_ROOMS_OF_CORE = ("detection", "why_not", "review", "tuning", "quality")
_Key = tuple[str, str, str]  # context, text, plural


def main() -> int:
    """Update every catalogue; returns the exit code."""
    texts = set(texts_in_code())
    for file in sorted(LANGUAGES.glob("*.po")):
        said = {key(entry): entry for entry in polib.pofile(str(file))}
        catalogue = polib.pofile(str(file))
        catalogue.clear()
        catalogue.wrapwidth = 98
        for wanted in sorted(texts, key=lambda k: (k[0] == CORE, k[1].lower(), k)):
            catalogue.append(said.get(wanted) or _entry(wanted))
        catalogue.save(str(file))
        missing = len(catalogue.untranslated_entries())
        print(f"{file.name}: {len(catalogue)} texts, {missing} not translated")
    return 0


def key(entry: polib.POEntry) -> _Key:
    """What tells an entry from the others."""
    return entry.msgctxt or "", entry.msgid, entry.msgid_plural or ""


def texts_in_code() -> Iterator[_Key]:
    """Every text that the code may show."""
    for module in sorted((_ROOT / "inspector").rglob("*.py")):
        for node in ast.walk(ast.parse(module.read_text("utf-8"))):
            if isinstance(node, ast.Call):
                yield from _called(node)
    for script in sorted((ASSETS / "lesson_page").iterdir()):
        for meaning, text in texts_of_script(script.read_text("utf-8")):
            yield meaning, text, ""
    for room in _ROOMS_OF_CORE:
        place = _ROOT / "twistcore" / room
        for module in sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]:
            for form in _forms(ast.parse(module.read_text("utf-8"))):
                yield CORE, form, ""


def _called(call: ast.Call) -> Iterator[_Key]:
    """The text that a call shows, also one inside of an f-string; what is no literal is none."""
    name = call.func.id if isinstance(call.func, ast.Name) else ""
    said = [arg.value if isinstance(arg, ast.Constant) else None for arg in call.args]
    texts = [text for text in said[_TEXTS.get(name, slice(0))] if isinstance(text, str)]
    if texts:
        context = str(said[0]) if name == "tr_as" else ""
        yield context, texts[0], texts[1] if name == "plural" else ""


def _forms(tree: ast.AST) -> Iterator[str]:
    """The forms of what looks like a sentence or words for people, docstrings left out."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, ast.JoinedStr):
            form = _form(node)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            form = node.value
        else:
            yield from _forms(node)
            continue
        if " " in form.strip() and any(c.isalpha() for c in form):
            yield form


def _form(sentence: ast.JoinedStr) -> str:
    pieces, holes = "", 0
    for part in sentence.values:
        if isinstance(part, ast.Constant):
            pieces += str(part.value)
        else:
            pieces += f"{{{holes}}}"
            holes += 1
    return pieces


def _entry(wanted: _Key) -> polib.POEntry:
    context, one, many = wanted
    plural = {0: "", 1: ""} if many else {}
    return polib.POEntry(
        msgctxt=context or None, msgid=one, msgid_plural=many, msgstr_plural=plural
    )


if __name__ == "__main__":
    sys.exit(main())
