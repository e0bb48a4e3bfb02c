"""Interpret joint names: which side and which part of the body they mean.

The words and their meanings are defined in `joint_vocabulary.py`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

from twistcore.skeleton.joint_vocabulary import (
    ROLES,
    JointName,
    Meaning,
    Vocabulary,
    default_vocabulary,
    fold_case_and_accents,
    parse_joint_meaning,
    read_joint_vocabulary_file,
    vocabulary_with_user_words,
)
from twistcore.skeleton.joint_words import joint_names_in_possible_encodings, split_joint_name
from twistcore.work.frozen import dataclass

__all__ = [
    "FEET",
    "HANDS",
    "ROLES",
    "TOES",
    "JointName",
    "Vocabulary",
    "changed_joint_name_meanings",
    "default_vocabulary",
    "interpret_names",
    "parse_joint_meaning",
    "read_joint_vocabulary_file",
    "vocabulary_with_user_words",
]

HANDS = ("wrist", "hand")
FEET = ("ankle", "foot")
TOES = ("toe", "ball", "foot")

# If at least this share of the joint names begins or ends with an unknown word, the word is the
# rig's name.
_SHARED = 0.6
_FEWEST = 3  # minimum number of bones that a language must add to those already recognised
_ENOUGH = 6  # no other language is tried if this many bones are recognised
_SHORTEST = 3  # minimum number of letters of a part of a compound word
_SHORTEST_SIDE = 4
_LONGEST = 60  # maximum number of letters of a word that is split
_LAST = 3  # rank of a name that is used only if no other name has its role


def interpret_names(names: Sequence[str], vocabulary: Vocabulary | None = None) -> list[JointName]:
    """Return the meaning of each joint name of a skeleton.

    If no vocabulary is given, the built-in one is used.
    """
    return list(_interpret_names(tuple(names), vocabulary or default_vocabulary()))


def changed_joint_name_meanings(names: Sequence[str], vocabulary: Vocabulary) -> dict[str, str]:
    """Return the joints that the user's vocabulary interprets differently from the built-in one.

    The result maps each joint name to a word for :func:`parse_joint_meaning`, such as 'left hand'.
    """
    before, after = interpret_names(names), interpret_names(names, vocabulary)
    return {
        name: _said(new)
        for name, old, new in zip(names, before, after, strict=True)
        if (old.side, old.roles, old.helper, old.other)
        != (new.side, new.roles, new.helper, new.other)
    }


def _said(joint: JointName) -> str:
    if joint.helper or joint.other:
        return "helper" if joint.helper else "other"
    return f"{joint.side} {joint.roles[0]}".lower() if joint.side and joint.roles else "unknown"


@lru_cache(maxsize=16)
def _interpret_names(names: tuple[str, ...], vocabulary: Vocabulary) -> tuple[JointName, ...]:
    readings = [
        _in_languages([*map(split_joint_name, text)], vocabulary)
        for text in joint_names_in_possible_encodings(names)
    ]
    found = max(readings, key=_known)  # the first one wins a tie
    own = vocabulary.joints
    return tuple(own.get(name, joint) for name, joint in zip(names, found, strict=True))


def _in_languages(words: list[list[str]], vocabulary: Vocabulary) -> list[JointName]:
    """Interpret names in the language in which most bones are recognised.

    `words` lists the words of each joint's name.
    """
    found = _read(words, vocabulary)
    if _limb_words(found) >= _ENOUGH:
        return found
    text = "\n".join(
        {fold_case_and_accents(word) for joint in words for word in joint if not word.isdigit()}
    )
    for language, both in zip(vocabulary.languages, vocabulary.with_languages, strict=True):
        if sum(word in text for word in language.words) < _FEWEST:
            continue
        other = _read(words, both)
        if _limb_words(other) >= _limb_words(found) + _FEWEST:
            found = other
    return found


def _known(joints: Iterable[JointName]) -> int:
    """Return the number of joints with a known name."""
    return sum(bool(joint.roles or joint.other or joint.trunk) for joint in joints)


def _limb_words(joints: Iterable[JointName]) -> int:
    """Return the number of distinct words for limb bones in joint names."""
    return len({joint.word for joint in joints if joint.roles and not joint.helper})


# -- meanings --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Piece:
    word: str
    meaning: Meaning | None  # None if the word is unknown
    upper: bool = False

    def __bool__(self) -> bool:
        return self.meaning is not None

    def has(self, mark: str) -> bool:
        return self.meaning is not None and mark in self.meaning.marks

    @property
    def side(self) -> str:
        return self.meaning.side if self.meaning is not None else ""

    @property
    def roles(self) -> tuple[str, ...]:
        return self.meaning.roles if self.meaning is not None else ()


def _read(words: list[list[str]], vocabulary: Vocabulary) -> list[JointName]:
    """Return the meaning of each joint name, given as a list of words.

    Names are first interpreted one by one and then compared with each other.
    """
    numbers = [_number(w, vocabulary) for w in words]
    letters = [[w for w in joint if not w.isdigit()] for joint in words]
    pieces = [_pieces(joint, vocabulary) for joint in letters]
    pieces = _without_shared(pieces, 0)
    pieces = _without_shared(pieces, -1)
    sides = _mirrored(pieces, numbers, vocabulary)
    joints = [
        _joint_name(p, number, side) for p, number, side in zip(pieces, numbers, sides, strict=True)
    ]
    return _best(joints, pieces)


def _number(words: list[str], vocabulary: Vocabulary) -> str:
    """Return the digits of a name, except those in a prefix of the whole rig, such as Bip01."""
    out = ""
    for k, word in enumerate(words):
        if word.isdigit():
            before = fold_case_and_accents(words[k - 1]) if k else ""
            two = fold_case_and_accents(words[k - 2]) + before if k > 1 else ""
            known = (vocabulary.words.get(w) for w in (before, two) if w)
            if not any(m is not None and "prefixes" in m.marks for m in known):
                out += word
    return out


def _pieces(words: list[str], vocabulary: Vocabulary) -> list[_Piece]:
    """Split a joint name into words, each with its meaning.

    Phrases of several words are joined, and compounds are split.
    """
    split: list[_Piece] = []
    for word in words:
        split += _split_side(fold_case_and_accents(word), word.isupper(), vocabulary)
    rest = [p for p in split if not p.side]
    out = [p for p in split if p.side]
    k = 0
    while k < len(rest):
        for stop in range(len(rest), k, -1):
            phrase = "".join(p.word for p in rest[k:stop])
            meaning = vocabulary.words.get(phrase)
            if meaning is not None and not meaning.side:
                piece = _Piece(phrase, meaning)
                apart = _split_compound(phrase, vocabulary) if piece.has("sided") else []
                # Split larm, but not L_larm.
                if any(p.side for p in out) or not any(p.side for p in apart):
                    apart = [piece]
                out += apart
                k = stop
                break
        else:
            out += _split_compound(rest[k].word, vocabulary) or [rest[k]]
            k += 1
    return out


def _split_side(word: str, upper: bool, vocabulary: Vocabulary) -> list[_Piece]:
    """Split a word for a side, such as 'left', off the beginning or end of `word`."""
    meaning = vocabulary.words.get(word)
    if meaning is not None:
        return [_Piece(word, meaning, upper)] if meaning.side else [_Piece(word, None, upper)]
    for length in range(min(len(word) - 1, vocabulary.longest), 0, -1):
        for side, rest in ((word[:length], word[length:]), (word[-length:], word[:-length])):
            known = vocabulary.words.get(side)
            if known is not None and known.side and _may_join(side, _SHORTEST_SIDE):
                return [_Piece(side, known), _Piece(rest, None)]
    return [_Piece(word, None, upper)]


def _may_join(word: str, shortest: int) -> bool:
    """Return True if a word may be part of a compound.

    It must have at least `shortest` letters, unless its script has no upper and lower case.
    """
    return len(word) >= shortest or not _has_case(word)


def _has_case(word: str) -> bool:
    return word.upper() != word


def _split_compound(word: str, vocabulary: Vocabulary) -> list[_Piece]:
    """Split a word into as few known words as possible, or return [] if there is no such split."""
    if len(word) > _LONGEST:
        return []
    best: list[list[_Piece] | None] = [None] * (len(word) + 1)
    best[0] = []
    for stop in range(1, len(word) + 1):
        for start in range(max(0, stop - vocabulary.longest), stop):
            before, part = best[start], word[start:stop]
            meaning = vocabulary.words.get(part)
            if before is None or meaning is None or (start, stop) == (0, len(word)):
                continue
            if meaning.side:
                at_end = start == 0 or stop == len(word)
                if any(p.side for p in before) or not (at_end or len(part) >= _SHORTEST_SIDE):
                    continue
                if len(part) > 1 and not _may_join(part, _SHORTEST_SIDE):
                    continue
            elif not _may_join(part, _SHORTEST):
                continue
            so_far = best[stop]
            if so_far is None or len(before) + 1 < len(so_far):
                best[stop] = [*before, _Piece(part, meaning)]
    return best[-1] or []


def _without_shared(pieces: list[list[_Piece]], place: int) -> list[list[_Piece]]:
    """Remove an unknown word that most names share as their first (`place` 0) or last (−1) word.

    Words for sides are never removed.
    """
    while True:
        rest = [[p for p in joint if not p.side] for joint in pieces]
        ends = Counter(r[place].word for r in rest if len(r) > 1 and not r[place])
        word, often = ends.most_common(1)[0] if ends else ("", 0)
        if often < max(2.0, _SHARED * len(pieces)):
            return pieces
        pieces = [
            [p for p in joint if p is not r[place]]
            if len(r) > 1 and not r[place] and r[place].word == word
            else joint
            for joint, r in zip(pieces, rest, strict=True)
        ]


def _mirrored(pieces: list[list[_Piece]], numbers: list[str], vocabulary: Vocabulary) -> list[str]:
    """Return the side of each joint, using words that mean a side only in pairs.

    Such a word is used only if the skeleton also has the mirrored name. The side is 'Left', 'Right'
    or ''.
    """
    out = [""] * len(pieces)
    for pair in vocabulary.pairs:
        seen: tuple[dict[Any, int], dict[Any, int]] = ({}, {})
        for joint, (joint_pieces, number) in enumerate(zip(pieces, numbers, strict=True)):
            if not any(p.word in pair for p in joint_pieces):
                continue
            if any(p.side for p in joint_pieces if p.word not in pair):
                continue
            rest = tuple(p.word for p in joint_pieces if p.word not in pair)
            known = any(p.roles or p.has("other") for p in joint_pieces if p.word not in pair)
            for words, letter in zip(seen, pair, strict=True):
                if known and any(p.word == letter for p in joint_pieces):
                    words[rest, number] = joint
        for key in seen[0].keys() & seen[1].keys():
            out[seen[0][key]], out[seen[1][key]] = "Left", "Right"
    return out


def _joint_name(pieces: list[_Piece], number: str, mirrored: str) -> JointName:
    side = mirrored or _side(pieces)
    rest = [p for p in pieces if not p.side]
    # The French word "main" (hand) is noise in other names.
    if not any(p.roles for p in rest if not p.has("noise")):
        stem = [p for p in rest if not p.has("noise") or (p.roles and side)]
    else:
        stem = [p for p in rest if not p.has("noise")]
    stem = [p for p in stem if p or len(p.word) > 1 or not _has_case(p.word)]
    if not stem:
        return JointName("", "".join(p.word for p in pieces), number)
    bones = [p for p in stem if p.roles and (side or not p.has("sided"))]
    other = next((p for p in stem if p.has("other")), None)
    trunk = next((p for p in stem if p.has("trunk")), None)
    bone = bones[-1] if bones else None
    if bone is not None and trunk is not None and not side:
        bone = None  # such as Kinect's SpineShoulder
    if bone is not None and (other is None or "toe" in bone.roles):
        other = trunk = None
    roles = bone.roles if bone is not None and other is None else ()
    said = other or (bone if roles else trunk)
    return JointName(
        side,
        "".join(p.word for p in stem),
        number,
        roles,
        any(p.has("helper") for p in stem),
        other is not None,
        trunk is not None and other is None,
        said.word if said else "",
    )


def _side(pieces: list[_Piece]) -> str:
    """Return the side that a name means, or ''.

    Words have priority over single letters, and capitals over lower case.
    """
    sides = [p for p in pieces if p.side]
    if len(sides) == len(pieces):
        return ""  # the name is only a side: Xsens' L5 is a vertebra
    sides.sort(key=lambda p: (len(p.word) == 1 and _has_case(p.word), not p.upper))
    return sides[0].side if sides else ""


def _best(joints: list[JointName], pieces: list[list[_Piece]]) -> list[JointName]:
    """Remove roles for which another joint has a better name, and sort the remaining roles.

    If a joint has several possible roles, a role that no other joint on its side has comes first.
    """
    ranks = [_rank(p) for p in pieces]
    best: dict[tuple[str, str], int] = {}
    for joint, rank in zip(joints, ranks, strict=True):
        if joint.roles and not joint.helper:
            for side in {joint.side, ""}:  # '' compares joints without a side with all others
                key = side, joint.roles[0]
                best[key] = min(rank, best.get(key, rank))
    out = list(joints)
    last = []
    for k, (joint, rank) in enumerate(zip(joints, ranks, strict=True)):
        if joint.roles and not joint.helper and rank == _LAST:
            last.append(k)
            out[k] = _without_roles(joint, pieces[k])
        elif joint.roles and not joint.helper and rank > best[joint.side, joint.roles[0]]:
            out[k] = _without_roles(joint, pieces[k])
    out, taken = _sorted_roles(out)
    if last := [k for k in last if (joints[k].side, joints[k].roles[0]) not in taken]:
        for k in last:
            out[k] = joints[k]
        out, taken = _sorted_roles(out)
    return out


def _without_roles(joint: JointName, pieces: list[_Piece]) -> JointName:
    layer = any(p.has("layer") for p in pieces)
    trunk = any(p.has("trunk") for p in pieces) and not layer
    return replace(joint, roles=(), other=layer, trunk=trunk)


def _sorted_roles(joints: list[JointName]) -> tuple[list[JointName], set[tuple[str, str]]]:
    """Sort each joint's possible roles, such as 'hand', with the most likely role first.

    A role comes last if it is certain for another joint. Return the joints and the pairs (side,
    role) that are certain.
    """
    out = list(joints)
    open_ = {k: list(joint.roles) for k, joint in enumerate(joints) if joint.roles}
    taken: set[tuple[str, str]] = set()
    while True:
        certain = {
            (out[k].side, roles[0])
            for k, roles in open_.items()
            if len(roles) == 1 and not out[k].helper
        }
        if certain == taken:
            return out, taken
        taken = certain
        for k, roles in open_.items():
            free = [role for role in roles if (out[k].side, role) not in taken]
            if free and len(roles) > 1:
                open_[k] = free
                rest = [role for role in out[k].roles if role not in free]
                out[k] = replace(out[k], roles=(*free, *rest))


def _rank(pieces: list[_Piece]) -> int:
    """Rank a joint name from 0 (a plain, known name) to 3 (used only if no other name fits)."""
    if any(p.has("third") for p in pieces):
        return _LAST
    bare = [p for p in pieces if p or len(p.word) > 1]
    two = sum(len(p.roles) == 1 for p in bare) > 1  # such as Unreal's calf_knee
    if two or not all(bare) or any(_is_extra(p) for p in bare):
        return 2
    return int(any(p.has("second") for p in bare))


def _is_extra(piece: _Piece) -> bool:
    return piece.has("layer") or piece.has("tip") or (piece.has("trunk") and not piece.roles)
