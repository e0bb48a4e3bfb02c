"""Make a process end with its parent, even if the parent was killed with kill -9."""

from __future__ import annotations

import os
import runpy
import sys
import threading
import time
from collections.abc import Sequence

_LOOK_S = 0.5  # seconds between two checks of the parent


def end_with_parent(parent: int) -> None:
    """End this process when the process `parent` ends, even in the middle of a computation.

    The process ends within a second, unless a single call outside Python takes longer. On Windows,
    where a process does not get a new parent, this function does nothing. There, the process ends
    when it next tries to read a request.
    """
    if os.name == "posix":
        threading.Thread(target=_watch, args=(parent,), name="parent", daemon=True).start()


def parent_bound_module_command(module: str, *words: str) -> list[str]:
    """Return a command that runs `python -m MODULE` and ends with this process.

    `words` are the arguments of the module.
    """
    program = (
        "from twistcore.work.with_parent import run_module_until_parent_exits; "
        f"run_module_until_parent_exits({module!r}, {os.getpid()})"
    )
    return [sys.executable, "-c", program, *words]


def run_module_until_parent_exits(module: str, parent: int) -> None:
    """Run `python -m MODULE` with the arguments of this process until process `parent` ends."""
    end_with_parent(parent)
    runpy.run_module(module, run_name="__main__", alter_sys=True)


def parent_bound_command(command: Sequence[str]) -> list[str]:
    """Return a command that runs `command` and, on Linux, is killed when the calling thread ends.

    On other systems, `command` is returned unchanged.
    """
    if sys.platform != "linux":
        return list(command)
    return [sys.executable, "-I", "-c", _BOUND, str(os.getpid()), *command]


# Set PR_SET_PDEATHSIG, which survives exec. If the parent has already ended, start nothing.
_BOUND = (
    "import ctypes, os, sys; ctypes.CDLL(None).prctl(1, 9); "
    "os.getppid() == int(sys.argv[1]) and os.execv(sys.argv[2], sys.argv[2:])"
)


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOK_S)
    os._exit(1)
