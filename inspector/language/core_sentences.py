"""Translate the sentences of twistcore.

These sentences are in English, because they are also written to terminals and files. The catalogue
contains their templates with the context 'core'. For example, the template '{0} has {1} frames.'
matches the sentence for any values of `{0}` and `{1}`; these values are then inserted into the
translation.
"""

from __future__ import annotations

import re
from functools import lru_cache

from inspector.language.catalogue import SOURCE, chosen_language, core_translations
from twistcore.files.encoding import escape_control_characters

# Error messages of the system about reading and writing.
OF_SYSTEM = (
    "File exists",
    "File name too long",
    "Input/output error",
    "Is a directory",
    "No space left on device",
    "No such file or directory",
    "Not a directory",
    "Permission denied",
    "Read-only file system",
    "Too many levels of symbolic links",
)
# Names of chains, limbs and joints.
LABELS = (
    *(
        f"{side} {segment}"
        for side in ("Left", "Right")
        for segment in ("Shoulder", "Arm", "ForeArm", "UpLeg", "Leg", "arm", "leg")
    ),
    *(f"{side} {end}" for side in ("Left", "Right") for end in ("Hand", "Foot", "Toe")),
    *(f"{side} {middle}" for side in ("Left", "Right") for middle in ("elbow", "knee")),
    *(f"{side} {middle}" for side in ("left", "right") for middle in ("elbow", "knee")),
    *(f"{side} {bone}" for side in ("left", "right") for bone in ("arm", "leg", "forearm", "shin")),
    *("elbow", "knee", "hand", "foot", "shoulder", "wrist", "ankle", "joint"),
)
_HOLE = re.compile(r"\{(\d+)\}")
# Separators between sentences and between parts of sentences, larger parts first.
_JOINTS = (". ", "; ", ": ", " (", ", ", " · ")


def translate_core_sentence(said: object) -> str:
    """Translate a sentence of twistcore. Text that matches no template is returned unchanged.

    `said` is a string or an exception. If no template matches the whole sentence, its parts are
    translated one by one. Control characters are escaped.
    """
    language, sentence = chosen_language(), escape_control_characters(said, lines=True)
    return sentence if language == SOURCE else _translated(language, sentence)[0]


@lru_cache(8192)
def _translated(language: str, sentence: str) -> tuple[str, int]:
    """Return the best translation of a sentence, and the number of characters that templates cover.

    The best translation is the one whose templates cover the most characters of the sentence.
    """
    best = sentence, 0
    if not any(letter.isalpha() for letter in sentence):
        return best
    for piece, pattern, letters, translation in _forms(language):
        if piece in sentence and (match := pattern.fullmatch(sentence)):
            # An inserted value may itself be a word from twistcore, such as a kind of error.
            found = {name: _translated(language, w) for name, w in match.groupdict().items()}
            known = letters + sum(n for _, n in found.values())
            if known > best[1]:
                best = translation.format(*(found[f"_{k}"][0] for k in range(len(found)))), known
    for joint in _JOINTS:
        if not best[1] and joint in sentence:
            first, rest = _parted(sentence, joint)
            parts = [_translated(language, part) for part in (first, rest[0])]
            known = sum(n for _, n in parts)
            if known:
                stop = joint.removeprefix(".")
                best = f"{parts[0][0]}{stop}{parts[1][0]}{rest[1]}", known
    return best


def _parted(sentence: str, joint: str) -> tuple[str, tuple[str, str]]:
    """Split a sentence at the separator `joint` into the first part and the rest.

    If the separator is an opening bracket, the closing bracket is returned separately: (first,
    (rest, bracket)). The bracket is '' if there is none.
    """
    first, _, rest = sentence.partition(joint)
    bracket = joint == " (" and rest.endswith(")")
    return first + "." * joint.startswith("."), (rest[:-1], ")") if bracket else (rest, "")


@lru_cache(1)
def _forms(_language: str) -> tuple[tuple[str, re.Pattern[str], int, str], ...]:
    """Return each template as (longest fixed part, pattern, number of characters, translation)."""
    entries = sorted(core_translations(), key=lambda e: (-_letters(e[0]), e[0]))
    return tuple(
        (_piece(form), re.compile(_pattern(form), re.DOTALL), _letters(form), text)
        for form, text in entries
    )


def _piece(form: str) -> str:
    """Return the longest fixed part of a template, which is tested before the slower pattern."""
    return max(_HOLE.split(form)[::2], key=len).format()


def _letters(form: str) -> int:
    return len(_HOLE.sub("", form))


def _pattern(form: str) -> str:
    pieces = _HOLE.split(form)  # text, number, text, …
    texts, numbers = pieces[::2], pieces[1::2]
    holes = [f"(?P<_{number}>.*?)" for number in numbers]
    return "".join(
        re.escape(t.format()) + h for t, h in zip(texts, [*holes, ""], strict=True)
    )  # in templates, literal braces are doubled
