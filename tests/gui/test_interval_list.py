"""The list of intervals: filters, columns, order; numbers and names as a person reads them."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QValidator

from inspector.panels.chains_panel import ChainsPanel
from inspector.panels.interval_columns import COLUMNS, PLACE, columns_that_fit
from inspector.panels.interval_filter import IntervalFilter
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.panels.rig_names import chain_joint_names, joint_names_unlike_label
from inspector.session.settings import Settings
from inspector.widgets.signed_numbers import SignedBox, format_number, format_signed_number
from inspector.widgets.theme import LIGHT, Colours
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, open_clip
from twistcore.detection import Interval, Kind
from twistcore.review import Annotate, Decide, Decision, Judged


@pytest.mark.parametrize(
    ("value", "digits", "with_sign", "without"),
    [
        (-109.06, 1, "−109.1", "−109.1"),
        (-0.04, 1, "0.0", "0.0"),
        (0.04, 1, "0.0", "0.0"),
        (-0.0, 2, "0.00", "0.00"),
        (0.06, 1, "+0.1", "0.1"),
        (np.float64(12.0), 0, "+12", "12"),
    ],
)
def test_a_number_has_a_real_minus_and_a_zero_no_sign(value, digits, with_sign, without):
    assert format_signed_number(value, digits) == with_sign
    assert format_number(value, digits) == without


def test_a_box_shows_a_minus_and_takes_either(qtbot):
    box = SignedBox(minimum=-180.0, maximum=180.0, decimals=2, suffix="°")
    qtbot.addWidget(box)
    box.setValue(-109.06)
    assert box.text() == "−109.06°"
    for typed in ("-20.5", "−20.5"):
        box.selectAll()
        box.lineEdit().insert(typed)  # as typed: checked by validate()
        qtbot.keyClick(box, Qt.Key.Key_Return)
        assert (box.value(), box.text()) == (-20.5, "−20.50°")
    assert box.validate("−", 1)[0] == QValidator.State.Intermediate
    assert box.validate("x", 1)[0] == QValidator.State.Invalid


def test_names_of_the_file_are_told_where_they_say_something_else(analysed):
    skeleton, limb = analysed.motion.skeleton, analysed.chains_and_limbs[-1]
    arm = next(c for c in analysed.chains if c.name == "LeftForeArm")
    assert chain_joint_names(arm, skeleton) == "LeftForeArm → LeftHand"
    assert chain_joint_names(limb, skeleton).count(" → ") == 2
    assert joint_names_unlike_label(arm, skeleton) == ""
    for prefix, named in (("mixamorig:", False), ("x", False)):
        names = tuple(f"{prefix}{name}" for name in skeleton.names)
        assert bool(joint_names_unlike_label(arm, replace(skeleton, names=names))) == named
    names = tuple({"LeftForeArm": "lradius"}.get(n, n) for n in skeleton.names)
    assert joint_names_unlike_label(arm, replace(skeleton, names=names)) == "lradius → LeftHand"


def judged(**changes):
    interval = Interval("LeftArm", 3, 5, np.ones(2), confidence=changes.pop("confidence", 0.9))
    return Judged(1, replace(interval, kind=changes.pop("kind", Kind.COUNTER_TWIST)), **changes)


@pytest.mark.parametrize(
    ("parts", "admitted"),
    [
        (("All", "Any confidence", ""), True),
        (("Undecided", "Any confidence", ""), True),
        (("Accepted", "Any confidence", ""), False),
        (("Limb flips", "Any confidence", ""), False),
        (("This chain", "Any confidence", ""), True),
        (("All", "≥ 0.95", ""), False),
        (("All", "< 0.95", ""), True),
        (("All", "Any confidence", ">=0.9"), True),
        (("All", "Any confidence", "> 0,9"), False),
        (("All", "≥ 0.50", "<0.8"), False),
        (("All", "Any confidence", "STRAP left"), True),
        (("All", "Any confidence", "strap right"), False),
    ],
)
def test_what_a_filter_admits(parts, admitted):
    named = "Left Arm loose strap"
    assert IntervalFilter.read(*parts).admits(judged(), True, lambda _: named) == admitted


def test_what_has_no_confidence_is_on_neither_side_of_a_bound():
    for bound in ("≥ 0.50", "< 0.50"):
        wanted = IntervalFilter.read("All", bound, "")
        assert not wanted.admits(judged(confidence=None), True, lambda _: "")


def test_an_error_of_another_chain_is_not_of_this_chain():
    for chosen, admitted in (("All", True), ("This chain", False)):
        wanted = IntervalFilter.read(chosen, "Any confidence", "")
        assert wanted.admits(judged(), False, lambda _: "") == admitted


def test_columns_go_one_by_one_as_room_gets_short():
    widths = {column.id: 60 for column in COLUMNS} | {"chain": 100}
    said = set(PLACE)
    before = columns_that_fit(widths, said, 2000)
    assert before == [c.id for c in COLUMNS if c.id != "joints"]
    for room in range(1000, 200, -7):
        shown = columns_that_fit(widths, said, room)
        assert set(shown) <= set(before)
        rest = room - 60 * (len(shown) - 1)
        assert rest >= 100 or shown == ["chain", "decision", "start", "delta"]
        before = shown


@pytest.fixture
def panel(qtbot, open_document):
    """The list of the walk with eight errors, 545 pixels wide."""
    panel = IntervalsPanel(open_document(INJECTED), Colours(LIGHT), Settings())
    panel.document = panel._document
    qtbot.addWidget(panel)
    panel.resize(545, 300)
    panel.show()
    return panel


def cut(table):
    """Texts wider than their column, but for the chain's; columns that end out of sight."""
    model = table.model()
    shown = [c for c in range(1, model.columnCount()) if not table.isColumnHidden(c)]
    return [
        model.index(row, c).data()
        for row in range(model.rowCount())
        for c in shown
        if table.sizeHintForIndex(model.index(row, c)).width() > table.columnWidth(c)
        or table.columnViewportPosition(c) + table.columnWidth(c) > table.viewport().width()
    ]


def test_the_columns_are_those_of_before_when_a_removed_chain_comes_back(qtbot, panel):
    def columns():
        return [c.id for c in COLUMNS if not panel.table.isColumnHidden(PLACE[c.id])]

    document, before = panel.document, columns()
    rig = document.review.state.rig
    document.change_chains(rig.without("LeftForeArm"), "Remove")
    qtbot.waitUntil(lambda: document.review.state.rig != rig)
    document.undo()
    qtbot.waitUntil(lambda: document.review.state.rig == rig)
    assert columns() == before


@pytest.mark.parametrize("width", [340, 400, 479, 545, 700, 1200])
def test_nothing_is_cut_whatever_the_decision_says(panel, width):
    document = panel.document
    first = document.intervals[0]
    document.do(Decide((first.id,), Decision.ACCEPTED, "Ada", "2026-01-01T00:00:00+00:00"))
    document.set_tau(np.radians(100.0), first.interval.chain)
    document.insert_interval(0, replace(first.interval, start=first.interval.start - 1,
                                        offset=np.ones(first.interval.frames + 1)))  # fmt: skip
    panel.resize(width, 300)
    texts = [panel.table.model().index(r, 1).data() for r in range(panel.table.model().rowCount())]
    assert "✓ accepted + <τ" in texts
    assert cut(panel.table) == []


def test_confidence_and_frames_are_seen_at_the_first_width(panel):
    assert {"confidence", "frames", "start", "stop", "delta"} <= set(panel.columns.shown())


def test_columns_and_order_are_chosen_and_kept(panel, qtbot, open_document):
    settings = panel.columns._settings
    menu = panel.columns.menu()
    ticked = {action.text(): action for action in menu.actions()}
    assert not ticked["Chain"].isEnabled()
    ticked["Time"].trigger()
    ticked["Joints in the file"].trigger()
    assert "time" not in settings.columns
    panel.table.sortByColumn(PLACE["delta"], Qt.SortOrder.DescendingOrder)
    assert settings.interval_sort == "-delta"
    largest = panel.shown_ids()
    other = IntervalsPanel(panel.document, Colours(LIGHT), settings)
    qtbot.addWidget(other)
    assert other.shown_ids() == largest
    assert other.columns.shown() == panel.columns.shown() == settings.columns
    again = {action.text(): action for action in panel.columns.menu().actions()}
    again["All columns that fit"].trigger()
    assert settings.columns == []
    assert "time" in panel.columns.shown()


def test_columns_of_another_version_do_no_harm(qtbot, open_document):
    settings = Settings(columns=["heat", "delta"], interval_sort="-heat")
    panel = IntervalsPanel(open_document(INJECTED), Colours(LIGHT), settings)
    qtbot.addWidget(panel)
    assert panel.columns.shown() == ["chain", "delta"]
    assert len(panel.shown_ids()) == 8


@pytest.mark.thorough
def test_a_search_finds_notes_and_reasons_and_is_what_is_judged(opened):
    document, panel = opened.document, opened.intervals
    number = document.intervals[3].id
    document.do(Annotate(number, "loose strap", "fast but real"))
    act(opened, "next_interval")
    panel.search.setText("strap")
    assert document.interval is None  # A and R never judge what is not listed
    assert panel.shown_ids() == (number,)
    panel.search.setText("FAST real upleg")
    assert panel.shown_ids() == (number,)
    restore = panel.list_all()
    assert len(panel.shown_ids()) == 8
    restore()
    assert panel.shown_ids() == (number,)
    panel.search.setText("nobody")
    assert panel.shown_ids() == ()


def test_the_ends_of_flips_are_a_column(opened, monkeypatch):
    panel, document = opened.intervals, opened.document
    assert "end" not in panel.columns.shown()
    index = panel.table.model().index(0, PLACE["end"])
    assert index.data() == ""
    flip = replace(document.intervals[0].interval, kind=Kind.LIMB_FLIP, carried=True)
    changed = (replace(document.intervals[0], interval=flip), *document.intervals[1:])
    monkeypatch.setattr(type(document), "intervals", property(lambda _: changed))
    document.intervals_changed.emit()
    assert index.data() == "turned"
    monkeypatch.undo()
    document.intervals_changed.emit()


@pytest.mark.parametrize("width", [300, 350])
def test_chains_fit_into_a_narrow_dock(qtbot, open_document, width):
    panel = ChainsPanel(open_document(INJECTED), Colours(LIGHT), QAction("Joint names…"))
    qtbot.addWidget(panel)
    panel.resize(width, 400)
    panel.show()
    assert cut(panel.table) == []
    assert panel.table.columnWidth(0) >= 95


def test_the_worst_come_first_and_other_orders_on_request(qtbot, show_window):
    settings = Settings(turn_ms=0, order="worst")
    window = show_window(settings)
    open_clip(qtbot, window, INJECTED)
    document = window.document
    severity = {j.id: document.severity(j) for j in document.intervals}
    listed = window.intervals.shown_ids()
    assert list(listed) == sorted(severity, key=severity.get, reverse=True)
    act(window, "next_interval")
    assert document.interval_id == listed[0]
    act(window, "next_interval")
    assert document.interval_id == listed[1]
    document.edit(listed[1], document.interval.interval.with_offset(0, np.full(300, 2.0)))
    assert window.intervals.shown_ids()[0] == document.interval_id == listed[1]
    act(window, "undo")
    act(window, "order_chain")
    assert window.intervals.shown_ids() == tuple(sorted(listed))
    act(window, "order_time")
    starts = [document.found(k).interval.start for k in window.intervals.shown_ids()]
    assert starts == sorted(starts)
    act(window, "order_worst")
    assert (settings.order, window.intervals.shown_ids()) == ("worst", listed)


def test_a_new_user_sees_the_worst_first():
    words = "from inspector.session.settings import Settings; print(Settings().order)"
    found = subprocess.run([sys.executable, "-c", words], text=True, capture_output=True)
    assert found.stdout.strip() == "worst", found.stderr


def test_a_row_that_is_clicked_shows_the_whole_interval_in_the_plots(qtbot, at_forearm):
    document, visible = at_forearm.document, at_forearm.timeline.visible
    short = min(document.intervals, key=lambda j: j.interval.frames)
    long = max(document.intervals, key=lambda j: j.interval.frames)
    document.select_interval(short.id, jump=True)
    visible.zoom_to_interval()
    table = at_forearm.intervals.table
    row = next(r for r in range(table.model().rowCount())
               if at_forearm.intervals._thing(r).judged.id == long.id)  # fmt: skip
    at = table.visualRect(table.model().index(row, 0)).center()
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    qtbot.waitUntil(lambda: document.interval_id == long.id)
    first, last = visible.ends
    assert first <= long.interval.start < long.interval.stop <= last
    document.select_interval(short.id)
    visible.show(long.interval.start, long.interval.stop - 2)
    ends = visible.ends
    document.select_interval(long.id)  # as by a drag in the plots, which must not move
    qtbot.wait(30)
    assert visible.ends == ends
