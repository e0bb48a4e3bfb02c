"""The words in joints' names and what they mean: `joint_names.toml`, and a person's own file."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from twistcore.document_values import bytes_of, flag, has, items, parsed_toml, saying, text, texts
from twistcore.errors import FormatError

ROLES = ("shoulder", "arm", "forearm", "hand", "upleg", "leg", "foot", "toe")

_DEFAULT = Path(__file__).with_name("joint_names.toml")
_KANA_MARKS = "\u3099\u309a"  # か with one is が, another letter
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
    """What a name says.

    side: 'Left', 'Right' or ''; stem: the rest in lower-case letters, without accents; number: its
    digits; roles: which of ROLES the word can mean, the likeliest first, () for none; helper: the
    joint only shares out the twist of the bone that it lies in; other: it is a part of the head or
    hand, or something carried, and never part of an arm or leg; trunk: it is the pelvis, spine or
    neck; word: the word that said so.
    """

    side: str
    stem: str
    number: str
    roles: tuple[str, ...] = ()
    helper: bool = False
    other: bool = False
    trunk: bool = False
    word: str = ""

    @property
    def no_limb(self) -> bool:
        """Whether it names a part of the head or hand, or something carried."""
        return self.other


@dataclass(frozen=True)
class Meaning:
    """What a word says; see `joint_names.toml`."""

    side: str = ""
    roles: tuple[str, ...] = ()
    marks: frozenset[str] = frozenset()  # 'sided', 'other', …

    def joined(self, other: Meaning) -> Meaning:
        """Both, of a word that is in two lists."""
        roles = tuple(dict.fromkeys(self.roles + other.roles))
        return Meaning(self.side or other.side, roles, self.marks | other.marks)


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """Words, folded as :func:`folded` does, and what they mean.

    pairs: words for left and right that mean it only on mirrored names; languages: vocabularies
    whose words count only for a skeleton that is named in them as a whole; joints: what a person
    says of single joints, by their whole names.
    """

    words: Mapping[str, Meaning]
    pairs: tuple[tuple[str, str], ...] = ()
    languages: tuple[Vocabulary, ...] = ()
    joints: Mapping[str, JointName] = field(default_factory=dict)

    def over(self, other: Vocabulary) -> Vocabulary:
        """This one's words, where it has none those of the other."""
        return Vocabulary(
            {**other.words, **self.words},
            tuple(dict.fromkeys(self.pairs + other.pairs)),
            tuple(language for language in other.languages if language is not self),
            {**other.joints, **self.joints},
        )

    @cached_property
    def with_languages(self) -> tuple[Vocabulary, ...]:
        """This one with each of its languages."""
        return tuple(language.over(self) for language in self.languages)

    @cached_property
    def longest(self) -> int:
        """Letters of the longest word."""
        return max(map(len, self.words), default=0)


@cache
def default_vocabulary() -> Vocabulary:
    """The words that come with the program."""
    return _vocabulary(parsed_toml(_DEFAULT.read_bytes()))


def read_vocabulary(path: Path) -> Vocabulary:
    """A person's own file over the default; raises TwistError, FormatError for a damaged file."""
    with saying(path):
        own = _vocabulary(parsed_toml(bytes_of(path)))
        return own.over(default_vocabulary())


def folded(word: str) -> str:
    """Lower-case letters without accents, of full and half width alike."""
    plain = unicodedata.normalize("NFD", unicodedata.normalize("NFKC", word).casefold())
    kept = (c for c in plain if not unicodedata.combining(c) or c in _KANA_MARKS)
    return unicodedata.normalize("NFC", "".join(kept)).translate(_PLAIN)


def _vocabulary(document: Mapping[str, Any]) -> Vocabulary:
    """What a document says; FormatError where it is damaged."""
    words: dict[str, Meaning] = {}
    pairs: list[tuple[str, str]] = []
    languages: list[Vocabulary] = []
    joints: dict[str, JointName] = {}
    for name, table in document.items():
        with saying(name):
            if name == "joints":
                joints |= _own_joints(table)
                continue
            found, its_pairs = _table(has(table, what="a table"))
            if flag(table.get("whole", False), "whole"):
                languages.append(Vocabulary(found, its_pairs))
            else:
                pairs += its_pairs
                for word, meaning in found.items():
                    words[word] = meaning.joined(words[word]) if word in words else meaning
    return Vocabulary(words, tuple(pairs), tuple(languages), joints)


def _table(table: Mapping[str, Any]) -> tuple[dict[str, Meaning], tuple[tuple[str, str], ...]]:
    if unknown := sorted(table.keys() - set(_KEYS)):
        raise FormatError(f"expected {', '.join(_KEYS)}; found {unknown[0]!r}")
    words: dict[str, Meaning] = {}

    def add(word: str, meaning: Meaning) -> None:
        key = _phrase(word)
        words[key] = words[key].joined(meaning) if key in words else meaning

    for key in _SIDES:
        for word in texts(table.get(key, []), key):
            add(word, Meaning(side=_SIDES[key]))
    for word, roles in has(table.get("either", {}), what="either").items():
        add(word, Meaning(roles=_roles(roles, word)))
    for key in ROLES:
        for word in texts(table.get(key, []), key):
            add(word, Meaning(roles=(key,)))
    for key in _MARKS:
        for word in texts(table.get(key, []), key):
            add(word, Meaning(marks=frozenset({key, "noise"} if key == "prefixes" else {key})))
    pairs = []
    for pair in items(table.get("pairs", []), "pairs"):
        two = texts(pair, "pairs")
        if len(two) != 2:
            raise FormatError("expected pairs of two words, left and right")
        pairs.append((folded(two[0]), folded(two[1])))
    return words, tuple(pairs)


def _roles(value: Any, word: str) -> tuple[str, ...]:
    roles = texts(value, word)
    if unknown := [role for role in roles if role not in ROLES]:
        raise FormatError(f"expected {', '.join(ROLES)} for {word}, found {unknown[0]!r}")
    return roles


def _phrase(words: str) -> str:
    """A phrase as it is looked up: written together."""
    return "".join(folded(c) for c in words if c.isalnum() or unicodedata.category(c)[0] == "M")


def _own_joints(table: Any) -> dict[str, JointName]:
    """What a person says of single joints, by name."""
    return {
        name: joint_as_said(name, text(said, name))
        for name, said in has(table, what="joints").items()
    }


def joint_as_said(name: str, said: str) -> JointName:
    """What a person says of one joint: 'left hand', 'helper', 'other' or 'unknown'.

    Raises FormatError for other words.
    """
    words = said.casefold().split()
    side = _SIDES[words.pop(0)] if words and words[0] in _SIDES else ""
    what = " ".join(words)
    if what not in (*ROLES, "helper", "other", "unknown") or (what in ROLES) != bool(side):
        raise FormatError(
            f"expected left or right and {', '.join(ROLES)}, or helper, other, unknown for "
            f"{name}, found {said!r}"
        )
    joint = JointName(side, folded(name), "", (what,) if what in ROLES else (), word=name)
    return replace(joint, helper=what == "helper", other=what == "other")
