"""Update the catalogues from the texts in the code: `python -m inspector.language.extraction`.

New texts are added without a translation. Texts that no longer occur in the code are removed.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TypeGuard

import polib

from inspector.bundled import ASSETS, LANGUAGES
from inspector.language.catalogue import CORE
from inspector.language.core_sentences import LABELS, OF_SYSTEM
from inspector.language.script_texts import texts_of_script

_ROOT = Path(__file__).resolve().parents[2]
# Functions that are called with texts, and their arguments in order.
_CALLS = {"tr": ("text",), "plural": ("text", "many"), "tr_as": ("meaning", "text")}
# Parts of twistcore whose sentences the window shows.
_ROOMS_OF_CORE = (
    *("detection", "review", "tuning", "errors", "quamo/response", "quamo/track_clip"),
    *("quamo/spline", "quamo/clip_tracking", "quamo/clip_smoothing", "quamo/tracking_settings"),
    *("analysis/clip_analysis", "analysis/examination", "analysis/why_not", "analysis/quality"),
    "analysis/error_groups",
    *("analysis/correction/corrected", "analysis/correction/protected_measures"),
    *("analysis/correction/twist_removal", "analysis/correction/joint_repairs"),
    *("skeleton/body", "skeleton/chain", "skeleton/limb", "skeleton/motion", "skeleton/notation"),
    "skeleton/joint_owners",
    *("skeleton/rig", "formats/reading", "formats/clip", "formats/clip_files", "formats/suffixes"),
    *("formats/bvh", "formats/amc", "formats/npz"),
    *("files/atomic", "files/lock", "files/kinds", "files/wide_text", "files/encoding"),
    *("files/document_values", "files/ordinary", "work/processes", "synthesis/truth"),
    *("report/clip_report", "batch/inputs", "batch/run", "batch/clip_task", "batch/clip_survey"),
    *("export/compare", "export/scene_keys", "export/exported_clips"),
    *("study/class_exercise", "study/exercise_clip"),
)
# The values of these names are single words, which are shown as well
_WORDS = ("Kind", "Decision", "SEEN")
# The context of each text that is passed to these classes, keyed by field.
_INFOS = {
    "DetectorInfo": dict.fromkeys(
        ("label", "short", "measures", "strength", "tau", "action"), CORE
    ),
    "KindInfo": {
        **dict.fromkeys(
            ("name", "here", "named", "legend", "tip", "why", "happens", "offer"), CORE
        ),
        "label": "",
    },
}
# Texts that are written to files, matched or compared, or that only programmers see.
_IN_FILES = re.compile(
    r"#|\(\?|<|\"[a-z]+\": true$|[a-z_]+ = |End Site$|from |twistcore batch$|\{0\}\t|6 X"
)
_FOR_PROGRAMS = ("__repr__", "compile", "KeyError", "TypeError", "AttributeError")
_Key = tuple[str, str, str]  # context, text, plural


def main() -> int:
    """Update the catalogue of every language, and return the exit code."""
    texts = set(texts_in_code())
    for file in sorted(LANGUAGES.glob("*.po")):
        known = {catalogue_entry_key(entry): entry for entry in polib.pofile(str(file))}
        catalogue = polib.pofile(str(file))
        catalogue.clear()
        catalogue.wrapwidth = 98
        for text in sorted(texts, key=lambda k: (k[0] == CORE, k[1].lower(), k)):
            catalogue.append(known.get(text) or _entry(text))
        catalogue.save(str(file))
        missing = len(catalogue.untranslated_entries())
        print(f"{file.name}: {len(catalogue)} texts, {missing} not translated")
    return 0


def catalogue_entry_key(entry: polib.POEntry) -> _Key:
    """Return the key of a catalogue entry: its context, text and plural."""
    return entry.msgctxt or "", entry.msgid, entry.msgid_plural or ""


def texts_in_code() -> Iterator[_Key]:
    """Yield the key of every text in the code that the window may show."""
    for module in sorted((_ROOT / "inspector").rglob("*.py")):
        for node in ast.walk(ast.parse(module.read_text("utf-8"))):
            if (call := _name(node)) in _CALLS and isinstance(node, ast.Call):
                found = {what: _text(node, k) for k, what in enumerate(_CALLS[call])}
                if None not in found.values():
                    yield found.get("meaning") or "", found["text"] or "", found.get("many") or ""
    for script in sorted((ASSETS / "lesson_page").iterdir()):
        for meaning, text in texts_of_script(script.read_text("utf-8")):
            yield meaning, text, ""
    for sentence in (*OF_SYSTEM, *LABELS):
        yield CORE, sentence, ""
    for room in _ROOMS_OF_CORE:
        place = _ROOT / "twistcore" / room
        for module in sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]:
            tree = ast.parse(module.read_text("utf-8"))
            for form in _forms(tree):
                yield CORE, form, ""
            for meaning, text in _announced(tree):
                yield meaning, text, ""


def _forms(tree: ast.AST) -> Iterator[str]:
    """Yield a template for each string that looks like a text for users, except docstrings."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if _name(node) in _FOR_PROGRAMS:
            continue
        if _name(node) in _WORDS:
            yield from (str(ast.literal_eval(n.value)) for n in ast.walk(node) if _is_word(n))
        elif isinstance(node, ast.Call) and _name(node) in _INFOS:
            continue
        elif isinstance(node, ast.JoinedStr):
            yield from _if_words(_form(node))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from _if_words(_escaped(node.value))
        else:
            yield from _forms(node)


def _announced(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield the texts that detectors and kinds of errors declare, with the context of each text."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and (fields := _INFOS.get(_name(node))):
            for word in node.keywords:
                text = _constant(word.value)
                if word.arg in fields and len(text) > 1:
                    yield fields[word.arg], _numbered(text)


def _numbered(template: str) -> str:
    """Return a template with its named placeholders replaced by numbers."""
    for number, name in enumerate(re.findall(r"\{\w+\}", template)):
        template = template.replace(name, f"{{{number}}}", 1)
    return template


def _name(node: ast.AST) -> str:
    """Return the name that a node defines or calls, or ''."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return node.name
    if isinstance(node, ast.Assign):
        return getattr(node.targets[0], "id", "")
    called = node.func if isinstance(node, ast.Call) else None
    return getattr(called, "id", getattr(called, "attr", ""))


def _text(call: ast.Call, place: int) -> str | None:
    """Return the text of a call's argument, or None if the argument is not a constant text."""
    argument = call.args[place] if place < len(call.args) else None
    found = argument.value if isinstance(argument, ast.Constant) else None
    return found if isinstance(found, str) else None


def _constant(node: ast.expr) -> str:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def _is_word(node: ast.AST) -> TypeGuard[ast.Assign]:
    return isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)


def _if_words(form: str) -> Iterator[str]:
    words = any(c.isalpha() for c in re.sub(r"\{\d+\}", "", form))
    if words and " " in form.strip() and not _IN_FILES.match(form):
        yield form


def _form(sentence: ast.JoinedStr) -> str:
    pieces, holes = "", 0
    for part in sentence.values:
        if isinstance(part, ast.Constant):
            pieces += _escaped(str(part.value))
        else:
            pieces += f"{{{holes}}}"
            holes += 1
    return pieces


def _escaped(text: str) -> str:
    return text.replace("{", "{{").replace("}", "}}")


def _entry(text: _Key) -> polib.POEntry:
    context, one, many = text
    plural = {0: "", 1: ""} if many else {}
    return polib.POEntry(
        msgctxt=context or None, msgid=one, msgid_plural=many, msgstr_plural=plural
    )


if __name__ == "__main__":
    sys.exit(main())
