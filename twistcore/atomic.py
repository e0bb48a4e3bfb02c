"""Files that are either the old or the new, never half of one; what is no file is written into."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO

from twistcore.errors import TwistError
from twistcore.ordinary_files import read_file

STANDARD_OUTPUT = Path("/dev/stdout")  # by this name also on systems that have no such file

_MOST_LINKS = 40  # as many as Linux follows
_STREAMS = (stat.S_IFIFO, stat.S_IFCHR)
_REFUSED = {
    stat.S_IFDIR: (errno.EISDIR, "a folder"),
    stat.S_IFBLK: (errno.EINVAL, "a block device"),
    stat.S_IFSOCK: (errno.EINVAL, "a socket"),
}


def write_atomically(path: Path, data: bytes) -> None:
    """Put data where a path leads: all of it or nothing.

    A file is replaced: what is new is written beside it under a temporary name, fsynced, renamed,
    and the folder fsynced. Links are followed and stay. The new file has the old one's permissions,
    and its owner and group where we may give it away (root); else it is ours, as with any program
    that saves by renaming. Other hard links of the old file keep the old bytes: they may be
    somebody's backup, and whole is worth more than shared.

    Open descriptors of this process (STANDARD_OUTPUT, /dev/fd/N), FIFOs and character devices are
    written into and stay what they are; to open a FIFO waits for its reader.

    Raises OSError, BrokenPipeError where a reader has gone; a file is then as it was.
    """
    with writing_atomically(path) as file:
        file.write(data)


@contextlib.contextmanager
def writing_atomically(path: Path) -> Iterator[IO[bytes]]:
    """A file to write into bit by bit, which ends where a path leads once all is in it.

    As :func:`write_atomically`, for what is larger than memory should hold. What is raised inside
    leaves the file as it was; of a stream, with what had been written by then.
    """
    try:
        descriptor = _descriptor_to_write(path)
        if descriptor is None:
            with _replacing(destination(path)) as file:
                yield file
        else:
            with os.fdopen(descriptor, "wb") as file:
                yield file
    except OSError as error:  # the person knows this name, not a temporary one or a link's end
        raise OSError(error.errno, error.strerror, str(path)) from None


def move_into_place(part: Path, end: Path) -> None:
    """Give a finished file, in the folder of a :func:`destination`, that one's name.

    Permissions and owner are the replaced file's, as with :func:`write_atomically`. Raises OSError.
    """
    _settle(part, end)
    part.replace(end)
    sync_folder(end.parent)


def destination(path: Path) -> Path:
    """What a path leads to over all links, there or not.

    An open descriptor of this process is an end, though Linux shows it as a link. Raises OSError
    for a loop of links, and for what can be neither replaced nor written into: a folder, a block
    device, a socket.
    """
    end = path
    for _ in range(_MOST_LINKS):
        end = Path(os.path.realpath(end.parent), end.name)
        if descriptor_number(end) is not None:
            return end
        if not end.is_symlink():
            if refused := _REFUSED.get(_kind(end)):
                code, what = refused
                raise OSError(code, f"is {what}, expected a file to write", str(path))
            return end
        end = end.parent / end.readlink()
    raise OSError(errno.ELOOP, "is a loop of links, expected a file to write", str(path))


def is_stream(path: Path) -> bool:
    """Whether bytes go into what is there, which nothing can replace; raises OSError."""
    end = destination(path)
    return descriptor_number(end) is not None or _kind(path) in _STREAMS


def is_standard_output(path: Path) -> bool:
    """Whether bytes written to a path come out where `print` prints."""
    try:
        return descriptor_number(destination(path)) == 1
    except OSError:
        return False


def same_file(a: Path, b: Path) -> bool:
    """Whether both lead to one file that is there, by links of either kind or other spellings."""
    return a.exists() and b.exists() and a.samefile(b)


def descriptor_number(end: Path) -> int | None:
    """Of an open descriptor of this process by its path without links, else None."""
    if end == STANDARD_OUTPUT:
        return 1
    folders = ("/dev/fd", f"/proc/{os.getpid()}/fd")
    return int(end.name) if str(end.parent) in folders and end.name.isdecimal() else None


def _descriptor_to_write(path: Path) -> int | None:
    """A descriptor to write into and close, or None where a file is to be replaced."""
    if not is_stream(path):
        return None
    number = descriptor_number(destination(path))
    if number is not None:  # the same opening: opened anew, a file would be written from its start
        return os.dup(number)
    return os.open(path, os.O_WRONLY | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0))


def _kind(path: Path) -> int:
    """The type bits of what is there over links, 0 where nothing is."""
    try:
        return stat.S_IFMT(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return 0


@contextlib.contextmanager
def _replacing(end: Path) -> Iterator[IO[bytes]]:
    handle, name = tempfile.mkstemp(dir=end.parent, prefix=f".{end.name}.", suffix=".part")
    part = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        move_into_place(part, end)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _settle(part: Path, end: Path) -> None:
    """Permissions and owner of the file that is replaced, or of any that a person creates."""
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
            with contextlib.suppress(OSError):  # only root may give a file away
                os.chown(part, old.st_uid, old.st_gid)
    part.chmod(old.st_mode & 0o777)


def sync_folder(folder: Path) -> None:
    """See to it that a new name is on the disk, not the file's bytes alone."""
    if os.name != "posix":  # Windows does not open folders
        return
    with contextlib.suppress(OSError):  # some file systems know no such thing
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def free_name(path: Path, suffix: str = "") -> Path:
    """The first of NAME, NAME-2, NAME-3 … beside `path` (with `suffix`) that is not taken."""
    wanted = path.with_name(path.name + suffix)
    free, number = wanted, 2
    while os.path.lexists(free):
        free, number = wanted.with_name(f"{wanted.name}-{number}"), number + 1
    return free


def write_companions(companions: Mapping[str, bytes], folder: Path) -> None:
    """Put files into a folder, but those that are there.

    Raises TwistError where one has other bytes there, before any is written; OSError.
    """
    missing = {name: data for name, data in companions.items() if not (folder / name).exists()}
    for name in companions.keys() - missing.keys():
        if read_file(folder / name) != companions[name]:
            raise TwistError(
                f"{folder / name}: expected the file of that name that lies beside the clip, "
                "without which it means another motion"
            )
    for name, data in missing.items():
        write_atomically(folder / name, data)
