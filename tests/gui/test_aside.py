"""A borrowed clip: what is written of it stays, and what it takes the place of goes on."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from inspector.bundled import TOUR
from inspector.lessons.classroom import write_for_class
from inspector.recording.record_dialog import RecordDialog
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip
from twistcore.bvh import read_bvh
from twistcore.review import Decision


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
    act(window, "save_session_as")
    dialog = window.findChildren(QFileDialog)[-1]
    paths += map(Path, dialog.selectedFiles())
    dialog.reject()
    return paths


@pytest.mark.parametrize("what", ["lesson", "exercise"])
def test_what_is_written_of_a_borrowed_clip_lies_beside_the_persons_own(qtbot, at_forearm, what):
    own = at_forearm.document.data.clip.path.parent
    beside = proposed(at_forearm)
    assert [path.parent for path in beside] == [own] * 4
    begin(qtbot, at_forearm, what)
    wanted = proposed(at_forearm)
    assert [path.parent for path in wanted] == [own] * 4
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


# -- nothing is kept ------------------------------------------------------------------------------


@pytest.mark.parametrize("what", ["lesson", "exercise"])
def test_nothing_of_a_borrowed_clip_is_kept_unasked(qtbot, at_forearm, what):
    """Neither by keys that save without a question, nor as a record in somebody's name."""
    window, own = at_forearm, at_forearm.document.data.clip.path.parent
    whose = "A lesson" if what == "lesson" else "An exercise"
    begin(qtbot, window, what)
    folders = own, window.document.data.clip.path.parent
    before = [files(folder) for folder in folders]
    window.document.decide(Decision.ACCEPTED, [window.document.intervals[0].id])
    assert any(j.decision == Decision.ACCEPTED for j in window.document.intervals)
    assert window.reviewer_line.isHidden()
    for action in ("save_session", "save_profile"):
        window.bar.clear()
        act(window, action)
        assert f"{whose} keeps nothing" in said_by(window)
    assert not window.files.save_quietly()
    act(window, "export_at_once")
    (dialog,) = window.findChildren(ExportDialog)
    assert dialog.isVisible()
    dialog.reject()
    assert window.findChildren(QFileDialog) == []
    assert not window.document.review.saved
    assert not window.isWindowModified()  # nothing of it waits to be saved
    assert [files(folder) for folder in folders] == before
    window.lesson_actions.leave_guide()
    window.document.decide(Decision.ACCEPTED, [window.document.intervals[0].id])
    assert window.reviewer_line.isVisible()
    act(window, "save_session")
    assert window.document.review.saved


def files(folder):
    """What lies there but the journal, which goes with a borrowed clip."""
    return sorted(path for path in folder.iterdir() if "journal" not in path.name)


def said_by(window):
    """What the message bar shows."""
    return window.bar.label.text() if not window.bar.isHidden() else ""


def test_who_does_an_exercise_of_a_class_is_asked(qtbot, at_forearm, tmp_path):
    write_for_class(ASSETS / "walk.bvh", tmp_path / "class.json", 3, "judge")
    own = at_forearm.document.data
    act(at_forearm, "exercise")
    at_forearm.lesson_actions.hidden_errors.do_one(tmp_path / "class.json")
    qtbot.waitUntil(lambda: at_forearm.document.data is not own, timeout=20_000)
    at_forearm.document.decide(Decision.ACCEPTED, [at_forearm.document.intervals[0].id])
    assert at_forearm.reviewer_line.isVisible()
    act(at_forearm, "save_session")
    assert "Hand in…" in said_by(at_forearm)
    assert at_forearm.lesson_actions.hidden_errors._class is not None


def test_a_lesson_that_is_left_without_a_clip_of_ones_own_asks_nothing(
    qtbot, show_window, tmp_path, monkeypatch
):
    monkeypatch.setenv("HOME", str(tmp_path))
    window = show_window(Settings(turn_ms=0, autosave=False))
    begin(qtbot, window, "lesson")
    window.lesson_actions.leave_guide()
    window.document.decide(Decision.ACCEPTED, [window.document.intervals[0].id])
    assert window.reviewer_line.isHidden()
    own = shutil.copy(ASSETS / "walk.bvh", tmp_path / "own.bvh")
    open_clip(qtbot, window, own)
    assert not window.bar.asks


# -- an exercise that does not begin ---------------------------------------------------------------


@pytest.fixture
def said(at_forearm):
    """What is told."""
    told = []
    at_forearm.document.message.connect(lambda text, wrong: told.append((text, wrong)))
    return told


def test_an_exercise_that_was_left_before_its_clip_was_there_can_be_started(qtbot, at_forearm):
    exercise, own = at_forearm.lesson_actions.hidden_errors, at_forearm.document.data
    act(at_forearm, "exercise")
    exercise.start.click()
    assert not exercise.start.isEnabled()
    exercise.leave.click()
    assert at_forearm.document.data is own
    act(at_forearm, "exercise")
    assert exercise.start.isEnabled()
    begin(qtbot, at_forearm, "exercise")
    assert exercise.start.text() == "Start anew"
    exercise.leave.click()
    act(at_forearm, "exercise")
    assert (exercise.start.text(), exercise.start.isEnabled()) == ("Start", True)
    exercise.leave.click()


def test_why_an_exercise_cannot_start_is_told(qtbot, at_forearm, said, tmp_path):
    exercise = at_forearm.lesson_actions.hidden_errors
    exercise._clips = (tmp_path / "gone.bvh",)
    act(at_forearm, "exercise")
    exercise.start.click()
    qtbot.waitUntil(lambda: bool(said), timeout=20_000)
    ((text, wrong),) = said
    assert "gone.bvh" in text
    assert wrong
    assert exercise.start.isEnabled()
    assert not exercise.score_button.isEnabled()


def fail_to_open(qtbot, window, said, folder):
    """Try to do an exercise of a class whose clip is another."""
    folder.mkdir()
    write_for_class(ASSETS / "walk.bvh", folder / "class.json", 3, "find")
    shutil.copy(ASSETS / "dance.bvh", folder / "class.bvh")
    act(window, "exercise")
    window.lesson_actions.hidden_errors.do_one(folder / "class.json")
    qtbot.waitUntil(lambda: bool(said), timeout=20_000)
    said.clear()


def test_the_own_clip_is_saved_by_itself_while_no_other_is_there(qtbot, at_forearm, said, tmp_path):
    document = at_forearm.document
    fail_to_open(qtbot, at_forearm, said, tmp_path / "class")
    assert not at_forearm.lesson_actions.program.aside.open
    at_forearm.files._idle.setInterval(1)
    document.decide(Decision.ACCEPTED, [document.intervals[0].id])
    qtbot.waitUntil(lambda: document.review.saved, timeout=10_000)


@pytest.mark.parametrize("when", ["failed", "begun"])
def test_an_exercise_for_a_class_is_of_the_own_clip(qtbot, at_forearm, said, tmp_path, when):
    own = at_forearm.document.data
    at_forearm.lesson_actions.hidden_errors.teacher._clips = (ASSETS / "dance.bvh",)
    if when == "failed":
        fail_to_open(qtbot, at_forearm, said, tmp_path / "class")
    else:
        begin(qtbot, at_forearm, "exercise")
        said.clear()
    at_forearm.lesson_actions.hidden_errors.teacher.write(tmp_path / "mine_too.json")
    qtbot.waitUntil(lambda: bool(said), timeout=20_000)
    assert said[-1][0].startswith("For your class: mine_too.json")
    written = read_bvh(tmp_path / "mine_too.bvh").values
    assert written.shape == own.clip.values.shape
    assert np.median(np.abs(written - own.clip.values)) < 1e-3


def test_a_damaged_file_of_a_student_is_told(qtbot, at_forearm, said, tmp_path):
    _, key = write_for_class(ASSETS / "walk.bvh", tmp_path / "class.json", 3, "find")
    (tmp_path / "kim.json").write_text("[" * 200_000)
    act(at_forearm, "exercise")
    at_forearm.lesson_actions.hidden_errors.teacher.score([key, tmp_path / "kim.json"])
    qtbot.waitUntil(lambda: bool(said), timeout=20_000)
    assert "kim.json" in said[0][0]
    assert at_forearm.findChildren(QFileDialog) == []
