"""Lock open files with the operating system, which releases the locks when the program ends."""

from __future__ import annotations

import os
import sys
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_AT_ONCE = getattr(os, "O_NONBLOCK", 0)  # opening a FIFO would wait for its writer
_FAR = 1 << 40  # position of the byte to lock, beyond the data, since Windows locks bytes


def lock_file(handle: int) -> bool:
    """Lock an open file, given by its descriptor.

    Returns False if it is already locked through another open file. Returns True on a file system
    without locks.
    """
    try:
        _lock(handle)
    except BlockingIOError:
        return False
    except OSError:
        return sys.platform != "win32"
    return True


def lock_file_requiring_support(handle: int) -> bool:
    """Lock an open file. Return False if it is already locked, or if locks are not supported."""
    try:
        _lock(handle)
    except OSError:
        return False
    return True


def is_file_locked(path: Path) -> bool:
    """Return True if a running program has locked the file.

    Return False if the file cannot be opened.
    """
    try:
        handle = os.open(path, os.O_RDONLY | _AT_ONCE)
    except OSError:
        return False
    try:
        return not lock_file(handle)
    finally:
        os.close(handle)


def _lock(handle: int) -> None:
    if sys.platform == "win32":
        os.lseek(handle, _FAR, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
    else:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
