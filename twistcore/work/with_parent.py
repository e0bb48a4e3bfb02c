"""Processes that end with the one that started them, however that ended: by kill -9, too."""

from __future__ import annotations

import os
import runpy
import sys
import threading
import time
from collections.abc import Sequence

_LOOK_S = 0.5  # between looks whether the parent is still there


def end_with_parent(parent: int) -> None:
    """Let this process end, in the midst of its work, once `parent` is not its parent any more.

    Within a second, unless a single call out of Python takes longer. Nothing happens on Windows,
    where nobody inherits a process: there it ends when it next looks for work.
    """
    if os.name == "posix":
        threading.Thread(target=_watch, args=(parent,), name="parent", daemon=True).start()


def python_bound(module: str, *words: str) -> list[str]:
    """A command that runs `python -m MODULE WORDS`, and ends with this process."""
    program = f"from twistcore.work.with_parent import become; become({module!r}, {os.getpid()})"
    return [sys.executable, "-c", program, *words]


def become(module: str, parent: int) -> None:
    """Be `python -m MODULE` with the words of this process, for as long as there is `parent`."""
    end_with_parent(parent)
    runpy.run_module(module, run_name="__main__", alter_sys=True)


def bound(command: Sequence[str]) -> list[str]:
    """A command of another program that ends with the thread that starts it (Linux).

    Elsewhere the command itself.
    """
    if sys.platform != "linux":
        return list(command)
    return [sys.executable, "-I", "-c", _BOUND, str(os.getpid()), *command]


# PR_SET_PDEATHSIG, which outlives the exec; whose parent was gone before is not begun.
_BOUND = (
    "import ctypes, os, sys; ctypes.CDLL(None).prctl(1, 9); "
    "os.getppid() == int(sys.argv[1]) and os.execv(sys.argv[2], sys.argv[2:])"
)


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOK_S)
    os._exit(1)
