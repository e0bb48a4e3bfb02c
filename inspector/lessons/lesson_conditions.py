"""What tells that the task of a page is done, as words in a lesson file."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from inspector.lessons.lesson_place import LOOKS
from inspector.teaching.symbols import SYMBOLS
from twistcore.detection import Kind

_AT_LEAST = re.compile(r">=\s*(\S+)")
_SINGULAR = ("swing", "bend")
_KINDS = tuple(kind.value.replace(" ", "-") for kind in Kind)

_MOST = {"swing": 180.0, "twist": 180.0, "applied": 1.0}  # as far as the sliders go

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
    conditions = tuple(_condition(part.strip()) for part in text.split(","))
    names = {condition.name for condition in conditions}
    if {"along", "counter"} <= names:
        raise ValueError("'along' or 'counter': a child does one of them")
    for name, what in (("seen", "one of what is shown"), ("lit", "one symbol: one is lit")):
        words = [set(c.words) for c in conditions if c.name == name]
        if words and not set.intersection(*words):
            raise ValueError(f"{what} after {name!r}")
    return conditions


def _condition(text: str) -> Condition:
    name, _, rest = text.partition(" ")
    rest = rest.strip()
    form = CONDITIONS.get(name)
    if form is None:
        raise ValueError(f"a condition of {', '.join(CONDITIONS)}")
    if form == "frames":
        return Condition(name, _number(rest, f"a number of frames after {name!r}"))
    if form.startswith(">="):
        expected = f"'{name} {form.replace('>= ', '>= number of ')}'"
        limit = _AT_LEAST.fullmatch(rest)
        if limit is None:
            raise ValueError(expected)
        return Condition(name, _number(limit[1].rstrip("°"), expected, _MOST[name]))
    known = tuple(SYMBOLS) if form == "symbol" else tuple(re.split(r"[| ]", form)) if form else ()
    words = tuple(rest.split())
    few = {"lit": 1, "seen": 1, "nudged": 1}.get(name, 0)
    if any(word not in known for word in words) or len(words) < few:
        after = f"one of {', '.join(known)}" if known else "nothing"
        raise ValueError(f"{after} after {name!r}")
    return Condition(name, words=words)


def _number(text: str, expected: str, most: float = math.inf) -> float:
    try:
        number = float(text)
    except ValueError:
        raise ValueError(expected) from None
    if not (math.isfinite(number) and number > 0.0):  # what always holds is no task
        raise ValueError(f"{expected}, above 0")
    if number > most:  # and what never does is none either
        raise ValueError(f"{expected}, above 0 and up to {most:g}")
    return number
