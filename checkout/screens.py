"""Screens that programs of a checkout run on: the real one, or a virtual one of their own."""

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

QT_API = {"QT_API": "pyside6"}  # QtPy, under pyvistaqt, may see another Qt as well


@contextlib.contextmanager
def screen() -> Iterator[dict[str, str]]:
    """The environment for a program with windows; a virtual screen where there is no real one."""
    if has_screen():
        yield os.environ | QT_API
        return
    with virtual_screen() as env:
        yield env


@contextlib.contextmanager
def virtual_screen(*options: str) -> Iterator[dict[str, str]]:
    """The environment for a program on a virtual screen of its own; options: of Xvfb."""
    env = os.environ | QT_API
    reader, writer = os.pipe()
    command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1920x1080x24"]
    command += ["+extension", "GLX", "+render", "-noreset", *options]
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as scratch:
        # A session of its own, so that Ctrl+C does not take the screen from under the program.
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
    """The number that Xvfb writes once it is ready."""
    line = b""
    while not line.endswith(b"\n"):
        ready, _, _ = select.select([descriptor], [], [], seconds)
        chunk = os.read(descriptor, 16) if ready else b""
        if not chunk:
            raise SetupError(
                "The virtual screen (Xvfb) did not start; run Xvfb by hand to see why."
            )
        line += chunk
    return line.decode().strip()
