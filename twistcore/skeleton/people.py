"""Find the people in a skeleton, with their joints and names.

People have separate roots or a common parent joint, and they have the same limbs. Their joint names
differ by a namespace (`A:Hips`), by words before or after the rest of the name (`P1_Hips`,
`Hips_B`), or by the number that a reader adds to a duplicate name (`Hips #2`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from twistcore.skeleton.joint_names import JointName, interpret_names
from twistcore.skeleton.motion import Skeleton, cache_per_object
from twistcore.work.frozen import dataclass

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[^\W\d_A-Za-z]+")
# A name to which a reader added a number, because it was a duplicate.
_NUMBERED = re.compile(r"(.+) #([0-9]+)")
_BREAKS = " _-.:|"
_SIDES = frozenset(("l", "r", "left", "right"))
# Minimum share of a person's joints whose names contain the part that identifies the person.
_MOST = 0.6
# Limits for a figure whose hands and feet have unknown names:
_FEWEST = 8  # minimum number of joints
# Minimum number of lines of joints, and minimum number of joints in a line. The lines must begin at
# two or more joints, because all lines of a cape begin at one joint.
_LINES, _LONG = 3, 3
_ALIKE = 0.7  # minimum share of joint names in common with another figure below the same joint
_EVERY = 0.9  # minimum share of the skeleton's joints that all such figures have together
_ENDS = ("hand", "foot")
_SHORTEST = 3  # minimum number of joints of a limb
_LEVELS = 5  # number of branching levels, from the roots downwards, that are searched for people
_CROWD = 50  # maximum number of people; damaged files seem to have more
_LATEST = 8  # a limb is assigned only to one of this number of people that were found last


@dataclass(frozen=True)
class Person:
    """One of the people in a skeleton.

    Attributes
    ----------
    name
        Name of the person, or '' if there is only one.
    joints
        Indices of the person's joints, in file order.
    words
        Names of these joints, without the part that identifies the person.
    """

    name: str
    joints: tuple[int, ...]
    words: tuple[str, ...]


@dataclass(frozen=True)
class _Mark:
    """The parts of joint names that identify a person. Each is '' if there is none.

    Attributes
    ----------
    namespace
        The part before a colon.
    affix
        Words at the beginning or end of the names.
    number
        The number that a reader added to duplicate names.
    """

    namespace: str = ""
    affix: str = ""
    number: str = ""


@dataclass(frozen=True)
class _Top:
    """A joint with its subtree, which is a person or a part of one.

    Attributes
    ----------
    joint
        Index of the topmost joint.
    joints
        Indices of all joints of the subtree.
    mark
        The parts of the names that identify the person.
    words
        Names of the joints, without the mark.
    limbs
        Limbs whose end has a known name, as (side, 'hand' or 'foot').
    """

    joint: int
    joints: tuple[int, ...]
    mark: _Mark
    words: tuple[str, ...]
    limbs: frozenset[tuple[str, str]]


@cache_per_object
def find_people(skeleton: Skeleton) -> tuple[Person, ...]:
    """Return the people in a skeleton, in file order. A single person has the name ''.

    Two sibling joints begin two people if both subtrees have the same limb, such as a left arm. If
    the hands and feet have unknown names, both subtrees must look like a whole figure, and they
    must begin at roots or have similar joint names.
    """
    roots = [joint for joint, parent in enumerate(skeleton.parents.tolist()) if parent < 0]
    groups = _split(skeleton, roots, _sizes(skeleton))
    if not 1 < len(groups) <= _CROWD:
        return (Person("", tuple(range(len(skeleton))), skeleton.names),)
    people = []
    for name, tops in zip(_person_names(groups), groups, strict=True):
        own = {j: word for top in tops for j, word in zip(top.joints, top.words, strict=True)}
        above = int(skeleton.parents[tops[0].joint])
        if len(tops) > 1 and above >= 0:  # these are the hips, with another person below them
            own[above] = skeleton.names[above]
        joints = tuple(sorted(own))
        people.append(Person(name, joints, tuple(own[j] for j in joints)))
    return tuple(people)


def interpret_person_joint_names(skeleton: Skeleton, people: Sequence[Person]) -> list[JointName]:
    """Return the meaning of each joint's name, without the part that identifies the person.

    Joints above several people belong to no person. Their names have no meaning.
    """
    names = [JointName("", "", "")] * len(skeleton)
    for person in people:
        for joint, name in zip(person.joints, interpret_names(person.words), strict=True):
            names[joint] = name
    return names


# -- splitting the skeleton into people ------------------------------------------------------------


def _split(
    skeleton: Skeleton, begin: Sequence[int], sizes: Sequence[int], levels: int = _LEVELS
) -> list[list[_Top]]:
    """Divide the subtrees of sibling joints among people, and return the subtrees of each person.

    `begin` contains the siblings, `sizes` the number of joints in the subtree of every joint, and
    `levels` is the number of branching levels to search. The result is empty if there are fewer
    than two people.
    """
    begin = [joint for joint in begin if sizes[joint] >= _SHORTEST]
    while len(begin) == 1:
        begin = [c for c in skeleton.children[begin[0]] if sizes[c] >= _SHORTEST]
    if not begin or not levels:
        return []
    tops = _tops(skeleton, begin)
    groups = _with_equal_limbs(skeleton, tops) or _whole_figures(skeleton, tops)
    carrying = [top for top in tops if top.limbs or len(top.joints) >= _FEWEST]
    people = []
    for group in groups or [[top] for top in carrying]:
        alone = len(group) == 1
        children = skeleton.children[group[0].joint] if alone else ()
        below = _split(skeleton, children, sizes, levels - 1)
        people += below or ([group] if groups else [])
    return people


def _with_equal_limbs(skeleton: Skeleton, tops: Sequence[_Top]) -> list[list[_Top]]:
    """Group subtrees into people by their limbs, or return [] if no limb occurs twice.

    Subtrees with the same mark and different limbs belong to one person. A group with a single limb
    is a person only if its subtrees begin at roots.
    """
    if max(Counter(limb for top in tops for limb in top.limbs).values(), default=0) < 2:
        return []
    groups: list[list[_Top]] = []
    for top in sorted(tops, key=lambda top: -len(top.limbs)):
        fitting = [
            group
            for group in groups[-_LATEST:]
            if group[0].mark == top.mark and not top.limbs & _limbs_of(group)
        ]
        if top.limbs and fitting:
            max(reversed(fitting), key=lambda group: len(_limbs_of(group))).append(top)
        elif top.limbs or _is_figure(skeleton, top):
            groups.append([top])
    fewest = 1 if skeleton.parents[tops[0].joint] < 0 else 2
    people = [g for g in groups if len(_limbs_of(g)) >= fewest or not _limbs_of(g)]
    return sorted(people, key=lambda g: min(t.joint for t in g)) if len(people) > 1 else []


def _limbs_of(tops: Sequence[_Top]) -> frozenset[tuple[str, str]]:
    return frozenset[tuple[str, str]]().union(*(top.limbs for top in tops))


def _whole_figures(skeleton: Skeleton, tops: Sequence[_Top]) -> list[list[_Top]]:
    """Return the people whose hands and feet have unknown names, or [] if there are fewer than two.

    Every person must look like a whole figure. The subtrees must begin at roots or have similar
    joint names.
    """
    figures = [top for top in tops if _is_figure(skeleton, top)]
    if len(figures) < 2 or sum(len(t.joints) for t in figures) < _EVERY * len(skeleton):
        return []
    at_root = skeleton.parents[figures[0].joint] < 0
    alike = all(_likeness(figures[0], other) >= _ALIKE for other in figures[1:])
    return [[top] for top in figures] if at_root or alike else []


def _is_figure(skeleton: Skeleton, top: _Top) -> bool:
    """Return True if a subtree looks like a whole figure.

    Long lines of joints must begin at two or more of its joints, such as hips and chest.
    """
    if len(top.joints) < _FEWEST:
        return False
    leave, own = [], set(top.joints)
    for joint in top.joints:
        if skeleton.children[joint]:
            continue
        length, here = 1, int(skeleton.parents[joint])
        while here in own and len(skeleton.children[here]) == 1:
            length, here = length + 1, int(skeleton.parents[here])
        if length >= _LONG:
            leave.append(here)
    return len(leave) >= _LINES and len(set(leave)) > 1


def _likeness(one: _Top, other: _Top) -> float:
    """Return the Jaccard similarity of the joint names of two subtrees, 0…1."""
    a, b = Counter(one.words), Counter(other.words)
    return (a & b).total() / (a | b).total()


def _tops(skeleton: Skeleton, begin: Sequence[int]) -> list[_Top]:
    """Return the subtree of each sibling joint, with its mark and limbs."""
    below = [_all_below(skeleton, joint) for joint in begin]
    marks = _marks([[skeleton.names[j] for j in joints] for joints in below])
    return [
        _Top(joint, joints, mark, words, _limbs(skeleton, joints, interpret_names(words)))
        for joint, joints, (mark, words) in zip(begin, below, marks, strict=True)
    ]


def _limbs(
    skeleton: Skeleton, joints: Sequence[int], names: Sequence[JointName]
) -> frozenset[tuple[str, str]]:
    """Return (side, part) of each hand and foot that is below at least two joints of its side."""
    # Number of joints of each side on the path from the top, keyed by joint.
    above: dict[int, Counter[str]] = {-1: Counter()}
    found = set()
    for joint, name in zip(joints, names, strict=True):
        sides = above.get(int(skeleton.parents[joint]), above[-1])
        part = "" if name.other or name.helper else next(iter(name.roles), "")
        if part in _ENDS and name.side and sides[name.side] > 1:
            found.add((name.side, part))
        above[joint] = sides + Counter([name.side])
    return frozenset(found)


def _sizes(skeleton: Skeleton) -> list[int]:
    """Return the number of joints in each joint's subtree, which includes the joint."""
    sizes = [1] * len(skeleton)
    for joint in reversed(range(len(sizes))):
        if (parent := int(skeleton.parents[joint])) >= 0:
            sizes[parent] += sizes[joint]
    return sizes


def _all_below(skeleton: Skeleton, joint: int) -> tuple[int, ...]:
    """Return a joint and all its descendants, in file order."""
    out = [joint]
    for here in out:
        out.extend(skeleton.children[here])
    return tuple(sorted(out))


# -- names of people -------------------------------------------------------------------------------


def _person_names(groups: Sequence[Sequence[_Top]]) -> list[str]:
    """Return each person's name.

    The name is the part of the joint names that identifies the person. If there is none, it is the
    first joint's name or a number.
    """
    own = [min(group, key=lambda top: top.joint).words[0] for group in groups]
    names = [group[0].mark.namespace or group[0].mark.affix for group in groups]
    if known := next(filter(None, names), ""):
        before = _before(known, names)
        names = [name or before or str(k) for k, name in enumerate(names, 1)]
    else:
        names = own if len(set(own)) == len(own) else [str(k) for k in range(1, len(own) + 1)]
    out: list[str] = []
    for name in names:
        number, unique = 2, name
        while unique in out:
            number, unique = number + 1, f"{name} {number}"
        out.append(unique)
    return out


def _before(name: str, names: Sequence[str]) -> str:
    """Return the name that precedes another one: 'A' before 'B', '1' before '2', 'P1' before 'P2'.

    The result is '' if there is no such name, or if `names` already contains it.
    """
    found = ""
    if len(name) == 1 and name.isalpha():
        found = chr(ord(name) - 1)
        found = found if found.isalpha() else ""
    elif (digits := re.search(r"[0-9]+$", name)) and int(digits.group()) > 0:
        number = str(int(digits.group()) - 1).zfill(len(digits.group()))
        found = name[: digits.start()] + number
    return "" if found in names else found


def _marks(names: Sequence[Sequence[str]]) -> list[tuple[_Mark, tuple[str, ...]]]:
    """Return the mark of each group of joint names, and the names without the mark.

    A mark is the part of the names that identifies a person.
    """
    spaces, numbers, bare = [], [], []
    for group in names:
        parts = [_NUMBERED.fullmatch(name) for name in group]
        number = _of_most([part.group(2) if part else "" for part in parts])
        own = [
            part.group(1) if part and part.group(2) == number else name
            for name, part in zip(group, parts, strict=True)
        ]
        space = _of_most([name.rpartition(":")[0] for name in own])
        spaces.append(space)
        numbers.append(number)
        bare.append([name.removeprefix(f"{space}:") if space else name for name in own])
    several = {k: len(set(values)) > 1 for k, values in enumerate((spaces, numbers))}
    fronts = [_shared_words(group, 1) for group in bare]
    backs = [_shared_words(group, -1) for group in bare]
    front, back = _in_common(fronts), _in_common(backs)
    marks = []
    for k, group in enumerate(bare):
        first, last = fronts[k][front:], backs[k][back:]
        words = tuple(
            _without(_without(name, fronts[k], front, 1), backs[k], back, -1) for name in group
        )
        affix = _affix(first, fronts[k][:front]) or _affix(last[::-1], backs[k][:back][::-1])
        mark = _Mark(spaces[k] if several[0] else "", affix, numbers[k] if several[1] else "")
        marks.append((mark, words))
    return marks


def _of_most(values: Sequence[str]) -> str:
    """Return the most frequent value, or '' if fewer than 60 % of the values equal it."""
    value, count = Counter(values).most_common(1)[0]
    return value if count >= _MOST * len(values) else ""


def _shared_words(names: Sequence[str], step: int) -> list[str]:
    """Return the words with which most names begin (`step` 1) or end (`step` −1).

    The result begins with the outermost word.
    """
    words = [_WORD.findall(name)[::step] for name in names]
    shared: list[str] = []
    while True:
        k = len(shared)
        nxt = Counter(w[k] for w in words if w[:k] == shared and len(w) > k + 1)
        word, count = nxt.most_common(1)[0] if nxt else ("", 0)
        if count < max(2.0, _MOST * len(words)) or word.lower() in _SIDES:
            return shared
        shared.append(word)


def _in_common(runs: Sequence[Sequence[str]]) -> int:
    """Return the length of the longest common prefix of lists of words."""
    count = 0
    while all(len(run) > count for run in runs) and len({run[count] for run in runs}) == 1:
        count += 1
    return count


def _affix(words: Sequence[str], shared: Sequence[str]) -> str:
    """Return a person's name, such as 'B', or 'Person1' if the name is only a number.

    `words` belong to one person, and `shared` are the words next to them that all people share.
    """
    if words and shared and all(word.isdigit() for word in words):
        words = [shared[-1], *words]
    return "".join(words)


def _without(name: str, words: Sequence[str], keep: int, step: int) -> str:
    """Remove words from the beginning (`step` 1) or end (−1) of a name.

    The `keep` outermost words are not removed.
    """
    spans = [found.span() for found in _WORD.finditer(name)][::step]
    own = [name[a:b] for a, b in spans]
    if len(words) == keep or own[: len(words)] != list(words) or len(own) == len(words):
        return name
    (a, b), (c, d) = spans[keep], spans[len(words) - 1]
    start, stop = min(a, c), max(b, d)
    left, right = name[:start], name[stop:]
    inner = right.lstrip(_BREAKS) if step == 1 else left.rstrip(_BREAKS)
    return left + inner if step == 1 else inner + right
