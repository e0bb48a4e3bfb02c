"""Limit the memory that a process may use for a clip, and measure its peak (Linux only)."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

SPARE = 1_500_000_000  # bytes allowed for Python and its libraries
OF_FILE = 12  # memory allowed for reading and analysing a file, as a multiple of its size

_OWN = Path("/proc/self")


@contextlib.contextmanager
def limited_memory(size: int, spare: int = SPARE) -> Iterator[None]:
    """Limit the memory of this process while it reads and analyses a file of `size` bytes.

    The limit is the current memory plus `spare` bytes plus OF_FILE times `size`. Beyond it, a
    MemoryError is raised before the machine begins to swap. The limit applies to the address space,
    which is larger than the memory in use. At the end of the block, the earlier limit is restored.
    On systems other than Linux, there is no limit.
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


def reset_peak_memory() -> None:
    """Reset the peak that :func:`peak_memory` returns, if the system supports this."""
    with contextlib.suppress(OSError):
        (_OWN / "clear_refs").write_text("5", encoding="ascii")


def peak_memory() -> int:
    """Return the peak memory in bytes since the start or the last reset, or 0 if unknown."""
    with contextlib.suppress(OSError, ValueError):
        for line in (_OWN / "status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return 0


def _pages(column: int) -> int:
    return int((_OWN / "statm").read_text(encoding="ascii").split()[column])
