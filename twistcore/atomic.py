"""Files that are either the old or the new, never half of one."""

from __future__ import annotations

import errno
import os
import tempfile
from pathlib import Path


def write_atomically(path: Path, data: bytes) -> None:
    """Write to a temporary name in the same folder, fsync, rename.

    Raises OSError and leaves `path` as it was.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder, expected a file to write", str(path))
    try:
        handle, temporary = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.name}.", suffix=".part"
        )
    except OSError as error:  # the person knows the file's name, not the temporary one
        raise OSError(error.errno, error.strerror, str(path)) from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        # mkstemp makes private files; an export is as readable as any file the person creates.
        Path(temporary).chmod(_ordinary_mode(path))
        Path(temporary).replace(path)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from None
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _ordinary_mode(path: Path) -> int:
    if path.exists():
        return path.stat().st_mode & 0o777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def sync_folder(folder: Path) -> None:
    """Put the names in a folder on disk: a new file, or one that took another's place."""
    if os.name == "nt":
        return  # a folder cannot be opened there, and names are written with their files
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno != errno.EINVAL:  # a file system that has no such thing
            raise
    finally:
        os.close(handle)


def free_name(path: Path, suffix: str = "") -> Path:
    """The first of NAME, NAME-2, NAME-3 … beside `path` (with `suffix`) that is not taken."""
    wanted = path.with_name(path.name + suffix)
    free, number = wanted, 2
    while os.path.lexists(free):
        free, number = wanted.with_name(f"{wanted.name}-{number}"), number + 1
    return free
