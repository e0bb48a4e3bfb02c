"""The tuning tab in the real window: curves, τ, profiles, the folder, and nothing left running."""

import multiprocessing
import os
import shutil
import time

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from inspector.session.settings import Settings
from inspector.tuning.cost_plot import CostPlot
from inspector.widgets.theme import LIGHT, Colours
from tests.conftest import ASSETS
from tests.gui.known_costs import remember, remind
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, open_clip
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decide, Decision
from twistcore.tuning import Tuned, prepare_clip_tuning, read_profile, write_profile
from twistcore.tuning.tau_curve import ALARM_PRICE, SMALLEST_ERROR

LEFT, NONE = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton


@pytest.fixture(autouse=True)
def no_worker_left():
    """No process measures on behind a window that is closed."""
    yield
    assert multiprocessing.active_children() == []


@pytest.fixture
def window(qtbot, show_window, tmp_path):
    """The sample with eight errors, a chain with three of them selected, the tab in front."""
    window = show_window(Settings(turn_ms=0, of_features={"error_draws": 1}), size=(1440, 900))
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path))
    window.document.select_chain("LeftForeArm")
    return window


@pytest.fixture
def tuning(qtbot, window):
    remind(window.tuning.costs)
    act(window, "show_tuning")
    qtbot.waitUntil(lambda: len(window.tuning.costs.curves) == 10, timeout=30_000)
    qtbot.wait(50)
    remember(window.tuning.costs)
    return window.tuning


def taus(window):
    """Of the chains, degrees: a limb's is another quantity."""
    tau, chains = window.document.review.state.tau, window.document.data.chains
    return {c.name: round(float(np.degrees(tau[c.name])), 6) for c in chains}


def at(plot, degrees):
    """Place in a plot's viewport of a τ, half way up."""
    low, high = plot.view.viewRange()[1]
    scene = plot.view.mapViewToScene(QPointF(np.log10(degrees), 0.5 * (low + high)))
    return QPointF(plot.mapFromScene(scene))


def send(plot, kind, place, button, buttons):
    there = QPointF(plot.viewport().mapToGlobal(place.toPoint()))
    event = QMouseEvent(kind, place, there, button, buttons, Qt.KeyboardModifier.NoModifier)
    QApplication.sendEvent(plot.viewport(), event)


def drag(qtbot, plot, start, stop, steps=6):
    first, last = at(plot, start), at(plot, stop)
    send(plot, QEvent.Type.MouseMove, first, NONE, NONE)
    send(plot, QEvent.Type.MouseButtonPress, first, LEFT, LEFT)
    for k in range(1, steps + 1):
        place = first + (last - first) * (k / steps)
        send(plot, QEvent.Type.MouseMove, place, NONE, LEFT)
        qtbot.wait(15)
    send(plot, QEvent.Type.MouseButtonRelease, last, LEFT, NONE)
    qtbot.wait(50)


# --- curves -------------------------------------------------------------------------------------


def test_without_a_curve_no_false_alarms_are_drawn(qapp):
    plot = CostPlot(Colours(LIGHT))
    assert not plot.alarms.isVisible()
    plot.show_curve(None)
    assert not plot.alarms.isVisible()


@pytest.mark.thorough
def test_the_curves_are_those_of_the_core(window, tuning):
    clip = read_bvh(INJECTED)
    core = prepare_clip_tuning(clip.motion, clip.name, seeds=range(1)).curve("LeftForeArm")
    shown = tuning.costs.curves["LeftForeArm"]
    np.testing.assert_array_equal(shown.repaired, core.repaired)
    np.testing.assert_array_equal(shown.alarms, core.alarms)
    x, y = tuning.curves.cost.fsr.getData()
    np.testing.assert_allclose(10**x, np.degrees(core.tau))
    np.testing.assert_allclose(y, 100.0 * core.fsr)
    assert tuning.curves.cost.alarms.isVisible()
    words = tuning.curves.cost_words.text().replace("&nbsp;", " ")
    low, high = np.degrees(core.plateau(np.radians(1.5), ALARM_PRICE, SMALLEST_ERROR))
    assert low == pytest.approx(1.5)
    assert high >= np.degrees(core.suggested())
    assert f"{low:.2f}–{high:.2f}° cost the same: no change" in words
    strength = np.degrees(window.document.detector.strength("LeftForeArm"))
    drawn = np.expm1(
        tuning.curves.histogram.below.getData()[1] + tuning.curves.histogram.above.getData()[1]
    )
    assert round(drawn.sum()) == (strength >= 0.5).sum()
    assert (
        f"{(strength >= np.radians(1.5)).sum()} of 344 frames reach τ"
        in tuning.curves.strength_words.text()
    )


@pytest.mark.thorough
def test_nothing_is_measured_while_nobody_looks(qtbot, window):
    qtbot.wait(300)
    assert multiprocessing.active_children() == []
    assert window.tuning.costs.curves == {}


@pytest.mark.thorough
def test_the_selected_chain_comes_first(qtbot, window):
    window.document.select_chain("RightLeg")
    act(window, "show_tuning")
    qtbot.waitUntil(lambda: len(window.tuning.costs.curves) > 0, timeout=30_000)
    assert next(iter(window.tuning.costs.curves)) == "RightLeg"


@pytest.mark.thorough
@pytest.mark.parametrize("leave", ["another clip", "another tab", "close"])
def test_a_stale_measurement_ends(qtbot, window, tmp_path, leave):
    act(window, "show_tuning")
    qtbot.waitUntil(lambda: bool(multiprocessing.active_children()), timeout=10_000)
    (process,) = multiprocessing.active_children()
    if leave == "another clip":
        open_clip(qtbot, window, shutil.copy(ASSETS / "dance.bvh", tmp_path))
    elif leave == "another tab":
        window.docks["tuning"].parent().findChild(
            type(window.docks["tuning"]), "intervals"
        ).raise_()
    else:
        window.document.review.mark_saved()
        window.close()
    qtbot.waitUntil(lambda: process not in multiprocessing.active_children(), timeout=5_000)
    if leave == "another clip":
        qtbot.waitUntil(lambda: len(window.tuning.costs.curves) == 10, timeout=30_000)
        seconds = window.tuning.costs.curves["LeftArm"].minutes * 60.0
        assert seconds == pytest.approx(window.document.frames / 120.0, rel=1e-3)


@pytest.mark.thorough
def test_a_verdict_is_taken_into_account_and_a_known_state_is_remembered(qtbot, window, tuning):
    document, costs = window.document, tuning.costs
    before = costs.curves["LeftForeArm"]
    assert not before.alarms.any()
    first = document.review.state.of_chain("LeftForeArm")[0]
    document.do(Decide((first.id,), Decision.REJECTED))
    assert costs.curves == {}
    qtbot.waitUntil(lambda: len(costs.curves) == 10, timeout=30_000)
    assert costs.curves["LeftForeArm"].alarms[0] >= 1
    document.undo()
    assert costs.curves["LeftForeArm"] is before
    qtbot.wait(600)
    assert not costs.running


@pytest.mark.thorough
def test_a_moving_tau_does_not_measure_again(qtbot, window, tuning):
    known = dict(tuning.costs.curves)
    for degrees in (3.0, 30.0, 2.0):
        tuning.set_tau_degrees(degrees)
        qtbot.wait(20)
    assert not tuning.costs.running
    assert dict(tuning.costs.curves) == known


@pytest.mark.thorough
def test_a_clip_that_changed_on_disk_is_told(qtbot, window):
    path = window.document.data.clip.path
    path.write_bytes(path.read_bytes() + b"\n")
    act(window, "show_tuning")
    qtbot.waitUntil(lambda: window.tuning.costs.trouble != "", timeout=10_000)
    qtbot.wait(50)
    assert window.tuning.curves.state.text()
    assert not window.tuning.costs.running


@pytest.mark.thorough
def test_a_killed_measurement_is_told(qtbot, window):
    act(window, "show_tuning")
    qtbot.waitUntil(lambda: bool(multiprocessing.active_children()), timeout=10_000)
    multiprocessing.active_children()[0].kill()
    qtbot.waitUntil(lambda: window.tuning.costs.trouble != "", timeout=10_000)
    assert multiprocessing.active_children() == []


@pytest.mark.thorough
@pytest.mark.skipif(os.name == "nt", reason="needs the processor time of child processes")
def test_the_window_stays_free_while_it_is_measured(qtbot, window):
    """Between two looks at events the window's thread does little of what a process measures."""

    def by_processes():
        times = os.times()
        return times.children_user + times.children_system

    before = by_processes()
    act(window, "show_tuning")
    longest, last = 0.0, time.thread_time()
    while len(window.tuning.costs.curves) < 10 or multiprocessing.active_children():
        qtbot.wait(5)
        now = time.thread_time()
        longest, last = max(longest, now - last), now
    print("TIMES", longest, by_processes() - before)
    assert longest < 0.2 * (by_processes() - before)


# --- τ ------------------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize("plot", ["histogram", "cost"])
def test_dragging_the_line_sets_tau_in_one_step(qtbot, window, tuning, plot):
    count = len(window.document.intervals)
    steps = window.document.review.position
    drag(qtbot, getattr(tuning.curves, plot), 1.5, 60.0)
    assert taus(window)["LeftForeArm"] == pytest.approx(60.0, rel=0.05)
    assert window.document.review.position == steps + 1
    assert len(window.document.intervals) == count - 1  # one of 20.8° is below
    # The other plot, the time line, the box and the table follow.
    for other in (tuning.curves.histogram, tuning.curves.cost):
        assert 10 ** other.tau_line.value() == pytest.approx(taus(window)["LeftForeArm"], rel=0.01)
    assert window.timeline.tau_line.value() ** 2 == pytest.approx(taus(window)["LeftForeArm"])
    assert tuning.box.value() == pytest.approx(taus(window)["LeftForeArm"])
    assert window.intervals.table.model().rowCount() == count - 1
    act(window, "undo")
    qtbot.wait(50)
    assert taus(window)["LeftForeArm"] == 1.5
    assert len(window.document.intervals) == count
    assert 10 ** tuning.curves.cost.tau_line.value() == pytest.approx(1.5)


def test_a_double_click_sets_tau(qtbot, window, tuning):
    place = at(tuning.curves.cost, 10.0)
    for kind, button in (
        (QEvent.Type.MouseButtonPress, LEFT),
        (QEvent.Type.MouseButtonRelease, NONE),
        (QEvent.Type.MouseButtonDblClick, LEFT),
        (QEvent.Type.MouseButtonRelease, NONE),
    ):
        send(tuning.curves.cost, kind, place, LEFT, button)
    qtbot.wait(50)
    assert taus(window)["LeftForeArm"] == pytest.approx(10.0, rel=0.03)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("scope", "chains"),
    [
        ("tau_for_chain", {"LeftForeArm"}),
        ("tau_for_segment", {"LeftForeArm", "RightForeArm"}),
        ("tau_for_all", None),
    ],
)
def test_tau_and_its_suggestion_for_a_joint_a_segment_or_all(qtbot, window, tuning, scope, chains):
    before = taus(window)
    chains = chains or set(before)
    window.actions_by_id[scope].trigger()
    qtbot.keyClick(tuning.box, Qt.Key.Key_Up)
    qtbot.wait(20)
    set_to = taus(window)["LeftForeArm"]
    assert set_to > 1.5
    assert {n for n, t in taus(window).items() if t == set_to} == chains
    assert {n for n, t in taus(window).items() if t == before[n]} == set(before) - chains
    steps = window.document.review.position
    act(window, "suggest_tau")  # 1.60° costs the same as the best: nothing moves without a gain
    assert window.document.review.position == steps
    assert "nothing was changed" in window.bar.label.text()
    tuning.set_tau_degrees(60.0)
    act(window, "suggest_tau")
    for name in chains:
        wanted = np.degrees(tuning.costs.curves[name].suggested())
        assert taus(window)[name] == pytest.approx(wanted)
    assert {n for n, t in taus(window).items() if t == before[n]} == set(before) - chains
    for _ in range(3):
        act(window, "undo")
    assert taus(window) == before


@pytest.mark.thorough
def test_a_suggestion_waits_for_its_curve(qtbot, window):
    act(window, "show_tuning")
    act(window, "tau_for_all")
    assert not window.actions_by_id["suggest_tau"].isEnabled()
    qtbot.waitUntil(lambda: len(window.tuning.costs.curves) == 10, timeout=30_000)
    qtbot.waitUntil(lambda: window.actions_by_id["suggest_tau"].isEnabled())


# --- profiles -----------------------------------------------------------------------------------


def cells(window):
    model = window.tuning.profiles.table.model()
    return [
        [model.index(r, c).data() for c in range(model.columnCount())]
        for r in range(model.rowCount())
    ]


def test_a_saved_profile_comes_back_in_one_step(qtbot, window, tuning, tmp_path):
    tuning.set_tau_degrees(7.5)
    saved = taus(window)
    window.tuning_actions.save_profile_to(tmp_path / "mine.toml")
    profile = read_profile(tmp_path / "mine.toml")
    assert profile.method == "consistency"
    text = (tmp_path / "mine.toml").read_text()
    assert text.count("fsr_percent") == 10
    act(window, "undo")
    window.tuning_actions.load_profile_from(tmp_path / "mine.toml")
    assert taus(window) == pytest.approx(saved, abs=1e-4)
    act(window, "undo")
    assert set(taus(window).values()) == {1.5}


@pytest.mark.thorough
def test_a_damaged_profile_is_one_sentence_and_changes_nothing(window, tmp_path):
    path = tmp_path / "bad.toml"
    state = window.document.review.state
    for text in (b"[LeftArm", b"\xff\xfe", b"[LeftArm]\ntau_deg = -1\n", None):
        path.unlink() if text is None else path.write_bytes(text)
        for load, given in (("load_profile_from", path), ("compare_with", [path])):
            window.bar.clear()
            getattr(window.tuning_actions, load)(given)
            assert window.document.review.state is state
            assert window.tuning.profiles.model.others == ()
            assert window.bar.isVisible()
            assert "bad.toml" in window.bar.label.text()
            assert "\n" not in window.bar.label.text()
        assert path.exists() == (text is not None)


@pytest.mark.thorough
def test_a_profile_of_other_joints_changes_nothing(window, tmp_path):
    write_profile(tmp_path / "p.toml", {"Tail": Tuned(2, 1, 99, 0)}, "x", "consistency")
    state = window.document.review.state
    window.tuning_actions.load_profile_from(tmp_path / "p.toml")
    assert window.document.review.state is state
    assert window.bar.label.text()


@pytest.mark.thorough
def test_a_profile_of_the_other_detector_brings_it_along(qtbot, window, tmp_path):
    write_profile(tmp_path / "p.toml", {"LeftArm": Tuned(6, 1, 99, 0)}, "x", "paper")
    window.tuning_actions.load_profile_from(tmp_path / "p.toml")
    qtbot.waitUntil(lambda: window.document.review.state.method == "paper")
    assert taus(window)["LeftArm"] == 6.0
    assert taus(window)["RightArm"] == 5.0
    act(window, "undo")
    assert window.document.review.state.method == "consistency"


@pytest.mark.thorough
def test_a_profile_that_cannot_be_written_leaves_the_old_one(window, tmp_path):
    target = tmp_path / "folder.toml"
    target.mkdir()
    window.tuning_actions.save_profile_to(target)
    assert window.bar.label.text()
    clip = window.document.data.clip.path
    bytes_before = clip.read_bytes()
    window.tuning_actions.save_profile_to(clip)
    assert clip.read_bytes() == bytes_before


def test_profiles_side_by_side(qtbot, window, tuning, tmp_path):
    for name, tau in (("a.toml", 4.0), ("b.toml", 12.0)):
        tuned = {"LeftForeArm": Tuned(tau, 1.5, 0, 0), "RightLeg": Tuned(tau, 1.5, 0, 0)}
        write_profile(tmp_path / name, tuned, "x", "consistency")
    window.tuning_actions.compare_with([tmp_path / "b.toml"])
    qtbot.wait(50)
    row = cells(window)[2]
    curve = tuning.costs.curves["LeftForeArm"]
    wanted = [f"{100 * curve.at(np.radians(t))[0]:.1f} %" for t in (1.5, 12.0)]
    own = ["Left ForeArm", "1.50°", wanted[0], "3 (3)", "0"]
    assert row == [*own, "12.00°", wanted[1], "3 (3)", "0"]
    assert cells(window)[0][5:] == ["–", "–", "–", "–"]
    window.tuning_actions.compare_with([tmp_path / "a.toml", tmp_path / "b.toml"])
    assert [r[1] for r in cells(window)][2] == "4.00°"
    assert tuning.profiles.table.model().columnCount() == 9
    act(window, "take_profile")
    assert taus(window)["RightLeg"] == 12.0
    assert taus(window)["LeftArm"] == 1.5
    act(window, "close_comparison")
    assert tuning.profiles.table.model().columnCount() == 5
    assert cells(window)[9][1] == "12.00°"


@pytest.mark.thorough
def test_a_folder_is_analysed_with_the_present_tau(qtbot, window, tmp_path):
    folder = tmp_path / "clips"
    folder.mkdir()
    for name in ("walk", "walk_injected"):
        shutil.copy(ASSETS / f"{name}.bvh", folder)
    path = folder / "walk_injected.bvh"
    act(window, "profile_to_folder")
    assert window.bar.label.text()
    window.queue.open(folder)
    qtbot.waitUntil(lambda: not window.queue.running, timeout=60_000)
    assert window.queue.clips[path].intervals == 8
    act(window, "show_tuning")
    window.tuning.set_tau_degrees(60.0)
    act(window, "profile_to_folder")
    qtbot.waitUntil(lambda: not window.queue.running, timeout=60_000)
    assert window.queue.clips[path].intervals == 7
    window.document.review.mark_saved()  # or the window asks
    open_clip(qtbot, window, path)
    assert taus(window)["LeftForeArm"] == 60.0
    assert len(window.document.intervals) == 7
    act(window, "automatic_folder")
    qtbot.waitUntil(lambda: not window.queue.running, timeout=60_000)
    assert window.queue.clips[path].intervals == 8
