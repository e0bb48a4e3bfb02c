"""What both programs of a bundle start with: the one whose name was called, or a process of theirs.

A bundle has no Python beside it. What the programs start as processes of their own, which they ask
of `sys.executable` in Python's words, `-m MODULE` and `-c CODE`, is therefore answered here.
"""

import multiprocessing
import os
import runpy
import sys
from pathlib import Path


def main() -> int:
    """Run what was asked for; returns the exit code."""
    multiprocessing.freeze_support()  # a spawned process goes on in here and never returns
    words = sys.argv[1:]
    if words[:1] == ["-c"]:
        sys.argv = ["-c", *words[2:]]
        exec(words[1], {"__name__": "__main__"})
        return 0
    if words[:1] == ["-m"] and words[1].split(".")[0] in {"inspector", "twistcore"}:
        sys.argv = words[1:]
        runpy.run_module(words[1], run_name="__main__", alter_sys=True)
        return 0
    if Path(sys.executable).stem == "twistcore":
        from twistcore.cli import main as start
    else:
        from inspector.__main__ import main as start
    return start()


if __name__ == "__main__":
    if sys.stdout is None:  # a program without a console on Windows
        sys.stdout = sys.stderr = Path(os.devnull).open("w")  # noqa: SIM115 - as long as the program
    sys.exit(main())
