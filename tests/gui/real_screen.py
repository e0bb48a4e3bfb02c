"""A screen of its own with a window manager, and a person's mouse, keys and eyes for it."""

import contextlib
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import dev

needs_real_screen = pytest.mark.skipif(
    not all(shutil.which(program) for program in dev.TEST_PROGRAMS),
    reason=f"needs {', '.join(dev.TEST_PROGRAMS)}",
)
ROOT = Path(__file__).parents[2]
_STEP = 0.05  # seconds between two looks
_XWD_FIELDS = 25  # of a header that a colour table and the picture follow


@dataclass(frozen=True)
class RealScreen:
    """env: of programs on it; folder: where Xvfb keeps the picture."""

    env: dict[str, str]
    folder: Path

    def picture(self):
        """What is to be seen now, (height, width, bytes of a pixel)."""
        data = (self.folder / "Xvfb_screen0").read_bytes()
        header = np.frombuffer(data, ">u4", _XWD_FIELDS).tolist()
        size, height, line, colours = header[0], header[5], header[12], header[19]
        pixels = np.frombuffer(data, np.uint8, height * line, size + 12 * colours)
        return pixels.reshape(height, -1, 4)[..., :3]

    def steady_picture(self):
        """The picture once it has not changed for a while."""
        seen, since = self.picture(), time.monotonic()
        while time.monotonic() - since < 6 * _STEP:
            time.sleep(_STEP)
            now = self.picture()
            if (now != seen).any():
                seen, since = now, time.monotonic()
        return seen

    def status_bar(self):
        """The picture's part with the active window's lowest line.

        A title bar higher, as xdotool counts it twice.
        """
        words = self.use("getactivewindow", "getwindowgeometry", "--shell")
        at = dict(word.split("=") for word in words if "=" in word)
        left, top = int(at["X"]), int(at["Y"])
        bottom = top + int(at["HEIGHT"])
        return self.picture()[bottom - 50 : bottom, left : left + int(at["WIDTH"]) // 2]

    def use(self, *words):
        """Move the mouse, click, press keys: what xdotool knows."""
        return self._asked(*words, check=True).stdout.split()

    def windows(self, title):
        """Numbers of the windows to be seen with this in their title."""
        return self._asked("search", "--onlyvisible", "--name", title).stdout.split()

    def active(self):
        """The number of the window that gets the keys; None while none does."""
        done = self._asked("getactivewindow")
        return done.stdout.strip() if done.returncode == 0 else None

    def shown(self, title):
        """The window with this in its title, once it gets the keys."""
        wait_until(lambda: self.active() in self.windows(title))
        return self.active()

    def managed(self):
        """Whether the window manager is there: until it is, its keys do nothing."""
        return self._asked("get_num_desktops").returncode == 0

    def _asked(self, *words, check=False):
        return subprocess.run(
            ["xdotool", *map(str, words)], env=self.env, check=check, capture_output=True, text=True
        )


@contextlib.contextmanager
def real_screen(folder):
    """Xvfb and openbox, without a compositor, as long as it lasts."""
    with dev.virtual_screen("-fbdir", str(folder)) as env:
        manager = subprocess.Popen(["openbox"], env=env, stderr=subprocess.DEVNULL)
        screen = RealScreen(env, folder)
        try:
            wait_until(screen.managed)
            yield screen
        finally:
            manager.kill()
            manager.wait()


@contextlib.contextmanager
def program(env, folder, *words):
    """The program as a person starts it, its settings in the folder; killed if it is left over."""
    own = {
        **env,
        "PYTHONPATH": str(ROOT),
        "PYTHONFAULTHANDLER": "1",  # a crash, or SIGABRT, says where every thread stands
        "TWIST_INSPECTOR_SETTINGS": str(folder / "settings.json"),
        "XDG_STATE_HOME": str(folder / "state"),
    }
    process = subprocess.Popen(
        [sys.executable, "-m", "inspector", *map(str, words)],
        env=own,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def wait_until(ready, seconds=20.0, meanwhile=lambda: None):
    """Until something is so; `meanwhile` is done every second."""
    end = time.monotonic() + seconds
    again = time.monotonic() + 1.0
    while not ready():
        assert time.monotonic() < end, "it did not happen in time"
        if time.monotonic() > again:
            again += 1.0
            meanwhile()
        time.sleep(_STEP)
