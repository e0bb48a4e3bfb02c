"""Compute the SHA-256 of files, and cache it until the size, timestamp or inode changes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from twistcore.files.ordinary import is_file, open_to_read

_LONG = 50_000_000  # bytes, which take about 50 ms to read
_MOST = 1000  # maximum number of files in the cache; the oldest entries are removed first

_State = tuple[int, int, int]
_marks: dict[Path, tuple[_State, str]] = {}


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file, without using the cache. Raises OSError."""
    with open_to_read(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def cached_sha256(path: Path) -> str:
    """Return the SHA-256 of a file. It is computed again only if the file has changed.

    Thread-safe. Raises OSError.
    """
    state = _state(path)
    known = _marks.get(path)
    if known is not None and known[0] == state:
        return known[1]
    mark = sha256_of(path)
    _marks[path] = state, mark  # the state before reading, to notice a change during reading
    for oldest in tuple(_marks)[:-_MOST]:
        _marks.pop(oldest, None)
    return mark


def find_file_by_sha256(places: Iterable[Path], mark: str) -> Path | None:
    """Return the first path in `places` with the SHA-256 `mark`, or else the first that exists.

    The result is None if no path exists.
    """
    there = [path for path in places if is_file(path)]
    return next((path for path in there if cached_sha256(path) == mark), (*there, None)[0])


def is_slow_to_hash(path: Path) -> bool:
    """Return True if :func:`cached_sha256` would take so long that a thread should call it.

    The result is False if the file is missing.
    """
    with suppress(OSError):
        state, known = _state(path), _marks.get(path)
        return path.is_file() and state[0] > _LONG and (known is None or known[0] != state)
    return False


def forget_cached_hashes(paths: Iterable[Path]) -> None:
    """Remove files from the cache, so that they are read again."""
    for path in paths:
        _marks.pop(path, None)


def _state(path: Path) -> _State:
    status = path.stat()
    return status.st_size, status.st_mtime_ns, status.st_ino
