"""Compiled loops, once they pay: numba (extra `fast`) takes half a second to begin.

Until then, and wherever numba is missing or cannot work, the numpy code does the same to the bit,
two to five times slower. Nothing is imported before :func:`warm` or a lot of text needs it.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

import numpy as np

from twistcore import kernels

# What a process reads until the time lost to numpy equals that for importing numba and loading the
# compiled loops: having waited so long costs at most twice what the better choice would have.
BREAK_EVEN = 150_000_000  # bytes


@dataclass(frozen=True)
class Loops:
    """The compiled functions of :mod:`twistcore.kernels` and the scanner; all release the GIL."""

    scan: Any
    find_tokens: Any
    path_costs: Any
    path_back: Any
    compose: Any
    descend: Any


_lock = threading.Lock()
_loops: Loops | None = None
_tried = False
_read = 0


def loops() -> Loops | None:
    """The compiled loops if they are there already; costs nothing."""
    return _loops


def loops_for(size: int) -> Loops | None:
    """The same for this much text more, in bytes; begun now where enough was read before it.

    So a single large file never pays for numba in time or in memory.
    """
    global _read
    if _loops is None and not _tried and _read >= BREAK_EVEN:
        warm()
    _read += size
    return _loops


def warm() -> bool:
    """Import numba and load the compiled loops; whether they can be used from now on.

    Takes about 0.6 s and 110 MB, once a process, and some seconds more the first time after an
    installation.
    May be called from any thread, by whoever will read much: a window once it stands, workers.
    """
    global _loops, _tried
    with _lock:
        if not _tried:
            _loops = _compiled(cache=True) or _compiled(cache=False)
            _tried = True
    return _loops is not None


def _compiled(*, cache: bool) -> Loops | None:
    try:
        import numba

        if numba.config.DISABLE_JIT:
            return None
        from twistcore.scanning import scan

        jit = numba.njit(nogil=True, cache=cache)
        plain = {**vars(kernels), "scan": scan}
        found = Loops(**{name: jit(plain[name]) for name in Loops.__dataclass_fields__})
        _call_each(found)
    # Whatever goes wrong with it (an unwritable or damaged cache, a numba that is too old for this
    # Python), reading goes on: it is only slower.
    except Exception:
        return None
    return found


def _call_each(found: Loops) -> None:
    """Compile, or load from the cache, for the types that are used."""
    text = np.frombuffer(b"1 ", dtype=np.uint8)
    integers = np.zeros((1, 3), dtype=np.int64)
    one, some = np.ones(1), np.zeros((1, 1, 4))
    found.scan(text, np.ones(23), one.copy(), integers[0], integers)
    found.find_tokens(text, np.zeros(1, dtype=np.int64), integers)
    found.path_costs(np.zeros((4, 0)), one)
    found.path_back(np.zeros((2, 1), dtype=np.bool_), np.zeros(1, dtype=np.int64), 0)
    places = np.zeros((1, 3), dtype=np.int64)
    found.compose(one[:, None], one[:, None], places, places, some)
    found.descend(some, np.zeros((1, 1, 3)), np.full(1, -1))
