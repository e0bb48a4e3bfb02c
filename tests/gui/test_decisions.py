"""What a decision is: a rejection with its reason one step, and on a group only what was drawn."""

import json
import shutil

import pytest
from PySide6.QtCore import QElapsedTimer, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMenu

from inspector.panels.reason_palette import ReasonPalette
from inspector.session.session_files import journals, session_path
from inspector.session.settings import Settings
from inspector.window import look_through
from tests.conftest import ASSETS
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, decisions, open_clip, press, wait_until_active
from twistcore.review import Annotate, Decision, replay_journal

ONE_WINDOW = True
SERIES = 13  # errors in the second group of the clip
KEY, CTRL = Qt.Key, Qt.KeyboardModifier.ControlModifier
REASON = "fast but real"  # the second one in the palette


@pytest.fixture
def show(qtbot, window_for_clips, tmp_path):
    """A copy of a clip in the window."""

    def open_copy(path):
        window = window_for_clips(Settings(turn_ms=0, reviewer="Ada"))
        open_clip(qtbot, window, shutil.copy(path, tmp_path / path.name))
        return window

    return open_copy


def reject_for(qtbot, window, key):
    """Press Q, and a key in the palette."""
    wait_until_active(window)
    press(qtbot, window, KEY.Key_Q)
    palette = window.findChildren(ReasonPalette)[-1]
    QTest.keyClick(palette.line, key)
    qtbot.waitUntil(lambda: not palette.isVisible())
    end(qtbot, window.review_actions.look_through)


def lines(window):
    (journal,) = journals(session_path(window.document.data.clip.path))
    return [json.loads(line) for line in journal.read_text("utf-8").splitlines()[1:]]


def test_a_rejection_with_a_reason_is_undone_by_one_key(qtbot, show):
    window = show(INJECTED)
    document = window.document
    press(qtbot, window, KEY.Key_N)
    first, before = document.interval_id, document.review.state
    reject_for(qtbot, window, KEY.Key_2)
    judged = document.found(first)
    said = judged.decision, judged.reason, judged.reviewer
    assert said == (Decision.REJECTED, REASON, "Ada")
    assert document.interval_id != first  # on to the next one
    assert document.review.history == ("Reject interval",)
    assert [(line["do"], line["reason"]) for line in lines(window)] == [("Decide", REASON)]
    press(qtbot, window, KEY.Key_Z, CTRL)
    assert document.review.state is before
    assert document.interval_id == first
    press(qtbot, window, KEY.Key_Y, CTRL)
    assert document.found(first) == judged
    (journal,) = journals(session_path(document.data.clip.path))
    assert replay_journal(journal, document.data.clip).review.state.find(first).reason == REASON


def test_the_reason_of_a_group_is_the_reason_of_all_its_errors(qtbot, show):
    window = show(ASSETS / "kick.bvh")
    document = window.document
    for _ in range(2):
        press(qtbot, window, KEY.Key_N)
    group = window.intervals.selected_ids()
    assert len(group) > 1
    reject_for(qtbot, window, KEY.Key_2)
    rejected = [j for j in document.intervals if j.decision == Decision.REJECTED]
    assert {j.id for j in rejected} == set(group)
    assert {j.reason for j in rejected} == {REASON}
    press(qtbot, window, KEY.Key_Z, CTRL)
    assert set(decisions(window)) == {Decision.UNDECIDED}
    assert {j.reason for j in document.intervals} == {""}


def test_a_new_reason_for_what_is_rejected_is_a_step_and_the_same_one_is_none(qtbot, show):
    window = show(INJECTED)
    document = window.document
    press(qtbot, window, KEY.Key_N)
    first = document.interval_id
    press(qtbot, window, KEY.Key_R)
    for _ in range(2):
        document.select_interval(first, jump=True)
        act(window, "zoom_to_interval")
        reject_for(qtbot, window, KEY.Key_2)
        assert document.found(first).reason == REASON
        assert document.review.position == 2
    press(qtbot, window, KEY.Key_Z, CTRL)
    assert (document.found(first).decision, document.found(first).reason) == ("rejected", "")


# -- groups: nothing is decided that was not drawn -------------------------------------------------


@pytest.fixture
def connect():
    """Connects a signal until the test is over: others have the same window."""
    made = []

    def make(signal, slot):
        signal.connect(slot)
        made.append((signal, slot))

    yield make
    for signal, slot in made:
        signal.disconnect(slot)


@pytest.fixture
def series(qtbot, show):
    """The window with a group of thirteen errors selected, the first of which is painted."""
    window = show(ASSETS / "kick.bvh")
    for _ in range(2):
        press(qtbot, window, KEY.Key_N)
    assert len(window.intervals.selected_ids()) == SERIES
    qtbot.waitUntil(window.viewport.has_painted_interval)
    return window


@pytest.fixture
def painted(series, connect):
    """The ids of the intervals that are painted from now on, in this order."""
    found = []

    def note():
        if series.viewport.has_painted_interval():
            found.append(series.document.interval_id)

    connect(series.viewport.interval_painted, note)
    return found


def begin(window, key):
    """Press a key with which the errors of the group begin to be shown."""
    look = window.review_actions.look_through
    QTest.keyClick(window, key)
    assert look.running
    return look


def end(qtbot, look):
    qtbot.waitUntil(lambda: not look.running)


@pytest.mark.parametrize(("key", "verdict"), [(KEY.Key_A, "accepted"), (KEY.Key_R, "rejected")])
def test_a_group_is_decided_when_all_its_errors_are_painted(
    qtbot, series, connect, painted, key, verdict
):
    document, group = series.document, series.intervals.selected_ids()
    before = []
    first = document.interval_id

    def note():
        if document.review.undo_text:
            before.append((set(painted), series.bar.label.text()))

    connect(document.intervals_changed, note)
    look = begin(series, key)
    assert set(decisions(series)) == {Decision.UNDECIDED}
    assert series.intervals.selected_ids() == group  # while each is shown
    end(qtbot, look)
    assert [j.id for j in document.intervals if j.decision == verdict] == sorted(group)
    assert before[0][0] | {first} >= set(group)
    assert "12 errors" in before[0][1]
    assert not series.bar.isVisible()  # nothing is left to say
    assert series.statusBar().currentMessage() == ""
    assert document.review.position == 1
    assert document.interval_id not in group  # on to the next group


def test_each_error_is_shown_for_a_while(qtbot, series):
    series.settings.look_ms = 20
    clock = QElapsedTimer()
    clock.start()
    press(qtbot, series, KEY.Key_A)
    series.settings.look_ms = 0
    assert clock.elapsed() >= 20 * (SERIES - 1)
    assert decisions(series).count(Decision.ACCEPTED) == SERIES


@pytest.mark.parametrize("way", ["Esc", "undo", "frame", "N", "edit"])
def test_whatever_else_is_done_stops_and_nothing_is_decided(qtbot, series, way):
    document, group = series.document, series.intervals.selected_ids()
    document.do(Annotate(group[0], "a step"))  # to undo
    series.settings.look_ms = 10_000
    look = begin(series, KEY.Key_A)
    now = document.interval_id
    if way == "frame":
        QTest.keyClick(series, KEY.Key_Period)
    elif way == "undo":
        QTest.keyClick(series, KEY.Key_Z, CTRL)
    elif way == "edit":
        document.do(Annotate(now, "look again"))
    else:
        QTest.keyClick(series, KEY.Key_Escape if way == "Esc" else KEY.Key_N)
    series.settings.look_ms = 0
    assert not look.running
    assert series.bar.label.text().startswith("Nothing was decided")
    assert Decision.ACCEPTED not in decisions(series)
    assert document.review.position == 1 + (way == "edit")  # undo only stops
    assert (series.intervals.selected_ids() == group) == (way != "N")
    qtbot.wait(20)
    assert Decision.ACCEPTED not in decisions(series)


def test_an_open_menu_stops(qtbot, series, connect):
    look = series.review_actions.look_through
    menu = QMenu(series)
    menu.addAction("x")
    connect(look.showing, lambda number, _: number == 2 and menu.popup(QPoint(0, 0)))
    QTest.keyClick(series, KEY.Key_A)
    end(qtbot, look)
    menu.close()
    assert set(decisions(series)) == {Decision.UNDECIDED}


def test_a_second_key_neither_hurries_nor_decides(qtbot, series):
    series.settings.look_ms = 10_000
    look = begin(series, KEY.Key_A)
    now = series.document.interval_id
    qtbot.waitUntil(series.viewport.has_painted_interval)
    for key in (KEY.Key_A, KEY.Key_R):
        QTest.keyClick(series, key)
        assert look.running
        assert series.document.interval_id == now
    look.stop()
    series.settings.look_ms = 0
    assert set(decisions(series)) == {Decision.UNDECIDED}


def test_after_a_stop_only_the_rest_is_shown(qtbot, series, connect):
    look, counts = series.review_actions.look_through, []
    connect(look.began, lambda count, _: counts.append(count))
    connect(look.showing, lambda number, _: number == 5 and len(counts) == 1 and look.stop())
    press(qtbot, series, KEY.Key_A)
    assert set(decisions(series)) == {Decision.UNDECIDED}
    press(qtbot, series, KEY.Key_R)
    assert counts[0] == SERIES - 1
    assert 0 < counts[1] <= SERIES - 5  # the fifth was perhaps painted before the key
    assert decisions(series).count(Decision.REJECTED) == SERIES


def test_a_group_whose_errors_were_seen_one_by_one_is_decided_at_once(qtbot, series):
    document, group = series.document, series.intervals.selected_ids()
    for k in group:
        document.select_interval(k, jump=True)
        qtbot.waitUntil(series.viewport.has_painted_interval)
    table = series.intervals.table
    row = next(
        r for r in range(table.model().rowCount()) if len(series.intervals._thing(r).ids) == SERIES
    )
    table.setCurrentIndex(table.model().index(row, 0))
    act(series, "zoom_to_interval")
    qtbot.waitUntil(series.viewport.has_painted_interval)
    assert series.intervals.selected_ids() == group
    QTest.keyClick(series, KEY.Key_A)
    assert decisions(series).count(Decision.ACCEPTED) == SERIES


def test_of_a_large_group_the_worst_errors_are_shown_and_this_is_said(
    qtbot, series, connect, painted, monkeypatch
):
    document, group = series.document, series.intervals.selected_ids()
    monkeypatch.setattr(look_through, "MOST", 3)
    others = [document.found(k) for k in group if k != document.interval_id]
    worst = sorted(others, key=document.severity, reverse=True)[:3]
    announced = []
    look = series.review_actions.look_through
    connect(look.began, lambda *_: announced.append(series.bar.label.text()))
    press(qtbot, series, KEY.Key_A)
    assert decisions(series).count(Decision.ACCEPTED) == SERIES
    assert set(painted) & {j.id for j in others} == {j.id for j in worst}
    assert "not seen 12 errors" in announced[0]
    assert "worst 3 " in announced[0]
    assert series.statusBar().currentMessage() == (
        "The decision applies to 13 errors. You have seen 4 of them."
    )


def test_rows_that_a_person_has_selected_are_decided_at_once(qtbot, series):
    table = series.intervals.table
    table.selectAll()
    assert series.intervals.has_several_selected
    qtbot.waitUntil(series.viewport.has_painted_interval)
    QTest.keyClick(series, KEY.Key_A)
    assert set(decisions(series)) == {Decision.ACCEPTED}
