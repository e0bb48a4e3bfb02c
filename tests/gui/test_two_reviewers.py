"""Two people review one clip: the window lists where they differ, and keys settle it."""

import json
import shutil
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit, QToolButton

from inspector.language import use_language
from inspector.reviewers.feature import feature
from inspector.session.settings import Settings
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, close_window, open_clip, press, wait_until_active
from twistcore.analysis.clip_analysis import detect
from twistcore.cli import main as twistcore
from twistcore.detection.interval_offsets import new_constant_offset_interval, resized_interval
from twistcore.formats.bvh import read_bvh
from twistcore.review import (
    Annotate,
    Decide,
    Decision,
    Edit,
    Insert,
    Review,
    read_session,
    write_session,
)
from twistcore.review.agreement import pair_intervals

A, R = Decision.ACCEPTED, Decision.REJECTED
SHIFT, CTRL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
THEN, LATER = "2026-11-01T09:00:00+00:00", "2026-11-02T09:00:00+00:00"

ONE_WINDOW = True


@pytest.fixture
def clip(tmp_path):
    return read_bvh(shutil.copy(INJECTED, tmp_path / "walk.bvh"))


def written(clip, name, accepted, rejected, at, *more):
    review = Review(detect(clip))
    review.do(Decide(accepted, A, name, at))
    review.do(Decide(rejected, R, name, at))
    for command in more:
        review.do(command)
    path = clip.path.with_name(f"{name.lower().strip(chr(0x202E))}.twist.json".replace("<b>", ""))
    write_session(clip, review, path)
    return path


@pytest.fixture
def ada(clip):
    return written(clip, "Ada", (1, 2, 3, 5), (6,), THEN)


@pytest.fixture
def ben(clip):
    """Opposite to Ada on 3 and 5, longer at 2, alone on 4, and with a ninth interval."""
    one = Review(detect(clip)).state.find(2).interval
    more = (
        Edit(2, resized_interval(one, one.start, one.stop + 3)),
        Annotate(3, "looks natural", "motion"),
        Insert(new_constant_offset_interval("LeftArm", 300, 310, 0.4)),
        Decide((9,), A, "Ben", LATER),
    )
    return written(clip, "Ben", (1, 2, 4), (3, 5, 6), LATER, *more)


def compare(qtbot, window, path):
    """File → Compare with another review…, typed into the dialog."""
    QApplication.setAttribute(Qt.ApplicationAttribute.AA_DontUseNativeDialogs)
    act(window, "compare_reviews")
    qtbot.waitUntil(lambda: window.findChild(QFileDialog) is not None)
    dialog = window.findChild(QFileDialog)
    wait_until_active(dialog)
    line = dialog.findChild(QLineEdit)
    line.setCompleter(None)
    line.setText(str(path))
    qtbot.keyClick(line, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: window.findChild(QFileDialog) is None)
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)


@pytest.fixture
def compared(qtbot, window_for_clips, ada, ben):
    """Ada's review, compared with Ben's by Carla."""
    window = window_for_clips(Settings(turn_ms=0, reviewer="Carla"))
    open_clip(qtbot, window, ada)
    compare(qtbot, window, ben)
    qtbot.waitUntil(lambda: bool(window.comparison.rows))
    return window


def keys(window):
    return [row.key for row in window.comparison.rows]


def left(window):
    return [row.key for row in window.comparison.rows if not row.settled]


def button(window, name):
    action = window.actions_by_id[name]
    buttons = window.comparison.findChildren(QToolButton)
    return next(b for b in buttons if b.defaultAction() is action)


def test_the_differences_are_listed_and_a_click_goes_to_one(qtbot, compared):
    panel, document = compared.comparison, compared.document
    assert compared.docks["comparison"].isVisible()
    assert keys(compared) == left(compared) == [9, 2, 3, 4, 5]
    assert panel.summary.text() == (
        "Decided by both reviewers: 5, with the same decision: 3 (60 %), Cohen's kappa: 0.29. "
        "Differences: 5, not settled: 5."
    )
    model = panel.model
    assert model.heads[1:] == ("Mine\nAda", "Theirs\nBen")
    assert model.row(2).texts == ("Left ForeArm 305–323", "✓ accepted", "✗ rejected")
    assert model.row(1).texts[1:] == ("✓ 206–213", "✓ 206–216")
    assert model.row(0).texts[1:] == ("–", "✓ accepted")
    place = panel.table.visualRect(model.index(2, 0)).center()
    qtbot.mouseClick(panel.table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert (document.interval_id, document.chain) == (3, "LeftForeArm")
    assert 305 <= document.frame < 323
    for words in ("Opposite decisions", "Ada, 2026-11-01 09:00", "Ben", "motion, looks natural"):
        assert words in panel.detail.text()


def test_each_difference_is_settled_by_one_key_and_signed(qtbot, compared, ben):
    document = compared.document
    press(qtbot, compared, Qt.Key.Key_X)  # from Ben's own interval to the next
    assert document.interval_id == 2
    press(qtbot, compared, Qt.Key.Key_T, SHIFT)
    assert document.found(2).interval.stop == 216
    assert document.interval_id == 3  # and on to the next
    press(qtbot, compared, Qt.Key.Key_M, SHIFT)
    assert (document.found(3).decision, document.interval_id) == (A, 4)
    press(qtbot, compared, Qt.Key.Key_R)  # a third opinion, by the usual key
    qtbot.waitUntil(lambda: document.interval_id == 5)
    press(qtbot, compared, Qt.Key.Key_T, SHIFT)
    assert document.interval_id is None  # only Ben has the last one
    assert (document.chain, document.frame) == ("LeftArm", 300)
    press(qtbot, compared, Qt.Key.Key_T, SHIFT)
    assert left(compared) == []
    verdicts = {j.id: j.decision for j in document.intervals if j.reviewer == "Carla"}
    assert verdicts == {2: A, 3: A, 4: R, 5: R, 9: A}
    assert {j.reviewer for j in document.intervals if j.id in (1, 6)} == {"Ada"}
    assert "All differences" in compared.bar.label.text()
    for _ in range(5):
        press(qtbot, compared, Qt.Key.Key_Z, CTRL)
    qtbot.waitUntil(lambda: left(compared) == [9, 2, 3, 4, 5])
    assert document.review.saved


def test_what_only_they_have_is_rejected_by_keeping_mine(qtbot, compared):
    qtbot.mouseClick(button(compared, "keep_mine"), Qt.MouseButton.LeftButton)
    new = compared.document.found(9)
    assert (new.decision, new.by_hand, new.reviewer, new.interval.start) == (R, True, "Carla", 300)
    assert 9 not in left(compared)


@pytest.mark.thorough
def test_all_that_i_left_undecided_is_one_step_and_keeps_their_name(qtbot, compared, ben):
    document, before = compared.document, compared.document.review.state
    qtbot.mouseClick(button(compared, "take_undecided"), Qt.MouseButton.LeftButton)
    assert document.review.history == ("Settle 2 differences",)
    assert {j.id for j in document.intervals if j.reviewer == "Ben"} == {4, 9}
    assert document.found(3).decision == A  # opposite: left to a person
    qtbot.waitUntil(lambda: left(compared) == [2, 3, 5])
    qtbot.mouseClick(button(compared, "take_undecided"), Qt.MouseButton.LeftButton)
    assert "already decided on every interval" in compared.bar.label.text()
    press(qtbot, compared, Qt.Key.Key_Z, CTRL)
    assert document.review.state is before


@pytest.mark.thorough
def test_a_third_verdict_survives_a_crash_and_is_exported(qtbot, compared, show_window, ada, clip):
    act(compared, "next_difference")
    press(qtbot, compared, Qt.Key.Key_T, SHIFT)
    act(compared, "take_undecided")
    [journal] = ada.parent.glob("*.journal")
    kept, expected = journal.read_bytes(), compared.document.intervals
    assert compared.files.save_session()
    out = ada.with_name("out.bvh")
    assert twistcore(["apply", str(ada), str(clip.path), "-o", str(out)]) == 0
    again = read_session(ada).state.intervals
    assert all(pair.difference is None for pair in pair_intervals(expected, again))
    written(clip, "Ada", (1, 2, 3, 5), (6,), THEN)
    close_window(qtbot, compared)
    journal.write_bytes(kept)  # as a killed program leaves it
    other = show_window()
    open_clip(qtbot, other, ada)
    restore = next(b for b in other.bar.buttons() if b.text() == "Restore")
    qtbot.mouseClick(restore, Qt.MouseButton.LeftButton)
    assert [(j.id, j.decision, j.reviewer) for j in other.document.intervals] == [
        (j.id, j.decision, j.reviewer) for j in expected
    ]


@pytest.mark.thorough
def test_another_clip_s_session_is_refused_and_another_clip_ends_the_comparison(
    qtbot, compared, tmp_path
):
    rows = keys(compared)
    other = tmp_path / "other.bvh"
    other.write_bytes(Path(INJECTED).read_bytes() + b"\n")
    stranger = written(read_bvh(other), "Dan", (1,), (2,), THEN)
    compared.part(feature).compare_with(stranger)
    qtbot.waitUntil(lambda: "different clips" in compared.bar.label.text())
    assert keys(compared) == rows
    compared.part(feature).compare_with(other)
    qtbot.waitUntil(lambda: "expected a session" in compared.bar.label.text())
    open_clip(qtbot, compared, INJECTED)
    assert keys(compared) == []
    assert not compared.docks["comparison"].isVisible()
    assert "Compare with another review" in compared.comparison.summary.text()
    for name in ("next_difference", "take_theirs", "keep_mine", "take_undecided"):
        assert not compared.actions_by_id[name].isEnabled()


def test_a_session_that_does_not_fit_the_clip_is_not_compared(qtbot, compared, ben):
    rows = keys(compared)
    document = json.loads(ben.read_text(encoding="utf-8"))
    document["intervals"][-1] |= {"start": 9_000, "stop": 9_010}
    ben.write_text(json.dumps(document), encoding="utf-8")
    compared.part(feature).compare_with(ben)
    qtbot.waitUntil(lambda: "last frame" in compared.bar.label.text())
    assert keys(compared) == rows


@pytest.mark.thorough
def test_it_speaks_german(qtbot, show_window, ada, ben):
    window = show_window(Settings(turn_ms=0, reviewer="Carla"))
    open_clip(qtbot, window, ada)
    use_language("de")
    try:
        window.part(feature).compare_with(ben)
        qtbot.waitUntil(lambda: bool(window.comparison.rows))
        assert window.comparison.summary.text() == (
            "Von beiden entschieden: 5, gleich: 3 (60 %), Cohens Kappa: 0.29. "
            "Unterschiede: 5, offen: 5."
        )
        assert "Nur von einer Person eingefügt" in window.comparison.detail.text()
        assert window.comparison.model.heads[1:] == ("Meine\nAda", "Andere\nBen")
    finally:
        use_language("en")


@pytest.mark.thorough
def test_names_and_notes_of_strangers_are_shown_as_they_are_written(
    qtbot, show_window, ada, clip, tmp_path
):
    note = "<img src=x>\x1b[31m" + 100_000 * "x"
    stranger = written(clip, "<b>Eve\u202e", (4,), (3,), LATER, Annotate(3, note))
    window = show_window(Settings(turn_ms=0))
    open_clip(qtbot, window, ada)
    window.part(feature).compare_with(stranger)
    qtbot.waitUntil(lambda: bool(window.comparison.rows))
    [key] = (r.key for r in window.comparison.rows if r.pair.either.id == 3)
    while window.comparison.current.key != key:
        act(window, "next_difference")
    shown = window.comparison.detail.text()
    assert "&lt;img src=x&gt;\\x1b[31mxxx" in shown
    assert "&lt;b&gt;Eve\\u202e" in shown
    assert len(shown) < 1_000
