"""The screen on which programs of a checkout run, either the real or a virtual one."""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import tempfile
from typing import TYPE_CHECKING

from checkout.starting import SetupError
from inspector.system_libraries import has_screen

if TYPE_CHECKING:
    from collections.abc import Iterator

QT_API = {"QT_API": "pyside6"}  # pyvistaqt uses QtPy, which may also find another Qt


@contextlib.contextmanager
def screen() -> Iterator[dict[str, str]]:
    """Yield the environment variables for a program with windows.

    If there is no real screen, the program runs on a virtual one.
    """
    if has_screen():
        yield os.environ | QT_API
        return
    with virtual_screen() as env:
        yield env


@contextlib.contextmanager
def virtual_screen(*options: str) -> Iterator[dict[str, str]]:
    """Start a virtual screen, and yield the environment variables for a program that uses it.

    `options` are additional options of Xvfb.
    """
    env = os.environ | QT_API
    reader, writer = os.pipe()
    command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1920x1080x24"]
    command += ["+extension", "GLX", "+render", "-noreset", *options]
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as scratch:
        # In a new session, because Ctrl+C must not stop the screen before the program.
        server = subprocess.Popen(
            command,
            pass_fds=[writer],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            os.close(writer)
            env |= {"DISPLAY": f":{read_line(reader, seconds=30)}", "QT_QPA_PLATFORM": "xcb"}
            env.setdefault("XDG_RUNTIME_DIR", scratch)  # Qt complains without one
            yield env
        finally:
            os.close(reader)
            server.terminate()
            server.wait()


def read_line(descriptor: int, seconds: float) -> str:
    """Return the line that Xvfb writes when it is ready: its display number.

    Raise SetupError if there is none after `seconds`.
    """
    line = b""
    while not line.endswith(b"\n"):
        ready, _, _ = select.select([descriptor], [], [], seconds)
        chunk = os.read(descriptor, 16) if ready else b""
        if not chunk:
            raise SetupError(
                "The virtual screen (Xvfb) did not start. Run Xvfb yourself to see the error."
            )
        line += chunk
    return line.decode().strip()
