"""The whole window, or a document and a 3D view of it; nothing left beside the clips."""

import gc
import inspect
import itertools
import shutil
import threading
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from inspector.folder.queue import FolderQueue
from inspector.session import opening
from inspector.session.document import Document
from inspector.session.opening import analyse_file
from inspector.session.settings import Settings
from inspector.viewport.viewport import Viewport
from inspector.widgets.fonts import use_shipped_fonts
from inspector.widgets.theme import DARK, Colours
from inspector.window.main_window import MainWindow
from tests.conftest import ASSETS
from tests.gui.browser import Browser
from tests.gui.kept_window import KeptWindow
from tests.gui.looks import looks_of
from tests.gui.pictures import FRAME, INJECTED, WALK, reject_all, settle
from tests.gui.programs import Program, ProgramHere
from tests.gui.real_screen import real_screen
from tests.gui.windows import act, close_window, open_clip, wait_until_active
from twistcore.analysis.clip_analysis import analyse
from twistcore.files.marks import cached_sha256
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rig import AS_FOUND
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle

_PATIENCE_MS = 60_000  # on a machine with much to do


def pytest_collection_finish() -> None:
    """From now on garbage is collected between two tests, as the program does between events."""
    gc.collect()
    gc.freeze()
    gc.disable()


_ran = itertools.count(1)


def pytest_runtest_logfinish() -> None:
    """What tests leave dies in this thread, between two of them; it takes 0.1 s, so not always."""
    if next(_ran) % 4 == 0:
        gc.collect()


def pytest_generate_tests(metafunc):
    """Give a test by hand the look, or looks, it runs in; one for all that share a program."""
    if "look" in metafunc.fixturenames:
        test = "" if "one_program" in metafunc.fixturenames else metafunc.function.__name__
        looks = looks_of(metafunc.module, test)
        metafunc.parametrize("look", looks, ids=str, scope="module")


@pytest.fixture(scope="session")
def qapp(qapp):
    """The application in the shipped fonts: sizes are the same, whatever a machine has."""
    use_shipped_fonts()
    return qapp


class PatientQtBot(QtBot):
    """Waits for a condition as long as a busy machine may need: what a test says is the least."""

    def waitUntil(self, callback, *, timeout=0):  # noqa: N802 - pytest-qt's name
        """Until the callback is true, or asserts nothing."""
        super().waitUntil(callback, timeout=max(timeout, _PATIENCE_MS))

    def waitSignal(self, signal, *, timeout=0, **how):  # noqa: N802 - and this
        """Until a signal has come."""
        return super().waitSignal(signal, timeout=max(timeout, _PATIENCE_MS), **how)


@pytest.fixture
def qtbot(qapp, request):
    """pytest-qt's, with patience."""
    return PatientQtBot(request)


@pytest.fixture
def queue(qtbot):
    """Clips of a folder, without a window."""
    queue = FolderQueue(workers=2)
    yield queue
    queue.close()
    queue.deleteLater()
    qtbot.wait(20)


@pytest.fixture(autouse=True)
def nothing_left_over(tmp_path, monkeypatch):
    """No window on the screen, no thread of ours, no journal beside the samples."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("XDG_DOCUMENTS_DIR", str(tmp_path / "documents"))
    monkeypatch.setenv("TWIST_INSPECTOR_SETTINGS", str(tmp_path / "config" / "settings.json"))
    threads = set(threading.enumerate())
    yield
    for pattern in ("*.journal*", "*.twist.json*", "*.replay.json"):
        for path in ASSETS.glob(pattern):
            path.unlink()
    started = [
        t.name for t in set(threading.enumerate()) - threads if not t.name.startswith("Dummy")
    ]
    assert started == []
    if app := QApplication.instance():
        shown = [w for w in app.topLevelWidgets() if w.isVisible()]
        assert [(w, w.toolTip(), getattr(w, "text", str)()) for w in shown] == []


@pytest.fixture(autouse=True, scope="module")
def no_view_outlives_its_window():
    """VTK's render windows: as many behind a module's tests as before, but for the last one."""
    before = _render_windows()
    yield
    if app := QApplication.instance():
        app.processEvents()
    assert _render_windows() <= before + 1


@pytest.fixture(autouse=True)
def chain_by_chain(monkeypatch):
    """Intervals in the order of the chains, on which most tests count; a new user's: the worst.

    The errors of a group are shown no longer than it takes to paint them.
    """
    names = list(inspect.signature(Settings.__init__).parameters)[1:]
    defaults = list(Settings.__init__.__defaults__)
    defaults[names.index("order")] = "chain"
    defaults[names.index("look_ms")] = 0
    monkeypatch.setattr(Settings.__init__, "__defaults__", tuple(defaults))


@pytest.fixture(autouse=True)
def known_samples(monkeypatch):
    """A sample is examined once in a module, however often tests open it or copies of it."""
    monkeypatch.setattr(opening, "core", SimpleNamespace(analyse=_analyse_once))


@pytest.fixture(scope="module")
def analysed():
    """The sample walk, for tests that do not edit its review."""
    return analyse_file(WALK)


@pytest.fixture
def open_document(qapp, tmp_path):
    """Opens a copy of a clip: its review is not kept."""
    shown = []

    def show(path):
        document = Document()
        document.show_clip(analyse_file(Path(shutil.copy(path, tmp_path))))
        shown.append(document)
        return document

    yield show
    for document in shown:
        document.close_clip()
        document.deleteLater()


@pytest.fixture
def document(open_document):
    """The walk at a frame in the middle, the left forearm selected, nothing to correct."""
    document = open_document(WALK)
    reject_all(document)
    document.select_chain("LeftForeArm")
    document.go_to(FRAME)
    return document


@pytest.fixture
def show_view(qtbot):
    """Opens the view of a document; closes it again."""
    opened = []

    def show(document, theme=DARK, size=(640, 480)):
        view = Viewport(document, Colours(theme))
        view.resize(*size)
        view.show()
        assert QTest.qWaitForWindowExposed(view, 60_000)
        opened.append(view)
        settle(qtbot, view)
        return view

    yield show
    for view in opened:
        view.close()
        view.deleteLater()
    qtbot.wait(10)


@pytest.fixture
def show_window(qtbot):
    """Opens the program's window; closes it again."""
    shown = []

    def show(settings=None, settings_file=None, size=None):
        window = MainWindow(settings or Settings(turn_ms=0), settings_file)
        if size is not None:
            window.resize(*size)
        window.show()
        wait_until_active(window)
        shown.append(window)
        return window

    yield show
    for window in shown:
        close_window(qtbot, window)
        window.deleteLater()
    qtbot.wait(20)


@pytest.fixture
def window(qtbot, show_window, tmp_path):
    """The program's window in front, nothing open."""
    window = show_window(settings_file=tmp_path / "settings" / "settings.json")
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    return window


@pytest.fixture(scope="module")
def kept():
    """The windows that the tests of a module have in common: at most one."""
    kept = []
    yield kept
    for one in kept:
        one.close()


@pytest.fixture
def new_window(kept):
    """For a test that needs a window in which no other test was."""
    while kept:
        kept.pop().close()


@pytest.fixture
def window_for_clips(request, show_window, kept, tmp_path):
    """A window for a test that opens a clip: with `ONE_WINDOW` in the module always the same."""
    used = []

    def show(settings, size=None):
        if not getattr(request.module, "ONE_WINDOW", False):
            return show_window(settings, tmp_path / "config" / "settings.json", size)
        if not (kept and kept[0].fits(settings, size)):
            while kept:
                kept.pop().close()
            kept.append(KeptWindow(settings, size))
        used.append(kept[0])
        return kept[0].show()

    yield show
    for one in used:
        if one.window.isVisible():
            one.put_away()
        else:  # the test has closed it
            kept.remove(one)
            one.close()


@pytest.fixture
def opened(qtbot, window_for_clips):
    """The walk with eight errors in the window."""
    window = window_for_clips(Settings(turn_ms=0))
    open_clip(qtbot, window, INJECTED)
    return window


@pytest.fixture
def at_forearm(qtbot, window_for_clips, tmp_path):
    """A copy of that walk in a dark window, the left forearm selected, a frame in the middle."""
    window = window_for_clips(Settings(theme="dark", turn_ms=0))
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path / "mine.bvh"))
    window.document.select_chain("LeftForeArm")
    window.document.go_to(90)
    return window


@pytest.fixture
def taught(qtbot, at_forearm):
    """That window with the teaching tab shown and its formulas set."""
    act(at_forearm, "show_teaching")
    qtbot.waitUntil(lambda: at_forearm.teaching.typesetter.done, timeout=30_000)
    qtbot.wait(100)
    return at_forearm


@pytest.fixture
def clip(tmp_path):
    """A copy of the walk with eight errors in a folder of its own."""
    folder = tmp_path / "clips"
    folder.mkdir()
    return Path(shutil.copy(INJECTED, folder / "walk.bvh"))


@pytest.fixture
def lone_turn(tmp_path):
    """The walk with an upper arm that turns alone by 24° from frame 200 on."""
    clip = read_bvh(WALK)
    chain = next(c for c in find_chains(clip.motion) if c.name == "LeftArm")
    q = clip.motion.rotations.copy()
    turn = quaternion_from_axis_angle(chain.axis, np.radians(24.0))
    q[200:, chain.parent] = multiply(q[200:, chain.parent], turn)
    path = tmp_path / "lone" / "lone.bvh"
    path.parent.mkdir()
    write_clip(clip, replace(clip.motion, rotations=q), path)
    return path


@pytest.fixture
def start(tmp_path):
    """Starts the program on a clip, as a process; kills what is still there at the end."""
    started = []

    def run(clip):
        started.append(Program(clip, tmp_path / "state"))
        return started[-1]

    yield run
    for program in started:
        if program.process.poll() is None:
            program.kill()


@pytest.fixture
def start_here(qtbot, kept):
    """Starts the program on a clip as `start` does, but in this process, one at a time."""
    started = []

    def run(clip):
        started.append(ProgramHere(clip, kept))
        return started[-1]

    yield run
    for program in started:
        program.end()


_analyses = {}


@cache
def _samples():
    return {cached_sha256(path) for path in ASSETS.glob("*.bvh")}


def _analyse_once(clip, rig=AS_FOUND):
    if clip.sha256 not in _samples():
        return analyse(clip, rig=rig)
    key = clip.sha256, clip.name, rig
    if key not in _analyses:
        _analyses[key] = analyse(clip, rig=rig)
    return _analyses[key]


def _render_windows() -> int:
    gc.collect()
    return sum(isinstance(o, vtkRenderWindow) for o in gc.get_objects())


@pytest.fixture(scope="module")
def screen(tmp_path_factory, look):
    """A real screen for a test by hand."""
    with real_screen(tmp_path_factory.mktemp("screen"), size=(1440, 900), look=look) as shown:
        yield shown


@pytest.fixture(scope="module")
def started(tmp_path_factory):
    """One browser for all tests of a module."""
    browser = Browser(tmp_path_factory.mktemp("browser"))
    browser.size(1280, 900)
    yield browser
    browser.close()
