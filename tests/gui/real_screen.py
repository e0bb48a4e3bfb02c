"""A screen of its own with a window manager, and a person's mouse, keys and eyes for it.

The program is started as a person starts it: fresh settings, the look of the screen, no test's
hand on its focus. Mouse and keys go through the X server (XTEST); what is on the screen is read
from the X server's own memory; where a widget is and what the review says can be asked.
"""

import contextlib
import json
import os
import queue
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from checkout.screens import virtual_screen
from checkout.system_packages import TEST_PROGRAMS
from tests.gui import forked
from tests.gui.forked import Forked
from tests.gui.looks import Look

needs_real_screen = pytest.mark.skipif(
    not all(shutil.which(program) for program in TEST_PROGRAMS),
    reason=f"needs {', '.join(TEST_PROGRAMS)}",
)
# Another checkout's program can be tried by these tests: to see one fail on what it is to find.
_OWN = Path(__file__).parents[2]
ROOT = Path(os.environ.get("TWIST_INSPECTOR_TRIED") or _OWN)
_WATCHED = Path(__file__).with_name("watched_program.py")
_MARK = "watched: "
_STEP = 0.05  # seconds between two looks
_XWD_FIELDS = 25  # of a header that a colour table and the picture follow
_PLAIN = Look()
_PATIENCE = 60.0  # seconds for anything on a machine with much to do: most need a second or two
FULL_HD = (1920, 1080)


@dataclass(frozen=True)
class RealScreen:
    """env: of programs on it; folder: where Xvfb keeps the picture; size: in pixels."""

    env: dict[str, str]
    folder: Path
    size: tuple[int, int] = FULL_HD
    look: Look = _PLAIN

    # -- eyes ---------------------------------------------------------------------------------

    def picture(self, part=None):
        """What is to be seen now, (height, width, bytes of a pixel); part: left, top, w, h."""
        data = (self.folder / "Xvfb_screen0").read_bytes()
        header = np.frombuffer(data, ">u4", _XWD_FIELDS).tolist()
        size, height, line, colours = header[0], header[5], header[12], header[19]
        pixels = np.frombuffer(data, np.uint8, height * line, size + 12 * colours)
        whole = pixels.reshape(height, -1, 4)[..., :3]
        if part is None:
            return whole
        left, top, wide, high = part
        return whole[max(top, 0) : top + high, max(left, 0) : left + wide]

    def steady_picture(self, part=None):
        """The picture once it has not changed for a while."""
        seen, since = self.picture(part), time.monotonic()
        while time.monotonic() - since < 6 * _STEP:
            time.sleep(_STEP)
            now = self.picture(part)
            if (now != seen).any():
                seen, since = now, time.monotonic()
        return seen

    def save(self, path, part=None):
        """Keep what is to be seen as a PNG, to be looked at."""
        from PySide6.QtGui import QImage

        bgr = self.steady_picture(part)
        rgb = np.ascontiguousarray(bgr[..., ::-1])
        height, width, _ = rgb.shape
        QImage(rgb.data, width, height, 3 * width, QImage.Format.Format_RGB888).save(str(path))

    def status_bar(self):
        """The picture's part with the active window's lowest line.

        A title bar higher, as xdotool counts it twice.
        """
        words = self.use("getactivewindow", "getwindowgeometry", "--shell")
        at = dict(word.split("=") for word in words if "=" in word)
        left, top = int(at["X"]), int(at["Y"])
        bottom = top + int(at["HEIGHT"])
        return self.picture()[bottom - 50 : bottom, left : left + int(at["WIDTH"]) // 2]

    # -- hands --------------------------------------------------------------------------------

    def use(self, *words):
        """Move the mouse, click, press keys: what xdotool knows."""
        return self._asked(*words, check=True).stdout.split()

    def key(self, *keys):
        """Press keys one after the other, once a window has them: 'n', 'ctrl+z', 'Escape'."""
        wait_until(self.active)
        self.use("key", "--delay", 30, *keys)

    def type(self, text):
        """Write a text, once a window has the keys."""
        wait_until(self.active)
        self.use("type", "--delay", 20, text)

    def park(self):
        """The pointer in the lower right corner, where it lights nothing."""
        self.use("mousemove", self.size[0] - 1, self.size[1] - 1)

    def click(self, part, button=1, times=1):
        """Click in the middle of a rectangle, or at a point (x, y)."""
        self.use("mousemove", *middle(part), "click", "--repeat", times, "--delay", 60, button)

    def wheel(self, part, clicks):
        """Turn the wheel over a rectangle, away (+) or towards the person (−)."""
        button = 4 if clicks > 0 else 5
        self.use(
            "mousemove", *middle(part), "click", "--repeat", abs(clicks), "--delay", 30, button
        )

    def drag(self, start, end, button=1, steps=8, held=lambda: None):
        """Drag from one point to another, on the way at some between.

        held: done before the button is let go.
        """
        (x, y), (u, v) = middle(start), middle(end)
        words = ["mousemove", x, y, "mousedown", button]
        for k in range(1, steps + 1):
            words += ["mousemove", x + (u - x) * k // steps, y + (v - y) * k // steps]
            words += ["sleep", 0.02]
        self.use(*words)
        held()
        self.use("mouseup", button)

    # -- windows ------------------------------------------------------------------------------

    def windows(self, title):
        """Numbers of the windows to be seen with this in their title."""
        return self._asked("search", "--onlyvisible", "--name", title).stdout.split()

    def active(self):
        """The number of the window that gets the keys; None while none does."""
        done = self._asked("getactivewindow")
        return done.stdout.strip() if done.returncode == 0 else None

    def shown(self, title, seconds=_PATIENCE):
        """The window with this in its title, once it gets the keys."""
        try:
            wait_until(lambda: self.active() in self.windows(title), seconds)
        except AssertionError:
            told = f"{self.windows('')}, of which {self.active()} has the keys"
            raise AssertionError(f"no {title!r} with the keys; windows: {told}") from None
        return self.active()

    def managed(self):
        """Whether the window manager is there: until it is, its keys do nothing."""
        return self._asked("get_num_desktops").returncode == 0

    def _asked(self, *words, check=False):
        return subprocess.run(
            ["xdotool", *map(str, words)], env=self.env, check=check, capture_output=True, text=True
        )


def middle(part):
    """Of a rectangle (left, top, width, height); a point is its own."""
    if len(part) == 2:
        return tuple(part)
    left, top, width, height = part
    return left + width // 2, top + height // 2


def differing(a, b):
    """How many pixels differ, from a picture or a colour; all of them where the sizes do."""
    if a.shape != b.shape and b.ndim == a.ndim:
        return max(a.shape[0] * a.shape[1], b.shape[0] * b.shape[1])
    return int((a != b).any(axis=-1).sum())


@contextlib.contextmanager
def real_screen(folder, *, size=FULL_HD, look=_PLAIN):
    """Xvfb and openbox as long as it lasts, with the look's desktop and compositor."""
    options = ("-screen", "0", f"{size[0]}x{size[1]}x24", "-fbdir", str(folder))
    with contextlib.ExitStack() as stack:
        env = stack.enter_context(virtual_screen(*options))
        screen = RealScreen({**env, **look.desktop_env(folder)}, folder, size, look)
        stack.enter_context(_beside(["openbox"], env))
        wait_until(screen.managed)
        if look.compositor:
            stack.enter_context(_beside(["xcompmgr", "-n"], env))
        yield screen


@contextlib.contextmanager
def _beside(words, env):
    process = subprocess.Popen(words, env=env, stderr=subprocess.DEVNULL)
    try:
        yield
        assert process.poll() is None, f"{words[0]} ended before the test did"
    finally:
        process.kill()
        process.wait()


def person_env(env, folder):
    """Of a program whose settings and journals are in the folder: a new user's."""
    return {
        **env,
        "PYTHONPATH": str(ROOT),
        "PYTHONFAULTHANDLER": "1",  # a crash, or SIGABRT, says where every thread stands
        "TWIST_INSPECTOR_SETTINGS": str(folder / "settings.json"),
        "XDG_STATE_HOME": str(folder / "state"),
        "XDG_DOCUMENTS_DIR": str(folder / "documents"),
    }


@contextlib.contextmanager
def program(env, folder, *words):
    """The program as a person starts it, its settings in the folder; killed if it is left over."""
    process = subprocess.Popen(
        [sys.executable, "-m", "inspector", *map(str, words)],
        env=person_env(env, folder),
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@dataclass
class WatchedProgram:
    """The program, started as by a person, that can be asked what it shows."""

    screen: RealScreen
    process: Forked | subprocess.Popen
    said: list[str] = field(default_factory=list)  # what it wrote by itself
    _answers: queue.Queue = field(default_factory=queue.Queue)

    def ask(self, expression, seconds=_PATIENCE):
        """The value of an expression over `window`, `app`, `rect`, `row`, `entry`.

        The program answers once it has done what keys and clicks before have asked for.
        """
        self.process.stdin.write(expression.replace("\n", " ") + "\n")
        self.process.stdin.flush()
        try:
            answer = json.loads(self._answers.get(timeout=seconds))
        except queue.Empty:
            raise AssertionError(f"no answer to {expression}; it said: {self.said}") from None
        assert "error" not in answer, f"{expression}: {answer['error']}"
        return answer["value"]

    def rect(self, widget):
        """Where a widget is on the screen, by its expression: left, top, width, height.

        What a key or click has just asked for is waited for: before it is shown it is nowhere.
        """
        self.until(f"({widget}).isVisible()")
        return self.ask(f"rect({widget})")

    def until(self, expression, seconds=_PATIENCE):
        """Wait until an expression is true; its value."""
        end = time.monotonic() + seconds
        while not (value := self.ask(expression)):
            assert time.monotonic() < end, f"it did not come to {expression}"
            time.sleep(_STEP)
        return value

    def drag(self, start, end, steps=8):
        """Drag what moves a moment after the mouse, as a border between docks, and wait for it.

        Qt forgets where it was dragged to if the button is let go in that moment.
        """
        self.screen.drag(start, end, steps=steps, held=lambda: self.ask("None"))

    def press(self, *keys):
        """Press keys, each once what the one before has asked for is on the screen."""
        for key in keys:
            self.settle()
            self.screen.key(key)

    def settle(self):
        """Wait until the event loop is idle and the picture stands."""
        self.ask("None")
        self.screen.steady_picture()

    def decisions(self):
        """Of all intervals, in the review's order."""
        return self.ask("[j.decision.value for j in window.document.intervals]")

    def kill(self):
        """kill -9."""
        self.process.kill()
        self.process.wait()


@contextlib.contextmanager
def watched(screen, folder, *words, settings=None, scale=1):
    """The program on a screen, when its window has the keys; a clip among the words is open then.

    settings: what the file of settings says beside the screen's look; None: what it said before,
    or a new user's.
    """
    file, of_look = folder / "settings.json", screen.look.settings()
    if settings is not None or not file.exists():  # most tests count on the order of the chains
        file.write_text(json.dumps({"order": "chain"} | of_look | (settings or {})))
    env = person_env(screen.env, folder)
    if scale != 1:
        env["QT_SCALE_FACTOR"] = str(scale)
    process = _start([str(_WATCHED), *map(str, words)], env)
    seen = WatchedProgram(screen, process)
    reader = threading.Thread(target=_read, args=(seen,), daemon=True)
    reader.start()
    try:
        screen.shown("Twist Inspector$")
        seen.until("app.focusWindow() is not None")  # Qt has heard of it, too
        if any(str(word).lower().endswith((".bvh", ".json")) for word in words):
            seen.until("window.document.data is not None")
        seen.settle()
        desktop = seen.ask("app.styleHints().colorScheme() == Qt.ColorScheme.Dark")
        assert desktop == (screen.look.desktop == "dark"), "Qt does not see the desktop's theme"
        dark = seen.ask("app.palette().window().color().lightness() < 128")
        assert dark == screen.look.dark, "the program has another theme"
        yield seen
    finally:
        process.kill()
        process.wait()
        reader.join(5)
        with contextlib.suppress(BrokenPipeError):
            process.__exit__(None, None, None)


def _start(words, env):
    """Run `python WORDS`: forked off, unless it is another checkout that is tried."""
    if ROOT == _OWN:
        return forked.start(words, env, errors=subprocess.STDOUT)
    return subprocess.Popen(
        [sys.executable, *words],
        env=env | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(_OWN)])},
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        bufsize=1,
    )


def _read(seen):
    for line in seen.process.stdout:
        if line.startswith(_MARK):
            seen._answers.put(line[len(_MARK) :])
        else:
            seen.said.append(line.rstrip())


def wait_until(ready, seconds=_PATIENCE, meanwhile=lambda: None):
    """Until something is so; `meanwhile` is done every second."""
    end = time.monotonic() + seconds
    again = time.monotonic() + 1.0
    while not ready():
        assert time.monotonic() < end, "it did not happen in time"
        if time.monotonic() > again:
            again += 1.0
            meanwhile()
        time.sleep(_STEP)
