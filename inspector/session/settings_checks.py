"""What a value read from a file must be for a program not to stumble over it.

A check takes any value that JSON can hold and returns what can be kept of it; ValueError where that
is nothing. Of lists and objects the good entries are kept.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

Check = Callable[[Any], Any]

_SEAL = "-"
_LONGEST_PATH = 32_767  # of Windows, the longest there is


def _of(
    *kinds: type,
    good: Callable[[Any], bool] = lambda _: True,
    keep: Callable[[Any], Any] = lambda value: value,
) -> Check:
    """A `good` value of these types, as `keep` returns it; both may raise ValueError."""

    def check(value: Any) -> Any:
        if type(value) not in kinds or not good(value):
            raise ValueError
        return keep(value)

    return check


def any_of(*allowed: str) -> Check:
    """One of these words."""
    return _of(str, good=lambda value: value in allowed)


def whole_between(low: int, high: int) -> Check:
    """A whole number from `low` to `high`; true and false are none."""
    return _of(int, good=lambda value: low <= value <= high)


def truth(value: Any) -> bool:
    """True or false, no number."""
    if not isinstance(value, bool):
        raise ValueError
    return value


def number_between(low: float, high: float) -> Check:
    """A number from `low` to `high`, as a float."""
    return _of(int, float, good=lambda value: low <= value <= high, keep=float)


def text_up_to(longest: int) -> Check:
    """Text that any file can hold: no half of a surrogate pair."""
    # UnicodeEncodeError is a ValueError.
    return _of(str, good=lambda value: len(value) <= longest, keep=_encodable)


def _encodable(value: str, errors: str = "strict") -> str:
    value.encode(errors=errors)
    return value


def file_path(value: Any) -> str:
    """A file's path; bytes that are not UTF-8 are escaped in it, as Python has them."""
    if not isinstance(value, str) or not 0 < len(value) <= _LONGEST_PATH or "\0" in value:
        raise ValueError
    return _encodable(value, "surrogateescape")


def file_path_or_none(value: Any) -> str:
    """A file's path, or '' for none."""
    return "" if value == "" else file_path(value)


def sealed_bytes(longest: int) -> Check:
    """Bytes as hexadecimal digits, without the seal that they came with; it must fit."""

    def unsealed(value: str) -> str:
        digits, _, _ = value.partition(_SEAL)
        bytes.fromhex(digits)
        if value not in (digits, sealed(digits)):  # earlier versions wrote no seal
            raise ValueError
        return digits

    return _of(str, good=lambda value: len(value) <= longest and value.isascii(), keep=unsealed)


def sealed(digits: str) -> str:
    """Hexadecimal digits with a sum behind them that shows damage: Qt crashes on some."""
    return f"{digits}{_SEAL}{zlib.crc32(digits.encode()):08x}" if digits else ""


def both(first: Check, second: Check) -> Check:
    """A list of two."""
    return _of(
        list,
        tuple,
        good=lambda two: len(two) == 2,
        keep=lambda two: (first(two[0]), second(two[1])),
    )


def list_of(entry: Check, most: int) -> Check:
    """A list of at most so many, all of them good."""
    return _of(
        list, good=lambda some: len(some) <= most, keep=lambda some: [entry(one) for one in some]
    )


def first_of(entry: Check, most: int) -> Check:
    """A list; its first good entries are kept."""
    return _of(list, keep=lambda some: _good(entry, some)[:most])


def last_by(key: Check, entry: Check, most: int) -> Check:
    """An object; its last good entries are kept."""
    pair = both(key, entry)
    return _of(dict, keep=lambda some: dict(_good(pair, some.items())[-most:]))


def record(**checks: Check) -> Check:
    """An object with these entries, all of them good; others are left out."""
    return _of(
        dict,
        good=lambda some: checks.keys() <= some.keys(),
        keep=lambda some: {name: check(some[name]) for name, check in checks.items()},
    )


def shallow(value: Any, depth: int = 20) -> Any:
    """Anything that JSON holds and that is not nested too deeply to be written again."""
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError
    if isinstance(value, dict | list):
        if not depth:
            raise ValueError
        for entry in value.values() if isinstance(value, dict) else value:
            shallow(entry, depth - 1)
    return value


def _good(check: Check, values: Iterable[Any]) -> list[Any]:
    """What is kept of some values; those of which that is nothing are left out."""
    good = []
    for value in values:
        with suppress(ValueError):
            good.append(check(value))
    return good
