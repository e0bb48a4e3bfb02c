"""Processes that a test has started, seen from outside (Linux)."""

import contextlib
import time
from pathlib import Path


def until(condition, seconds=60.0, every_s=0.02):
    """Wait until a condition holds, asked so often; what it gave."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, f"it took more than {seconds:.0f} s"
        time.sleep(every_s)
    return found


def children_of(pid):
    """The numbers of all processes below one."""
    found, below = set(), [pid]
    while below:
        with contextlib.suppress(OSError):
            for task in Path(f"/proc/{below.pop()}/task").iterdir():
                more = set(map(int, (task / "children").read_text().split())) - found
                found |= more
                below += more
    return found


def is_alive(pid):
    """Whether a process has not ended, whoever is to hear of it."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"
