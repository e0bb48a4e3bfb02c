"""Errors that belong together are one row of the list, which unfolds, and one decision."""

import itertools
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from inspector.language import use_language
from inspector.panels.interval_columns import PLACE
from inspector.panels.interval_rows import GroupRow
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.session.session_files import journals, session_path
from inspector.session.settings import Settings, load_settings
from inspector.widgets.theme import LIGHT, Colours
from tests.conftest import ASSETS
from tests.gui.windows import act, close_window, decisions, open_clip, press
from twistcore.detection import Interval, Kind
from twistcore.review import Decision, Judged
from twistcore.review.model import SEEN

ONE_WINDOW = True
KEY, CTRL = Qt.Key, Qt.KeyboardModifier.ControlModifier
FOUND = 16  # intervals of the clip: a spike, two groups
SERIES, PAIR = 13, 2  # intervals in the groups
SERIES_NAME = "the same error 5 times: right knee flips, and 8 more errors"


@pytest.fixture
def kick(qtbot, window_for_clips, tmp_path):
    """A dancer whose knee flips six times, with jumps of the foot at the edges, in the window."""
    window = window_for_clips(Settings(turn_ms=0))
    open_clip(qtbot, window, shutil.copy(ASSETS / "kick.bvh", tmp_path / "kick.bvh"))
    return window


def things(window):
    panel = window.intervals
    return [panel._thing(row) for row in range(panel.table.model().rowCount())]


def texts(window, column):
    model = window.intervals.table.model()
    return [model.index(row, PLACE[column]).data() for row in range(model.rowCount())]


def current(window):
    """What the selected row is: a group or an interval."""
    return window.intervals._thing(window.intervals.table.currentIndex().row())


def go_to_series(qtbot, window):
    for _ in range(2):
        press(qtbot, window, KEY.Key_N)
    assert current(window).name == SERIES_NAME


def press_in(qtbot, window, widget, key):
    """Press a key in a widget of the window once the selected interval is painted."""
    qtbot.waitUntil(window.viewport.has_painted_interval)
    QTest.keyClick(widget, key)
    qtbot.wait(5)


def decided(window):
    return [d for d in decisions(window) if d != Decision.UNDECIDED]


def test_a_group_is_one_row_that_counts_its_intervals(kick):
    assert texts(kick, "chain") == ["Left Arm", "▸ Right leg (13)", "▸ Right leg (2)"]
    assert texts(kick, "stop")[1:] == [
        SERIES_NAME.replace("the", "The", 1),
        "Right knee flips and the jump at its edge",
    ]
    assert texts(kick, "start") == ["39", "14", "174"]
    assert kick.intervals.count.text() == "0 of 16 decided · 2 groups"
    assert len(kick.intervals.shown_ids()) == FOUND
    table = kick.intervals.table
    assert [table.columnSpan(row, PLACE["stop"]) > 1 for row in range(3)] == [False, True, True]


def test_a_and_r_decide_a_group_and_one_undo_takes_it_back(qtbot, kick):
    document = kick.document
    go_to_series(qtbot, kick)
    assert document.interval.interval.kind == Kind.LIMB_FLIP  # what the picture shows
    assert kick.detail.buttons[Decision.ACCEPTED].text() == "Accept (13)"
    press(qtbot, kick, KEY.Key_A)
    assert decided(kick) == [Decision.ACCEPTED] * SERIES
    assert (
        current(kick).ids
        == tuple(j.id for j in document.intervals if j.interval.start == 174)[::-1]
    )  # the next group
    press(qtbot, kick, KEY.Key_R)
    assert decided(kick).count(Decision.REJECTED) == PAIR
    (journal,) = journals(session_path(document.data.clip.path))
    steps = [json.loads(line) for line in journal.read_text("utf-8").splitlines()]
    assert [len(s["ids"]) for s in steps if s.get("do") == "Decide"] == [SERIES, PAIR]
    press(qtbot, kick, KEY.Key_Z, CTRL)
    assert current(kick).ids == kick.intervals.selected_ids()
    assert len(current(kick).ids) == PAIR
    press(qtbot, kick, KEY.Key_Z, CTRL)
    assert decided(kick) == []
    assert current(kick).name == SERIES_NAME


def test_a_key_before_the_picture_decides_no_group(qtbot, kick):
    press(qtbot, kick, KEY.Key_N)
    qtbot.waitUntil(kick.viewport.has_painted_interval)
    QTest.keyClick(kick, KEY.Key_N)
    QTest.keyClick(kick, KEY.Key_A)
    assert isinstance(current(kick), GroupRow)
    assert decided(kick) == []
    press(qtbot, kick, KEY.Key_A)
    assert len(decided(kick)) == SERIES


def test_right_unfolds_and_left_folds_wherever_the_focus_is(qtbot, kick):
    document = kick.document
    go_to_series(qtbot, kick)
    for focus in (kick.intervals.table, kick.viewport.view):
        focus.setFocus()
        frame = document.frame
        press_in(qtbot, kick, focus, KEY.Key_Right)
        assert (len(things(kick)), document.frame) == (3 + SERIES, frame)
        assert current(kick).unfolded
        press_in(qtbot, kick, focus, KEY.Key_Right)  # nothing left to unfold
        assert (len(things(kick)), document.frame) == (3 + SERIES, frame + 1)
        press_in(qtbot, kick, focus, KEY.Key_Left)
        assert (len(things(kick)), document.frame) == (3, frame + 1)
        press_in(qtbot, kick, focus, KEY.Key_Left)
        press_in(qtbot, kick, focus, KEY.Key_Period)  # only moves
        assert (len(things(kick)), document.frame) == (3, frame + 1)
        document.go_to(frame)
    kick.docks["history"].raise_()  # in front of the list
    qtbot.waitUntil(lambda: kick.intervals.table.visibleRegion().isEmpty())
    press(qtbot, kick, KEY.Key_Right)
    assert (len(things(kick)), document.frame) == (3, frame + 1)
    assert decided(kick) == []


@pytest.mark.thorough
def test_the_keyboard_goes_through_an_unfolded_group(qtbot, kick):
    """Also if the focus was in the 3D view: Right moves it into the list."""

    def go(key):
        press_in(qtbot, kick, kick.focusWidget(), key)

    go_to_series(qtbot, kick)
    group, members = current(kick).ids, SERIES
    kick.viewport.view.setFocus()
    go(KEY.Key_Right)
    seen = []
    for _ in range(members):
        go(KEY.Key_Down)
        seen += kick.intervals.selected_ids()
    assert sorted(seen) == sorted(group)
    assert kick.document.interval_id == seen[-1]
    for _ in range(members - 1):
        go(KEY.Key_Up)
    assert kick.intervals.selected_ids() == (seen[0],)
    frame = kick.document.frame
    go(KEY.Key_Right)  # there is nothing to unfold
    assert kick.document.frame == frame + 1
    go(KEY.Key_Left)
    assert (len(things(kick)), kick.intervals.selected_ids()) == (3, group)
    assert kick.document.frame == frame + 1
    go(KEY.Key_Left)
    assert kick.document.frame == frame
    go(KEY.Key_Down)  # the next group
    assert len(kick.intervals.selected_ids()) == PAIR
    assert decided(kick) == []


def test_outside_the_list_left_goes_back_a_frame(qtbot, kick):
    document = kick.document
    flip = next(j for j in document.intervals if j.interval.kind == Kind.LIMB_FLIP)
    document.select_interval(flip.id, jump=True)
    kick.viewport.view.setFocus()
    frame, rows = document.frame, len(things(kick))
    press_in(qtbot, kick, kick.viewport.view, KEY.Key_Left)
    assert (len(things(kick)), document.frame) == (rows, frame - 1)


def test_an_arrow_is_clicked(qtbot, kick):
    table = kick.intervals.table
    model = table.model()
    place = table.visualRect(model.index(1, 0)).topLeft() + QPoint(6, 6)
    for count in (3 + SERIES, 3):
        qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=place)
        assert len(things(kick)) == count
        assert len(kick.intervals.selected_ids()) == SERIES
    beyond = place + QPoint(60, 0)
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=beyond)
    assert len(things(kick)) == 3


@pytest.mark.thorough
def test_an_interval_of_an_unfolded_group_is_decided_alone(qtbot, kick):
    table = kick.intervals.table
    go_to_series(qtbot, kick)
    table.setFocus()
    press_in(qtbot, kick, table, KEY.Key_Right)
    press_in(qtbot, kick, table, KEY.Key_Down)
    first = kick.document.interval_id
    assert kick.intervals.selected_ids() == (first,)
    assert kick.detail.buttons[Decision.ACCEPTED].text() == "Accept"
    press_in(qtbot, kick, table, KEY.Key_R)
    assert decided(kick) == [Decision.REJECTED]
    assert texts(kick, "decision")[1] == "1 of 13"
    assert current(kick).group.name == SERIES_NAME  # the next one of the group
    for _ in range(SERIES - 1):
        press_in(qtbot, kick, table, KEY.Key_A)
    assert len(decided(kick)) == SERIES
    assert isinstance(current(kick), GroupRow)  # and then the next group
    assert len(kick.intervals.selected_ids()) == PAIR


def test_what_is_selected_elsewhere_is_one_interval(qtbot, kick):
    """A click in the plots or in 3D means an interval, not its group."""
    document = kick.document
    jump = next(j for j in document.intervals if j.interval.start == 52)
    document.select_interval(jump.id, jump=True)
    assert kick.intervals.selected_ids() == (jump.id,)
    assert len(things(kick)) == 3 + SERIES
    press(qtbot, kick, KEY.Key_A)
    assert decided(kick) == [Decision.ACCEPTED]
    assert document.review.state.find(jump.id).decision == Decision.ACCEPTED


def test_of_two_alternatives_the_surer_or_the_selected_one_is_shown(document):
    limb, chain, state = "LeftArm-LeftHand", "LeftArm", document.review.state
    offset = np.full(20, 0.5)
    sure = Interval(chain, 100, 120, offset, confidence=0.9, kind=Kind.CARRIED_ROLL, carried=True)
    flip = Interval(limb, 100, 120, 2.0 * offset, confidence=1.0, open=True, kind=Kind.LIMB_FLIP)
    review = state.with_intervals([Judged(1, sure), Judged(2, flip)], 3)
    document.review.state = review
    document._review_changed()

    def corrected():
        return [bool(document.offset(name)[110]) for name in (chain, limb)]

    changes = []
    document.intervals_changed.connect(lambda: changes.append(corrected()))
    assert corrected() == [True, False]
    document.select_interval(2)
    assert corrected() == [False, True]
    document.select_interval(1)
    assert changes == [[False, True], [True, False]]
    document.decide(Decision.ACCEPTED, [2])
    assert corrected() == [True, True]  # what accepting both would do
    document.select_interval(None)
    assert corrected() == [False, True]


def test_a_group_that_is_in_part_decided_is_gone_to_once(qtbot, kick):
    document = kick.document
    go_to_series(qtbot, kick)
    series = current(kick)
    document.decide(Decision.ACCEPTED, series.ids[:1])
    document.select_interval(None)
    document.go_to(0)
    press(qtbot, kick, KEY.Key_N)
    seen = []
    for _ in range(3):
        seen.append(kick.intervals.selected_ids())
        press(qtbot, kick, KEY.Key_N)
    assert sorted(map(len, seen)) == [1, PAIR, SERIES]
    assert document.interval_id in seen[0]


@pytest.mark.thorough
def test_groups_are_turned_off_and_this_is_remembered(qtbot, show_window, tmp_path, kick):
    go_to_series(qtbot, kick)
    act(kick, "group_errors")
    assert len(things(kick)) == FOUND
    assert kick.intervals.count.text() == "0 of 16 decided"
    press(qtbot, kick, KEY.Key_A)
    assert len(decided(kick)) == 1
    act(kick, "group_errors")
    assert len([thing for thing in things(kick) if isinstance(thing, GroupRow)]) == 2
    file = tmp_path / "grouping.json"
    first = show_window(Settings(turn_ms=0), file)
    act(first, "group_errors")
    close_window(qtbot, first)
    again = show_window(load_settings(file)[0], file)
    assert not again.actions_by_id["group_errors"].isChecked()
    open_clip(qtbot, again, ASSETS / "kick.bvh")
    assert len(things(again)) == FOUND


def test_a_filter_decides_what_is_in_a_group(qtbot, kick):
    kick.intervals.search.setText("flip")
    assert texts(kick, "stop")[0] == "The same error 5 times: right knee flips"
    press(qtbot, kick, KEY.Key_N)
    press(qtbot, kick, KEY.Key_A)
    assert len(decided(kick)) == 5  # A and R never judge what is not listed
    kick.intervals.search.clear()
    assert texts(kick, "decision")[1] == "5 of 13"


def test_a_group_without_corrections_is_seen_not_accepted(kick):
    rows = kick.intervals.table.model().sourceModel()
    kick.document.decide(Decision.ACCEPTED, [j.id for j in kick.document.intervals])
    group = next(row for row in things(kick) if isinstance(row, GroupRow))
    jumps = tuple(j for j in group.members if j.verdict == SEEN)
    assert 0 < len(jumps) < len(group.members)
    said = [
        rows.describe(row).texts[PLACE["decision"]]
        for row in (group, replace(group, members=jumps))
    ]
    assert said == ["✓ accepted", "✓ seen"]


def test_intervals_follow_their_group_in_every_order(qtbot, kick):
    go_to_series(qtbot, kick)
    press(qtbot, kick, KEY.Key_Right)
    table = kick.intervals.table
    down, up = Qt.SortOrder.DescendingOrder, Qt.SortOrder.AscendingOrder
    for column, order in itertools.product(["chain", "start", "delta", "kind"], (down, up)):
        table.sortByColumn(PLACE[column], order)
        rows = things(kick)
        at = next(k for k, thing in enumerate(rows) if getattr(thing, "unfolded", False))
        members = rows[at + 1 : at + 1 + SERIES]
        assert {thing.id for thing in members} == set(rows[at].ids)
        values = [kick.intervals._model.row_for(thing).sort[PLACE[column]] for thing in members]
        assert values == sorted(values, reverse=order == down), (column, order)
        spans = [table.columnSpan(row, PLACE["stop"]) > 1 for row in range(len(rows))]
        assert spans == [isinstance(thing, GroupRow) for thing in rows], (column, order)
    table.sortByColumn(-1, up)  # for the next test in this window


def test_an_interval_made_by_hand_is_in_no_group(kick):
    document = kick.document
    flip = next(j for j in document.intervals if j.interval.kind == Kind.LIMB_FLIP)
    document.insert_interval(0, document.data.proposed(flip.interval.chain, 33))
    made = next(j for j in document.intervals if j.by_hand)
    assert [thing.id for thing in things(kick) if thing.id == made.id] == [made.id]
    assert kick.intervals.count.text().endswith("2 groups")


def test_an_exercise_has_no_groups(open_document, qtbot):
    """Each of its intervals is decided: a group would tell which are alike."""
    document = open_document(ASSETS / "kick.bvh")
    document.data = replace(document.data, blind=True)
    panel = IntervalsPanel(document, Colours(LIGHT), Settings())
    qtbot.addWidget(panel)
    assert panel.table.model().rowCount() == FOUND


@pytest.mark.thorough
def test_a_group_is_named_in_the_language_of_the_window(qtbot, show_window):
    use_language("de")
    try:
        window = show_window()
        open_clip(qtbot, window, ASSETS / "kick.bvh")
        assert texts(window, "stop")[1:] == [
            "5-mal derselbe Fehler: rechtes Knie klappt um, und 8 weitere Fehler",
            "Rechtes Knie klappt um, mit dem Sprung an der Kante",
        ]
    finally:
        use_language("en")


def test_a_group_says_how_many_of_its_corrections_make_something_worse(qtbot, kick, monkeypatch):
    go_to_series(qtbot, kick)
    series = current(kick).ids
    plain = kick.detail.several.text()
    intervals = [j.interval for j in kick.document.intervals if j.id in series]
    worse = [i for i in intervals if i.open][:2]
    found = Interval.evidence.fget
    noted = property(
        lambda i: {
            **(found(i) or {}),
            **({"worse": ["bend"]} if any(i is w for w in worse) else {}),
        }
    )
    monkeypatch.setattr(Interval, "evidence", noted)
    kick.detail.show_selected(series)
    said = kick.detail.several.text().removeprefix(plain)
    assert " 2 " in said
    kick.detail.show_selected(series[:1])
    assert kick.detail.several.isHidden()
