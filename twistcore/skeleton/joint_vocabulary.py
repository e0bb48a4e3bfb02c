"""Words in joint names and their meanings, from `joint_names.toml` and the user's file."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable, Mapping
from dataclasses import field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TypeVar

from twistcore.errors import FormatError
from twistcore.files.document_values import (
    check_bool,
    check_keys,
    check_list,
    check_string,
    check_string_list,
    parsed_toml,
    prefix_format_errors,
    read_bytes_limited,
)
from twistcore.work.frozen import dataclass

ROLES = ("shoulder", "arm", "forearm", "hand", "upleg", "leg", "foot", "toe")

_Value = TypeVar("_Value")
DEFAULT_WORDS = Path(__file__).with_name("joint_names.toml")
_KANA_MARKS = "\u3099\u309a"  # a mark changes か into が, a different letter
_PLAIN = str.maketrans({"ł": "l", "ø": "o", "đ": "d", "ı": "i", "æ": "ae", "œ": "oe"})
_MARKS = (
    "sided",
    "second",
    "third",
    "trunk",
    "other",
    "helper",
    "layer",
    "tip",
    "noise",
    "prefixes",
)
_SIDES = {"left": "Left", "right": "Right"}
_KEYS = (*_SIDES, *ROLES, *_MARKS, "pairs", "either", "whole")


@dataclass(frozen=True)
class JointName:
    """The meaning of a joint's name.

    Attributes
    ----------
    side
        'Left', 'Right', or '' if unknown.
    stem
        The name without side and number, in lower-case letters, without accents.
    number
        The digits of the name.
    roles
        The ROLES that the name can mean, most likely first.
    helper
        True if the joint only distributes the twist of its bone.
    other
        True for a part of the head, a hand or a prop, which does not belong to an arm or a leg.
    trunk
        True for the pelvis, the spine and the neck.
    word
        The word in the name that has this meaning.
    """

    side: str
    stem: str
    number: str
    roles: tuple[str, ...] = ()
    helper: bool = False
    other: bool = False
    trunk: bool = False
    word: str = ""


@dataclass(frozen=True)
class Meaning:
    """The meaning of a word.

    Attributes
    ----------
    side
        'Left', 'Right', or '' if the word does not mean a side.
    roles
        The ROLES that the word can mean, most likely first.
    marks
        Further properties, such as 'sided' or 'other'. `joint_names.toml` explains them.
    """

    side: str = ""
    roles: tuple[str, ...] = ()
    marks: frozenset[str] = frozenset()

    def joined(self, other: Meaning) -> Meaning:
        """Return the union of two meanings of the same word."""
        roles = tuple(dict.fromkeys(self.roles + other.roles))
        return Meaning(self.side or other.side, roles, self.marks | other.marks)


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """Words with their meanings.

    The keys of `words` are in the form that ``folded`` returns.

    Attributes
    ----------
    pairs
        Pairs of words for left and right. They mean a side only if the skeleton has both of two
        mirrored names.
    languages
        Vocabularies whose words are used only if the whole skeleton is named in that language.
    joints
        The user's meanings of single joints, keyed by joint name.
    """

    words: Mapping[str, Meaning]
    pairs: tuple[tuple[str, str], ...] = ()
    languages: tuple[Vocabulary, ...] = ()
    joints: Mapping[str, JointName] = field(default_factory=dict)

    def over(self, other: Vocabulary) -> Vocabulary:
        """Return this vocabulary extended by the words of `other`.

        If a word is in both vocabularies, its meaning in this one is used.
        """
        return Vocabulary(
            {**other.words, **self.words},
            tuple(dict.fromkeys(self.pairs + other.pairs)),
            tuple(language for language in other.languages if language is not self),
            {**other.joints, **self.joints},
        )

    @cached_property
    def with_languages(self) -> tuple[Vocabulary, ...]:
        """Return, for each language, this vocabulary extended by the language's words."""
        return tuple(language.over(self) for language in self.languages)

    @cached_property
    def longest(self) -> int:
        """Return the length of the longest word, in characters."""
        return max(map(len, self.words), default=0)


@cache
def default_vocabulary() -> Vocabulary:
    """Return the vocabulary of `joint_names.toml`, loaded quickly from `known_words.py`."""
    from twistcore.skeleton.known_words import VOCABULARIES

    common, *languages = (Vocabulary(_meanings(groups), pairs) for groups, pairs in VOCABULARIES)
    return replace(common, languages=tuple(languages))


def _meanings(groups: Iterable[tuple[str, str, str, str]]) -> dict[str, Meaning]:
    found: dict[str, Meaning] = {}
    for side, roles, marks, words in groups:
        meaning = Meaning(side, tuple(roles.split()), frozenset(marks.split()))
        found |= dict.fromkeys(words.split(), meaning)
    return found


def parse_builtin_joint_names_file() -> Vocabulary:
    """Parse `joint_names.toml` and return its vocabulary.

    :func:`default_vocabulary` returns the same vocabulary faster.
    """
    return _vocabulary(parsed_toml(DEFAULT_WORDS.read_bytes()))


def read_joint_vocabulary_file(path: Path) -> dict[str, Any]:
    """Read and check the user's word file. Return the parsed TOML document.

    Raises TwistError if the file cannot be read, and FormatError if it is invalid.
    """
    data = read_bytes_limited(path)
    with prefix_format_errors(path):
        document = parsed_toml(data)
        try:
            _vocabulary(document)
        except _WordsError as error:
            raise FormatError(f"{_place(data, error.at)}{error}") from None
    return document


def vocabulary_with_user_words(words: Mapping[str, Any]) -> Vocabulary:
    """Return the default vocabulary, extended by the words of a parsed word file.

    Raises FormatError if a word or a meaning is invalid.
    """
    return _vocabulary(words).over(default_vocabulary())


class _WordsError(FormatError):
    """An error in a word file.

    `at` contains words in or above the faulty line, which are used to find the line number.
    """

    def __init__(self, message: str, *at: str) -> None:
        super().__init__(message)
        self.at = at


def _place(data: bytes, at: tuple[str, ...]) -> str:
    """Return the line number of an error in a word file, as 'line 7: ', or '' if it is not found.

    The words of `at` are searched for in order. The last one is in the faulty line.
    """
    found = 0
    lines = data.decode("utf-8", "replace").splitlines()
    for word in at:
        later = (k for k in range(found, len(lines)) if word in lines[k].partition("#")[0])
        found = next(later, -1)
        if found < 0:
            return ""
    return f"line {found + 1}: "


def fold_case_and_accents(word: str) -> str:
    """Convert a word to lower case and half-width characters, and remove accents."""
    if word.isascii():
        return word.lower()
    plain = unicodedata.normalize("NFD", unicodedata.normalize("NFKC", word).casefold())
    kept = (c for c in plain if not unicodedata.combining(c) or c in _KANA_MARKS)
    return unicodedata.normalize("NFC", "".join(kept)).translate(_PLAIN)


def _vocabulary(document: Mapping[str, Any]) -> Vocabulary:
    """Return the vocabulary in a parsed document. Raises FormatError if it is invalid."""
    words: dict[str, Meaning] = {}
    pairs: list[tuple[str, str]] = []
    languages: list[Vocabulary] = []
    joints: dict[str, JointName] = {}
    for name, table in document.items():
        if not isinstance(table, Mapping):
            raise _WordsError(f"expected {name} in a table such as [english]", name)
        if name == "joints":
            joints |= _own_joints(table)
            continue
        found, its_pairs = _table(name, table)
        if _checked(check_bool, table.get("whole", False), name, "whole"):
            languages.append(Vocabulary(found, its_pairs))
        else:
            pairs += its_pairs
            for word, meaning in found.items():
                words[word] = meaning.joined(words[word]) if word in words else meaning
    return Vocabulary(words, tuple(pairs), tuple(languages), joints)


def _table(
    name: str, table: Mapping[str, Any]
) -> tuple[dict[str, Meaning], tuple[tuple[str, str], ...]]:
    if unknown := sorted(table.keys() - set(_KEYS)):
        expected = f"expected one of {', '.join(_KEYS)}, found {unknown[0]!r}"
        raise _WordsError(expected, name, unknown[0])
    words: dict[str, Meaning] = {}

    def add(word: str, meaning: Meaning, at: str) -> None:
        key = _phrase(word)
        if not meaning.side:
            key = _without_side(key)
        if not key:
            raise _WordsError(f"expected a word with letters for {at}, found {word!r}", name, at)
        words[key] = words[key].joined(meaning) if key in words else meaning

    for key in _SIDES:
        for word in _checked(check_string_list, table.get(key, []), name, key):
            add(word, Meaning(side=_SIDES[key]), key)
    for word, roles in _checked(_mapping, table.get("either", {}), name, "either").items():
        add(word, Meaning(roles=_checked(_roles, roles, name, word)), word)
    for key in ROLES:
        for word in _checked(check_string_list, table.get(key, []), name, key):
            add(word, Meaning(roles=(key,)), key)
    for key in _MARKS:
        marks = frozenset({key, "noise"} if key == "prefixes" else {key})
        for word in _checked(check_string_list, table.get(key, []), name, key):
            add(word, Meaning(marks=marks), key)
    return words, _checked(_pairs, table.get("pairs", []), name, "pairs")


def _checked(check: Callable[[Any, str], _Value], value: Any, table: str, key: str) -> _Value:
    """Check and convert a value of a table.

    `check` converts the value or raises FormatError. In that case, _WordsError is raised with the
    table and the key.
    """
    try:
        return check(value, key)
    except FormatError as error:
        raise _WordsError(str(error), table, key) from None


def _mapping(value: Any, what: str) -> Mapping[str, Any]:
    return check_keys(value, what=what)


def _roles(value: Any, word: str) -> tuple[str, ...]:
    roles = check_string_list(value, word)
    if unknown := [role for role in roles if role not in ROLES]:
        raise FormatError(f"expected one of {', '.join(ROLES)} for {word}, found {unknown[0]!r}")
    return roles


def _pairs(value: Any, what: str) -> tuple[tuple[str, str], ...]:
    pairs = [check_string_list(pair, what) for pair in check_list(value, what)]
    if any(len(pair) != 2 for pair in pairs):
        raise FormatError("expected pairs of words, the first for left and the second for right")
    return tuple(
        (fold_case_and_accents(left), fold_case_and_accents(right)) for left, right in pairs
    )


def _phrase(words: str) -> str:
    """Convert a phrase to a single word, in the form of the vocabulary's keys."""
    if words.isascii():
        return "".join(filter(str.isalnum, words)).lower()
    return "".join(
        fold_case_and_accents(c) for c in words if c.isalnum() or unicodedata.category(c)[0] == "M"
    )


def _without_side(phrase: str) -> str:
    """Remove 'left' or 'right' from both ends of a phrase, because users may enter a full name."""
    for side in _SIDES:
        rest = phrase.removeprefix(side).removesuffix(side)
        if rest:
            phrase = rest
    return phrase


def _own_joints(table: Mapping[str, Any]) -> dict[str, JointName]:
    """Return the user's meanings of single joints, keyed by joint name."""
    return {name: _checked(_as_said, said, "joints", name) for name, said in table.items()}


def _as_said(said: Any, name: str) -> JointName:
    return parse_joint_meaning(name, check_string(said, name))


def parse_joint_meaning(name: str, said: str) -> JointName:
    """Parse the meaning that the user gave a joint, such as 'left hand', 'helper' or 'unknown'.

    `name` is the joint's name, and `said` is the user's text. Raises FormatError if the text has no
    known meaning.
    """
    words = said.casefold().split()
    side = _SIDES[words.pop(0)] if words and words[0] in _SIDES else ""
    what = " ".join(words)
    if what not in (*ROLES, "helper", "other", "unknown") or (what in ROLES) != bool(side):
        raise FormatError(
            f"expected 'left' or 'right' with one of {', '.join(ROLES)}, or 'helper', "
            f"'other' or 'unknown' for {name}, found {said!r}"
        )
    joint = JointName(
        side, fold_case_and_accents(name), "", (what,) if what in ROLES else (), word=name
    )
    return replace(joint, helper=what == "helper", other=what == "other")
