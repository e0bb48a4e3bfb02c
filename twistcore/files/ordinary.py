"""Read only regular files, because reading other files, such as devices, may never end."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable
from contextlib import suppress
from io import BufferedReader
from pathlib import Path

from twistcore.errors import TwistError

_AT_ONCE = getattr(os, "O_NONBLOCK", 0)  # opening a FIFO would wait for its writer
_REFUSED = {
    stat.S_IFIFO: (errno.EINVAL, "expected a file, found a FIFO"),
    stat.S_IFCHR: (errno.EINVAL, "expected a file, found a device"),
    stat.S_IFBLK: (errno.EINVAL, "expected a file, found a device"),
    stat.S_IFSOCK: (errno.EINVAL, "expected a file, found a socket"),
    stat.S_IFDIR: (errno.EISDIR, os.strerror(errno.EISDIR)),
}


def read_file(path: Path | str) -> bytes:
    """Return all bytes of a regular file. Raises OSError as in :func:`open_to_read`."""
    with open_to_read(path) as file:
        return file.read()


def open_to_read(path: Path | str) -> BufferedReader:
    """Open a regular file for reading. Raises OSError, also for a FIFO, a socket or a device.

    The descriptors /dev/stdin and /dev/fd/N, and therefore a shell's `<(…)`, may be of any type,
    because another program has opened them for this one.
    """
    path = Path(path)
    if _was_given(path):
        return path.open("rb")
    check_regular_file(path, path.stat().st_mode)  # first, since opening some devices has effects
    file = open(path, "rb", opener=lambda name, flags: os.open(name, flags | _AT_ONCE))  # noqa: SIM115
    try:
        check_regular_file(path, os.fstat(file.fileno()).st_mode)
    except OSError:
        file.close()
        raise
    return file


def check_no_links(folder: Path, path: Path) -> None:
    """Raise TwistError if any part of a path below `folder` is a symbolic link.

    Use this for output folders in which the program chooses the file names.
    """
    way = folder
    for step in path.relative_to(folder).parts:
        way /= step
        if way.is_symlink():
            raise TwistError(
                f"{way} is a symbolic link, and the program does not write through "
                "symbolic links; remove the link, or choose another folder"
            )


def path_exists(path: Path | str) -> bool:
    """Return True if a path exists, False if not or if this cannot be determined.

    Unlike `Path.exists`, the function raises no error for a name that is too long or for a folder
    without access.
    """
    return os.path.exists(path)  # noqa: PTH110


def is_file(path: Path | str) -> bool:
    """Return True if a path leads to a regular file, False if this cannot be determined."""
    return os.path.isfile(path)  # noqa: PTH113


def user_folder_or_uncreatable_path(find: Callable[[], Path]) -> Path:
    """Return one of the user's folders, such as the cache folder.

    `find` is the function of platformdirs that returns the folder. If there is no home folder, a
    path that cannot be created is returned. In this case, `find` raises an error or, in older
    versions, returns a path that begins with '~' and would be created in the current folder.
    """
    with suppress(RuntimeError):
        if (folder := find()).is_absolute():
            return folder
    return Path(os.devnull) / "twist-inspector"


def real_path(path: Path) -> Path:
    """Return the absolute path with links resolved as far as possible.

    Unlike `Path.resolve`, the function does not fail for a loop of links. It returns the link's
    path.
    """
    return Path(os.path.realpath(path))


def _was_given(path: Path) -> bool:
    folders = ("/dev/fd", f"/proc/{os.getpid()}/fd")
    return str(path) == "/dev/stdin" or (
        path.name.isdecimal() and os.path.realpath(path.parent) in folders
    )


def check_regular_file(path: Path, mode: int) -> None:
    """Raise OSError unless a file with this mode, from `stat`, is a regular file."""
    if refused := _REFUSED.get(stat.S_IFMT(mode)):
        code, why = refused
        raise OSError(code, why, str(path))
