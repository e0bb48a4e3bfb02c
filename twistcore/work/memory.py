"""Limit a process's memory for each clip, and measure its peak (Linux)."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

SPARE = 1_500_000_000  # bytes for Python and its libraries
OF_FILE = 12  # ratio of the memory for reading and analysing a file to its size

_OWN = Path("/proc/self")


@contextlib.contextmanager
def limited_memory(size: int, spare: int = SPARE) -> Iterator[None]:
    """Limit this process to its current memory plus `spare` and a multiple of a file's bytes.

    Beyond the limit, a MemoryError is raised before the machine begins to swap. The limit applies
    to the address space, which is larger than the memory really used. The earlier limit is restored
    afterwards, since other code may share the process. On systems other than Linux there is no
    limit.
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
    """Reset the value of :func:`peak_memory`, if the system can do this."""
    with contextlib.suppress(OSError):
        (_OWN / "clear_refs").write_text("5", encoding="ascii")


def peak_memory() -> int:
    """Return the most memory used since the start or the last reset, in bytes, or 0 if unknown."""
    with contextlib.suppress(OSError, ValueError):
        for line in (_OWN / "status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return 0


def _pages(column: int) -> int:
    return int((_OWN / "statm").read_text(encoding="ascii").split()[column])
