"""Check the values in a parsed document before objects are built from them.

A document from an unknown source may contain any value anywhere. Each function returns the value if
it is as expected. If not, it raises FormatError with a short message that states the expected
value, the actual value, and its place in the document. The parameter `what` names this place.
"""

from __future__ import annotations

import json
import math
import os
import re
import reprlib
import stat
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from twistcore.errors import FormatError, TwistError
from twistcore.files.ordinary import open_to_read

MOST_FRAMES = 20_000_000  # largest number of frames of a clip (two days at 115 fps)
DEGREES = 1e6  # largest size of an angle in degrees
LARGEST = 1e300  # largest number
_MOST_DIGITS = 30  # maximum number of digits of an integer, since long ones are slow to parse
# Maximum size of a file. The session of a long clip with an offset for each frame has 100 MB.
_MOST_BYTES = 256_000_000
_MOST_TOML = 1_000_000  # maximum size of a TOML file; real files have a few kilobytes
_MOST_DOTS = 20  # maximum number of dots in a line of TOML; the parser's time grows as its square
_QUOTED = re.compile(r""""(?:[^"\\\n]|\\.)*"|'[^'\n]*'|#[^\n]*""")
_LONGEST_PATH = 32_767  # characters: the limit of Windows, the highest of all systems

_Value = TypeVar("_Value")
_SHOWN = reprlib.Repr()
_SHOWN.maxstring = _SHOWN.maxlong = _SHOWN.maxother = 50
_SHOWN.maxlevel, _SHOWN.maxlist, _SHOWN.maxdict = 2, 4, 3
_HALF = 100  # characters kept at each end of a text that is still too long


def read_bytes_limited(path: Path, most: int = _MOST_BYTES) -> bytes:
    """Return the bytes of a file. Raises TwistError if unreadable or larger than `most` bytes."""
    try:
        with open_to_read(path) as file:
            status = os.fstat(file.fileno())
            whole_file = stat.S_ISREG(status.st_mode) and status.st_size <= most
            # read(most) allocates `most` bytes even if the file has only a few.
            data = file.read() if whole_file else file.read(most + 1)
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError:
        raise TwistError(f"{path!r}: expected a path without a NUL character") from None
    if len(data) > most:
        raise TwistError(f"{path}: expected a file of at most {most // 10**6} MB")
    return data


def parsed_toml(data: bytes) -> dict[str, Any]:
    """Parse a TOML file, given as bytes. Raises FormatError if it is not valid TOML."""
    import tomllib  # slow to load; few commands need it

    if len(data) > _MOST_TOML:
        raise FormatError(f"expected a file of at most {_MOST_TOML // 10**6} MB")
    try:
        text = data.decode("utf-8").replace("\r\n", "\n")
        if any(line.count(".") > _MOST_DOTS for line in _QUOTED.sub("", text).split("\n")):
            raise FormatError("expected TOML with fewer dots in its keys")
        return tomllib.loads(text)
    except RecursionError:
        raise FormatError("expected TOML with fewer nested levels") from None
    except ValueError as error:
        raise FormatError(f"expected TOML ({shorten_foreign_message(error)})") from None


def parsed_json(data: bytes | str) -> Any:
    """Parse JSON. Raises FormatError if it is not valid, or contains NaN or infinity."""
    try:
        return json.loads(data, parse_int=_whole, parse_float=_finite, parse_constant=_no_number)
    except RecursionError:
        raise FormatError("expected JSON with fewer nested levels") from None
    except ValueError as error:
        raise FormatError(f"expected JSON ({shorten_foreign_message(error)})") from None


def _whole(digits: str) -> int:
    if len(digits) > _MOST_DIGITS:
        raise ValueError(f"a number with {len(digits)} digits is too long")
    return int(digits)


def _finite(digits: str) -> float:
    if math.isfinite(found := float(digits)):
        return found
    raise ValueError(f"a number is too large ({digits[:20]})")


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a number")


def format_value_for_message(value: object) -> str:
    """Return a value as text for a message: short, on one line, and printable."""
    shown = _SHOWN.repr(value)
    return shown if len(shown) <= 2 * _HALF else f"{shown[:_HALF]}…{shown[-_HALF:]}"


def shorten_foreign_message(said: object) -> str:
    """Shorten a message from another program and escape its unprintable characters."""
    words = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(said)[:200])
    return words if len(str(said)) <= 200 else f"{words}…"


def unexpected_value_error(expected: str, what: str, value: object) -> FormatError:
    """Return a FormatError that states the expected value, the actual value, and their place.

    `what` is the name of the place in the document.
    """
    return FormatError(f"expected {expected} for {what}, found {format_value_for_message(value)}")


@contextmanager
def prefix_format_errors(place: object) -> Iterator[None]:
    """Add `place` at the start of the message of any FormatError raised in the block."""
    try:
        yield
    except FormatError as error:
        raise FormatError(f"{place}: {error}") from None


def check_keys(document: Any, *keys: str, what: str = "the document") -> Mapping[str, Any]:
    """Return the document. Raises FormatError unless it is a JSON object with all of these keys."""
    if not isinstance(document, Mapping):
        raise unexpected_value_error("an object", what, document)
    for key in keys:
        if key not in document:
            raise FormatError(f"the key {key} is missing")
    return document


def check_string(value: Any, what: str) -> str:
    """Return the value. Raises FormatError if it is not a string."""
    if not isinstance(value, str):
        raise unexpected_value_error("a string", what, value)
    return value


def check_path_string(value: Any, what: str) -> str:
    """Return the value. Raises FormatError if it cannot be a path.

    The path may contain surrogate escapes, which represent bytes that are not UTF-8.
    """
    try:
        good = isinstance(value, str) and len(value) <= _LONGEST_PATH and "\0" not in value
        if good:
            value.encode("utf-8", "surrogateescape")
            return str(value)
    except UnicodeEncodeError:
        pass
    raise unexpected_value_error("a path", what, value)


def check_bool(value: Any, what: str) -> bool:
    """Return the value. Raises FormatError if it is not a bool."""
    if not isinstance(value, bool):
        raise unexpected_value_error("true or false", what, value)
    return value


def check_number(value: Any, what: str, low: float = -LARGEST, high: float = LARGEST) -> float:
    """Return the value as a float.

    Raises FormatError unless it is a number from `low` to `high`. NaN, infinity and bools are not
    accepted.
    """
    good = isinstance(value, int | float) and not isinstance(value, bool)
    if not (good and low <= value <= high):
        raise unexpected_value_error(f"a number{_bounds(low, high, LARGEST)}", what, value)
    return float(value)


def check_positive_number(value: Any, what: str) -> float:
    """Return the value as a float. Raises FormatError unless it is a finite number above 0."""
    if not (check_number(value, what) > 0.0):
        raise unexpected_value_error("a number above 0", what, value)
    return float(value)


def check_integer(value: Any, what: str, low: int = 0, high: int = 2**53) -> int:
    """Return the value. Raises FormatError unless it is an integer from `low` to `high`."""
    if not (isinstance(value, int) and not isinstance(value, bool) and low <= value <= high):
        raise unexpected_value_error(f"a whole number{_bounds(low, high, 2**53)}", what, value)
    return value


def _bounds(low: float, high: float, most: float) -> str:
    if high < most:
        return f" from {low} to {high}"
    return f" of at least {low}" if low > -most else ""


def check_choice(value: Any, what: str, known: Collection[str]) -> str:
    """Return the value. Raises FormatError unless it is one of the strings in `known`."""
    if not (isinstance(value, str) and value in known):
        raise unexpected_value_error(" or ".join(map(repr, known)), what, value)
    return value


def check_list(value: Any, what: str) -> list[Any]:
    """Return the value as a list. Raises FormatError if it is not a list."""
    if not isinstance(value, list | tuple):
        raise unexpected_value_error("a list", what, value)
    return list(value)


def check_string_list(value: Any, what: str) -> tuple[str, ...]:
    """Return the value as a tuple. Raises FormatError if it is not a list of strings."""
    if not all(isinstance(one, str) for one in check_list(value, what)):
        raise unexpected_value_error("a list of strings", what, value)
    return tuple(value)


def read_each(value: Any, what: str, read: Callable[[Any], _Value]) -> tuple[_Value, ...]:
    """Apply `read` to every item of a list. If an item is invalid, the error states its number."""
    found = []
    for k, one in enumerate(check_list(value, what), start=1):
        with prefix_format_errors(f"{what}, number {k}"):
            found.append(read(one))
    return tuple(found)


def read_frame_span(entry: Mapping[str, Any], last: int = MOST_FRAMES) -> tuple[int, int]:
    """Return an entry's `start` and `stop`. Raises FormatError unless they are a span of frames.

    The span must not be empty. `last` is the largest allowed value of `stop`.
    """
    start = check_integer(entry["start"], "start", 0, last - 1)
    return start, check_integer(entry["stop"], "stop", start + 1, last)
