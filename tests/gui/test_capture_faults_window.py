"""Noise bursts and frozen frames in the window: listed, filtered, seen, and led to Quality."""

import pytest
from PySide6.QtCore import Qt

from inspector.panels.interval_filter import FILTERS
from inspector.session.session_files import session_path
from inspector.session.settings import Settings
from tests.gui.windows import act, open_clip, press, wait_until_active
from tests.messages import names_in_one_line
from tests.twistcore.test_capture_faults import FAULTS, faulty_clip
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision, Review, read_session, write_session


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "walk.bvh"
    path.write_bytes(faulty_clip().data)
    return path


@pytest.fixture
def opened(qtbot, show_window, path):
    window = show_window(Settings(turn_ms=0, group_errors=False), size=(1280, 800))
    open_clip(qtbot, window, path)
    return window


def rows_of(window, kind):
    return [j for j in window.document.intervals if j.interval.kind == kind]


def click(qtbot, widget, where=None):
    button = Qt.MouseButton.LeftButton
    qtbot.mouseClick(widget, button, pos=where or widget.rect().center())
    qtbot.wait(20)


def show_only(qtbot, window, kind):
    """Choose a kind in the list of filters with the arrow keys."""
    box = window.intervals.filter
    wanted = list(FILTERS).index(kind)
    press(qtbot, box, Qt.Key.Key_Home)
    for _ in range(wanted):
        press(qtbot, box, Qt.Key.Key_Down)
    assert box.currentData() == kind


def click_row(qtbot, window, row):
    table = window.intervals.table
    at = table.visualRect(table.model().index(row, 0)).center()
    click(qtbot, table.viewport(), at)


def test_a_burst_is_filtered_seen_and_led_to_its_page_of_tracking(qtbot, opened):
    wait_until_active(opened)
    show_only(qtbot, opened, "Noise bursts")
    table, detail, quality = opened.intervals.table, opened.detail, opened.quality
    assert table.model().rowCount() == len(rows_of(opened, Kind.NOISE_BURST)) == 2
    click_row(qtbot, opened, 1)
    judged = opened.document.interval
    assert (judged.interval.kind, judged.interval.joint) == (Kind.NOISE_BURST, "LeftForeArm")
    assert "LeftForeArm" in detail.why.text()
    assert not detail.delta.isEnabled()
    assert detail.to_quality.text()
    click(qtbot, detail.to_quality)
    qtbot.waitUntil(lambda: quality.chosen == ("LeftForeArm",), timeout=10_000)
    assert not quality.visibleRegion().isEmpty()
    assert quality.tabs.currentWidget() is quality.page
    qtbot.waitUntil(lambda: "LeftForeArm" in quality.page.joints.text(), timeout=10_000)
    assert judged.interval.start <= opened.document.frame < judged.interval.stop
    qtbot.waitUntil(opened.actions_by_id["track_joints"].isEnabled, timeout=10_000)
    opened.docks["intervals"].raise_()
    press(qtbot, opened, Qt.Key.Key_A)
    assert opened.document.review.state.find(judged.id).decision == Decision.ACCEPTED
    assert not opened.document.offset("LeftForeArm").any()


@pytest.mark.thorough
def test_the_button_is_for_faults_of_the_capture_alone(qtbot, opened):
    (frozen,) = rows_of(opened, Kind.FROZEN)
    opened.document.select_interval(frozen.id)
    detail = opened.detail
    assert names_in_one_line(detail.why.text(), "Right arm", "0.42 s")
    assert detail.to_quality.isVisible()
    click(qtbot, detail.to_quality)
    quality = opened.quality
    qtbot.waitUntil(lambda: quality.chosen == ("RightShoulder",), timeout=10_000)
    assert quality.tabs.currentIndex() == 0
    opened.document.select_interval(None)
    assert not detail.to_quality.isVisibleTo(detail)


@pytest.mark.thorough
def test_a_session_from_before_gets_them_undecided_and_brings_them_back(qtbot, show_window, path):
    clip = read_bvh(path)
    review = Review.of(analyse(clip).detect(kinds=frozenset(Kind) - FAULTS))
    write_session(clip, review.state, session_path(path))
    window = show_window(size=(1280, 800))
    open_clip(qtbot, window, path)
    assert window.document.data.added == 3
    assert {j.decision for j in window.document.intervals} <= {Decision.UNDECIDED}
    assert len(rows_of(window, Kind.NOISE_BURST)) == 2
    window.document.decide(Decision.ACCEPTED, [rows_of(window, Kind.FROZEN)[0].id])
    act(window, "save_session")
    kept = read_session(session_path(path)).state.intervals
    assert [j.verdict for j in kept if j.interval.kind == Kind.FROZEN] == ["seen"]
    open_clip(qtbot, window, path)
    assert len([j for j in window.document.intervals if j.interval.kind in FAULTS]) == 3
    assert window.document.data.added is None
