"""The texts of a web page's scripts and templates, which say `tr("…")` as the program does."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

_PIECE = r'"(?:[^"\\\n]|\\.)*"'
_CALL = re.compile(rf"\btr\(\s*({_PIECE}(?:\s*\+\s*{_PIECE})*)\s*[,)]")


def texts_of_script(script: str) -> Iterator[str]:
    """Every text that a script asks a translation of; its pieces, joined by +, are one."""
    for call in _CALL.finditer(script):
        yield "".join(json.loads(piece) for piece in re.findall(_PIECE, call[1]))
