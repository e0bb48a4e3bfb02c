"""A borrowed clip: what is written of it stays, and what it takes the place of goes on."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QMessageBox

from inspector.bundled import TOUR
from inspector.lessons.classroom import write_for_class
from inspector.recording.record_dialog import RecordDialog
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.windows import act, close_and_answer, decisions, open_clip
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision
from twistcore.study.class_exercise import read_student_answer

pytestmark = pytest.mark.thorough
ONE_WINDOW = True


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
    return paths


@pytest.mark.parametrize("what", ["lesson", "exercise"])
def test_what_is_written_of_a_borrowed_clip_lies_beside_the_persons_own(qtbot, at_forearm, what):
    own = at_forearm.document.data.clip.path.parent
    beside = proposed(at_forearm)
    assert [path.parent for path in beside] == [own] * 3
    begin(qtbot, at_forearm, what)
    wanted = proposed(at_forearm)
    assert [path.parent for path in wanted] == [own] * 3
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


@pytest.mark.usefixtures("new_window")
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
    for action in ("save_session", "save_session_as", "save_profile"):
        window.bar.clear()
        act(window, action)
        assert f"{whose} does not save anything" in said_by(window)
    assert not window.files.save_quietly()
    act(window, "export_at_once")
    (dialog,) = window.findChildren(ExportDialog)
    assert dialog.isVisible()
    dialog.reject()
    assert window.findChildren(QFileDialog) == []
    assert not window.files.save_session(own / "asked_before_the_clip_was_there.twist.json")
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


# -- a class's verdicts ----------------------------------------------------------------------------


@pytest.fixture
def of_a_class(qtbot, at_forearm, tmp_path):
    """The window with a class's exercise open."""
    write_for_class(ASSETS / "walk.bvh", tmp_path / "class.json", 3, "judge")
    own = at_forearm.document.data
    act(at_forearm, "exercise")
    at_forearm.lesson_actions.hidden_errors.do_one(tmp_path / "class.json")
    qtbot.waitUntil(lambda: at_forearm.document.data is not own, timeout=20_000)
    return at_forearm


def test_who_does_an_exercise_of_a_class_is_asked(of_a_class):
    at_forearm = of_a_class
    at_forearm.document.decide(Decision.ACCEPTED, [at_forearm.document.intervals[0].id])
    assert at_forearm.reviewer_line.isVisible()
    act(at_forearm, "save_session")
    assert "Hand in…" in said_by(at_forearm)
    assert at_forearm.lesson_actions.hidden_errors._class is not None


def test_verdicts_for_a_class_are_not_given_up_unasked(qtbot, of_a_class, tmp_path):
    window, document = of_a_class, of_a_class.document
    exercise, data = window.lesson_actions.hidden_errors, document.data
    document.decide(Decision.ACCEPTED, [document.intervals[0].id])
    waits = "You have not handed in your verdicts on class.bvh."
    for leave in (
        exercise.leave.click,
        exercise.start.click,
        lambda: exercise.do_one(tmp_path / "class.json"),
        lambda: act(window, "tour"),
        lambda: act(window, "exercise"),
        lambda: window.open_path(ASSETS / "walk.bvh"),
    ):
        leave()
        assert (window.bar.asks, said_by(window)) == (True, waits)
        assert answers(window) == ["Hand in…", "Leave without handing in", "Cancel"]
        answer(window, "Cancel")
        assert not exercise._task.running
    assert close_and_answer(window, QMessageBox.StandardButton.Cancel) == waits
    assert (document.data, window.isVisible()) == (data, True)
    assert decisions(window)[0] == Decision.ACCEPTED
    # Where it cannot be written it goes nowhere, and once it is, it is left.
    exercise.leave.click()
    answer(window, "Hand in…")
    window.findChildren(QFileDialog)[-1].fileSelected.emit(str(tmp_path / "no" / "ada.json"))
    assert document.data is data
    exercise.leave.click()
    answer(window, "Hand in…")
    window.findChildren(QFileDialog)[-1].fileSelected.emit(str(tmp_path / "ada.json"))
    assert read_student_answer(tmp_path / "ada.json").verdicts[0].decision == Decision.ACCEPTED
    assert not exercise.running
    assert document.borrowed is None


def test_verdicts_for_a_class_are_asked_about_where_they_are_newer(of_a_class, tmp_path):
    window, document = of_a_class, of_a_class.document
    exercise, first = window.lesson_actions.hidden_errors, document.intervals[0].id
    assert not exercise.not_handed_in
    document.decide(Decision.ACCEPTED, [first])
    document.undo()
    assert not exercise.not_handed_in
    document.redo()
    exercise.hand_in(tmp_path / "ada.json")
    document.sign("Ada")
    assert not exercise.not_handed_in
    document.decide(Decision.REJECTED, [first])
    exercise.leave.click()
    answer(window, "Leave without handing in")
    assert document.borrowed is None


def test_handing_in_on_the_way_out_closes_the_window(qtbot, of_a_class, tmp_path):
    window = of_a_class
    window.document.decide(Decision.ACCEPTED, [window.document.intervals[0].id])
    close_and_answer(window, QMessageBox.StandardButton.Save)
    assert window.isVisible()
    window.findChildren(QFileDialog)[-1].fileSelected.emit(str(tmp_path / "ada.json"))
    qtbot.waitUntil(lambda: not window.isVisible())
    assert (tmp_path / "ada.json").exists()


def answers(window):
    """What the message bar offers."""
    return [button.text() for button in window.bar.buttons()]


def answer(window, text):
    """Press what it offers."""
    window.bar.buttons()[answers(window).index(text)].click()


# -- without a clip of one's own -------------------------------------------------------------------


def test_what_a_lesson_leaves_open_without_a_clip_of_ones_own_is_to_look_at(
    qtbot, show_window, tmp_path, monkeypatch
):
    monkeypatch.setenv("HOME", str(tmp_path))
    window = show_window(Settings(turn_ms=0, autosave=False))
    begin(qtbot, window, "lesson")
    document = window.document
    document.decide(Decision.REJECTED, [document.intervals[0].id])
    window.lesson_actions.leave_guide()
    state, chains = document.review.state, document.data
    for change in (
        lambda: document.decide(Decision.ACCEPTED, [document.intervals[0].id]),
        document.undo,
        lambda: document.change_chains(replace(state.rig, remove=(chains.chains[0].name,)), "Drop"),
        lambda: act(window, "save_session"),
    ):
        window.bar.clear()
        change()
        assert said_by(window)
        assert not document.opener.busy
    assert (document.review.state, document.data) == (state, chains)
    assert window.reviewer_line.isHidden()
    begin(qtbot, window, "exercise")
    document.decide(Decision.ACCEPTED, [document.intervals[0].id])
    assert document.review.state is not state
    window.lesson_actions.leave_guide()
    own = shutil.copy(ASSETS / "walk.bvh", tmp_path / "own.bvh")
    open_clip(qtbot, window, own)
    assert not window.bar.asks


def test_a_borrowed_clip_with_other_chains_is_still_borrowed(
    qtbot, show_window, tmp_path, monkeypatch
):
    monkeypatch.setenv("HOME", str(tmp_path))
    window = show_window()
    aside, document = window.lesson_actions.program.aside, window.document
    begin(qtbot, window, "lesson")
    before = document.data
    without = replace(document.review.state.rig, remove=(before.chains[0].name,))
    document.change_chains(without, "Drop")
    qtbot.waitUntil(lambda: document.data is not before, timeout=20_000)
    window.lesson_actions.leave_guide()
    assert aside.own is None
    begin(qtbot, window, "lesson")
    window.lesson_actions.leave_guide()
    assert document.borrowed is not None


def test_the_own_clip_is_saved_by_itself_after_a_lesson(qtbot, at_forearm):
    window, document = at_forearm, at_forearm.document
    document.decide(Decision.ACCEPTED, [document.intervals[0].id])
    begin(qtbot, window, "lesson")
    assert document.review.saved  # the lesson's
    with qtbot.waitSignal(window.files._idle.timeout):
        window.files._idle.start(1)
    window.lesson_actions.leave_guide()
    assert not document.review.saved
    window.files._idle.setInterval(1)
    qtbot.waitUntil(lambda: document.review.saved, timeout=10_000)


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
    assert exercise.start.text() == "Start again"
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


@pytest.mark.usefixtures("new_window")
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
    assert "mine_too.json" in said[-1][0]
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
