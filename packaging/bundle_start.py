"""The start of both programs of a bundle, and of the processes that they start.

A bundle has no Python interpreter, and `sys.executable` is the program itself. When the program
starts it with the arguments `-m MODULE` or `-c CODE`, this module runs the module or the code.
"""

import multiprocessing
import os
import runpy
import sys
from pathlib import Path


def main() -> int:
    """Run the program, or the module or code in the arguments. Return the exit status."""
    multiprocessing.freeze_support()  # in a spawned process, this call never returns
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
