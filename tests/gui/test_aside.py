"""A borrowed clip: what is written of it stays, and what it takes the place of goes on."""

import shutil
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from inspector.bundled import TOUR
from inspector.recording.record_dialog import RecordDialog
from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip


def begin(qtbot, window, what):
    """Begin a lesson or an exercise and wait for its clip."""
    before = window.document.data
    if what == "lesson":
        window.lesson_actions.play(TOUR)
    else:
        act(window, "exercise")
        qtbot.mouseClick(window.lesson_actions.hidden_errors.start, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.document.data is not before, timeout=20_000)


def proposed(window):
    """Where each dialog wants to write."""
    paths = []
    for action, kind in (("record_dialog", RecordDialog), ("export_dialog", ExportDialog)):
        act(window, action)
        dialog = window.findChildren(kind)[-1]
        if kind is ExportDialog:
            paths.append(dialog.choice().path)
            dialog.path.setText("typed.bvh")
        paths.append(dialog.choice().path)
        dialog.reject()
    for action in ("save_session_as", "save_profile"):
        act(window, action)
        dialog = window.findChildren(QFileDialog)[-1]
        paths += map(Path, dialog.selectedFiles())
        dialog.reject()
    return paths


@pytest.mark.parametrize("what", ["lesson", "exercise"])
def test_what_is_written_of_a_borrowed_clip_lies_beside_the_persons_own(qtbot, at_forearm, what):
    own = at_forearm.document.data.clip.path.parent
    beside = proposed(at_forearm)
    assert [path.parent for path in beside] == [own] * 5
    begin(qtbot, at_forearm, what)
    wanted = proposed(at_forearm)
    assert [path.parent for path in wanted] == [own] * 5
    for path in wanted:
        path.write_bytes(b"made in a lesson")
    # What is there is not proposed again: it may be the person's own export.
    again = [path for path in proposed(at_forearm) if path.name != "typed.bvh"]
    assert not set(again) & set(wanted)
    at_forearm.lesson_actions.leave_guide()
    assert all(path.read_bytes() == b"made in a lesson" for path in wanted)
    assert proposed(at_forearm) == beside


def test_without_a_clip_of_ones_own_it_lies_at_home(qtbot, show_window, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    window = show_window()
    begin(qtbot, window, "exercise")
    assert {path.parent for path in proposed(window)} == {tmp_path}
    window.lesson_actions.leave_guide()  # the borrowed clip stays, its folder does not
    assert {path.parent for path in proposed(window)} == {tmp_path}
    folder = tmp_path / "own"
    folder.mkdir()
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk.bvh", folder / "own.bvh"))
    assert {path.parent for path in proposed(window)} == {folder}
