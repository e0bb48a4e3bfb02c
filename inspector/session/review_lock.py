"""The lock on a clip's review, so that only one window at a time can change the review.

The operating system locks the file, and releases the lock when the program that holds it ends. A
reused process id or an empty file after a crash therefore never locks the review forever. The text
in the file has the format of a QLockFile (process id, program, computer) and is shown to the user.
If it names another computer, the user is asked, because this computer may not see locks of other
computers.
"""

from __future__ import annotations

import os
import socket
import sys
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from inspector.language import tr
from twistcore.files.lock import lock_file
from twistcore.files.ordinary import check_regular_file

_NO_LINK = getattr(os, "O_NOFOLLOW", 0)  # a link might lead to another user's file


@dataclass(frozen=True)
class Holder:
    """The program that holds a lock, as written in the lock file.

    Attributes
    ----------
    process
        The process id, or 0 if unknown.
    program, computer
        Names, or '' if unknown.
    since
        The local time when the lock was taken.
    """

    process: int
    program: str
    computer: str
    since: datetime

    @property
    def here(self) -> bool:
        """Return True if the holder runs on this computer."""
        return self.computer in ("", socket.gethostname())

    def __str__(self) -> str:
        who = self.program or tr("a program")
        if self.process:
            who = tr("{program}, process {number}", program=who, number=self.process)
        where = tr("on this computer")
        if not self.here:
            where = tr("on the computer {name}", name=self.computer)
        since = self.since.strftime(tr("%d %B %H:%M"))
        return tr("{who}, {where}, since {since}", who=who, where=where, since=since)


class ReviewLock:
    """A lock file. It is not locked until :meth:`take` is called."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.holder: Holder | None = None  # the holder, if another program holds the lock
        self._handle: int | None = None

    def take(self) -> bool:
        """Try to lock the review. Returns False if another program holds the lock.

        Raises OSError if the file cannot be written.
        """
        self.holder = None
        while True:
            handle, writable = _open(self.path)
            try:
                held = not lock_file(handle)
                if not _same(self.path, handle):
                    continue  # the previous holder has just deleted the file
                found = _read(handle)
                if held or (found is not None and not found.here):
                    self.holder = found or Holder(0, "", "", _written(handle))
                    return False
                if not writable:  # the file belongs to another user's program, which has ended
                    self.path.unlink()
                    continue
                _write(handle)
                self._handle, handle = handle, -1
                return True
            finally:
                if handle >= 0:
                    os.close(handle)

    def is_free(self) -> bool:
        """Return True if no program holds the lock."""
        with suppress(OSError):
            if self.take():
                self.release()
                return True
        return False

    def take_over(self) -> bool:
        """Take the lock over from its holder, and return True if that succeeded.

        Raises OSError if the lock file cannot be deleted, for example on Windows while the holder
        is running.
        """
        self.path.unlink(missing_ok=True)
        return self.take()

    def is_ours(self) -> bool:
        """Return True if this window still holds the lock.

        If the lock file was deleted, it is created again. If another window has taken the lock
        over, return False and set `holder`.
        """
        if self._handle is not None and _same(self.path, self._handle):
            return True
        self._let_go()
        with suppress(OSError):
            return self.take()
        return False

    def release(self) -> None:
        """Release the lock, and delete its file if this window holds it."""
        if self._handle is not None and _same(self.path, self._handle):
            if sys.platform == "win32":
                self._let_go()
            with suppress(OSError):
                self.path.unlink()
        self._let_go()

    def _let_go(self) -> None:
        if self._handle is not None:
            handle, self._handle = self._handle, None
            os.close(handle)


def _open(path: Path) -> tuple[int, bool]:
    """Open or create a lock file. Return its handle and whether it is writable. Raises OSError."""
    with suppress(FileNotFoundError):
        check_regular_file(path, path.lstat().st_mode)
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT | _NO_LINK, 0o666), True
    except PermissionError:
        if not path.exists():
            raise
        return os.open(path, os.O_RDONLY | _NO_LINK), False


def _same(path: Path, handle: int) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except OSError:
        return False


def _read(handle: int) -> Holder | None:
    """Return the holder that is written in a lock file, or None if the file does not name one."""
    os.lseek(handle, 0, os.SEEK_SET)
    lines = os.read(handle, 4096).decode("utf-8", "replace").splitlines()
    if len(lines) < 3 or not lines[0].strip().isdecimal():
        return None
    return Holder(int(lines[0]), lines[1].strip(), lines[2].strip(), _written(handle))


def _written(handle: int) -> datetime:
    return datetime.fromtimestamp(os.fstat(handle).st_mtime)


def _write(handle: int) -> None:
    with suppress(OSError):  # even if the disk is full, this program holds the lock
        os.lseek(handle, 0, os.SEEK_SET)
        os.ftruncate(handle, 0)
        os.write(handle, f"{os.getpid()}\nTwist Inspector\n{socket.gethostname()}\n".encode())
