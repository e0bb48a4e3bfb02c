"""What twistcore says, in the chosen language.

twistcore knows of no languages: what it says goes to terminals and into files as well, in English.
Its sentences are found again by their forms, which the catalogue holds with the context 'core':
'{0} has {1} frames.' is that sentence for every `{0}` and `{1}`, which are kept.
"""

from __future__ import annotations

import re
from functools import lru_cache

from inspector.language.catalogue import SOURCE, chosen_language, entries_of_core
from twistcore.files.encoding import legible

# Why the system could not read or write, which it says in English.
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
# What chains and limbs are called, and their joints.
LABELS = (
    *(
        f"{side} {segment}"
        for side in ("Left", "Right")
        for segment in ("Shoulder", "Arm", "ForeArm", "UpLeg", "Leg", "arm", "leg")
    ),
    *(f"{side} {end}" for side in ("Left", "Right") for end in ("Hand", "Foot", "Toe")),
    *(f"{side} {bone}" for side in ("left", "right") for bone in ("arm", "leg", "forearm", "shin")),
    *("elbow", "knee", "hand", "foot", "shoulder", "wrist", "ankle", "joint"),
)
_HOLE = re.compile(r"\{(\d+)\}")
# What joins sentences, and the parts of one: those that reach over more of it come first.
_JOINTS = (". ", "; ", ": ", " (", ", ", " · ")


def of_core(said: object) -> str:
    """A sentence of twistcore in the chosen language; as it is where its form is not known.

    said: words, or an error that has them. What is joined of several is translated part by part.
    Nothing in it is obeyed by what sets it: all is seen.
    """
    language, sentence = chosen_language(), legible(said, lines=True)
    return sentence if language == SOURCE else _translated(language, sentence)[0]


@lru_cache(8192)
def _translated(language: str, sentence: str) -> tuple[str, int]:
    """The reading of which most letters are known from forms, and how many these are."""
    best = sentence, 0
    if not any(letter.isalpha() for letter in sentence):
        return best
    for piece, pattern, letters, translation in _forms(language):
        if piece in sentence and (match := pattern.fullmatch(sentence)):
            # What is put in may be a word of twistcore's itself, such as a kind of error.
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
    """The part before a joint, with its full stop, and that behind it, without its bracket."""
    first, _, rest = sentence.partition(joint)
    bracket = joint == " (" and rest.endswith(")")
    return first + "." * joint.startswith("."), (rest[:-1], ")") if bracket else (rest, "")


@lru_cache(1)
def _forms(_language: str) -> tuple[tuple[str, re.Pattern[str], int, str], ...]:
    """Of each form its longest piece, pattern, letters, and its translation; the longest first."""
    entries = sorted(entries_of_core(), key=lambda e: (-_letters(e[0]), e[0]))
    return tuple(
        (_piece(form), re.compile(_pattern(form), re.DOTALL), _letters(form), text)
        for form, text in entries
    )


def _piece(form: str) -> str:
    """To look for it is quicker than to try the pattern."""
    return max(_HOLE.split(form)[::2], key=len).format()


def _letters(form: str) -> int:
    return len(_HOLE.sub("", form))


def _pattern(form: str) -> str:
    pieces = _HOLE.split(form)  # text, number, text, …
    texts, numbers = pieces[::2], pieces[1::2]
    holes = [f"(?P<_{number}>.*?)" for number in numbers]
    return "".join(
        re.escape(t.format()) + h for t, h in zip(texts, [*holes, ""], strict=True)
    )  # a brace of its own is doubled in a form
