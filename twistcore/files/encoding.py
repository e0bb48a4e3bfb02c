"""Text and JSON as bytes, whatever bytes the names in a file have.

A BVH may name a joint in bytes that are no UTF-8, as older programs write latin-1, and so may a
path. Python reads each such byte 0xXX as the lone surrogate U+DCXX (surrogateescape), which no
UTF-8 may hold. Written, it is the six letters backslash-udcXX: in JSON the very escape for it, so
that reading gives the same name again, elsewhere at least visible.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

# Patterns are compiled when they are first used: most commands need one of them.
_ESCAPED = r"\\u(dc[89a-f][0-9a-f])"
# What a terminal, or whatever sets a line of text, obeys instead of showing it: control and escape
# characters, line ends of Unicode, marks that turn the direction of writing, bytes without UTF-8.
_IN_LINE = "\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff"
_OBEYED = f"[{_IN_LINE}]"
_OBEYED_IN_LINES = f"(?![\n\t])[{_IN_LINE}]"
# Where a spreadsheet would begin a formula: at a cell's start, and behind what some take for its
# end, as those do that were told to part cells by semicolons.
_SIGNS = "=+\\-@\uff1d\uff0b\uff0d\uff20"
_AT_START, _BEHIND = f"(?=[ ']*[{_SIGNS}\t\r\n])", f"(?=[ ']*[{_SIGNS}])"
_FORMULA = f"^{_AT_START}|(?<=[;\t\r\n]){_BEHIND}"
_DEFUSED = f"^'{_AT_START}|(?<=[;\t\r\n])'{_BEHIND}"
_NUMBER = r"-?[0-9]+(\.[0-9]*)?(e[+-]?[0-9]+)?"


def encoded(text: str) -> bytes:
    """UTF-8, with bytes that were none escaped."""
    return text.encode("utf-8", "backslashreplace")


def escaped(text: str) -> str:
    """The same as text that every encoding of Unicode can write."""
    return encoded(text).decode("utf-8")


def unescaped(text: str) -> str:
    """The reverse of :func:`escaped`."""
    return re.sub(_ESCAPED, lambda found: chr(int(found[1], 16)), text)


def legible(text: object, *, lines: bool = False, most: int = 0) -> str:
    r"""A text of which all is seen and nothing obeyed: what would be is escaped, as `\x1b`.

    lines: line ends and tabs stay as they are; most: so many letters of it, then '…'; 0 for all.
    """
    obeyed, whole = _OBEYED_IN_LINES if lines else _OBEYED, str(text)
    part = f"{whole[:most]}…" if 0 < most < len(whole) else whole
    return re.sub(obeyed, lambda found: repr(found[0])[1:-1], part)


def legible_json(text: str) -> str:
    r"""A line of JSON with the same in JSON's own escapes, as `\u001b`: what it says stays."""
    return re.sub(_OBEYED, lambda found: f"\\u{ord(found[0]):04x}", text)


def json_text(document: Any, *, indent: int | None = 1) -> str:
    """A JSON document; ValueError where a number is not finite."""
    return escaped(json.dumps(document, indent=indent, ensure_ascii=False, allow_nan=False))


def json_bytes(document: Any, *, indent: int | None = 1) -> bytes:
    """The bytes of a JSON file, which ends in a line end."""
    return json_text(document, indent=indent).encode() + b"\n"


def toml_string(text: str) -> str:
    """A text as a string of TOML, which differs from JSON's in DEL: that is escaped."""
    return json.dumps(escaped(text), ensure_ascii=False).replace("\x7f", "\\u007f")


def csv_text(columns: Iterable[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """A line of column names, then one a row; None is empty.

    A text that a spreadsheet would take for a formula stands behind an apostrophe (:func:`cell`).
    """
    names = list(columns)
    return csv_lines([names, *([row.get(name) for name in names] for row in rows)])


def csv_lines(rows: Iterable[Iterable[Any]]) -> str:
    """The same of rows alone."""
    import csv  # few commands need it

    lines = _Lines()
    # This end of a line has both characters quoted that a reader may take for one.
    csv.writer(lines, lineterminator="\r\n").writerows([cell(x) for x in row] for row in rows)
    return "".join(lines)


class _Lines(list[str]):
    """What is written line by line, each ending as a line of ours."""

    def write(self, line: str) -> None:
        """Take a line."""
        self.append(line.removesuffix("\r\n") + "\n")


def cell(value: Any) -> Any:
    """A value as a cell of CSV: an apostrophe wherever a spreadsheet would begin a formula in it.

    :func:`text_in_cell` gives every text again. Numbers stay as they are, also those below 0.
    """
    if not isinstance(value, str) or re.fullmatch(_NUMBER, value):
        return value
    return re.sub(_FORMULA, "'", value)


def text_in_cell(text: str) -> str:
    """The reverse of :func:`cell`."""
    return text if re.fullmatch(_NUMBER, text) else re.sub(_DEFUSED, "", text)
