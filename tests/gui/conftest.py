"""A document and a 3D view of it in a real window; nothing left beside the clips."""

import gc
import shutil
import threading
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from inspector.analysed import analyse
from inspector.document import Document
from inspector.theme import DARK
from inspector.viewport import Viewport
from tests.conftest import ASSETS
from tests.gui.pictures import FRAME, WALK, settle
from twistcore.review import Decide, Decision


@pytest.fixture(autouse=True)
def nothing_left_over(tmp_path, monkeypatch):
    """No window on the screen, no thread of ours, no journal beside the samples."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    threads = set(threading.enumerate())
    yield
    for pattern in ("*.journal", "*.unanswered", "*.twist.json"):
        for path in ASSETS.glob(pattern):
            path.unlink()
    started = [
        t.name for t in set(threading.enumerate()) - threads if not t.name.startswith("Dummy")
    ]
    assert started == []
    if app := QApplication.instance():
        assert [w for w in app.topLevelWidgets() if w.isVisible()] == []


@pytest.fixture(autouse=True, scope="module")
def no_view_outlives_its_window():
    """VTK's render windows: as many behind a module's tests as before, but for the last one."""
    before = _render_windows()
    yield
    if app := QApplication.instance():
        app.processEvents()
    assert _render_windows() <= before + 1


@pytest.fixture(scope="module")
def analysed():
    """The sample walk, for tests that do not edit its review."""
    return analyse(WALK)


@pytest.fixture
def document(qapp, tmp_path):
    """The walk at a frame in the middle, the left forearm selected, nothing to correct."""
    document = Document()
    # A copy: the review's journal is written beside the clip.
    document.show_clip(analyse(Path(shutil.copy(WALK, tmp_path))))
    if document.intervals:
        document.do(Decide(tuple(j.id for j in document.intervals), Decision.REJECTED))
    document.select_chain("LeftForeArm")
    document.go_to(FRAME)
    yield document
    document.close_clip()
    document.deleteLater()


@pytest.fixture
def show_view(qtbot):
    """Opens the view of a document; closes it again."""
    opened = []

    def show(document, theme=DARK, size=(640, 480)):
        view = Viewport(document, theme)
        view.resize(*size)
        view.show()
        qtbot.waitExposed(view)
        opened.append(view)
        settle(qtbot, view)
        return view

    yield show
    for view in opened:
        view.close()
        view.deleteLater()
    qtbot.wait(10)


def _render_windows() -> int:
    gc.collect()
    return sum(isinstance(o, vtkRenderWindow) for o in gc.get_objects())
