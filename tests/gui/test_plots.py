"""The time line under a simulated mouse. Needs a display; `dev.py test` brings one."""

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication

from inspector.session.document import Document
from inspector.session.opening import analyse_file
from inspector.timeline.tau_line import set_tau_degrees
from inspector.timeline.timeline import Timeline
from inspector.widgets.axes import degrees_to_root_scale
from inspector.widgets.theme import DARK, LIGHT, Colours
from tests.gui.pictures import INJECTED
from twistcore.detection import DETECTORS, Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.review import Decision, Insert

LEFT, NONE = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton


@pytest.fixture
def document(open_document):
    """The walk with eight errors."""
    return open_document(INJECTED)


@pytest.fixture
def show_timeline(qtbot, open_document):
    """Opens a clip's time line."""

    def show(path):
        return shown(qtbot, open_document(path))

    return show


@pytest.fixture
def timeline(qtbot, document):
    return shown(qtbot, document)


def shown(qtbot, document):
    timeline = Timeline(document, Colours(LIGHT))
    qtbot.addWidget(timeline)
    timeline.resize(1280, 300)
    with qtbot.waitExposed(timeline):
        timeline.show()
    qtbot.wait(50)
    return timeline


def spot(timeline, key, frame, share=0.5):
    """Place in a plot's viewport: a frame, and a share of the height from above."""
    pane = timeline.panes[key]
    low, high = pane.view.viewRange()[1]
    scene = pane.view.mapViewToScene(QPointF(frame, high - share * (high - low)))
    return QPointF(pane.mapFromScene(scene))


def send(pane, kind, place, button, buttons, modifiers=Qt.KeyboardModifier.NoModifier):
    there = QPointF(pane.viewport().mapToGlobal(place.toPoint()))
    event = QMouseEvent(kind, place, there, button, buttons, modifiers)
    QApplication.sendEvent(pane.viewport(), event)


def click(qtbot, timeline, key, place, button=LEFT):
    pane = timeline.panes[key]
    send(pane, QEvent.Type.MouseMove, place, NONE, NONE)
    send(pane, QEvent.Type.MouseButtonPress, place, button, button)
    send(pane, QEvent.Type.MouseButtonRelease, place, button, NONE)
    qtbot.wait(20)


def double_click(qtbot, timeline, key, place):
    pane = timeline.panes[key]
    click(qtbot, timeline, key, place)
    send(pane, QEvent.Type.MouseButtonDblClick, place, LEFT, LEFT)
    send(pane, QEvent.Type.MouseButtonRelease, place, LEFT, NONE)
    qtbot.wait(20)


def drag(qtbot, timeline, key, start, stop, steps=8):
    pane = timeline.panes[key]
    send(pane, QEvent.Type.MouseMove, start, NONE, NONE)
    send(pane, QEvent.Type.MouseButtonPress, start, LEFT, LEFT)
    for k in range(1, steps + 1):
        send(pane, QEvent.Type.MouseMove, start + (stop - start) * (k / steps), NONE, LEFT)
        qtbot.wait(5)
    send(pane, QEvent.Type.MouseButtonRelease, stop, LEFT, NONE)
    qtbot.wait(20)


def an_interval(document):
    """An interval of the selected chain that is broad enough to be gripped by its body."""
    mine = document.review.state.of_chain(document.chain)
    return max(mine, key=lambda j: j.interval.frames)


def zoom(qtbot, timeline, judged):
    timeline.visible.zoom_to_interval(judged)
    qtbot.wait(20)


# -- τ ----------------------------------------------------------------------------------------


def test_dragging_the_line_changes_tau_and_intervals_in_one_undo_step(qtbot, timeline, document):
    state = document.review.state
    before = state.of_chain(document.chain)
    assert before
    pane = timeline.panes["strength"]
    frame = 0.4 * document.frames
    low, high = pane.view.viewRange()[1]
    share = (high - timeline.tau_line.value()) / (high - low)
    drag(
        qtbot,
        timeline,
        "strength",
        spot(timeline, "strength", frame, share),
        spot(timeline, "strength", frame, 0.03),
    )
    tau = np.degrees(document.review.state.tau[document.chain])
    peak = np.degrees(document.detector.strength(document.chain).max())
    assert tau > 20.0
    assert timeline.tau_line.value() == pytest.approx(float(degrees_to_root_scale(tau)), abs=0.05)
    expected = document.detector.intervals(document.chain, np.radians(tau))
    assert len(document.review.state.of_chain(document.chain)) == len(expected)
    if tau > peak:
        assert not expected
    document.undo()
    assert document.review.state is state
    qtbot.wait(20)
    low, high = pane.view.viewRange()[1]
    assert low <= timeline.tau_line.value() <= high


def drag_and_escape(qtbot, timeline, key, start, stop, meanwhile):
    """Drag from `start` to `stop`, press Esc, and move back before the button is released."""
    pane = timeline.panes[key]
    send(pane, QEvent.Type.MouseMove, start, NONE, NONE)
    send(pane, QEvent.Type.MouseButtonPress, start, LEFT, LEFT)
    for share in (0.25, 0.5, 1.0):
        send(pane, QEvent.Type.MouseMove, start + (stop - start) * share, NONE, LEFT)
        qtbot.wait(10)
    meanwhile()
    qtbot.keyClick(timeline, Qt.Key.Key_Escape)
    send(pane, QEvent.Type.MouseMove, start + (stop - start) * 0.7, NONE, LEFT)
    qtbot.wait(10)
    send(pane, QEvent.Type.MouseButtonRelease, stop, LEFT, NONE)
    qtbot.wait(20)


@pytest.mark.parametrize("what", ["edge", "body", "new", "tau"])
def test_escape_cancels_a_drag_and_nothing_before_it(qtbot, timeline, document, what):
    judged = an_interval(document)
    document.select_interval(judged.id)
    document.decide(Decision.REJECTED)
    document.select_interval(judged.id)
    zoom(qtbot, timeline, judged)
    state, home = document.review.state, document.frame
    frame = {"edge": judged.interval.stop - 0.5, "body": judged.interval.seen_at + 1}
    begin = frame.get(what, judged.interval.stop + 3.0)
    key, shares = "theta", (0.5, 0.5)
    if what == "tau":
        low, high = timeline.panes["strength"].view.viewRange()[1]
        key, shares = "strength", ((high - timeline.tau_line.value()) / (high - low), 0.1)

    def meanwhile():
        assert (document.review.state is state) == (what == "new")

    drag_and_escape(
        qtbot,
        timeline,
        key,
        spot(timeline, key, begin, shares[0]),
        spot(timeline, key, begin + 5.0, shares[1]),
        meanwhile,
    )
    assert document.review.state is state
    assert document.frame == home
    assert not timeline.gestures.dragging
    assert not timeline.tau_line.held
    document.undo()
    document.review.mark_saved()


def test_double_click_on_the_strength_sets_tau(qtbot, timeline, document):
    wanted = 12.0
    low, high = timeline.panes["strength"].view.viewRange()[1]
    share = (high - float(degrees_to_root_scale(wanted))) / (high - low)
    double_click(qtbot, timeline, "strength", spot(timeline, "strength", 5, share))
    tau = np.degrees(document.review.state.tau[document.chain])
    assert tau == pytest.approx(wanted, abs=1.5)
    assert timeline.panes["strength"].front.tau[1] == f"τ {tau:.1f}°"


def test_tau_is_in_view_whatever_it_is(qtbot, timeline, document):
    for degrees in (0.1, 5.0, 60.0, 180.0):
        set_tau_degrees(document, degrees)
        timeline.refresh()
        low, high = timeline.panes["strength"].view.viewRange()[1]
        assert low <= timeline.tau_line.value() <= high


# -- intervals --------------------------------------------------------------------------------


def test_dragging_an_edge_is_one_undo_step_of_whole_frames(qtbot, timeline, document):
    judged = an_interval(document)
    zoom(qtbot, timeline, judged)
    state, start, stop = document.review.state, judged.interval.start, judged.interval.stop
    drag(
        qtbot,
        timeline,
        "theta",
        spot(timeline, "theta", stop - 0.5),
        spot(timeline, "theta", stop + 4.6),
    )
    edited = document.review.state.find(judged.id)
    assert (edited.interval.start, edited.interval.stop) == (start, stop + 5)
    assert isinstance(edited.interval.stop, int)
    assert document.interval_id == judged.id
    document.undo()
    assert document.review.state is state


def test_an_edge_dragged_back_gives_the_interval_back(qtbot, timeline, document):
    judged = an_interval(document)
    zoom(qtbot, timeline, judged)
    edge = spot(timeline, "offset", judged.interval.start - 0.5)
    inside = spot(timeline, "offset", judged.interval.start + 1.5)
    pane = timeline.panes["offset"]
    send(pane, QEvent.Type.MouseMove, edge, NONE, NONE)
    send(pane, QEvent.Type.MouseButtonPress, edge, LEFT, LEFT)
    for place in (inside, edge):
        for _ in range(2):
            send(pane, QEvent.Type.MouseMove, place, NONE, LEFT)
            qtbot.wait(10)
    send(pane, QEvent.Type.MouseButtonRelease, edge, LEFT, NONE)
    again = document.review.state.find(judged.id).interval
    assert (again.start, again.stop) == (judged.interval.start, judged.interval.stop)
    np.testing.assert_array_equal(again.offset, judged.interval.offset)


def test_an_interval_keeps_a_frame_and_stays_in_the_clip(qtbot, timeline, document):
    judged = an_interval(document)
    zoom(qtbot, timeline, judged)
    edge = spot(timeline, "theta", judged.interval.stop - 0.5)
    drag(qtbot, timeline, "theta", edge, edge - QPointF(4000, 0))
    assert document.review.state.find(judged.id).interval.frames == 1
    document.undo()
    timeline.refresh()
    body = spot(timeline, "theta", 0.5 * (judged.interval.start + judged.interval.stop - 1))
    drag(qtbot, timeline, "theta", body, body + QPointF(9000, 0))
    moved = document.review.state.find(judged.id).interval
    assert moved.stop == document.frames
    assert moved.frames == judged.interval.frames


def test_dragging_the_body_moves_it(qtbot, timeline, document):
    judged = an_interval(document)
    zoom(qtbot, timeline, judged)
    middle = 0.5 * (judged.interval.start + judged.interval.stop - 1)
    here, there = (spot(timeline, "strength", f, 0.3) for f in (middle, middle + 6))
    drag(qtbot, timeline, "strength", here, there)
    moved = document.review.state.find(judged.id).interval
    assert moved.start == judged.interval.start + 6
    np.testing.assert_allclose(moved.offset, judged.interval.offset, atol=1e-9)


def test_clicking_a_region_selects_it_and_leaves_the_playhead(qtbot, timeline, document):
    judged = an_interval(document)
    document.select_interval(None)
    document.go_to(document.frames - 1)
    zoom(qtbot, timeline, judged)
    middle = 0.5 * (judged.interval.start + judged.interval.stop - 1)
    click(qtbot, timeline, "theta", spot(timeline, "theta", middle))
    assert document.interval_id == judged.id
    assert document.frame == document.frames - 1


def test_regions_follow_undo_and_redo(qtbot, timeline, document):
    def shown():
        timeline.refresh()
        return [(j.id, j.interval.start, j.interval.stop) for j in timeline.scenery.intervals]

    first = shown()
    set_tau_degrees(document, 179.0)
    assert shown() == []
    document.undo()
    assert shown() == first
    document.redo()
    assert shown() == []


# -- time -------------------------------------------------------------------------------------


def test_playhead_drags_and_clicks_move_it(qtbot, timeline, document):
    document.select_interval(None)
    set_tau_degrees(document, 180.0)  # no regions in the way
    timeline.refresh()
    document.go_to(100)
    here, there = spot(timeline, "theta", 100), spot(timeline, "theta", 200)
    drag(qtbot, timeline, "theta", here, there)
    assert document.frame == 200
    click(qtbot, timeline, "delta", spot(timeline, "delta", 50))
    assert document.frame == 50
    assert timeline.scenery.frame == 50
    assert "frame  50" in timeline.readout.text()


def test_a_click_at_a_peak_in_no_interval_goes_there_and_says_why(qtbot, show_timeline, lone_turn):
    timeline = show_timeline(lone_turn)
    document, told = timeline.document, []
    document.answered.connect(told.append)
    document.select_chain("LeftArm")
    timeline.refresh()
    document.go_to(20)
    click(qtbot, timeline, "strength", spot(timeline, "strength", 201))
    assert document.frame == 200
    (text,) = told
    assert "frame 200" in text
    assert "LeftArm" in text
    click(qtbot, timeline, "strength", spot(timeline, "strength", 100))  # no peak
    click(qtbot, timeline, "delta", spot(timeline, "delta", 201))  # no strength
    assert document.frame == 201
    assert len(told) == 1


def test_the_curves_fit_the_interval_they_zoom_to(qtbot, show_timeline):
    timeline = show_timeline(INJECTED)
    document, theta = timeline.document, timeline.panes["theta"]
    document.select_interval(document.intervals[0].id, jump=True)
    timeline.refresh()
    whole = np.ptp(theta.view.viewRange()[1])
    timeline.visible.zoom_to_interval()
    timeline.refresh()
    low, high = theta.view.viewRange()[1]
    assert high - low < 0.25 * whole  # 20.8° of 330°
    interval = document.interval.interval
    first, last = timeline.visible.ends
    assert interval.frames >= (last - first) / 8.0
    for name, (y, _) in theta.values.items():
        seen = y[int(np.ceil(first)) : int(last) + 1]
        seen = seen[np.isfinite(seen)]
        assert ((low <= seen) & (seen <= high)).all(), name
    document.edit(document.interval_id, interval.with_offset(interval.start, interval.offset * 4.0))
    timeline.refresh()
    assert np.ptp(theta.view.viewRange()[1]) > 1.5 * (high - low)  # still in view
    timeline.fit()
    assert np.ptp(theta.view.viewRange()[1]) >= 0.99 * whole


def test_an_interval_of_a_frame_is_wide_enough_to_grab(qtbot, show_timeline):
    timeline = show_timeline(INJECTED)
    document = timeline.document
    (short,) = [j for j in document.intervals if j.interval.frames == 1]
    document.select_chain(short.interval.chain)
    timeline.refresh()
    middle, pixel = float(short.interval.start), 1.0  # frames per pixel
    parts = [timeline.gestures.hit(middle + x * pixel, pixel).part.value for x in (-4, 0, 4)]
    assert parts == ["start", "body", "stop"]


def test_wheel_zooms_at_the_cursor_and_shift_pans(qtbot, timeline, document):
    pane = timeline.panes["delta"]

    def wheel(frame, modifiers):
        place = spot(timeline, "delta", frame)
        event = QWheelEvent(
            place,
            QPointF(pane.viewport().mapToGlobal(place.toPoint())),
            QPointF(0, 0).toPoint(),
            QPointF(0, 120).toPoint(),
            NONE,
            modifiers,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
        QApplication.sendEvent(pane.viewport(), event)

    before = timeline.visible.ends
    wheel(80, Qt.KeyboardModifier.NoModifier)
    first, last = timeline.visible.ends
    assert last - first < before[1] - before[0]
    at = (80 - before[0]) / (before[1] - before[0])
    assert (80 - first) / (last - first) == pytest.approx(at, abs=0.01)
    wheel(80, Qt.KeyboardModifier.ShiftModifier)
    panned = timeline.visible.ends
    assert panned[1] - panned[0] == pytest.approx(last - first)
    assert panned != (first, last)
    for pane in timeline.panes.values():
        assert tuple(pane.view.viewRange()[0]) == pytest.approx(panned)
    timeline.visible.show_all()
    assert timeline.visible.ends == pytest.approx(before)


def test_view_follows_the_playhead_out_of_sight(qtbot, timeline, document):
    timeline.visible.show(0, 60)
    document.go_to(document.frames - 5)
    first, last = timeline.visible.ends
    assert first <= document.frame <= last


def test_a_drag_on_empty_ground_draws_an_interval_in_one_step(qtbot, timeline, document):
    state = document.review.state
    here, there = (spot(timeline, "delta", frame) for frame in (250, 280))
    drag(qtbot, timeline, "delta", there, here)  # backwards
    drawn = document.interval
    assert drawn.by_hand
    assert (drawn.interval.chain, drawn.interval.start, drawn.interval.stop) == (
        document.chain, 250, 281,
    )  # fmt: skip
    assert document.frame in range(250, 281)
    assert timeline.scenery.drag_label is None
    document.undo()
    assert document.review.state is state
    drag(qtbot, timeline, "delta", here, here + QPointF(40, 0))
    document.undo()
    assert document.review.state is state
    send(timeline.panes["delta"], QEvent.Type.MouseButtonPress, here, LEFT, LEFT)
    for place in (here + QPointF(40, 0), here + QPointF(1, 0)):  # and back: nothing is drawn
        send(timeline.panes["delta"], QEvent.Type.MouseMove, place, NONE, LEFT)
        qtbot.wait(10)
    send(timeline.panes["delta"], QEvent.Type.MouseButtonRelease, here, LEFT, NONE)
    assert document.review.state is state


def test_a_flip_is_drawn_on_a_limb(qtbot, timeline, document):
    limb = document.data.analysis.limbs[0].name
    document.select_chain(limb)
    timeline.refresh()
    qtbot.wait(50)  # its own plots find their places
    drag(qtbot, timeline, "height", spot(timeline, "height", 100), spot(timeline, "height", 130))
    assert document.interval.interval.kind == Kind.LIMB_FLIP
    assert (document.interval.interval.start, document.interval.interval.stop) == (100, 131)


def test_the_overview_hits_the_interval_of_the_nearest_row(qtbot, timeline, document):
    strip = timeline.overview
    rows = strip._rows()
    assert set(rows) == {j.interval.chain for j in document.intervals} | {document.chain}
    for judged in document.intervals:
        top, height = rows[judged.interval.chain]
        middle = 0.5 * (judged.interval.start + judged.interval.stop - 1)
        assert strip.interval_at(QPointF(strip._x(middle), top + 0.5 * height)) is judged
    top, height = rows[document.chain]
    assert strip.interval_at(QPointF(strip._x(30), top + 0.5 * height)) is None


def test_values_stay_as_they_were_zoomed_until_another_chain(qtbot, timeline, document):
    view = timeline.panes["strength"].time
    whole = view.viewRange()[1]
    view.zoom_values(0.0, 4.0)
    close = view.viewRange()[1]
    assert close[1] == pytest.approx(whole[1] * 1.25**-4)
    set_tau_degrees(document, 90.0)  # another range would show all
    timeline.refresh()
    assert view.viewRange()[1] == close
    view.zoom_values(0.0, -100.0)
    assert np.ptp(view.viewRange()[1]) < 10.0 * np.ptp(whole)
    document.select_chain("RightUpLeg")
    timeline.refresh()
    assert not view.zoomed


def test_overview_moves_the_playhead(qtbot, timeline, document):
    strip = timeline.overview
    qtbot.mouseClick(strip, LEFT, pos=strip.rect().center())
    assert abs(document.frame - document.frames // 2) <= 2


# -- menu, plots, states ----------------------------------------------------------------------


def test_menu_never_deletes_and_judges_what_it_was_opened_on(qtbot, timeline, document):
    judged = an_interval(document)
    menu = timeline.gestures.open_menu(
        "strength",
        float(judged.interval.start),
        3.0,
        timeline.mapToGlobal(timeline.rect().center()),
    )
    actions = {a.text(): a for a in menu.actions() if a.text()}
    assert not [text for text in actions if "elete" in text or "emove" in text]
    assert "Set τ to 9.0°" in actions
    actions["Reject"].trigger()
    assert document.review.state.find(judged.id).decision == Decision.REJECTED
    menu.close()


def test_new_interval_is_selected_and_by_hand(qtbot, timeline, document):
    set_tau_degrees(document, 180.0)
    count = len(document.intervals)
    document.insert_interval(150)
    assert len(document.intervals) == count + 1
    assert document.interval.by_hand
    assert document.interval.interval.start <= 150 < document.interval.interval.stop


def test_plots_hide_and_come_back(qtbot, timeline):
    timeline.show_plot("delta", shown=False)
    assert not timeline.panes["delta"].isVisible()
    assert timeline.panes["theta"].isVisible()
    timeline.show_plot("delta", shown=True)
    assert timeline.panes["delta"].isVisible()


def test_without_a_clip_there_is_a_hint(qtbot):
    timeline = Timeline(Document(), Colours(DARK))
    qtbot.addWidget(timeline)
    timeline.resize(900, 280)
    timeline.show()
    timeline.refresh()
    assert timeline.grid.hint.text()
    assert timeline.grid.hint.isVisible()


def test_every_chain_draws_in_both_themes(qtbot, timeline, document):
    for theme in (DARK, LIGHT):
        timeline.scenery.colours.use(theme)
        for chain in document.data.chains:
            document.select_chain(chain.name)
            timeline.refresh()
            assert not timeline.grab().isNull()


def test_another_clip_may_be_jumped_through_at_once(qtbot, timeline, document):
    longer = analyse_file(INJECTED.with_name("dance.bvh"))
    assert longer.motion.frames > document.frames
    document.show_clip(longer)
    document.go_to(document.frames - 1)
    timeline.refresh()
    assert timeline.visible.ends[1] > longer.motion.frames - 1


def test_a_crowd_of_regions_is_drawn(qtbot, timeline, document):
    for start in range(0, document.frames - 1, 2):
        document.do(Insert(new_constant_offset_interval(document.chain, start, start + 1, 0.1)))
    timeline.refresh()
    assert not timeline.grab().isNull()
    timeline.visible.show(10, 40)
    assert not timeline.grab().isNull()


def test_the_other_detector_stands_beside(qtbot, timeline, document):
    """Its own τ, its own intervals, of the chain that is selected; it follows clip and method."""
    timeline.toggles["other"].setChecked(True)
    qtbot.waitUntil(lambda: bool(timeline.panes["other"].intervals))
    paper = DETECTORS["paper"].analyse(document.data.motion, document.data.chains)

    def wanted(chain):
        found = paper.intervals(chain, paper.automatic_tau(chain))
        return [(i.start, i.stop) for i in found]

    def shown():
        return [(j.interval.start, j.interval.stop) for j in timeline.panes["other"].intervals]

    assert shown() == wanted(document.chain)
    before = document.review.state
    edge = timeline.panes["other"].intervals[0].interval.start - 0.5
    drag(qtbot, timeline, "other", spot(timeline, "other", edge), spot(timeline, "other", 60))
    assert document.review.state == before  # nothing of it is under review
    document.select_chain("RightUpLeg")
    timeline.refresh()
    assert shown() == wanted("RightUpLeg")
    document.use_method("paper")
    timeline.refresh()
    assert timeline.panes["other"].method == "consistency"
    qtbot.waitUntil(lambda: bool(timeline.panes["other"].intervals))
    ours = DETECTORS["consistency"].analyse(document.data.motion, document.data.chains)
    found = ours.intervals("RightUpLeg", ours.automatic_tau("RightUpLeg"))
    assert shown() == [(i.start, i.stop) for i in found]
    document.review.mark_saved()
