"""What a value read from a file must be for a program not to stumble over it.

A check takes any value that JSON can hold and returns what can be kept of it; ValueError where that
is nothing. Of lists and objects the good entries are kept.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from typing import Any

Check = Callable[[Any], Any]

_SEAL = "-"
_LONGEST_PATH = 32_767  # of Windows, the longest there is


def one_of(*allowed: str) -> Check:
    """One of these words."""

    def check(value: Any) -> str:
        if not isinstance(value, str) or value not in allowed:
            raise ValueError
        return value

    return check


def whole(low: int, high: int) -> Check:
    """A whole number from `low` to `high`; true and false are none."""

    def check(value: Any) -> int:
        if type(value) is not int or not low <= value <= high:
            raise ValueError
        return value

    return check


def number(low: float, high: float) -> Check:
    """A number from `low` to `high`, as a float."""

    def check(value: Any) -> float:
        if type(value) not in (int, float) or not low <= value <= high:
            raise ValueError
        return float(value)

    return check


def text(longest: int) -> Check:
    """Text that any file can hold: no half of a surrogate pair."""

    def check(value: Any) -> str:
        if not isinstance(value, str) or len(value) > longest:
            raise ValueError
        value.encode()  # UnicodeEncodeError is a ValueError
        return value

    return check


def path(value: Any) -> str:
    """A file's path; bytes that are not UTF-8 are escaped in it, as Python has them."""
    if not isinstance(value, str) or not 0 < len(value) <= _LONGEST_PATH or "\0" in value:
        raise ValueError
    value.encode("utf-8", "surrogateescape")
    return value


def sealed_bytes(longest: int) -> Check:
    """Bytes as hexadecimal digits, without the seal that they came with; it must fit."""

    def check(value: Any) -> str:
        if not isinstance(value, str) or len(value) > longest or not value.isascii():
            raise ValueError
        digits, _, _ = value.partition(_SEAL)
        bytes.fromhex(digits)
        if value not in (digits, sealed(digits)):  # earlier versions wrote no seal
            raise ValueError
        return digits

    return check


def sealed(digits: str) -> str:
    """Hexadecimal digits with a sum behind them that shows damage: Qt crashes on some."""
    return f"{digits}{_SEAL}{zlib.crc32(digits.encode()):08x}" if digits else ""


def both(first: Check, second: Check) -> Check:
    """A list of two."""

    def check(value: Any) -> tuple[Any, Any]:
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise ValueError
        return first(value[0]), second(value[1])

    return check


def list_of(entry: Check, most: int) -> Check:
    """A list of at most so many, all of them good."""

    def check(value: Any) -> list[Any]:
        if not isinstance(value, list) or len(value) > most:
            raise ValueError
        return [entry(v) for v in value]

    return check


def first_of(entry: Check, most: int) -> Check:
    """A list; its first good entries are kept."""

    def check(value: Any) -> list[Any]:
        if not isinstance(value, list):
            raise ValueError
        return [kept for v in value for kept in _good(entry, v)][:most]

    return check


def last_by(key: Check, entry: Check, most: int) -> Check:
    """An object; its last good entries are kept."""

    def check(value: Any) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise ValueError
        pairs = [pair for item in value.items() for pair in _good(both(key, entry), item)]
        return dict(pairs[-most:])

    return check


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


def _good(check: Check, value: Any) -> list[Any]:
    """What is kept of a value as a list of one, an empty list where that is nothing."""
    try:
        return [check(value)]
    except ValueError:
        return []
