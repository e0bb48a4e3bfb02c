"""Check values read from a settings file.

A check is a function that takes any JSON value and returns the valid part of it, or raises
ValueError. The valid part of a list or object contains only its valid entries.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

Check = Callable[[Any], Any]

_SEAL = "-"
_LONGEST_PATH = 32_767  # the limit of Windows


def _of(
    *kinds: type,
    good: Callable[[Any], bool] = lambda _: True,
    keep: Callable[[Any], Any] = lambda value: value,
) -> Check:
    """Return a check that accepts values of the types `kinds` for which `good` returns True.

    `keep` converts an accepted value to the value to use.
    """

    def check(value: Any) -> Any:
        if type(value) not in kinds or not good(value):
            raise ValueError
        return keep(value)

    return check


def any_of(*allowed: str) -> Check:
    """Return a check that accepts only the given strings."""
    return _of(str, good=lambda value: value in allowed)


def whole_between(low: int, high: int) -> Check:
    """Return a check that accepts whole numbers from `low` to `high`, but no booleans."""
    return _of(int, good=lambda value: low <= value <= high)


def truth(value: Any) -> bool:
    """Return a value if it is a boolean. Raises ValueError for anything else, such as 0 or 1."""
    if not isinstance(value, bool):
        raise ValueError
    return value


def number_between(low: float, high: float) -> Check:
    """Return a check that accepts numbers from `low` to `high` and converts them to float."""
    return _of(int, float, good=lambda value: low <= value <= high, keep=float)


def text_up_to(longest: int) -> Check:
    """Return a check that accepts strings of at most `longest` characters.

    Strings with lone surrogates are rejected.
    """
    # UnicodeEncodeError, which lone surrogates cause, is a ValueError.
    return _of(str, good=lambda value: len(value) <= longest, keep=_encodable)


def _encodable(value: str, errors: str = "strict") -> str:
    value.encode(errors=errors)
    return value


def file_path(value: Any) -> str:
    """Return a value if it is a file path. Raises ValueError if it is not.

    Bytes that are not valid UTF-8 may be escaped as lone surrogates.
    """
    if not isinstance(value, str) or not 0 < len(value) <= _LONGEST_PATH or "\0" in value:
        raise ValueError
    return _encodable(value, "surrogateescape")


def file_path_or_none(value: Any) -> str:
    """Return a value if it is a file path or an empty string. Raises ValueError if not."""
    return "" if value == "" else file_path(value)


def hex_with_checksum(longest: int) -> Check:
    """Return a check that accepts hexadecimal digits and removes the checksum after them.

    `longest` is the maximum number of characters.
    """

    def unsealed(value: str) -> str:
        digits, _, _ = value.partition(_SEAL)
        bytes.fromhex(digits)
        if value not in (digits, append_hex_checksum(digits)):  # earlier versions wrote no checksum
            raise ValueError
        return digits

    return _of(str, good=lambda value: len(value) <= longest and value.isascii(), keep=unsealed)


def append_hex_checksum(digits: str) -> str:
    """Return hexadecimal digits with a checksum appended.

    The checksum detects damaged data, which would crash Qt.
    """
    return f"{digits}{_SEAL}{zlib.crc32(digits.encode()):08x}" if digits else ""


def both(first: Check, second: Check) -> Check:
    """Return a check that accepts a list of two values, each with its own check."""
    return _of(
        list,
        tuple,
        good=lambda two: len(two) == 2,
        keep=lambda two: (first(two[0]), second(two[1])),
    )


def list_of(entry: Check, most: int) -> Check:
    """Return a check that accepts a list of at most `most` entries if all entries are valid."""
    return _of(
        list, good=lambda some: len(some) <= most, keep=lambda some: [entry(one) for one in some]
    )


def first_of(entry: Check, most: int) -> Check:
    """Return a check that accepts a list and returns its first `most` valid entries."""
    return _of(list, keep=lambda some: _good(entry, some)[:most])


def last_by(key: Check, entry: Check, most: int) -> Check:
    """Return a check that accepts an object and returns its last `most` valid entries.

    `key` checks the keys and `entry` checks the values.
    """
    pair = both(key, entry)
    return _of(dict, keep=lambda some: dict(_good(pair, some.items())[-most:]))


def record(**checks: Check) -> Check:
    """Return a check that accepts an object if it has all required entries and they are valid.

    `checks` contains the check of each required entry, keyed by name. Other entries are dropped.
    """
    return _of(
        dict,
        good=lambda some: checks.keys() <= some.keys(),
        keep=lambda some: {name: check(some[name]) for name, check in checks.items()},
    )


def shallow_json(value: Any, depth: int = 20) -> Any:
    """Return a JSON value if it is nested at most `depth` levels deep and all numbers are finite.

    Raises ValueError if not.
    """
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError
    if isinstance(value, dict | list):
        if not depth:
            raise ValueError
        for entry in value.values() if isinstance(value, dict) else value:
            shallow_json(entry, depth - 1)
    return value


def _good(check: Check, values: Iterable[Any]) -> list[Any]:
    """Return the results of `check` for all valid values, and drop the invalid ones."""
    good = []
    for value in values:
        with suppress(ValueError):
            good.append(check(value))
    return good
