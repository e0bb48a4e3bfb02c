"""What other processes do in tests; in a module of its own, which loads nothing."""

import os
import signal
import time
from pathlib import Path

from twistcore.errors import BvhError

KILL = getattr(signal, "SIGKILL", signal.SIGTERM)


def work(name):
    """As its name says."""
    if name.startswith("dies"):
        time.sleep(0.2)  # so that others are under way
        os.kill(os.getpid(), KILL)
    if name.startswith("hangs"):
        time.sleep(600.0)
    while name.startswith("spins"):
        pass
    if name.startswith("slow"):
        time.sleep(1.0)
    if name == "memory":
        raise MemoryError
    if name == "bvh":
        raise BvhError("x.bvh", "expected OFFSET", line=2)
    if name == "defect":
        raise ZeroDivisionError("of\nours")
    return name.upper()


def dies_once(name):
    if not Path(name).exists():
        Path(name).touch()
        os.kill(os.getpid(), KILL)
    return "well"


def prints(name):
    print(name, flush=True)
    return 1


def unsendable(name):
    class DefectError(Exception):
        pass

    raise DefectError(name)
