"""Programs that a checkout starts: unseen, in the foreground, with nothing left running."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
import sys
import threading
from pathlib import Path
from typing import IO, TYPE_CHECKING

from checkout import places

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from tests.gui.forked import Forked

# What pip and uv say where the index cannot be reached, or is not trusted.
CERTIFICATE = re.compile(r"certificate|SSLError|UnknownIssuer", re.IGNORECASE)
CONNECTION = re.compile(
    r"connection|network|resolv|\bdns\b|timed out|unreachable|no route",
    re.IGNORECASE,
)
# Of graphics drivers that look for hardware which a virtual screen has not, and go on without.
DRIVER_NOISE = re.compile(rb"libGL |libEGL |MESA|glx: |.*(ZINK|zink|failed to load driver)")


class SetupError(Exception):
    """Something a person has to mend; the text says what, in words."""


def say(text: str) -> None:
    """Tell the person; at once, also into a pipe."""
    print(text, flush=True)


def quietly(command: Sequence[str], env: dict[str, str] | None = None) -> str:
    """Run a command unseen. Empty if it succeeded, else the last lines that say why not."""
    try:
        done = subprocess.run(
            command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
        )
    except OSError as error:
        return f"  {error}"
    if done.returncode == 0:
        return ""
    lines = [line for line in done.stdout.decode(errors="replace").splitlines() if line.strip()]
    reasons = [line for line in lines if line.lstrip().startswith(("ERROR:", "E:"))]  # pip, apt
    # Why nothing could be fetched stands before them, once a trial; ERROR: says what is lacking.
    causes = [line for line in lines if CERTIFICATE.search(line) or CONNECTION.search(line)]
    told = [*(line for line in causes[-1:] if line not in reasons), *(reasons or lines)[-6:]]
    return "\n".join(f"  {line.strip()}" for line in told) or f"  exit status {done.returncode}"


RUNNING: set[subprocess.Popen[bytes] | Forked] = set()


def start(
    command: Sequence[str],
    env: dict[str, str],
    cwd: Path = places.ROOT,
    output: IO[bytes] | None = None,
    errors: int | None = None,
) -> int:
    """Run a command in the foreground, or into `output`, and return its exit status.

    Ctrl+C reaches the command itself, so the first is left to it; the second ends it.
    """
    errors = errors if output is None else subprocess.STDOUT
    return finish(subprocess.Popen(command, env=env, cwd=cwd, stdout=output, stderr=errors))


def finish(child: subprocess.Popen[bytes] | Forked) -> int:
    """Wait for what was started, and return its exit status."""
    RUNNING.add(child)
    interrupted = False
    try:
        while True:
            try:
                status = child.wait()
            except KeyboardInterrupt:
                if interrupted:
                    child.terminate()
                interrupted = True
            except SystemExit:  # we were told to end: so is the command
                child.terminate()
                child.wait()
                raise
            else:
                return status if status >= 0 else 128 - status
    finally:
        RUNNING.discard(child)


@contextlib.contextmanager
def without_driver_noise() -> Iterator[int]:
    """Where a program's errors go: on to ours, but for what drivers say of a virtual screen."""
    reader, writer = os.pipe()

    def pass_on() -> None:
        with os.fdopen(reader, "rb") as lines:
            for line in lines:
                if not DRIVER_NOISE.match(line):
                    print(line.decode(errors="replace"), end="", file=sys.stderr, flush=True)

    thread = threading.Thread(target=pass_on, daemon=True)
    thread.start()
    try:
        yield writer
    finally:
        os.close(writer)
        thread.join(5)  # no longer, where something that was left running holds the pipe
