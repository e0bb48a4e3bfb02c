"""Files as they are read: whole, and never what would wait for somebody or has no end."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable
from contextlib import suppress
from io import BufferedReader
from pathlib import Path

_AT_ONCE = getattr(os, "O_NONBLOCK", 0)  # to open a FIFO would wait for its writer
_REFUSED = {
    stat.S_IFIFO: (errno.EINVAL, "is a FIFO, expected a file"),
    stat.S_IFCHR: (errno.EINVAL, "is a device, expected a file"),
    stat.S_IFBLK: (errno.EINVAL, "is a device, expected a file"),
    stat.S_IFSOCK: (errno.EINVAL, "is a socket, expected a file"),
    stat.S_IFDIR: (errno.EISDIR, os.strerror(errno.EISDIR)),
}


def read_file(path: Path | str) -> bytes:
    """All bytes of a file; raises OSError as :func:`open_to_read`."""
    with open_to_read(path) as file:
        return file.read()


def read_text_file(path: Path | str) -> str:
    """The same as UTF-8, with or without Windows' mark in front; also UnicodeDecodeError."""
    return read_file(path).decode("utf-8-sig")


def open_to_read(path: Path | str) -> BufferedReader:
    """A file to read from; raises OSError, also for what is none: a FIFO, a socket, a device.

    What this process was given open (/dev/stdin, /dev/fd/N, so a shell's `<(…)`) is read whatever
    it is: somebody is at its other end.
    """
    path = Path(path)
    if _was_given(path):
        return path.open("rb")
    check_ordinary(path, path.stat().st_mode)  # before: some devices take an opening for an order
    file = open(path, "rb", opener=lambda name, flags: os.open(name, flags | _AT_ONCE))  # noqa: SIM115
    try:
        check_ordinary(path, os.fstat(file.fileno()).st_mode)
    except OSError:
        file.close()
        raise
    return file


def is_there(path: Path | str) -> bool:
    """Whether a path leads to something; False where that cannot be told.

    Which `Path.exists` raises: of a name that is too long, of a folder that may not be looked into.
    """
    return os.path.exists(path)  # noqa: PTH110


def is_file(path: Path | str) -> bool:
    """Whether a path leads to a file; False where that cannot be told."""
    return os.path.isfile(path)  # noqa: PTH113


def own_folder(find: Callable[[], Path]) -> Path:
    """A folder of the person's own; where nobody knows a home, one that nothing can be put into.

    find: of platformdirs; without a home it raises or, an older one, gives a path that begins with
    '~', which would be made wherever the program was started.
    """
    with suppress(RuntimeError):
        if (folder := find()).is_absolute():
            return folder
    return Path(os.devnull) / "twist-inspector"


def real_path(path: Path) -> Path:
    """Absolute and without links, as far as it can be told.

    `Path.resolve` raises where links lead in a circle; here such a link is its own end.
    """
    return Path(os.path.realpath(path))


def _was_given(path: Path) -> bool:
    folders = ("/dev/fd", f"/proc/{os.getpid()}/fd")
    return str(path) == "/dev/stdin" or (
        path.name.isdecimal() and os.path.realpath(path.parent) in folders
    )


def check_ordinary(path: Path, mode: int) -> None:
    """Raise OSError for what is no file by its mode."""
    if refused := _REFUSED.get(stat.S_IFMT(mode)):
        code, why = refused
        raise OSError(code, why, str(path))
