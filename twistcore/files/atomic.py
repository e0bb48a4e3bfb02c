"""Files that are either the old or the new, never half of one; what is no file is written into."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO

from twistcore.errors import TwistError
from twistcore.files.lock import is_sure, lock
from twistcore.files.ordinary import is_there, read_file

STANDARD_OUTPUT = Path("/dev/stdout")  # by this name also on systems that have no such file

_LONGEST_NAME, _SPARE = 255, 10  # bytes; spare: of a number in between
_TRIES = 8
_BINARY = getattr(os, "O_BINARY", 0)
_HELD_TO_THE_END = os.name == "posix"  # Windows moves no file that is open
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
    return is_there(a) and is_there(b) and a.samefile(b)


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


def part_name(end: Path, suffix: str = "") -> Path:
    """Where a file is written before it has its name: always there, so that a leftover is found.

    One of a name that would be too long has a part of it and a mark of the whole.
    """
    name, mark = end.name, f".twist.part{suffix}"
    if len(os.fsencode(name)) + len(mark) + _SPARE > _LONGEST_NAME:
        import hashlib  # slow to load; few names are so long

        name = f"{name[:20]}-{hashlib.sha256(os.fsencode(name)).hexdigest()[:16]}"
    return end.with_name(f".{name}{mark}")


def take_part(part: Path) -> tuple[int, Path]:
    """A new file to write into, under this name or one like it, and locked while it is written.

    What a killed program left under the name is removed: a file of ours that nobody holds. What
    else is there stays, and another name is taken. Raises OSError.
    """
    for _ in range(_TRIES):
        _remove_left(part)
        with contextlib.suppress(FileExistsError):
            handle = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL | _BINARY, 0o600)
            if lock(handle) and _is_at(part, handle):
                return handle, part
            os.close(handle)  # another took it for a leftover before it was locked
            continue
        break
    import tempfile  # slow to load; few files need another name

    handle, name = tempfile.mkstemp(dir=part.parent, prefix=f"{part.stem}.", suffix=part.suffix)
    lock(handle)
    return handle, Path(name)


@contextlib.contextmanager
def _replacing(end: Path) -> Iterator[IO[bytes]]:
    handle, part = take_part(part_name(end))
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
    """Remove what a killed program left there; never a link, another's, or what somebody holds."""
    try:
        status = part.lstat()
        if not stat.S_ISREG(status.st_mode) or status.st_nlink != 1 or not _is_mine(status):
            return
        handle = os.open(part, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | _BINARY)
    except OSError:
        return
    try:
        if is_sure(handle) and _is_at(part, handle):
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
    missing = {name: data for name, data in companions.items() if not is_there(folder / name)}
    for name in companions.keys() - missing.keys():
        if read_file(folder / name) != companions[name]:
            raise TwistError(
                f"{folder / name}: expected this file next to the clip, because the clip is a "
                "different motion without it"
            )
    for name, data in missing.items():
        write_atomically(folder / name, data)
