"""Convert text, JSON and CSV to bytes, even if it contains names that are not valid UTF-8.

Joint names in BVH files and paths may contain bytes that are not UTF-8, because older programs
write Latin-1. Python reads each such byte 0xXX as the lone surrogate U+DCXX (surrogateescape),
which UTF-8 cannot encode. These functions write it as the six characters backslash-udcXX. In JSON,
these characters are the escape for the surrogate, so reading the file gives the same name again. In
other text, they are at least visible.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

# Patterns are compiled on first use, because most commands need only one of them.
_ESCAPED = r"\\u(dc[89a-f][0-9a-f])"
# Characters that control a terminal or text renderer instead of being displayed: control and escape
# characters, Unicode line ends, marks of the writing direction, and bytes that are not UTF-8.
_IN_LINE = "\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff"
_OBEYED = f"[{_IN_LINE}]"
_OBEYED_IN_LINES = f"(?![\n\t])[{_IN_LINE}]"
# Places where a spreadsheet may begin a formula: the start of a cell, and after a character that
# some programs treat as the end of a cell, such as a semicolon.
_SIGNS = "=+\\-@\uff1d\uff0b\uff0d\uff20"
_AT_START, _BEHIND = f"(?=[ ']*[{_SIGNS}\t\r\n])", f"(?=[ ']*[{_SIGNS}])"
_FORMULA = f"^{_AT_START}|(?<=[;\t\r\n]){_BEHIND}"
_DEFUSED = f"^'{_AT_START}|(?<=[;\t\r\n])'{_BEHIND}"
_NUMBER = r"-?[0-9]+(\.[0-9]*)?(e[+-]?[0-9]+)?"


def encode_utf8(text: str) -> bytes:
    """Encode text as UTF-8. Bytes that were not valid UTF-8 become backslash escapes."""
    return text.encode("utf-8", "backslashreplace")


def escape_invalid_utf8(text: str) -> str:
    """Return text in which bytes that were not valid UTF-8 are backslash escapes."""
    return encode_utf8(text).decode("utf-8")


def unescape_invalid_utf8(text: str) -> str:
    """Replace the escapes written by :func:`escape_invalid_utf8` with the original surrogates."""
    return re.sub(_ESCAPED, lambda found: chr(int(found[1], 16)), text)


def escape_control_characters(text: object, *, lines: bool = False, most: int = 0) -> str:
    r"""Return an object's text with all control characters escaped, such as `\x1b`.

    Set `lines` to True to keep line ends and tabs. `most` is the maximum number of characters
    before '…', or 0 for no maximum.
    """
    obeyed, whole = _OBEYED_IN_LINES if lines else _OBEYED, str(text)
    part = f"{whole[:most]}…" if 0 < most < len(whole) else whole
    return re.sub(obeyed, lambda found: repr(found[0])[1:-1], part)


def escape_json_control_characters(text: str) -> str:
    r"""Return a line of JSON in which control characters are JSON escapes, such as `\u001b`."""
    return re.sub(_OBEYED, lambda found: f"\\u{ord(found[0]):04x}", text)


def json_text(document: Any, *, indent: int | None = 1) -> str:
    """Return a document as JSON text. Raises ValueError if a number is not finite."""
    return escape_invalid_utf8(
        json.dumps(document, indent=indent, ensure_ascii=False, allow_nan=False)
    )


def json_bytes(document: Any, *, indent: int | None = 1) -> bytes:
    """Return a document as the bytes of a JSON file. Raises ValueError as in :func:`json_text`."""
    return json_text(document, indent=indent).encode() + b"\n"


def toml_string(text: str) -> str:
    """Return a string as a quoted TOML string. Unlike JSON, TOML requires DEL to be escaped."""
    return json.dumps(escape_invalid_utf8(text), ensure_ascii=False).replace("\x7f", "\\u007f")


def csv_text(columns: Iterable[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """Return rows as CSV with a header. None becomes an empty cell.

    An apostrophe is added to text that a spreadsheet would read as a formula
    (:func:`escape_csv_cell`).
    """
    names = list(columns)
    return csv_lines([names, *([row.get(name) for name in names] for row in rows)])


def csv_lines(rows: Iterable[Iterable[Any]]) -> str:
    """Return rows as CSV without a header. Text that looks like a formula gets an apostrophe."""
    import csv  # loaded here because few commands need it

    lines = _Lines()
    # With this terminator, the writer quotes cells with \r or \n.
    csv.writer(lines, lineterminator="\r\n").writerows(
        [escape_csv_cell(x) for x in row] for row in rows
    )
    return "".join(lines)


class _Lines(list[str]):
    """The lines that a CSV writer produces, with a single newline at the end of each."""

    def write(self, line: str) -> None:
        """Append a line."""
        self.append(line.removesuffix("\r\n") + "\n")


def escape_csv_cell(value: Any) -> Any:
    """Return a value for a CSV cell, with an apostrophe before text that looks like a formula.

    Numbers stay unchanged, including negative ones. :func:`unescape_csv_cell` removes the
    apostrophe.
    """
    if not isinstance(value, str) or re.fullmatch(_NUMBER, value):
        return value
    return re.sub(_FORMULA, "'", value)


def unescape_csv_cell(text: str) -> str:
    """Return the text in a CSV cell without the apostrophe that :func:`escape_csv_cell` added."""
    return text if re.fullmatch(_NUMBER, text) else re.sub(_DEFUSED, "", text)
