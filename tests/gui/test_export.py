"""An export with tracking is written off the GUI thread: told, usable meanwhile, safe to close."""

import os
import shutil
import threading

import pytest
from PySide6.QtCore import QTimer

import inspector.session.export_files as export_module
from inspector.session.export_files import ExportChoice
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from inspector.window.main_window import MainWindow
from tests.conftest import ASSETS
from tests.faults.test_interrupted_export import begin
from tests.gui.windows import act, wait_until_active
from tests.twistcore.batch_folders import KILL
from twistcore.errors import TwistError
from twistcore.formats.clip import write_clip
from twistcore.review import Track, Tracking
from twistcore.review.replay import accepted_motion

HAND = Tracking(("LeftForeArm", "LeftHand"), kp=3000.0, kd=33.0)


@pytest.fixture
def window(qtbot, tmp_path):
    window = MainWindow(Settings(turn_ms=0), None)
    window.show()
    wait_until_active(window)
    with qtbot.waitSignal(window.document.opened, timeout=10_000):
        window.open_path(type(ASSETS)(shutil.copy(ASSETS / "walk_injected.bvh", tmp_path)))
    window.document.accept_undecided()
    window.document.do(Track(HAND))
    yield window
    if window.isVisible():
        window.document.review.mark_saved()
        window.close()
    window.deleteLater()
    qtbot.wait(20)


@pytest.fixture
def held(monkeypatch):
    """The export's work waits halfway until `held.set()`; `held.where` is its thread."""
    gate = threading.Event()

    def slow(clip, chains, state, *, tell):
        gate.where = threading.current_thread()
        tell(0.5)
        assert gate.wait(10.0)
        if gate.error is not None:
            raise gate.error
        return accepted_motion(clip, chains, state, tell=tell)

    gate.where = gate.error = None
    monkeypatch.setattr(export_module, "accepted_motion", slow)
    yield gate
    gate.set()


@pytest.mark.thorough
def test_the_window_is_usable_and_told_how_far_it_is(qtbot, window, held, tmp_path):
    out = tmp_path / "out.bvh"
    state = window.document.review.state
    window.files.export(ExportChoice(out))
    qtbot.waitUntil(lambda: window.bar.label.text() == "Writing out.bvh … 50 %", timeout=5_000)
    assert held.where is not threading.main_thread()
    assert not out.exists()
    window.document.go_to(40)
    act(window, "undo")  # what is written is the review as it was when the person asked
    assert window.document.review.state.tracking is None
    window.files.export(ExportChoice(tmp_path / "other.bvh"))
    assert window.bar.label.text()
    held.set()
    qtbot.waitUntil(lambda: not window.exporter.running, timeout=10_000)
    assert window.bar.label.text()
    assert not (tmp_path / "other.bvh").exists()
    clip = window.document.data.clip
    write_clip(clip, accepted_motion(clip, window.document.data.chains, state), tmp_path / "a.bvh")
    assert out.read_bytes() == (tmp_path / "a.bvh").read_bytes()
    assert (tmp_path / "out.report.html").exists()


def test_what_goes_wrong_is_told_and_the_next_export_works(qtbot, window, held, tmp_path):
    held.error = TwistError("no such gains")
    held.set()
    out = tmp_path / "out.bvh"
    window.files.export(ExportChoice(out))
    assert not window.exporter.finish()
    assert window.bar.label.text() == f"{out} was not written: no such gains"
    assert not out.exists()
    held.error = None
    window.files.export(ExportChoice(out))
    assert window.exporter.finish()
    assert out.exists()


@pytest.mark.thorough
def test_closing_waits_for_the_file(qtbot, window, held, tmp_path):
    out = tmp_path / "out.bvh"
    window.files.export(ExportChoice(out))
    window.document.review.mark_saved()
    QTimer.singleShot(100, held.set)
    assert window.close()
    assert out.exists()
    assert not window.exporter.running


@pytest.mark.thorough
def test_the_window_stays_open_if_the_file_could_not_be_written(qtbot, window, held, tmp_path):
    held.error = OSError(28, "No space left on device")
    window.files.export(ExportChoice(tmp_path / "out.bvh"))
    window.document.review.mark_saved()
    QTimer.singleShot(100, held.set)
    assert not window.close()
    assert window.isVisible()
    assert "No space left" in window.bar.label.text()


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="Windows has no lasting names of open files")
def test_files_of_an_interrupted_export_are_named_as_such(qtbot, window):
    document = window.document
    clip = document.data.clip.path
    out = clip.with_name("walk_injected_refined.bvh")
    out.write_bytes(b"half")
    dialog = ExportDialog(document, window)
    foreign = dialog.replaces.text()
    with begin(clip.with_name("walk_injected_refined.replay.json"), clip) as process:
        os.kill(process.pid, KILL)
    dialog = ExportDialog(document, window)
    assert out.name in foreign
    assert out.name in dialog.replaces.text()
    assert dialog.replaces.text() != foreign
    assert not dialog.do_it.isEnabled()  # nobody has said that it may be replaced
    dialog.replace.setChecked(True)
    assert dialog.do_it.isEnabled()


@pytest.mark.thorough
def test_the_note_about_undecided_intervals_is_read_whole(qtbot, window):
    window.document.undo()
    window.document.undo()
    act(window, "export_dialog")
    dialog = window.findChild(ExportDialog)
    dialog.undecided.click()
    qtbot.waitUntil(
        lambda: dialog.warning.height() >= dialog.warning.heightForWidth(dialog.warning.width())
    )
    assert dialog.warning.isVisible()
    browse = dialog.where.itemAt(1).widget()
    assert browse.height() >= browse.minimumSizeHint().height()
    dialog.close()
