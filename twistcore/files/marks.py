"""The SHA-256 of files, computed once for each state of a file (size, time and inode)."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from twistcore.files.ordinary import open_to_read

_LONG = 50_000_000  # bytes, about 50 ms: smaller files are read before a person notices
_MOST = 1000  # files; the oldest entries are dropped first

_State = tuple[int, int, int]
_marks: dict[Path, tuple[_State, str]] = {}


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file, always reading it; raises OSError."""
    with open_to_read(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def file_mark(path: Path) -> str:
    """Return the SHA-256 of a file, read again only if the file has changed. Thread-safe."""
    state = _state(path)
    known = _marks.get(path)
    if known is not None and known[0] == state:
        return known[1]
    mark = sha256_of(path)
    _marks[path] = state, mark  # the state before reading: a change meanwhile is noticed
    for oldest in tuple(_marks)[:-_MOST]:
        _marks.pop(oldest, None)
    return mark


def takes_long(path: Path) -> bool:
    """True if the mark takes so long to compute that it belongs in a thread; False if missing."""
    with suppress(OSError):
        state, known = _state(path), _marks.get(path)
        return path.is_file() and state[0] > _LONG and (known is None or known[0] != state)
    return False


def forget_marks(paths: Iterable[Path]) -> None:
    """Forget the marks of these files, so that the files are read again."""
    for path in paths:
        _marks.pop(path, None)


def _state(path: Path) -> _State:
    status = path.stat()
    return status.st_size, status.st_mtime_ns, status.st_ino
