"""What the names of joints say: the side, and which part of the body."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

HANDS = ("wrist", "hand")
FEET = ("ankle", "foot")
TOES = ("toe", "ball", "foot")

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+")
_SIDES = {"l": "Left", "left": "Left", "r": "Right", "right": "Right"}
# What rigs add to every joint or to some, and what says nothing about the body.
_NOISE = re.compile(r"b|bip|bn|bone|bind|ctrl|def|fk|j|jnt|joint|jt|org|sk|skin|valvebiped")
_SHARED = 0.6  # a first word that so many joints share is the rig's name, not the joint's
_HELPER = re.compile(r"twist|roll|share", re.I)
_NO_LIMB = re.compile(
    r"head|face|jaw|eye|brow|lip|tongue|teeth|ear|nose|mouth|cheek|hair|breast|finger|thumb|index"
    r"|middle|ring|pinky|little|metacarp|carpal|prop|weapon|skirt|cloth|orbicularis|levator|oris"
)


@dataclass(frozen=True)
class JointName:
    """side: 'Left', 'Right' or ''; stem: the rest in lower-case letters; number: its digits."""

    side: str
    stem: str
    number: str
    roles: tuple[str, ...] = ()
    helper: bool = False
    other: bool = False

    @property
    def no_limb(self) -> bool:
        """Whether it names a part of the head or hand, or something carried."""
        return _NO_LIMB.match(self.stem) is not None


def understood(names: Sequence[str]) -> list[JointName]:
    """Side and stem of every joint of a skeleton, namespaces and the rig's own prefix left out."""
    words = [_words(name) for name in names]
    begin = [0] * len(words)  # the words before are left out
    while True:
        first = [w[k] for w, k in zip(words, begin, strict=True) if k + 1 < len(w)]
        shared = Counter(word for word in first if word.lower() not in _SIDES).most_common(1)
        if not shared or shared[0][1] < max(2.0, _SHARED * len(words)):
            break
        for joint, (w, k) in enumerate(zip(words, begin, strict=True)):
            begin[joint] += k + 1 < len(w) and w[k] == shared[0][0]
    found = [_joint_name(w[k:]) for w, k in zip(words, begin, strict=True)]
    return [
        replace(n, roles=_ROLES.get(n.stem, ()), helper=is_helper(whole), other=n.no_limb)
        for n, whole in zip(found, names, strict=True)
    ]


_ROLES = {
    "clavicle": ("shoulder",),
    "collar": ("shoulder",),
    "clav": ("shoulder",),
    "scapula": ("shoulder",),
    "shoulder": ("shoulder", "arm"),
    "shldr": ("arm",),
    "upperarm": ("arm",),
    "uparm": ("arm",),
    "arm": ("arm", "forearm"),
    "forearm": ("forearm",),
    "lowerarm": ("forearm",),
    "lowarm": ("forearm",),
    "elbow": ("forearm",),
    "hand": ("hand",),
    "wrist": ("hand",),
    "thigh": ("upleg",),
    "upleg": ("upleg",),
    "upperleg": ("upleg",),
    "hip": ("upleg",),
    "leg": ("leg", "upleg"),
    "shin": ("leg",),
    "calf": ("leg",),
    "lowleg": ("leg",),
    "lowerleg": ("leg",),
    "knee": ("leg",),
    "ankle": ("foot",),
    "foot": ("foot", "toe"),
    "toe": ("toe",),
    "toebase": ("toe",),
    "ball": ("toe",),
}


def is_helper(name: str) -> bool:
    """Whether a joint only shares out the twist of the bone that it lies in."""
    return _HELPER.search(name) is not None


def _words(name: str) -> list[str]:
    bare = name.rpartition(":")[2].removeprefix("CC_Base_")
    bare = re.sub(r"^mixamorig\d*_?", "", bare, flags=re.I)
    return _WORD.findall(re.sub(r"(?<![A-Za-z])bip\d+", " ", bare, flags=re.I)) or [bare]


def _joint_name(words: list[str]) -> JointName:
    side, rest = "", []
    number = "".join(w for w in words if w.isdigit())
    for word in (w.lower() for w in words if not w.isdigit()):
        if not side and word in _SIDES:
            side = _SIDES[word]
        elif not _NOISE.fullmatch(word):
            rest.append(word)
    stem = "".join(rest)
    if not side:
        for long, its_side in (("left", "Left"), ("right", "Right")):
            if long in stem:
                return JointName(its_side, stem.replace(long, "", 1), number)
        if stem[1:] in (*HANDS, *FEET) and stem[0] in _SIDES:  # lhand
            return JointName(_SIDES[stem[0]], stem[1:], number)
    return JointName(side, stem, number)
