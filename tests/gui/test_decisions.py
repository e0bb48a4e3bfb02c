"""What a decision is: a rejection with its reason one step, and on a group only what was drawn."""

import json
import shutil

import pytest
from PySide6.QtCore import QElapsedTimer, QItemSelectionModel, QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMenu

from inspector.panels.reason_palette import ReasonPalette
from inspector.session.session_files import journals, session_path
from inspector.session.settings import Settings
from inspector.window import look_through
from tests.conftest import ASSETS
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, decisions, open_clip, press, wait_until_active
from twistcore.review import Annotate, Decide, Decision, replay_journal
from twistcore.review.model import APPLIED

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


def row_of_series(window):
    table, panel = window.intervals.table, window.intervals
    return next(r for r in range(table.model().rowCount()) if len(panel._thing(r).ids) == SERIES)


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
    assert "12 grouped errors" in before[0][1]
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


@pytest.mark.parametrize("way", ["Esc", "undo", "redo", "frame", "N", "edit"])
def test_whatever_else_is_done_stops_and_nothing_is_decided(qtbot, series, way):
    document, group = series.document, series.intervals.selected_ids()
    document.do(Annotate(group[0], "a step"))  # to undo
    if way == "redo":
        document.undo()
    steps = document.review.position
    series.settings.look_ms = 10_000
    look = begin(series, KEY.Key_A)
    now = document.interval_id
    if way == "frame":
        QTest.keyClick(series, KEY.Key_Period)
    elif way == "undo":
        QTest.keyClick(series, KEY.Key_Z, CTRL)
    elif way == "redo":
        QTest.keyClick(series, KEY.Key_Y, CTRL)
    elif way == "edit":
        document.do(Annotate(now, "look again"))
    else:
        QTest.keyClick(series, KEY.Key_Escape if way == "Esc" else KEY.Key_N)
    series.settings.look_ms = 0
    assert not look.running
    said = series.bar.isVisible() and series.bar.label.text().startswith("Nothing was decided")
    assert said == (way != "edit")  # the edit is a change, and not of this key
    assert Decision.ACCEPTED not in decisions(series)
    assert document.review.position == steps + (way == "edit")  # undo and redo only stop
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


@pytest.mark.parametrize("other", [KEY.Key_R, KEY.Key_Backspace])
def test_a_second_key_neither_hurries_nor_decides_and_another_one_stops(qtbot, series, other):
    series.settings.look_ms = 10_000
    look = begin(series, KEY.Key_A)
    now = series.document.interval_id
    qtbot.waitUntil(series.viewport.has_painted_interval)
    QTest.keyClick(series, KEY.Key_A)
    assert look.running
    assert series.document.interval_id == now
    QTest.keyClick(series, other)
    series.settings.look_ms = 0
    assert not look.running
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
    table.setCurrentIndex(table.model().index(row_of_series(series), 0))
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
    assert "not seen 12 grouped errors" in announced[0]
    assert "worst 3 " in announced[0]
    assert series.statusBar().currentMessage() == (
        "The decision applies to 13 errors. You have seen 4 of them."
    )


def select_rows(window, rows):
    """Select rows of the table, as with Ctrl and clicks."""
    table = window.intervals.table
    flags = QItemSelectionModel.SelectionFlag
    table.selectionModel().clearSelection()
    for row in rows:
        how = flags.Select | flags.Rows
        table.selectionModel().setCurrentIndex(table.model().index(row, 0), how)
    assert window.intervals.has_several_selected


def test_rows_that_a_person_has_selected_one_by_one_are_decided_at_once(qtbot, series):
    act(series, "group_errors")
    try:
        select_rows(series, (1, 4))
        ids = series.intervals.selected_ids()
        qtbot.waitUntil(series.viewport.has_painted_interval)
        QTest.keyClick(series, KEY.Key_A)
        accepted = {j.id for j in series.document.intervals if j.decision == Decision.ACCEPTED}
        assert accepted == set(ids)
        assert len(ids) == 2
    finally:
        act(series, "group_errors")


@pytest.mark.parametrize("rows", ["every", "two"])
def test_of_several_selected_groups_all_errors_are_shown(qtbot, series, painted, rows, monkeypatch):
    monkeypatch.setattr(look_through, "MOST", 1000)
    table, document = series.intervals.table, series.document
    if rows == "every":
        table.selectAll()
    else:
        row = row_of_series(series)
        select_rows(series, (row, row + 1 if row == 0 else row - 1))
    ids, grouped = series.intervals.selected_ids(), series.intervals.ids_in_selected_groups()
    selected = series.intervals._selected_rows()
    first = document.interval_id
    qtbot.waitUntil(series.viewport.has_painted_interval)
    look = begin(series, KEY.Key_A)
    assert set(decisions(series)) == {Decision.UNDECIDED}
    assert series.intervals._selected_rows() == selected
    end(qtbot, look)
    assert {j.id for j in document.intervals if j.decision == Decision.ACCEPTED} == set(ids)
    assert len(grouped) >= SERIES
    assert {*painted, first, *seen_before(series)} >= set(grouped)


def seen_before(window):
    """The first error of the series, and what was selected on the way to it."""
    document = window.document
    look = window.review_actions.look_through
    return {j.id for j in document.intervals if j.interval in look._painted}


@pytest.mark.parametrize("way", ["all rows", "no groups"])
def test_the_decision_is_on_the_group_that_was_shown(qtbot, series, way):
    series.settings.look_ms = 10_000
    look = begin(series, KEY.Key_A)
    if way == "all rows":
        series.intervals.table.selectAll()
    else:
        act(series, "group_errors")
    try:
        assert not look.running
        assert set(decisions(series)) == {Decision.UNDECIDED}
    finally:
        if way == "no groups":
            act(series, "group_errors")


def test_the_ids_at_the_key_are_decided(qtbot, series, monkeypatch):
    group = series.intervals.selected_ids()
    look = begin(series, KEY.Key_A)
    every = tuple(j.id for j in series.document.intervals)
    monkeypatch.setattr(look, "_check", lambda: None)  # as if this change were not noticed
    monkeypatch.setattr(series.intervals, "selected_ids", lambda: every)
    end(qtbot, look)
    accepted = {j.id for j in series.document.intervals if j.decision == Decision.ACCEPTED}
    assert accepted == set(group)


def test_the_same_decision_of_another_reviewer_stays_that_reviewer_s(qtbot, series, connect):
    document, group = series.document, series.intervals.selected_ids()
    document.do(Decide(group[:5], Decision.ACCEPTED, "Kim", "then"))
    document.do(Decide(group[5:6], Decision.ACCEPTED, "Kim", "then", in_bulk=True))
    counts = []
    connect(series.review_actions.look_through.done, lambda *n: counts.append(n))
    press(qtbot, series, KEY.Key_A)
    by = {j.id: (j.reviewer, j.decided_at == "then", j.in_bulk) for j in document.intervals}
    assert {by[k] for k in group[:5]} == {("Kim", True, False)}
    assert {by[k] for k in group[5:]} == {("Ada", False, False)}
    assert counts == [(SERIES - 5, SERIES - 5)]


def test_an_automatic_correction_is_decided_by_the_person_who_accepts_it(qtbot, series):
    document, group = series.document, series.intervals.selected_ids()
    document.do(Decide(group[:5], Decision.ACCEPTED))  # no name and no time
    assert APPLIED in {document.found(k).verdict for k in group[:5]}
    look = begin(series, KEY.Key_A)
    end(qtbot, look)
    by = {j.id: j.reviewer for j in document.intervals}
    assert {by[k] for k in group} == {"Ada"}


def test_a_note_that_is_still_being_typed_does_not_stop_the_look(qtbot, series):
    """A tool button takes no focus, so the note is stored when the next error is selected."""
    series.review_actions.card.note.setText("strap slipped")
    look = begin(series, KEY.Key_A)
    end(qtbot, look)
    document = series.document
    assert decisions(series).count(Decision.ACCEPTED) == SERIES
    assert [j.note for j in document.intervals if j.note] == ["strap slipped"]


def test_an_interval_whose_frames_were_not_painted_is_not_seen(qtbot, series, painted):
    document, group = series.document, series.intervals.selected_ids()
    for k in group:
        document.select_interval(k)
        document.go_to(0)
        qtbot.waitUntil(lambda: document.frame == 0 and not series.viewport.pending)
        qtbot.waitUntil(series.viewport.has_painted_interval)
    assert all(document.found(k).interval.start > 0 for k in group)
    table = series.intervals.table
    table.setCurrentIndex(table.model().index(row_of_series(series), 0))
    document.go_to(document.interval.interval.seen_at)
    act(series, "zoom_to_interval")
    qtbot.waitUntil(series.viewport.has_painted_interval)
    painted.clear()
    look = begin(series, KEY.Key_A)
    end(qtbot, look)
    assert len({*painted} & {*group}) >= SERIES - 2


def test_errors_in_a_hidden_view_are_not_seen(qtbot, series, monkeypatch, connect):
    counts = []
    connect(series.review_actions.look_through.done, lambda *n: counts.append(n))
    monkeypatch.setattr(type(series.viewport), "is_hidden", True)
    press(qtbot, series, KEY.Key_A)
    ((seen, total),) = counts
    assert seen <= 1  # the first one was painted before the view was hidden
    assert total == SERIES
    assert f"seen {seen} of them" in series.statusBar().currentMessage()


def test_a_decision_that_fails_is_not_reported_as_made(qtbot, series, monkeypatch, connect):
    look, made = series.review_actions.look_through, []
    connect(look.done, lambda *n: made.append(n))
    monkeypatch.setattr(series.document, "_may_change", lambda: False)
    press(qtbot, series, KEY.Key_A)
    assert made == []
    assert not series.bar.isVisible()
    assert set(decisions(series)) == {Decision.UNDECIDED}


@pytest.mark.parametrize("way", ["minimised", "another program", "no paint"])
def test_without_a_person_who_sees_them_the_look_stops(qtbot, series, monkeypatch, way):
    look = series.review_actions.look_through
    if way == "no paint":
        monkeypatch.setattr(look_through, "_MOST_CHECKS", 3)
        monkeypatch.setattr(type(series.viewport), "painted_frame", None)
    elif way == "minimised":
        monkeypatch.setattr(series, "isMinimized", lambda: True)
    begin(series, KEY.Key_A)
    if way == "another program":
        go(Qt.ApplicationState.ApplicationInactive)
    end(qtbot, look)
    assert set(decisions(series)) == {Decision.UNDECIDED}


def go(state):
    """As if the person went to another program, or came back."""
    QGuiApplication.instance().applicationStateChanged.emit(state)


def test_a_moment_in_another_window_does_not_stop(qtbot, series):
    look = begin(series, KEY.Key_A)
    go(Qt.ApplicationState.ApplicationInactive)  # as when a popup closes
    go(Qt.ApplicationState.ApplicationActive)
    end(qtbot, look)
    assert decisions(series).count(Decision.ACCEPTED) == SERIES


def test_a_reason_is_only_for_a_rejection(series):
    with pytest.raises(ValueError, match="reason"):
        series.document.decide(Decision.ACCEPTED, reason="noise")
