"""Find a body's limbs, and report the limbs that were not found."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from twistcore.skeleton.body.by_names import ROLES, find_limbs_by_name
from twistcore.skeleton.body.by_shape import find_limbs_by_shape, limbs_from_joint_lines
from twistcore.skeleton.body.offsets import ancestors
from twistcore.skeleton.body.parts import LIMBS, Body, LimbLine, Unexamined
from twistcore.skeleton.body.shape import Shape
from twistcore.skeleton.joint_names import parse_joint_meaning
from twistcore.skeleton.motion import Motion, cache_per_object
from twistcore.skeleton.people import find_people, interpret_person_joint_names


def find_body(motion: Motion, *, said: Mapping[str, str] = MappingProxyType({})) -> Body:
    """Find the limbs of all people in a motion's skeleton.

    `said` maps joint names to meanings given by the user, such as 'left hand' or 'helper' (see
    :func:`parse_joint_meaning`).
    """
    return _found(motion, said) if said else _as_found(motion)


@cache_per_object
def _as_found(motion: Motion) -> Body:
    return _found(motion, MappingProxyType({}))


def _found(motion: Motion, said: Mapping[str, str]) -> Body:
    skeleton = motion.skeleton
    people = find_people(skeleton)
    own = {k: parse_joint_meaning(n, said[n]) for k, n in enumerate(skeleton.names) if n in said}
    names = tuple(
        own.get(k, name) for k, name in enumerate(interpret_person_joint_names(skeleton, people))
    )
    lines: list[LimbLine] = []
    missing: list[Unexamined] = []
    for person in people:
        shape = Shape(motion, names, frozenset(person.joints), frozenset(own))
        found, not_found = _limbs_of_one(shape)
        lines += (replace(line, person=person.name) for line in found)
        missing += (replace(limb, person=person.name) for limb in not_found)
    return Body(skeleton, names, tuple(lines), tuple(missing))


def _limbs_of_one(shape: Shape) -> tuple[Sequence[LimbLine], Sequence[Unexamined]]:
    """Return the limbs of one person, and the arms and legs that were not found."""
    lines = find_limbs_by_name(shape)
    shapes = shape.lines({j for line in lines.values() for j in line.joints})
    if not lines:
        found = limbs_from_joint_lines(shape, shapes)
        return found, _few_limbs(len(found))
    lines |= find_limbs_by_shape(shape, shapes, lines)
    return [lines[limb] for limb in LIMBS if limb in lines], tuple(_missing(shape, lines))


def _missing(shape: Shape, lines: Mapping[tuple[str, str], LimbLine]) -> Iterable[Unexamined]:
    """Yield the arms and legs that were not found, or of which only the upper bone was found."""
    inside = {j for line in lines.values() for j in line.joints}
    known = inside.union(*(ancestors(shape.skeleton, j) for j in inside))
    for side, kind in LIMBS:
        limb = f"{side.lower()} {kind}"
        if (side, kind) not in lines:
            yield Unexamined(limb, _why_missing(shape, side, kind, known), side, kind)
            continue
        have = {bone.segment for bone in lines[side, kind].bones}
        if kind == "arm" and "ForeArm" not in have:
            why = "it has no hand joint"
            yield Unexamined(f"{side.lower()} forearm", why, side, kind)
        if kind == "leg" and "Leg" not in have:
            why = "it has no foot joint"
            yield Unexamined(f"{side.lower()} shin", why, side, kind)


def _why_missing(shape: Shape, side: str, kind: str, known: set[int]) -> str:
    """Return the reason why a limb was not found, as a clause that lists unknown joint names.

    `known` contains the joints of the limbs that were found, and all joints above them.
    """
    end = ROLES[kind][-1]
    unknown = [
        shape.skeleton.names[j]
        for j in sorted(shape.joints - known)
        if shape.names[j].side == side
        and not (shape.names[j].roles or shape.names[j].helper or shape.names[j].other)
    ]
    if not unknown:
        return f"no joint name is recognised as a {end}"
    some = ", ".join(repr(name) for name in unknown[:3]) + (" …" if len(unknown) > 3 else "")
    return f"no joint name is recognised as a {end}; these names are unknown: {some}"


def _few_limbs(found: int) -> tuple[Unexamined, ...]:
    """Return a note if fewer than four limbs were found in a skeleton without known names."""
    if found >= len(LIMBS):
        return ()
    why = f"no joint has a known name, and only {found} of the four limbs were found by shape"
    return (Unexamined("arms and legs" if not found else "other limbs", why),)
