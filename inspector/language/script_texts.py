"""Find the texts marked with `tr("…")` in the scripts and the template of a web page."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

_PIECE = r'"(?:[^"\\\n]|\\.)*"'
_TEXT = rf"({_PIECE}(?:\s*\+\s*{_PIECE})*)\s*[,)]"
_CALL = re.compile(rf"\b(?:tr\(|tr_as\(\s*({_PIECE}),)\s*{_TEXT}")


def texts_of_script(script: str) -> Iterator[tuple[str, str]]:
    """Yield (meaning, text) for each text to translate in a script. The meaning may be ''.

    Strings joined with + are yielded as one text.
    """
    for call in _CALL.finditer(script):
        text = "".join(json.loads(piece) for piece in re.findall(_PIECE, call[2]))
        yield json.loads(call[1] or '""'), text
