"""SHA-256 of files, read once for each state of a file: its size, its time and its number."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from twistcore.files.ordinary import open_to_read

_LONG = 50_000_000  # bytes, some 50 ms: less is read before a person notices
_MOST = 1000  # files; those looked at first go first

_State = tuple[int, int, int]
_marks: dict[Path, tuple[_State, str]] = {}


def sha256_of(path: Path) -> str:
    """SHA-256 of a file's bytes, which are read in any case; raises OSError."""
    with open_to_read(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def file_mark(path: Path) -> str:
    """The same, read where the file is new or its state another. Safe to call in any thread."""
    state = _state(path)
    known = _marks.get(path)
    if known is not None and known[0] == state:
        return known[1]
    mark = sha256_of(path)
    _marks[path] = state, mark  # of the state before: changed meanwhile, it is read again
    for oldest in tuple(_marks)[:-_MOST]:
        _marks.pop(oldest, None)
    return mark


def takes_long(path: Path) -> bool:
    """Whether the file's mark is a matter for a thread; False for one that is not there."""
    with suppress(OSError):
        state, known = _state(path), _marks.get(path)
        return path.is_file() and state[0] > _LONG and (known is None or known[0] != state)
    return False


def forget_marks(paths: Iterable[Path]) -> None:
    """Read these again, whatever their state says."""
    for path in paths:
        _marks.pop(path, None)


def _state(path: Path) -> _State:
    status = path.stat()
    return status.st_size, status.st_mtime_ns, status.st_ino
