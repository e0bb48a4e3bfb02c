"""What tells that the task of a page is done, as words in a lesson file."""

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
_SINGULAR = ("swing", "bend")


def word_of(kind: Kind) -> str:
    """A kind of interval as one word."""
    return kind.value.replace(" ", "-")


_KINDS = tuple(map(word_of, Kind))

_MOST = {"swing": 180.0, "twist": 180.0, "applied": 1.0}  # as far as the sliders go
FARTHEST = 170.0  # degrees of twist up to which it can be told which way a child turned

# Name → what follows it, as the documentation has it.
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
}


@dataclass(frozen=True)
class Condition:
    """name: of CONDITIONS; amount: its number, degrees, frames or a share; words: its words."""

    name: str
    amount: float = 0.0
    words: tuple[str, ...] = ()


def read_conditions(text: str) -> tuple[Condition, ...]:
    """Conditions with commas between them; ValueError says what was expected.

    All of them hold at once, so that such as exclude each other are none.
    """
    conditions = [_condition(part.strip()) for part in text.split(",")]
    names = {condition.name for condition in conditions}
    if {"along", "counter"} <= names:
        raise ValueError(tr("'along' or 'counter': a child does one of them"))
    if any(c.name == "twist" and c.amount > FARTHEST for c in conditions) and "counter" in names:
        text = tr(
            "'twist' up to {most:g} beside 'counter': at 180° both ways are one", most=FARTHEST
        )
        raise ValueError(text)
    for name, what in (("seen", tr("one of what is shown")), ("lit", tr("one symbol: one is lit"))):
        if len(own := [c for c in conditions if c.name == name]) > 1:
            common = tuple(w for w in own[0].words if all(w in c.words for c in own))
            if not common:
                raise ValueError(tr("{what} after {name!r}", what=what, name=name))
            conditions = [c for c in conditions if c.name != name]
            conditions.append(Condition(name, words=common))
    return tuple(conditions)


def hold_at_once(conditions: Sequence[Condition], place: LessonPlace) -> bool:
    """Whether a page's own settings fulfil them all, as far as these tell: that is no task."""
    altered = place.what_if
    swing = None if altered.nudge or altered.toward else altered.swing
    set_so: dict[str, Callable[[Condition], bool]] = {
        "seen": lambda c: place.look in c.words,
        "lit": lambda c: place.lit in c.words,
        "swing": lambda c: swing is not None and swing >= math.radians(c.amount),
        "twist": lambda c: abs(altered.twist) >= math.radians(c.amount),
        "along": lambda _: not altered.counter,
        "applied": lambda c: altered.applied >= c.amount,
    }
    return bool(conditions) and all(c.name in set_so and set_so[c.name](c) for c in conditions)


def _condition(text: str) -> Condition:
    name, _, rest = text.partition(" ")
    rest = rest.strip()
    form = CONDITIONS.get(name)
    if form is None:
        raise ValueError(tr("a condition of {known}", known=", ".join(CONDITIONS)))
    if form == "frames":
        expected = tr("a whole number of frames after {name!r}", name=name)
        number = _number(rest, expected)
        if not number.is_integer():
            raise ValueError(expected)
        return Condition(name, number)
    if form.startswith(">="):
        share = form == CONDITIONS["applied"]
        unit = tr("number of share") if share else tr("number of degrees")
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
    if not (math.isfinite(number) and number > 0.0):  # what always holds is no task
        raise ValueError(tr("{expected}, above 0", expected=expected))
    if number > most:  # and what never does is none either
        raise ValueError(tr("{expected}, above 0 and up to {most:g}", expected=expected, most=most))
    return number
