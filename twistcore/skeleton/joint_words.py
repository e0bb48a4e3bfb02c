"""Split joint names into words, in any script."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from contextlib import suppress

_WORDS = 12  # maximum number of words read from each end of a name; rigs have shorter names
# Shift-JIS, the Chinese, Korean and Cyrillic encodings of Windows, and latin-1, which accepts any
# byte.
_ENCODINGS = ("cp932", "gb18030", "cp949", "cp1251", "latin-1")


def split_joint_name(name: str) -> list[str]:
    """Return the words in a name, which are runs of letters or of digits.

    Namespaces, paths and text in brackets are omitted.
    """
    plain = "".join(
        c for c in unicodedata.normalize("NFKC", name) if unicodedata.category(c) != "Cf"
    )
    parts = [part for part in re.split(r"[:|/\\]", plain) if any(c.isalnum() for c in part)]
    bare = parts[-1] if parts else plain
    without = re.sub(r"\[[^\]]*\]", " ", bare)
    runs = _runs(without) or _runs(bare) or [bare]
    return runs if len(runs) <= 2 * _WORDS else runs[:_WORDS] + runs[-_WORDS:]


def _runs(name: str) -> list[str]:
    words: list[str] = []
    kind = ""
    for c in unicodedata.normalize("NFC", name):
        now = _kind(c)
        if now == "mark":
            now = kind
        if now == "":
            pass
        elif now == kind or (kind, now) == ("upper", "lower"):
            if (kind, now) == ("upper", "lower") and len(words[-1]) > 1:  # such as LHip
                capitals = words.pop()
                before = capitals[:-1]
                words += before if _is_side_and_letter(before) else [before]
                words.append(capitals[-1] + c)
            else:
                words[-1] += c
        else:
            words.append(c)
        kind = now
    return words


def _is_side_and_letter(capitals: str) -> bool:
    """Return True if the first of two capitals means a side, and the second is an initial.

    Examples are LU in LUArm and RF in RFArm.
    """
    return len(capitals) == 2 and capitals[0] in "LR"


def _kind(c: str) -> str:
    if c.isdigit():
        return "digit"
    if c.isupper() or c.istitle():
        return "upper"
    if c.islower():
        return "lower"
    if c.isalpha():
        return "letter"  # of a script without case
    return "mark" if unicodedata.category(c) in ("Mn", "Mc") else ""


def joint_names_in_possible_encodings(names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the names decoded in each possible encoding.

    A byte that is not UTF-8 was read as a lone surrogate (:mod:`twistcore.files.encoding`). If
    the names contain no such byte, they are returned unchanged.
    """
    if not any(_is_byte(c) for name in names if not name.isascii() for c in name):
        return [tuple(names)]
    found = []
    for encoding in _ENCODINGS:
        with suppress(UnicodeDecodeError):
            found.append(tuple(_decoded(name, encoding) for name in names))
    return found


def _decoded(name: str, encoding: str) -> str:
    if not any(map(_is_byte, name)):
        return name
    return name.encode("utf-8", "surrogateescape").decode(encoding)


def _is_byte(c: str) -> bool:
    return "\udc80" <= c <= "\udcff"
