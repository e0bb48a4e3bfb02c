"""Text and JSON as bytes, whatever bytes the names in a file have.

A BVH may name a joint in bytes that are no UTF-8, as older programs write latin-1, and so may a
path. Python reads each such byte 0xXX as the lone surrogate U+DCXX (surrogateescape), which no
UTF-8 may hold. Written, it is the six letters backslash-udcXX: in JSON the very escape for it, so
that reading gives the same name again, elsewhere at least visible.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

_ESCAPED = re.compile(r"\\u(dc[89a-f][0-9a-f])")


def encoded(text: str) -> bytes:
    """UTF-8, with bytes that were none escaped."""
    return text.encode("utf-8", "backslashreplace")


def escaped(text: str) -> str:
    """The same as text that every encoding of Unicode can write."""
    return encoded(text).decode("utf-8")


def unescaped(text: str) -> str:
    """The reverse of :func:`escaped`."""
    return _ESCAPED.sub(lambda found: chr(int(found[1], 16)), text)


def json_text(document: Any, *, indent: int | None = 1) -> str:
    """A JSON document; ValueError where a number is not finite."""
    return escaped(json.dumps(document, indent=indent, ensure_ascii=False, allow_nan=False))


def json_bytes(document: Any, *, indent: int | None = 1) -> bytes:
    """The bytes of a JSON file, which ends in a line end."""
    return json_text(document, indent=indent).encode() + b"\n"


def csv_text(columns: Iterable[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """A line of column names, then one a row; None is empty."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(columns), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()
