"""Text, JSON and CSV as bytes, even for names that are not valid UTF-8.

A BVH may name a joint in bytes that are not UTF-8, since older programs write Latin-1, and so may a
path. Python reads each such byte 0xXX as the lone surrogate U+DCXX (surrogateescape), which UTF-8
cannot encode. These functions write it as the six characters backslash-udcXX. In JSON that is the
escape for the surrogate, so reading gives the same name again; in other text it is at least
visible.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

# Patterns are compiled when first used: most commands need only one of them.
_ESCAPED = r"\\u(dc[89a-f][0-9a-f])"
# Characters that a terminal or text renderer obeys instead of showing them: control and escape
# characters, Unicode line ends, marks of the writing direction, bytes that are not UTF-8.
_IN_LINE = "\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff"
_OBEYED = f"[{_IN_LINE}]"
_OBEYED_IN_LINES = f"(?![\n\t])[{_IN_LINE}]"
# Where a spreadsheet would begin a formula: at the start of a cell, and after a character that
# some programs take for its end, as with semicolons as separators.
_SIGNS = "=+\\-@\uff1d\uff0b\uff0d\uff20"
_AT_START, _BEHIND = f"(?=[ ']*[{_SIGNS}\t\r\n])", f"(?=[ ']*[{_SIGNS}])"
_FORMULA = f"^{_AT_START}|(?<=[;\t\r\n]){_BEHIND}"
_DEFUSED = f"^'{_AT_START}|(?<=[;\t\r\n])'{_BEHIND}"
_NUMBER = r"-?[0-9]+(\.[0-9]*)?(e[+-]?[0-9]+)?"


def encoded(text: str) -> bytes:
    """Encode text as UTF-8; bytes that were not UTF-8 become backslash escapes."""
    return text.encode("utf-8", "backslashreplace")


def escaped(text: str) -> str:
    """Return text with the escapes of :func:`encoded`, which every Unicode encoding can write."""
    return encoded(text).decode("utf-8")


def unescaped(text: str) -> str:
    """Decode the escapes that :func:`escaped` writes."""
    return re.sub(_ESCAPED, lambda found: chr(int(found[1], 16)), text)


def legible(text: object, *, lines: bool = False, most: int = 0) -> str:
    r"""Return a text with all control characters escaped, such as `\x1b`.

    Set `lines` to True to keep line ends and tabs. `most` is the number of characters to keep
    before '…', or 0 to keep all.
    """
    obeyed, whole = _OBEYED_IN_LINES if lines else _OBEYED, str(text)
    part = f"{whole[:most]}…" if 0 < most < len(whole) else whole
    return re.sub(obeyed, lambda found: repr(found[0])[1:-1], part)


def legible_json(text: str) -> str:
    r"""Return a line of JSON with control characters as JSON escapes such as `\u001b`."""
    return re.sub(_OBEYED, lambda found: f"\\u{ord(found[0]):04x}", text)


def json_text(document: Any, *, indent: int | None = 1) -> str:
    """Return a document as JSON text. Raises ValueError if a number is not finite."""
    return escaped(json.dumps(document, indent=indent, ensure_ascii=False, allow_nan=False))


def json_bytes(document: Any, *, indent: int | None = 1) -> bytes:
    """Return a document as the bytes of a JSON file, ending in a newline."""
    return json_text(document, indent=indent).encode() + b"\n"


def toml_string(text: str) -> str:
    """Return a text as a TOML string; unlike JSON, TOML requires DEL to be escaped."""
    return json.dumps(escaped(text), ensure_ascii=False).replace("\x7f", "\\u007f")


def csv_text(columns: Iterable[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """Return CSV with a line of column names, then one line per row; None becomes an empty cell.

    A text that a spreadsheet would take for a formula gets an apostrophe (:func:`cell`).
    """
    names = list(columns)
    return csv_lines([names, *([row.get(name) for name in names] for row in rows)])


def csv_lines(rows: Iterable[Iterable[Any]]) -> str:
    """Return rows as lines of CSV without a header."""
    import csv  # few commands need it

    lines = _Lines()
    # With this terminator the writer quotes both \r and \n in cells.
    csv.writer(lines, lineterminator="\r\n").writerows([cell(x) for x in row] for row in rows)
    return "".join(lines)


class _Lines(list[str]):
    """The lines that a CSV writer produces, each ending in a newline only."""

    def write(self, line: str) -> None:
        """Append a line."""
        self.append(line.removesuffix("\r\n") + "\n")


def cell(value: Any) -> Any:
    """Return a value for a CSV cell, with an apostrophe before text that looks like a formula.

    :func:`text_in_cell` is the reverse. All numbers stay unchanged, including negative ones.
    """
    if not isinstance(value, str) or re.fullmatch(_NUMBER, value):
        return value
    return re.sub(_FORMULA, "'", value)


def text_in_cell(text: str) -> str:
    """Return the text of a CSV cell without the apostrophe, the reverse of :func:`cell`."""
    return text if re.fullmatch(_NUMBER, text) else re.sub(_DEFUSED, "", text)
