"""What twistcore says, in the chosen language.

twistcore knows of no languages: what it says goes to terminals and into files as well, in English.
Its sentences are found again by their forms, which the catalogue holds with the context 'core':
'{0} has {1} frames.' is that sentence for every `{0}` and `{1}`, which are kept.
"""

from __future__ import annotations

import re
from functools import lru_cache

from inspector.language.catalogue import SOURCE, chosen_language, entries_of_core

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
)
# What chains and limbs are called, and their joints.
LABELS = (
    *(
        f"{side} {segment}"
        for side in ("Left", "Right")
        for segment in ("Shoulder", "Arm", "ForeArm", "UpLeg", "Leg", "arm", "leg")
    ),
    *("elbow", "knee", "hand", "foot"),
)
_HOLE = re.compile(r"\{(\d+)\}")
# What joins sentences, and the parts of one: those that reach over more of it come first.
_JOINTS = (". ", "; ", ": ", " (", ", ")


def of_core(said: object) -> str:
    """A sentence of twistcore in the chosen language; as it is where its form is not known.

    said: words, or an error that has them. What is joined of several is translated part by part.
    """
    language, sentence = chosen_language(), str(said)
    return sentence if language == SOURCE else _translated(language, sentence)


@lru_cache(4096)
def _translated(language: str, sentence: str) -> str:
    for pattern, translation in _forms(language):
        if match := pattern.fullmatch(sentence):
            # What is put in may be a word of twistcore's itself, such as a kind of error.
            found = {name: of_core(words) for name, words in match.groupdict().items()}
            return translation.format(*(found[f"_{k}"] for k in range(len(found))))
    for joint in _JOINTS:
        if joint in sentence:
            first, _, rest = sentence.partition(joint)
            return _ended(first, joint) + _begun(joint, rest)
    return sentence


def _ended(first: str, joint: str) -> str:
    """The part before a joint; a full stop belongs to the form."""
    if not joint.startswith("."):
        return of_core(first) + joint
    return of_core(f"{first}.") + joint[1:]


def _begun(joint: str, rest: str) -> str:
    """The part behind a joint; a bracket closes behind the form."""
    if joint != " (" or not rest.endswith(")"):
        return of_core(rest)
    return of_core(rest[:-1]) + ")"


@lru_cache(1)
def _forms(_language: str) -> tuple[tuple[re.Pattern[str], str], ...]:
    """Of each form its pattern and translation: those that leave least open first."""
    entries = sorted(entries_of_core(), key=lambda e: (-len(_HOLE.sub("", e[0])), e[0]))
    return tuple((re.compile(_pattern(form), re.DOTALL), text) for form, text in entries)


def _pattern(form: str) -> str:
    pieces = _HOLE.split(form)  # text, number, text, …
    texts, numbers = pieces[::2], pieces[1::2]
    holes = [f"(?P<_{number}>.*?)" for number in numbers]
    return "".join(
        re.escape(t.format()) + h for t, h in zip(texts, [*holes, ""], strict=True)
    )  # a brace of its own is doubled in a form
