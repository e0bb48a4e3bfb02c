"""The program in a process of its own: however it is started, it ends, and soon."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtGui import QImage

from inspector.session.opening import analyse_file
from inspector.session.settings import Settings
from inspector.window.demo import screenshot_script
from tests.conftest import ASSETS
from tests.gui import forked
from tests.gui.real_screen import (
    ROOT,
    needs_real_screen,
    person_env,
    program,
    real_screen,
    wait_until,
)
from twistcore.review import write_session

SOON = 2.5  # seconds of processor time; a long clip takes 5 and more to open
PATIENCE = 240.0  # seconds of the clock, on a machine with much to do
INJECTED = ASSETS / "walk_injected.bvh"


def run(folder, *words):
    """Exit status and what was said, forked off: other tests start the program from nothing."""
    words = ["-m", "inspector", *words]
    return forked.run(words, person_env(os.environ, folder), errors=subprocess.STDOUT)


def write_session_of(path):
    data = analyse_file(path)
    session = path.with_name(f"{path.stem}.twist.json")
    write_session(data.clip, data.review.state, session)
    return session


def long_clip(path, frames=100_000):
    """The walk again and again."""
    head, _, rows = INJECTED.read_text().rstrip().partition("Frame Time:")
    step, *lines = rows.splitlines()
    head = re.sub(r"Frames:.*", f"Frames: {frames}", head)
    rounds, rest = divmod(frames, len(lines))
    every = "\n".join(lines) + "\n"
    path.write_text(f"{head}Frame Time:{step}\n{every * rounds}" + "\n".join(lines[:rest]) + "\n")
    return path


@pytest.mark.thorough
def test_a_picture_of_the_empty_window(tmp_path):
    code, said = run(tmp_path, "--screenshot", tmp_path / "window.png")
    assert (code, said) == (0, "")
    assert (tmp_path / "window.png").stat().st_size > 10_000


@pytest.mark.thorough
def test_without_a_clip_the_sample_is_demonstrated_again_and_again(tmp_path):
    out = tmp_path / "out"
    for folder in (out, os.path.relpath(out, ROOT)):  # from where the program is started
        code, said = run(tmp_path, "--demo", folder)
        assert code == 0, said
        assert said.startswith("walk_injected_refined.bvh was written: ")
    assert (tmp_path / "out" / "walk_injected_refined.bvh").exists()
    assert (tmp_path / "out" / "inspector.png").exists()


@pytest.mark.thorough
def test_a_picture_of_a_session(tmp_path):
    session = write_session_of(shutil.copy(INJECTED, tmp_path / "mine.bvh"))
    code, said = run(tmp_path, session, "--screenshot", tmp_path / "window.png")
    assert (code, said) == (0, "")


@pytest.mark.thorough
@pytest.mark.parametrize("what", ["missing.bvh", "missing.json", "empty", "broken", "lost"])
def test_what_cannot_be_opened_ends_in_a_sentence(tmp_path, what):
    path = tmp_path / what
    if what in ("empty", "broken"):
        path.mkdir()
    if what == "broken":
        (path / "no.bvh").write_text("no")
    if what == "lost":
        clip = shutil.copy(INJECTED, tmp_path / "lost.bvh")
        path = write_session_of(clip)
        clip.unlink()
    code, said = run(tmp_path, path, "--screenshot", tmp_path / "window.png")
    assert code == 2
    assert len(said.splitlines()) == 1
    assert what.partition(".")[0] in said
    assert not (tmp_path / "window.png").exists()


def test_a_picture_that_cannot_be_written_ends_in_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    code, said = run(tmp_path, "--screenshot", tmp_path / "file" / "window.png")
    assert code == 2
    assert len(said.splitlines()) == 1


@pytest.mark.thorough
def test_a_dialog_that_nobody_answers_ends_it(qtbot, show_window, tmp_path, capsys):
    window = show_window()
    clip = Path(shutil.copy(INJECTED, tmp_path))
    script = screenshot_script(window, tmp_path / "window.png", clip)
    QTimer.singleShot(0, window, window.actions_by_id["show_about"].trigger)
    qtbot.waitUntil(lambda: not window.isVisible())
    assert script.code == 2
    assert capsys.readouterr().out


@pytest.mark.thorough
def test_a_picture_waits_until_the_camera_has_come_to_rest(qtbot, show_window, tmp_path):
    pictures = []
    for turn_ms in (0, 1500):
        window = show_window(Settings(turn_ms=turn_ms))
        path = tmp_path / f"{turn_ms}.png"
        screenshot_script(window, path, Path(shutil.copy(INJECTED, tmp_path)))
        qtbot.waitUntil(lambda w=window: not w.isVisible(), timeout=20_000)
        pictures.append(QImage(str(path)))
    assert not pictures[0].isNull()
    assert pictures[0] == pictures[1]


def _processor_time(process=None):
    """Seconds of all processes that have ended, and of one that has not."""
    times, own = os.times(), 0.0
    if process is not None:
        ticks = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
        own = sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")
    return times.children_user + times.children_system + own


def close_by_key(screen, process):
    """Processor time from Alt+F4 to the end. A key that got lost on its way is pressed once more.

    A program that does not end says where each of its threads stands.
    """
    begun = _processor_time(process)
    for _ in range(2):
        screen.use("key", "alt+F4")
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.communicate(timeout=PATIENCE)
            return _processor_time() - begun
    process.send_signal(signal.SIGABRT)
    pytest.fail("it does not end:\n" + process.communicate()[0])


@pytest.mark.thorough
@needs_real_screen
@pytest.mark.parametrize("share_seen", [False, True], ids=["reading", "analysing"])
def test_closing_the_window_ends_what_is_being_opened(tmp_path, share_seen):
    clip = long_clip(tmp_path / "long.bvh")
    with real_screen(tmp_path) as screen, program(screen.env, tmp_path, clip) as process:
        screen.shown("^Twist Inspector$")
        if share_seen:
            screen.steady_picture()  # it says what is being opened, not yet how far
            told = screen.status_bar()
            wait_until(lambda: (screen.status_bar() != told).any())
        assert not screen.windows("^long.bvh"), "it is open already"
        assert close_by_key(screen, process) < SOON
        assert process.returncode == 0


@pytest.mark.thorough
@needs_real_screen
@pytest.mark.parametrize(
    "number", [signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)]
)
def test_a_signal_ends_it_while_it_asks(tmp_path, number):
    """Decisions that are not saved, nor by themselves, wait in the journal."""
    clip = shutil.copy(INJECTED, tmp_path / "mine.bvh")
    (tmp_path / "settings.json").write_text('{"autosave": false}')
    with real_screen(tmp_path) as screen, program(screen.env, tmp_path, clip) as process:
        window = screen.shown("^mine.bvh")
        journal = tmp_path / "mine.twist.json.journal"
        wait_until(journal.exists, meanwhile=lambda: screen.use("key", "n", "key", "a"))
        screen.use("key", "alt+F4")
        wait_until(lambda: screen.active() not in (window, None))
        begun = _processor_time(process)
        process.send_signal(number)
        process.communicate(timeout=PATIENCE)
        assert _processor_time() - begun < SOON
        assert process.returncode == 128 + number
        assert journal.exists()


@pytest.mark.thorough
def test_garbage_dies_in_the_gui_thread_between_events(tmp_path):
    """In a worker's thread, or inside a call of Qt's, its death would crash the program."""
    code = (
        "import sys, threading\n"
        "from PySide6.QtCore import QTimer\n"
        "from inspector.app import make_application\n"
        "died = set()\n"
        "class Knot:\n"
        "    def __init__(self): self.me = self\n"
        "    def __del__(self):\n"
        "        caller = sys._getframe(1).f_code.co_name\n"
        "        died.add((threading.current_thread().name, caller))\n"
        "app = make_application()\n"
        "def work():\n"
        "    knots = [Knot() for _ in range(100_000)]\n"
        "threading.Thread(target=work).start()\n"
        "QTimer.singleShot(3000, app.quit)\n"
        "app.exec()\n"
        "print(died)\n"
    )
    env = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(
        [sys.executable, "-c", code], env=env, capture_output=True, text=True, check=False
    )
    assert done.stdout.strip() == "{('MainThread', 'collect_due_garbage')}", done.stderr


@pytest.mark.parametrize("left", [True, False])
def test_pyside_reads_no_source_of_what_is_imported(left):
    code = (
        "import inspect, sys\n"
        "from inspector.unread_sources import disable_pyside_source_reading\n"
        f"if {left}: disable_pyside_source_reading()\n"
        "read, getsource = [], inspect.getsource\n"
        "inspect.getsource = lambda module: read.append(module) or getsource(module)\n"
        "import PySide6.QtWidgets, xml.dom.minidom\n"
        "print(len(read))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (int(done.stdout) == 0) == left
