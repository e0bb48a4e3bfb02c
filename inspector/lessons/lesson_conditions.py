"""The conditions in a lesson file that determine whether a page's task is done."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from inspector.language import tr
from inspector.lessons.lesson_place import LOOKS, LessonPlace
from inspector.teaching.symbols import SYMBOLS
from twistcore.detection import Kind

_AT_LEAST = re.compile(r">=\s*(\S+)")
AT_LEAST, AT_MOST = ">=", "<="
_EITHER = re.compile(rf"({AT_LEAST}|{AT_MOST})\s*(\S+)")
_SINGULAR = ("swing", "bend")


def hyphenated_kind_name(kind: Kind) -> str:
    """Return the name of a kind of interval as one word with hyphens, such as 'limb-flip'."""
    return kind.value.replace(" ", "-")


_KINDS = tuple(map(hyphenated_kind_name, Kind))

_MOST = {"swing": 180.0, "twist": 180.0, "applied": 1.0, "tau": 180.0}  # the limits of the sliders
FARTHEST = 170.0  # degrees of twist up to which the child's direction of rotation is known

_COUNTED = ("frames", "intervals")

# Each condition with the form of its argument, as in the documentation.
CONDITIONS = {
    "moved": "frames",
    "seen": "|".join(LOOKS),
    "lit": "symbol",
    "swing": ">= degrees",
    "twist": ">= degrees",
    "along": "",
    "counter": "",
    "nudged": " ".join(_SINGULAR),
    "applied": ">= share",
    "accepted": "|".join(_KINDS),
    "tau": ">= or <= degrees",
    "listed": "intervals",
}


@dataclass(frozen=True)
class Condition:
    """A condition that must be met to complete a task.

    Attributes
    ----------
    name
        A key of CONDITIONS.
    amount
        The required number of degrees, frames or intervals, or a share.
    words
        The words after the name.
    """

    name: str
    amount: float = 0.0
    words: tuple[str, ...] = ()


def read_conditions(text: str) -> tuple[Condition, ...]:
    """Read conditions separated by commas. Raises ValueError with a description of valid text.

    All conditions of a page must be met at the same time, so conflicting conditions are rejected.
    """
    conditions = [_condition(part.strip()) for part in text.split(",")]
    names = {condition.name for condition in conditions}
    if {"along", "counter"} <= names:
        raise ValueError(tr("either 'along' or 'counter', because a child joint cannot do both"))
    if any(c.name == "twist" and c.amount > FARTHEST for c in conditions) and "counter" in names:
        text = tr(
            "a 'twist' of at most {most:g} with 'counter', because at 180° the direction is "
            "undefined",
            most=FARTHEST,
        )
        raise ValueError(text)
    for name, what in (
        ("seen", tr("the same view in all conditions of a page")),
        ("lit", tr("the same symbol in all conditions of a page")),
    ):
        if len(own := [c for c in conditions if c.name == name]) > 1:
            common = tuple(w for w in own[0].words if all(w in c.words for c in own))
            if not common:
                raise ValueError(tr("{what} after {name!r}", what=what, name=name))
            conditions = [c for c in conditions if c.name != name]
            conditions.append(Condition(name, words=common))
    return tuple(conditions)


def is_task_already_met(conditions: Sequence[Condition], place: LessonPlace) -> bool:
    """Return True if the settings of a page already meet all conditions of its task.

    The user would then have nothing to do.
    """
    altered = place.what_if
    swing = None if altered.nudge or altered.toward else altered.swing
    set_so: dict[str, Callable[[Condition], bool]] = {
        "seen": lambda c: place.look in c.words,
        "lit": lambda c: place.lit in c.words,
        "swing": lambda c: swing is not None and swing >= math.radians(c.amount),
        "twist": lambda c: abs(altered.twist) >= math.radians(c.amount),
        "along": lambda _: not altered.counter,
        "applied": lambda c: altered.applied >= c.amount,
        "tau": lambda c: place.tau is not None and tau_meets(c, place.tau),
    }
    return bool(conditions) and all(c.name in set_so and set_so[c.name](c) for c in conditions)


def tau_meets(condition: Condition, tau: float) -> bool:
    """Return True if τ, in radians, meets a condition named 'tau'."""
    degrees = round(math.degrees(tau), 6)
    return (
        degrees >= condition.amount if AT_LEAST in condition.words else degrees <= condition.amount
    )


def _condition(text: str) -> Condition:
    name, _, rest = text.partition(" ")
    rest = rest.strip()
    form = CONDITIONS.get(name)
    if form is None:
        raise ValueError(tr("one of the conditions {known}", known=", ".join(CONDITIONS)))
    if form in _COUNTED:
        expected = tr("a whole number after {name!r}", name=name)
        number = _number(rest, expected)
        if not number.is_integer():
            raise ValueError(expected)
        return Condition(name, number)
    if name == "tau":
        expected = "'tau >= {degrees}', 'tau <= {degrees}'".format(degrees=tr("degrees"))
        limit = _EITHER.fullmatch(rest)
        if limit is None:
            raise ValueError(expected)
        amount = _number(limit[2].rstrip("°"), expected, _MOST[name])
        return Condition(name, amount, (limit[1],))
    if form.startswith(">="):
        share = form == CONDITIONS["applied"]
        unit = tr("share") if share else tr("degrees")
        expected = f"'{name} >= {unit}'"
        limit = _AT_LEAST.fullmatch(rest)
        if limit is None:
            raise ValueError(expected)
        return Condition(name, _number(limit[1].rstrip("°"), expected, _MOST[name]))
    known = tuple(SYMBOLS) if form == "symbol" else tuple(re.split(r"[| ]", form)) if form else ()
    words = tuple(rest.split())
    few = {"lit": 1, "seen": 1, "nudged": 1}.get(name, 0)
    if any(word not in known for word in words) or len(words) < few:
        after = tr("one of {known}", known=", ".join(known)) if known else tr("nothing")
        raise ValueError(tr("{what} after {name!r}", what=after, name=name))
    return Condition(name, words=words)


def _number(text: str, expected: str, most: float = math.inf) -> float:
    try:
        number = float(text)
    except ValueError:
        raise ValueError(expected) from None
    if not (math.isfinite(number) and number > 0.0):  # a condition that is always met is no task
        raise ValueError(tr("{expected}, greater than 0", expected=expected))
    if number > most:  # neither is a condition that is never met
        raise ValueError(
            tr("{expected}, greater than 0 and at most {most:g}", expected=expected, most=most)
        )
    return number
