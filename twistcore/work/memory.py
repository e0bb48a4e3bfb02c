"""What memory a process may take for one clip after the other, and took for each (Linux)."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

SPARE = 1_500_000_000  # bytes for Python and its libraries
OF_FILE = 12  # times the file's size for reading and analysing it

_OWN = Path("/proc/self")


@contextlib.contextmanager
def limited_memory(size: int, spare: int = SPARE) -> Iterator[None]:
    """Let this process take `spare` and some times the bytes of a file more than it has by now.

    Past that there is a MemoryError instead of a machine that swaps. Of the address space, so that
    it is no measure of what is really used. The limit before comes back afterwards: this may be no
    process of its own. Nothing happens on other systems.
    """
    if sys.platform != "linux":
        yield
        return
    import resource

    limit = spare + OF_FILE * size + _pages(0) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def forget_peak() -> None:
    """Begin to count anew for :func:`peak_memory`, where the system can."""
    with contextlib.suppress(OSError):
        (_OWN / "clear_refs").write_text("5", encoding="ascii")


def peak_memory() -> int:
    """Most bytes that this process had in memory since it began or forgot; 0 if unknown."""
    with contextlib.suppress(OSError, ValueError):
        for line in (_OWN / "status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return 0


def _pages(column: int) -> int:
    return int((_OWN / "statm").read_text(encoding="ascii").split()[column])
