"""The quality tab in the real window: evidence, tracking, its picture, and the lesson beside it."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

from inspector.session.export_files import ExportChoice
from inspector.session.settings import Settings
from inspector.teaching.five_trackers import fixed_axis_rotations, tracker_errors
from tests.conftest import ASSETS
from tests.gui.pictures import INJECTED, changed, picture
from tests.gui.windows import act, open_clip, wait_until_active
from tests.twistcore.test_noise_bursts import ARM, HAND, START, noisy
from twistcore.analysis.quality.joint import joint_quality
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.quamo import Gains
from twistcore.quamo.clip_tracking import DEMONSTRATION, network_weights_identifier, tracked_motion
from twistcore.review import Decide, Decision, Review, Track, Tracking
from twistcore.review.session import session_bytes
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import wrap
from twistcore.skeleton.signals import twist_signals

ONE_WINDOW = True

PLACE = "Hips, position"


@pytest.fixture
def window(qtbot, window_for_clips, tmp_path):
    window = window_for_clips(Settings(turn_ms=0), size=(1280, 800))
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path))
    return window


@pytest.fixture
def quality(qtbot, window):
    act(window, "show_quality")
    qtbot.waitUntil(lambda: window.quality.evidence.known is not None, timeout=10_000)
    qtbot.wait(50)
    return window.quality


def column(quality, number):
    rows = range(quality.model.rowCount())
    return [quality.model.index(row, number).data() for row in rows]


def track(qtbot, quality, *joints, spline=False):
    if spline:
        quality.page.spline.setChecked(True)
    elif quality.page.spline.isChecked():
        quality.page.both_ways.setChecked(True)
    quality.choose(*joints)
    qtbot.wait(30)
    quality.track()
    qtbot.waitUntil(lambda: quality.tracked.result is not None, timeout=10_000)
    qtbot.wait(50)


# --- evidence -----------------------------------------------------------------------------------


@pytest.mark.thorough
def test_nothing_is_computed_before_the_tab_is_seen(qtbot, window):
    qtbot.wait(150)
    assert window.quality.evidence.known is None
    assert not window.quality.evidence.running


def test_the_table_holds_the_numbers_of_the_core_worst_first(window, quality):
    clip = read_bvh(INJECTED)
    core = joint_quality(clip, forward_kinematics(clip.motion)[1])
    shown = [float(text) for text in column(quality, 1)[:-1]]  # the place has none
    assert shown == [round(float(v), 2) for v in sorted(core.usual_jitter, reverse=True)]
    worst = clip.motion.skeleton.names[int(np.argmax(core.usual_jitter))]
    assert column(quality, 0)[0] == worst
    slides = dict(zip(column(quality, 0), column(quality, 4), strict=True))
    assert slides["LeftForeArm"] == "–"
    foot = clip.motion.skeleton.index("RightFoot")
    assert slides["RightFoot"] == f"{core.slides[foot]:.1f}"


@pytest.mark.thorough
def test_another_column_sorts_and_draws_its_curve_and_the_selection_stays(qtbot, window, quality):
    quality.choose("LeftForeArm")
    quality.table.sortByColumn(3, Qt.SortOrder.DescendingOrder)
    qtbot.wait(50)
    speeds = [float(text) for text in column(quality, 3)[:-1]]
    assert speeds == sorted(speeds, reverse=True)
    assert quality.chosen == ("LeftForeArm",)
    joint = window.document.data.motion.skeleton.index("LeftForeArm")
    drawn = quality.plot.curves[0].getData()[1]
    np.testing.assert_array_equal(drawn, quality.evidence.known.joints.speed[:, joint])
    quality.table.sortByColumn(4, Qt.SortOrder.AscendingOrder)
    assert column(quality, 4)[-1] == "–"  # no number is not the least slide


@pytest.mark.thorough
def test_a_click_in_the_curve_goes_to_the_frame_and_the_playhead_follows(qtbot, window, quality):
    plot = quality.plot
    scene = plot.view.mapViewToScene(QPointF(120.0, 0.0))
    place = plot.mapFromScene(QPointF(scene.x(), plot.viewport().height() / 2))
    QTest.mouseClick(plot.viewport(), Qt.MouseButton.LeftButton, pos=place)
    qtbot.wait(30)
    assert window.document.frame == pytest.approx(120, abs=1)
    window.document.go_to(33)
    assert plot.playhead.value() == 33


@pytest.mark.thorough
def test_a_chain_chosen_elsewhere_selects_its_joint(window, quality):
    window.document.select_chain("RightLeg")
    assert quality.model.names[quality.joint] == "RightLeg"
    assert len(quality.chosen) == len(quality.model.rows)  # nobody has selected what to track


@pytest.mark.thorough
def test_another_clip_gets_its_own_numbers(qtbot, window, quality, tmp_path):
    before = column(quality, 1)
    window.document.review.mark_saved()
    with qtbot.waitSignal(window.document.opened, timeout=10_000):
        window.open_path(type(ASSETS)(shutil.copy(ASSETS / "dance.bvh", tmp_path)))
    qtbot.waitUntil(lambda: quality.evidence.known is not None, timeout=10_000)
    assert len(quality.evidence.known.curve(0, 0)) == window.document.frames
    assert column(quality, 1) != before


# --- tracking -----------------------------------------------------------------------------------


@pytest.mark.thorough
def test_it_never_runs_unasked_and_the_warning_stands_there(qtbot, window, quality):
    qtbot.wait(300)
    assert quality.tracked.result is None
    assert window.document.review.state.tracking is None
    assert "blurs" in quality.page.warning.text()
    assert DEMONSTRATION in quality.page.warning.text()


def test_tracking_is_a_step_of_the_review_that_undo_takes_back(qtbot, window, quality):
    track(qtbot, quality, "LeftForeArm", "LeftHand")
    tracking = quality.page.tracking(("LeftForeArm", "LeftHand"), PLACE)
    assert window.document.review.state.tracking == tracking
    assert window.document.review.undo_text == "Track 2 joints"
    expected = tracked_motion(shown_motion(window.document), tracking)
    rotations, positions = forward_kinematics(expected)
    np.testing.assert_array_equal(quality.tracked.result.rotations, rotations)
    np.testing.assert_array_equal(quality.tracked.result.positions, positions)
    act(window, "undo")
    assert window.document.review.state.tracking is None
    assert quality.tracked.result is None
    act(window, "redo")
    qtbot.waitUntil(lambda: quality.tracked.result is not None, timeout=10_000)
    act(window, "stop_tracking")
    assert window.document.review.state.tracking is None


def shown_motion(document):
    """The motion with all intervals corrected that are not rejected."""
    from twistcore.analysis.correction.twist_removal import refine

    chosen = document.review.state.chosen(undecided=True)
    return refine(document.data.motion, document.data.chains, chosen)


@pytest.mark.thorough
def test_one_button_selects_all_there_is_to_track(qtbot, quality):
    quality.choose("LeftForeArm")
    assert len(quality.chosen) < len(quality.model.rows)
    qtbot.waitUntil(quality.page.all.isEnabled)
    quality.page.all.click()
    assert set(quality.chosen) == set(quality.model.rows)
    assert PLACE in quality.chosen
    qtbot.waitUntil(lambda: not quality.page.all.isEnabled())
    quality.choose("LeftForeArm")
    qtbot.waitUntil(quality.page.all.isEnabled)


@pytest.mark.thorough
def test_a_rejected_interval_is_tracked_anew_with_its_error(qtbot, window, quality):
    track(qtbot, quality, "LeftForeArm")
    first = quality.tracked.result
    ids = tuple(j.id for j in window.document.intervals)
    window.document.do(Decide(ids, Decision.REJECTED))
    qtbot.waitUntil(lambda: quality.tracked.result is not first, timeout=10_000)
    tracking = quality.page.tracking(("LeftForeArm",), PLACE)
    raw = tracked_motion(window.document.data.motion, tracking)
    rotations, _ = forward_kinematics(raw)
    np.testing.assert_array_equal(quality.tracked.result.rotations, rotations)


@pytest.mark.thorough
def test_cancelled_it_changes_nothing(qtbot, window, quality):
    quality.choose("LeftForeArm")
    quality.track()
    assert quality.tracked.running
    quality.refresh()  # now the action may be done
    act(window, "cancel_tracking")
    qtbot.wait(400)
    assert window.document.review.state.tracking is None
    assert quality.tracked.result is None
    assert window.document.review.undo_text == ""


@pytest.mark.thorough
def test_gains_that_would_diverge_are_refused_in_a_sentence(qtbot, window, quality):
    quality.choose("LeftForeArm")
    quality.page.both_ways.setChecked(True)
    quality.page.boxes["kd"].setValue(500.0)
    quality.track()
    qtbot.waitUntil(lambda: not quality.tracked.running, timeout=10_000)
    qtbot.wait(30)
    assert "120 Hz" in window.bar.label.text()
    assert window.document.review.state.tracking is None


@pytest.mark.thorough
@pytest.mark.usefixtures("new_window")
def test_gains_of_the_page_follow_rate_and_direction_until_a_person_chooses(qtbot, window, quality):
    page = quality.page
    for causal in (False, True, False):
        (page.causal if causal else page.both_ways).setChecked(True)
        usual = Gains.by_hand(1.0 / 120.0, causal=causal)
        assert page.boxes["kp"].value() == round(usual.kp)
        assert page.boxes["kd"].value() == round(usual.kd, 1)
    assert "14 ms" in page.causal.toolTip()
    data = window.document.data
    slower = replace(data, clip=replace(data.clip, frame_time=0.04))
    for chosen, expected in ((None, 550.0), (900.0, 900.0)):
        if chosen:
            page.boxes["kp"].setValue(chosen)
        window.document.show_clip(slower)
        qtbot.waitUntil(lambda: quality.evidence.known is not None, timeout=10_000)
        qtbot.wait(50)
        assert page.boxes["kp"].value() == expected


def shown(page):
    gains = tuple(box.value() for box in page.boxes.values())
    return gains, page.causal.isChecked(), page.learned.isChecked()


def usual(dt, *, causal=False):
    gains = Gains.by_hand(dt, causal=causal)
    return round(gains.kp), round(gains.kd, 1), 0.0


def show(qtbot, window, quality, tracking=None, dt=1.0 / 120.0):
    """The clip opened again, with a review that tracks this."""
    data, review = window.document.data, start_again(window.document.review)
    if tracking is not None:
        review.do(Track(tracking))
    clip = replace(data.clip, frame_time=dt)
    window.document.show_clip(replace(data, clip=clip, review=review))
    qtbot.waitUntil(lambda: quality.evidence.known is not None, timeout=10_000)
    qtbot.wait(50)


def start_again(review):
    return Review(replace(review.state, tracking=None))


@pytest.mark.thorough
def test_gains_of_a_reopened_review_stay_when_the_direction_is_changed(qtbot, window, quality):
    page = quality.page
    show(qtbot, window, quality, Tracking(("LeftForeArm",), kp=900.0, kd=20.0, causal=False))
    for causal in (False, True, False):
        (page.causal if causal else page.both_ways).setChecked(True)
        assert shown(page) == ((900.0, 20.0, 0.0), causal, False)
    # Of the two, the one that is as usual follows.
    kd = usual(1.0 / 120.0)[1]
    show(qtbot, window, quality, Tracking(("LeftForeArm",), kp=900.0, kd=kd, causal=False))
    page.causal.setChecked(True)
    assert shown(page)[0] == (900.0, usual(1.0 / 120.0, causal=True)[1], 0.0)
    show(qtbot, window, quality)  # nobody here chose them
    assert shown(page) == (usual(1.0 / 120.0), False, False)


@pytest.mark.thorough
def test_a_gain_that_was_chosen_stays_in_another_clip_and_the_others_follow(qtbot, window, quality):
    page = quality.page
    page.causal.setChecked(True)
    page.boxes["kp"].setValue(900.0)
    show(qtbot, window, quality, dt=0.04)
    assert shown(page) == ((900.0, 17.0, 0.0), False, False)


@pytest.mark.thorough
def test_undo_and_redo_show_direction_and_gains_of_the_review(qtbot, window, quality):
    page = quality.page
    first = Tracking(("LeftForeArm",), kp=900.0, kd=20.0, ka=5.0, causal=False)
    second = Tracking(("LeftForeArm",), kp=2000.0, kd=30.0)
    window.document.do(Track(first))
    assert shown(page) == ((900.0, 20.0, 5.0), False, False)
    window.document.do(Track(second))
    assert shown(page) == ((2000.0, 30.0, 0.0), True, False)
    act(window, "undo")
    assert shown(page) == ((900.0, 20.0, 5.0), False, False)
    window.document.do(Track(replace(first, learned=True, weights=network_weights_identifier())))
    assert shown(page)[1:] == (False, True)
    act(window, "undo")
    assert shown(page) == ((900.0, 20.0, 5.0), False, False)
    page.boxes["kp"].setValue(950.0)  # chosen for the next time: steps of another kind leave it
    window.document.accept_undecided()
    assert shown(page)[0] == (950.0, 20.0, 5.0)


@pytest.mark.thorough
@pytest.mark.usefixtures("new_window")
def test_what_is_chosen_while_it_is_tracked_stays(qtbot, window, quality):
    quality.choose("LeftForeArm")
    quality.page.both_ways.setChecked(True)
    quality.track()
    quality.page.boxes["kp"].setValue(900.0)
    qtbot.waitUntil(lambda: quality.tracked.result is not None, timeout=10_000)
    assert window.document.review.state.tracking.kp == usual(1.0 / 120.0)[0]
    assert quality.page.boxes["kp"].value() == 900.0


@pytest.mark.thorough
@pytest.mark.parametrize(("frames", "steps"), [(1, (0, 0)), (2, (2, 0))])
def test_a_clip_too_short_to_be_traced_is_tracked(qtbot, window, quality, tmp_path, frames, steps):
    lines = INJECTED.read_bytes().splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if line.startswith(b"Frames"))
    rows = lines[at + 12 : at + 12 + frames]
    short = tmp_path / "short.bvh"
    short.write_bytes(b"".join([*lines[:at], b"Frames: %d\n" % frames, lines[at + 1], *rows]))
    open_clip(qtbot, window, short)
    qtbot.waitUntil(lambda: quality.evidence.known is not None, timeout=10_000)
    quality.page.both_ways.setChecked(True)
    for button, expected in zip((quality.page.hand, quality.page.learned), steps, strict=True):
        button.setChecked(True)
        before = quality.tracked.result
        quality.choose("LeftForeArm", PLACE)
        qtbot.wait(30)
        quality.track()
        qtbot.waitUntil(lambda old=before: quality.tracked.result is not old, timeout=10_000)
        qtbot.wait(50)
        assert f"LeftForeArm and {PLACE}; untracked" in quality.page.done.text()
        assert len(quality.tracked.result.traces.frames) == expected
        assert ("Tracker gains" in quality.page.gain_words.text()) == (expected == 0)


@pytest.mark.thorough
def test_another_joint_is_tracked_and_its_traces_drawn(qtbot, window, quality):
    track(qtbot, quality, "LeftForeArm")
    first = quality.tracked.result
    quality.choose("RightLeg")
    quality.track()
    qtbot.waitUntil(lambda: quality.tracked.result is not first, timeout=10_000)
    window.document.go_to(40)  # before the page is drawn again
    qtbot.wait(50)
    assert "RightLeg" in quality.page.gain_words.text()


@pytest.mark.thorough
def test_both_ways_unless_causal_is_chosen_and_the_page_says_which(qtbot, window, quality):
    track(qtbot, quality, "LeftForeArm")
    assert not window.document.review.state.tracking.causal
    assert "LeftForeArm" in quality.page.done.text()
    first = quality.tracked.result
    quality.page.causal.setChecked(True)
    quality.track()
    qtbot.waitUntil(lambda: quality.tracked.result is not first, timeout=10_000)
    qtbot.wait(50)
    assert window.document.review.state.tracking.causal
    assert "LeftForeArm" in quality.page.done.text()


@pytest.mark.thorough
def test_the_place_has_a_row_of_its_own_and_what_is_left_is_said(qtbot, window, quality):
    assert column(quality, 0)[-1] == PLACE
    assert [cell[-1] for cell in (column(quality, k) for k in range(1, 5))] == ["–"] * 4
    quality.choose(PLACE)
    assert quality.joint is None
    assert quality.chosen == (PLACE,)
    track(qtbot, quality, "LeftForeArm")
    assert f"untracked: 30 joints and {PLACE}" in quality.page.done.text()
    first = quality.tracked.result
    quality.table.selectAll()
    qtbot.wait(30)
    assert len(quality.chosen) == 32
    quality.track()
    qtbot.waitUntil(lambda: quality.tracked.result is not first, timeout=10_000)
    qtbot.wait(50)
    tracking = window.document.review.state.tracking
    assert (len(tracking.joints), tracking.place) == (31, True)
    assert f"31 joints and {PLACE}; untracked: nothing" in quality.page.done.text()
    assert f"{PLACE} ┄" in column(quality, 0)
    hips = quality.tracked.result.positions[5:, 0] - window.document.data.motion.translation(0)[5:]
    assert np.abs(hips).max() > 1e-3
    quality.choose(PLACE)
    quality.track()
    qtbot.waitUntil(lambda: not window.document.review.state.tracking.joints, timeout=10_000)
    qtbot.wait(50)
    assert quality.tracked.result.wanted.tracking.place
    assert f"Tracked both ways: {PLACE}; untracked: 31 joints" in quality.page.done.text()


@pytest.mark.thorough
def test_learned_gains_are_traced_at_the_playhead(qtbot, window, quality):
    quality.page.learned.setChecked(True)
    track(qtbot, quality, "LeftForeArm")
    assert window.document.review.state.tracking.learned
    traces = quality.tracked.result.traces
    window.document.go_to(100)
    qtbot.wait(30)
    row = int(np.searchsorted(traces.frames, 100))
    assert f"κP {traces.gains[row, 0, 0]:.0f}" in quality.page.gain_words.text()
    assert f"P {traces.parts[row, 0, 0]:.0f}" in quality.page.part_words.text()
    assert len(quality.page.gains.curves) == 3
    assert len(quality.page.parts.curves) == 4


@pytest.mark.thorough
def test_the_third_figure_is_drawn_and_goes_with_before(qtbot, window, quality):
    act(window, "skin")
    act(window, "side_by_side")  # off: one picture
    window.document.go_to(150)
    without = picture(qtbot, window.viewport)
    track(qtbot, quality, "LeftArm", "RightUpLeg")
    pixels = picture(qtbot, window.viewport)
    magenta = (pixels[..., 0] > 120) & (pixels[..., 1] < 90) & (pixels[..., 2] > 80)
    assert magenta.sum() > 200
    assert changed(without, pixels).sum() >= magenta.sum() * 0.8
    assert "tracked" in window.viewport.overlays.legend.text()
    act(window, "cycle_show")
    while window.document.show != "before":
        act(window, "cycle_show")
    before = picture(qtbot, window.viewport)
    left = (before[..., 0] > 120) & (before[..., 1] < 90) & (before[..., 2] > 80)
    assert left.sum() == 0


@pytest.mark.thorough
def test_an_export_with_tracking_is_replayed_byte_for_byte(qtbot, window, quality, tmp_path):
    window.document.accept_undecided()
    track(qtbot, quality, "LeftForeArm", "RightLeg", PLACE)
    out = tmp_path / "out.bvh"
    window.files.export(ExportChoice(out, report=False))
    assert window.exporter.finish()
    again = tmp_path / "again.bvh"
    session = tmp_path / "out.replay.json"
    clip = window.document.data.clip.path
    assert main(["apply", str(session), str(clip), "-o", str(again)]) == 0
    assert again.read_bytes() == out.read_bytes()
    assert out.read_bytes() != clip.read_bytes()
    assert (read_bvh(out).values != read_bvh(clip).values)[:, :3].any(axis=0).all()


def test_all_joints_are_smoothed_with_the_spline_unless_a_person_chooses(qtbot, window, quality):
    quality.track()
    qtbot.waitUntil(lambda: quality.tracked.result is not None)
    tracking = window.document.review.state.tracking
    assert tracking.spline
    assert (len(tracking.joints), tracking.place, tracking.bursts) == (31, True, ())
    expected = tracked_motion(shown_motion(window.document), tracking)
    np.testing.assert_array_equal(quality.tracked.result.motion.rotations, expected.rotations)
    session = json.loads(session_bytes(window.document.data.clip, window.document.review.state))
    assert session["tracking"]["gains"] == "spline"
    page = quality.page
    page.both_ways.setChecked(True)
    assert not page.gains.isHidden()
    act(window, "undo")
    act(window, "redo")
    assert page.spline.isChecked()
    qtbot.waitUntil(page.gains.isHidden)


def test_before_and_after_are_in_the_table_the_curves_and_the_3d_view(qtbot, window, quality):
    document = window.document
    document.select_chain("LeftForeArm")
    quality.choose(*quality.model.rows)
    track(qtbot, quality, *quality.model.rows, spline=True)
    rows = dict(zip(column(quality, 0), column(quality, 1), strict=True))
    joint = quality.model.names.index("LeftForeArm")
    was, now = (float(text) for text in rows["LeftForeArm ┄"].split(" → "))
    assert was == round(float(quality.evidence.known.joints.usual_jitter[joint]), 2)
    assert now == round(float(quality.tracked.result.joints.usual_jitter[joint]), 2) < was
    quality.choose("LeftForeArm")
    qtbot.waitUntil(lambda: len(quality.plot.curves) == 2)
    pane = window.timeline.panes["theta"]
    signals = twist_signals(quality.tracked.result.motion, "LeftForeArm")
    qtbot.waitUntil(lambda: len(pane.values["p_tracked"][0]) == document.frames)
    drawn = pane.values["p_tracked"][0]
    there = np.isfinite(drawn)
    assert there.sum() > 20
    turn = wrap(np.radians(drawn[there]) - signals.theta_p[there])
    np.testing.assert_allclose(turn, 0.0, atol=1e-9)
    for _ in range(3):
        act(window, "cycle_show")
        if document.show == "after":
            break
    document.go_to(150)
    qtbot.waitUntil(lambda: not window.viewport.pending)
    shown = window.viewport.drawing.pose(window.viewport.scene, document.show)
    np.testing.assert_array_equal(shown.positions, quality.tracked.result.positions[150])
    act(window, "stop_tracking")
    qtbot.waitUntil(lambda: not len(pane.values["p_tracked"][0]))
    assert column(quality, 1)[0].count("→") == 0


def start_of(judged):
    return judged.interval.start


@pytest.mark.thorough
def test_a_burst_is_smoothed_in_its_frames_and_one_more_is_added(qtbot, window, tmp_path):
    clip = read_bvh(ASSETS / "walk.bvh")
    path = tmp_path / "burst.bvh"
    twice = noisy(ARM, HAND).rotations.copy()
    twice[10:70] = noisy(ARM, HAND).rotations[START : START + 60]
    write_clip(clip, clip.motion.with_rotations(twice), path)
    open_clip(qtbot, window, path)
    document = window.document
    bursts = [j for j in document.intervals if j.interval.kind == Kind.NOISE_BURST]
    first, last = min(bursts, key=start_of), max(bursts, key=start_of)
    document.select_interval(first.id)
    qtbot.waitUntil(window.detail.to_quality.isVisible)
    window.detail.to_quality.click()
    qtbot.waitUntil(lambda: document.review.state.tracking is not None)
    tracking = document.review.state.tracking
    assert tracking.spline
    page = window.quality.page
    qtbot.waitUntil(lambda: f"{tracking.cutoff:.1f} Hz" in page.done.text())
    assert {name for name, _, _ in tracking.bursts} == {"LeftArm", "LeftForeArm"}
    motion = window.quality.tracked.result.motion
    given = shown_motion(document)
    changed = (motion.rotations != given.rotations).any(axis=-1)
    start, stop = tracking.bursts[0][1:]
    assert changed[start:stop, [ARM, HAND]].all()
    changed[start:stop, [ARM, HAND]] = False
    assert not changed.any()
    assert (motion.positions == given.positions).all()
    window.quality.track_burst(last.interval)
    qtbot.waitUntil(lambda: len(document.review.state.tracking.bursts) > 2)
    assert set(tracking.bursts) < set(document.review.state.tracking.bursts)
    act(window, "undo")
    act(window, "undo")
    assert document.review.state.tracking is None


@pytest.mark.thorough
def test_a_clip_that_trembles_is_announced_with_the_way_to_the_page(qtbot, window, tmp_path):
    noisy = tmp_path / "noisy.bvh"
    assert main(["quamo", "noise", str(ASSETS / "walk.bvh"), "-o", str(noisy)]) == 0
    open_clip(qtbot, window, noisy)
    qtbot.waitUntil(lambda: "mm/frame³" in window.bar.label.text())
    (button,) = window.bar.buttons()
    button.click()
    assert window.quality.tabs.currentWidget() is window.quality.page
    assert window.quality.isVisible()


# --- the lesson ---------------------------------------------------------------------------------


@pytest.mark.thorough
def test_five_trackers_follow_a_joint_through_the_seam(qtbot, window):
    act(window, "why_quaternions")
    taught = window.lesson_actions.five_trackers
    wait_until_active(taught)
    furthest = {name: distance.max() for name, distance in taught.found.items()}
    assert list(furthest) == list(taught.plots)
    assert furthest["Quaternion"] < 5.0
    assert furthest["Euler XYZ, wrapped"] < 5.0
    assert furthest["Euler XYZ, raw"] > 90.0
    assert furthest["axis-angle, raw"] > 90.0
    assert f"{furthest['Quaternion']:.1f}°" in taught.titles["Quaternion"].text()
    taught.slider.setValue(150)
    expected = tracker_errors(fixed_axis_rotations(1.5))
    for name, found in taught.found.items():
        np.testing.assert_array_equal(found, expected[name])
    taught.at.setValue(70)
    assert all(plot.playhead.value() == 70 for plot in taught.plots.values())
    taught.close()
