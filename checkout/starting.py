"""Functions that start other programs and wait for them."""

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

# Messages of pip and uv if the index cannot be reached, or its certificate is not trusted.
CERTIFICATE = re.compile(r"certificate|SSLError|UnknownIssuer", re.IGNORECASE)
CONNECTION = re.compile(
    r"connection|network|resolv|\bdns\b|timed out|unreachable|no route",
    re.IGNORECASE,
)
# Harmless messages of graphics drivers that find no hardware on a virtual screen.
DRIVER_NOISE = re.compile(rb"libGL |libEGL |MESA|glx: |.*(ZINK|zink|failed to load driver)")


class SetupError(Exception):
    """The set-up failed. The error's text tells the user how to continue."""


def say(text: str) -> None:
    """Print a text and flush the output, so that it appears at once, even in a pipe."""
    print(text, flush=True)


def quietly(command: Sequence[str], env: dict[str, str] | None = None) -> str:
    """Run a command without showing its output.

    Return '' on success, or the last lines that explain the failure.
    """
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
    # The reason for a failed download precedes the lines with ERROR:, once per attempt.
    causes = [line for line in lines if CERTIFICATE.search(line) or CONNECTION.search(line)]
    shown = [*(line for line in causes[-1:] if line not in reasons), *(reasons or lines)[-6:]]
    return "\n".join(f"  {line.strip()}" for line in shown) or f"  exit status {done.returncode}"


RUNNING: set[subprocess.Popen[bytes] | Forked] = set()


def start(
    command: Sequence[str],
    env: dict[str, str],
    cwd: Path = places.ROOT,
    output: IO[bytes] | None = None,
    errors: int | None = None,
) -> int:
    """Run a command and return its exit status.

    The output goes to `output`, or to the terminal. The command itself receives Ctrl+C, so the
    first Ctrl+C has no effect here, but the second one terminates the command.
    """
    errors = errors if output is None else subprocess.STDOUT
    return finish(subprocess.Popen(command, env=env, cwd=cwd, stdout=output, stderr=errors))


def finish(child: subprocess.Popen[bytes] | Forked) -> int:
    """Wait for a started process and return its exit status."""
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
            except SystemExit:  # on SIGTERM, terminate the command, too
                child.terminate()
                child.wait()
                raise
            else:
                return status if status >= 0 else 128 - status
    finally:
        RUNNING.discard(child)


@contextlib.contextmanager
def without_driver_noise() -> Iterator[int]:
    """Yield a file descriptor for a program's errors.

    The errors are copied to standard error, without messages of graphics drivers about a virtual
    screen.
    """
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
        thread.join(5)  # limited, because a program that is still running may keep the pipe open
