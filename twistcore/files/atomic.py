"""Write files atomically, so that a file always has either its old or its new contents.

Data for a stream or a device is written directly, since these cannot be replaced.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO

from twistcore.errors import TwistError
from twistcore.files.lock import lock_file, lock_file_requiring_support
from twistcore.files.ordinary import path_exists, read_file

STANDARD_OUTPUT = Path("/dev/stdout")  # means standard output, even if there is no such file

_PART_MARK, _PART_END = ".twist", ".part"  # end of the names of temporary files
_LONGEST_NAME, _SPARE = 255, 10  # bytes; _SPARE leaves room for a number in the name
_TRIES = 8
_BINARY = getattr(os, "O_BINARY", 0)
_HELD_TO_THE_END = os.name == "posix"  # Windows cannot rename an open file
_MOST_LINKS = 40  # maximum number of links to follow, as in Linux
_STREAMS = (stat.S_IFIFO, stat.S_IFCHR)
_REFUSED = {
    stat.S_IFDIR: (errno.EISDIR, "a folder"),
    stat.S_IFBLK: (errno.EINVAL, "a block device"),
    stat.S_IFSOCK: (errno.EINVAL, "a socket"),
}


def write_atomically(path: Path, data: bytes) -> None:
    """Write all of the data to a path, or nothing if an error occurs.

    For a regular file:

    - The data is written to a temporary file next to it, which is flushed to disk and renamed.
    - Links are followed and kept.
    - The new file has the old one's permissions, and its owner and group if this process may change
      them (root). If not, the file belongs to the user, as with any program that saves by renaming.
    - Other hard links of the old file keep the old bytes, since they may be a backup.

    Data is written directly into an open descriptor of this process (STANDARD_OUTPUT, /dev/fd/N), a
    FIFO or a character device. Opening a FIFO waits for its reader.

    Raises OSError, or BrokenPipeError if the reader of a pipe has closed it. The old file is then
    unchanged.
    """
    with writing_atomically(path) as file:
        file.write(data)


@contextlib.contextmanager
def writing_atomically(path: Path) -> Iterator[IO[bytes]]:
    """Yield a file to write to. It replaces the file at the path when the block ends.

    Unlike :func:`write_atomically`, this works for data that is too large for memory. After an
    exception in the block, the old file is unchanged, but a stream keeps the bytes that were
    written before the exception. Raises OSError.
    """
    try:
        descriptor = _descriptor_to_write(path)
        if descriptor is None:
            with _replacing(resolve_write_path(path)) as file:
                yield file
        else:
            with os.fdopen(descriptor, "wb") as file:
                yield file
    except OSError as error:  # report the user's path, not a temporary or linked one
        raise OSError(error.errno, error.strerror, str(path)) from None


def move_into_place(part: Path, end: Path) -> None:
    """Rename a finished temporary file to `end`, which is in the same folder.

    The file gets the permissions and the owner of the replaced file, as in
    :func:`write_atomically`. `end` must not be a link (see :func:`resolve_write_path`). Raises
    OSError.
    """
    _copy_permissions(part, end)
    part.replace(end)
    sync_folder(end.parent)


def resolve_write_path(path: Path) -> Path:
    """Follow links from a path, and return the path at their end, which need not exist.

    An open descriptor of this process is not followed, although Linux shows it as a link. Raises
    OSError for a loop of links, and for a folder, a block device or a socket, since these cannot be
    written.
    """
    end = path
    for _ in range(_MOST_LINKS):
        end = Path(os.path.realpath(end.parent), end.name)
        if _descriptor_number(end) is not None:
            return end
        if not end.is_symlink():
            if refused := _REFUSED.get(_kind(end)):
                code, what = refused
                raise OSError(
                    code, f"expected a file that can be written to, found {what}", str(path)
                )
            return end
        end = end.parent / end.readlink()
    raise OSError(
        errno.ELOOP,
        "expected a file that can be written to, found a loop of symbolic links",
        str(path),
    )


def remove_half_written_files(folder: Path) -> None:
    """Remove the half-written files that killed programs left in a folder and its subfolders.

    Files of other programs, files of other users and files in use are kept.
    """
    for part in folder.rglob(f".*{_PART_MARK}*"):
        if part.name.endswith(_PART_END):
            _remove_left(part)


def is_stream(path: Path) -> bool:
    """Return True if a path leads to a stream or device, which is written to directly.

    Raises OSError.
    """
    end = resolve_write_path(path)
    return _descriptor_number(end) is not None or _kind(path) in _STREAMS


def is_standard_output(path: Path) -> bool:
    """Return True if a path leads to standard output."""
    try:
        return _descriptor_number(resolve_write_path(path)) == 1
    except OSError:
        return False


def same_file(a: Path, b: Path) -> bool:
    """Return True if both paths lead to the same existing file, for example through a link."""
    return path_exists(a) and path_exists(b) and a.samefile(b)


def _descriptor_number(end: Path) -> int | None:
    """Return this process's open file descriptor to which a path such as /dev/fd/3 refers, or None.

    `end` must not be a link.
    """
    if end == STANDARD_OUTPUT:
        return 1
    folders = ("/dev/fd", f"/proc/{os.getpid()}/fd")
    return int(end.name) if str(end.parent) in folders and end.name.isdecimal() else None


def _descriptor_to_write(path: Path) -> int | None:
    """Return an open descriptor for a stream, or None if the path is a file to be replaced.

    The caller closes the descriptor.
    """
    if not is_stream(path):
        return None
    number = _descriptor_number(resolve_write_path(path))
    if number is not None:  # a second open() would write from the start of the file
        return os.dup(number)
    return os.open(path, os.O_WRONLY | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0))


def _kind(path: Path) -> int:
    """Return the file type bits of a path, following links, or 0 if nothing exists there."""
    try:
        return stat.S_IFMT(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return 0


def temporary_file_path(end: Path, suffix: str = "") -> Path:
    """Return the name of the temporary file for a path.

    The name is always the same, so that a file left by a killed program is found. A name that is
    too long is shortened, and a hash of the full name is added.
    """
    name, mark = end.name, f"{_PART_MARK}{_PART_END}{suffix}"
    if len(os.fsencode(name)) + len(mark) + _SPARE > _LONGEST_NAME:
        import hashlib  # slow to load; few names are so long

        name = f"{name[:20]}-{hashlib.sha256(os.fsencode(name)).hexdigest()[:16]}"
    return end.with_name(f".{name}{mark}")


def open_temporary(part: Path) -> tuple[int, Path]:
    """Create, open and lock a temporary file. Return its descriptor and path.

    A file that already exists at `part` is removed if a killed program of this user left it there.
    Any other file is kept, and the temporary file gets a similar name. Raises OSError.
    """
    for _ in range(_TRIES):
        _remove_left(part)
        with contextlib.suppress(FileExistsError):
            handle = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL | _BINARY, 0o600)
            if lock_file(handle) and _is_at(part, handle):
                return handle, part
            os.close(handle)  # another process has removed the file before it was locked
            continue
        break
    import tempfile  # slow to load; few files need another name

    handle, name = tempfile.mkstemp(dir=part.parent, prefix=f"{part.stem}.", suffix=part.suffix)
    lock_file(handle)
    return handle, Path(name)


@contextlib.contextmanager
def _replacing(end: Path) -> Iterator[IO[bytes]]:
    handle, part = open_temporary(temporary_file_path(end))
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
            if _HELD_TO_THE_END:
                move_into_place(part, end)
        if not _HELD_TO_THE_END:
            move_into_place(part, end)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _remove_left(part: Path) -> None:
    """Remove a temporary file that a killed program left behind.

    Links, files of other users and files in use are kept.
    """
    try:
        status = part.lstat()
        if not stat.S_ISREG(status.st_mode) or status.st_nlink != 1 or not _is_mine(status):
            return
        handle = os.open(part, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | _BINARY)
    except OSError:
        return
    try:
        if lock_file_requiring_support(handle) and _is_at(part, handle):
            part.unlink()
    finally:
        os.close(handle)


def _is_mine(status: os.stat_result) -> bool:
    return os.name == "posix" and status.st_uid == os.geteuid()


def _is_at(path: Path, handle: int) -> bool:
    try:
        return os.path.samestat(path.lstat(), os.fstat(handle))
    except OSError:
        return False


def _copy_permissions(part: Path, end: Path) -> None:
    """Give a file the permissions and owner of the file that it replaces.

    If it replaces no file, it gets the usual permissions.
    """
    try:
        old = end.stat()
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        part.chmod(0o666 & ~mask)
        return
    if os.name == "posix":
        new = part.stat()
        if (old.st_uid, old.st_gid) != (new.st_uid, new.st_gid):
            with contextlib.suppress(OSError):  # only root may change the owner
                os.chown(part, old.st_uid, old.st_gid)
    part.chmod(old.st_mode & 0o777)


def sync_folder(folder: Path) -> None:
    """Flush a folder to disk, so that the names of new files survive a crash."""
    if os.name != "posix":  # Windows cannot open folders
        return
    with contextlib.suppress(OSError):  # some file systems do not support this
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def first_unused_path(path: Path, suffix: str = "") -> Path:
    """Return the first of NAME, NAME-2, NAME-3 … that does not exist in the path's folder.

    NAME is the name of `path` followed by `suffix`.
    """
    wanted = path.with_name(path.name + suffix)
    free, number = wanted, 2
    while os.path.lexists(free):
        free, number = wanted.with_name(f"{wanted.name}-{number}"), number + 1
    return free


def write_missing_companion_files(companions: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder, unless they already exist there with the same bytes.

    `companions` contains the bytes of the files, keyed by name. Raises TwistError before writing
    anything if an existing file has different bytes, and OSError if writing fails.
    """
    missing = {name: data for name, data in companions.items() if not path_exists(folder / name)}
    for name in companions.keys() - missing.keys():
        if read_file(folder / name) != companions[name]:
            raise TwistError(
                f"{folder / name}: expected this file next to the clip, because the clip "
                "cannot be read correctly without it"
            )
    for name, data in missing.items():
        write_atomically(folder / name, data)
