"""Stretches and spikes in the window: shown before and after, edited, accepted and exported."""

import numpy as np
import pytest
from PySide6.QtCore import Qt

import twistcore as tc
from inspector.session.open_clip import Show
from inspector.session.settings import Settings
from tests.gui.windows import act, open_clip, press
from tests.twistcore.test_joint_repairs import (
    ACROSS,
    SKELETON,
    WALK,
    spiked,
    the_only,
    tilted,
    turned,
)
from twistcore.review import Decision, read_session
from twistcore.skeleton.rotation import geodesic_angle

ONE_WINDOW = True
FOOT = SKELETON.index("LeftFoot")


@pytest.fixture
def opened(qtbot, window_for_clips, tmp_path):
    """A clip with a foot that stays turned, and a spike of a forearm; the stretch is selected."""
    path = tmp_path / "clip.bvh"
    both = turned("LeftFoot", 200, 260).rotations.copy()
    arm = SKELETON.index("LeftForeArm")
    both[:, arm] = spiked("LeftForeArm", 150, 152).rotations[:, arm]
    tc.write_clip(WALK, WALK.motion.with_rotations(both), path)
    window = window_for_clips(Settings(turn_ms=0), (1280, 800))
    open_clip(qtbot, window, path)
    select(window, tc.Kind.STRETCH)
    return window


def select(window, kind):
    judged = the_only(window.document.review.state, kind)
    window.document.select_interval(judged.id, jump=True)
    return judged


def row_of(window, judged):
    """The cells of an interval's row in the table."""
    model = window.intervals.table.model()
    rows = (
        [str(model.index(r, c).data()) for c in range(model.columnCount())]
        for r in range(model.rowCount())
    )
    kind, start = judged.interval.kind, str(judged.interval.start)
    return next(cells for cells in rows if kind in cells and start in cells)


def test_a_stretch_is_reviewed_like_any_other_error(qtbot, opened):
    document, card = opened.document, opened.detail
    captured, corrected = (document.pose(230, after=after)[0] for after in (False, True))
    assert np.degrees(geodesic_angle(captured, corrected)[FOOT]) == pytest.approx(150.0, abs=3.0)
    document.set_show(Show.AFTER)
    assert "Accept the detection to turn LeftFoot back" in card.why.text()
    assert all(box.isEnabled() for box in (card.start, card.stop, card.delta))
    assert card.delta.value() == pytest.approx(150.0, abs=3.0)
    assert not card.end.isHidden()
    assert card.end.shown == "carried along"

    before = document.review.state
    card.delta.setValue(150.0)
    act(opened, "turn_end")
    assert card.end.shown == "kept"
    document.go_to(205)
    act(opened, "start_here")
    interval = document.interval.interval
    assert (interval.start, interval.stop, interval.carried) == (205, 260, False)
    assert np.degrees(interval.offset) == pytest.approx(np.full(55, 150.0))
    act(opened, "make_following")
    assert "same offset in all its frames" in opened.bar.label.text()
    assert document.interval.interval is interval
    for _ in range(3):
        press(qtbot, opened, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert document.review.state is before


@pytest.mark.thorough
def test_accepting_it_corrects_the_exported_file(qtbot, opened):
    document = opened.document
    stretch, spike = (the_only(document.review.state, k) for k in (tc.Kind.STRETCH, tc.Kind.SPIKE))
    act(opened, "accept")
    accepted = document.found(stretch.id)
    assert accepted.verdict == "accepted"
    assert "✓ accepted" in row_of(opened, accepted)
    assert spike.interval not in document.review.state.chosen()
    assert spike.id not in document.automatic_ids(0.0, include_open=True)
    act(opened, "export_at_once")
    written = document.data.clip.path.with_name("clip_refined.bvh")
    qtbot.waitUntil(written.is_file)
    turn = geodesic_angle(tc.read_clip(written).motion.rotations, document.data.motion.rotations)
    changed = np.argwhere(turn > 1e-6)
    assert {*changed[:, 1].tolist()} == {FOOT}
    assert {*changed[:, 0].tolist()} == set(range(200, 260))
    opened.files.save_session()
    path = document.data.clip.path.with_name("clip.twist.json")
    assert the_only(read_session(path).state, tc.Kind.STRETCH).decision == Decision.ACCEPTED


def test_a_spike_has_frames_but_no_angle_to_edit(opened):
    document, card = opened.document, opened.detail
    spike = select(opened, tc.Kind.SPIKE)
    assert "joints below" in card.why.text()
    assert (card.start.isEnabled(), card.delta.isEnabled()) == (True, False)
    assert card.end.isHidden()
    card.stop.setValue(card.stop.value() + 1)
    assert document.interval.interval.frames == spike.interval.frames + 1
    before, after = (document.pose(151, after=after)[1] for after in (False, True))
    below = SKELETON.index("LeftHand")
    assert np.linalg.norm(before[below] - after[below]) > 0.1
    act(opened, "accept")
    assert document.found(spike.id).verdict == "accepted"


def test_a_lone_jump_refers_to_the_stretch_that_begins_there(opened):
    document = opened.document
    jumps = [j for j in document.intervals if j.interval.kind == tc.Kind.LONE_JUMP]
    assert [j.interval.start for j in jumps] == [200, 260]
    for jump in jumps:
        document.select_interval(jump.id)
        assert "Another interval (frames 200–260) begins or ends here" in opened.detail.why.text()


def test_insert_at_a_lone_jump_makes_the_stretch_that_it_may_begin(opened):
    """To the next jump of the joint; a stretch with the same frames is selected instead."""
    document = opened.document
    found = the_only(document.review.state, tc.Kind.STRETCH)
    first, last = (j for j in document.intervals if j.interval.kind == tc.Kind.LONE_JUMP)
    document.select_interval(first.id, jump=True)
    act(opened, "insert_interval")
    assert document.interval_id == found.id
    document.edit(found.id, found.interval.with_offset(210, found.interval.offset[10:]))
    document.select_interval(last.id, jump=True)
    act(opened, "insert_interval")
    made = document.interval
    assert made.by_hand
    assert (made.interval.kind, made.interval.joint) == (tc.Kind.STRETCH, "LeftFoot")
    assert (made.interval.start, made.interval.stop, made.interval.carried) == (200, 260, True)
    assert np.degrees(made.interval.delta) == pytest.approx(150.0, abs=3.0)
    assert opened.detail.why.text().endswith("Made by hand.")
    act(opened, "remove_interval")
    assert document.found(made.id) is None


@pytest.mark.parametrize("stop", [110, 160])
def test_insert_at_a_joint_jump_makes_what_fits_or_says_that_nothing_does(
    qtbot, show_window, tmp_path, stop
):
    path = tmp_path / "clip.bvh"
    tc.write_clip(WALK, tilted("LeftFoot", 100, stop, ACROSS), path)
    window = show_window(size=(1280, 800))
    open_clip(qtbot, window, path)
    document, before = window.document, window.document.review.state
    jump = next(j for j in before.intervals if j.interval.kind == tc.Kind.JOINT_JUMP)
    document.select_interval(jump.id, jump=True)
    assert "press Insert" in window.detail.why.text()
    act(window, "insert_interval")
    if stop == 160:
        assert "No correction fits this jump: LeftFoot" in window.bar.label.text()
        assert document.review.state is before
    else:
        made = document.interval
        assert made.by_hand
        assert (made.interval.kind, made.interval.start, made.interval.stop) == ("spike", 100, 110)


@pytest.mark.thorough
def test_an_earlier_version_s_session_gets_the_offset_that_it_lacks(qtbot, opened, show_window):
    """Only where nobody has decided: an accepted one stays as it was seen."""
    import json

    opened.files.save_session()
    path = opened.document.data.clip.path.with_name("clip.twist.json")
    document = json.loads(path.read_text("utf-8"))
    for entry in document["intervals"]:
        if entry["kind"] in ("stretch", "spike"):
            entry |= {"offset_deg": 0.0, "carried": False}
        if entry["kind"] == "spike":
            entry |= {"decision": "accepted", "reviewer": "Ada"}
    path.write_text(json.dumps(document), "utf-8")
    window = show_window()
    open_clip(qtbot, window, path)
    state = window.document.review.state
    stretch, spike = (the_only(state, k) for k in (tc.Kind.STRETCH, tc.Kind.SPIKE))
    assert (stretch.interval.correctable, stretch.interval.carried) == (True, True)
    assert (spike.verdict, spike.interval.offset.any()) == ("seen", False)
