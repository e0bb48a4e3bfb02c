"""What the tuning tab says of a τ: by which detector, how sure, and in which frames."""

import multiprocessing
import shutil

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtWidgets import QApplication

from inspector.session.settings import Settings, load_settings
from inspector.tuning.strength_histogram import histogram_bar_index, histogram_bar_label
from inspector.tuning.wishes import POINTS, SMALLEST
from tests.conftest import ASSETS
from tests.gui.known_costs import remember, remind
from tests.gui.pictures import INJECTED
from tests.gui.test_tuning import LEFT, NONE, cells, send, taus
from tests.gui.windows import act, open_clip
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision, read_session
from twistcore.tuning import Tuned, Verdicts, prepare_clip_tuning, write_profile

pytestmark = pytest.mark.thorough


@pytest.fixture(autouse=True)
def no_worker_left():
    """No process measures on behind a window that is closed."""
    yield
    assert multiprocessing.active_children() == []


@pytest.fixture
def settings_file(tmp_path):
    return tmp_path / "config" / "settings.json"


@pytest.fixture
def draws(request):
    """How many errors of each size are tried: one, unless a test needs a surer curve."""
    return getattr(request, "param", 1)


@pytest.fixture
def window(qtbot, show_window, tmp_path, settings_file, draws):
    """The sample with eight errors, a chain with three of them selected."""
    settings = Settings(turn_ms=0, of_features={"error_draws": draws})
    window = show_window(settings, settings_file, size=(1440, 900))
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path))
    window.document.select_chain("LeftForeArm")
    return window


@pytest.fixture
def tuning(qtbot, window):
    remind(window.tuning.costs)
    act(window, "show_tuning")
    wait_measured(qtbot, window)
    remember(window.tuning.costs)
    return window.tuning


def wait_measured(qtbot, window, method="consistency"):
    by = window.tuning.costs.by
    running = window.tuning.costs.coming
    qtbot.waitUntil(lambda: len(by(method)) == 10 and not running(method), timeout=60_000)
    qtbot.waitUntil(lambda: not window.tuning._stale.pending)


def write_tau(path, degrees, method="", names=("LeftForeArm", "RightLeg")):
    if method:
        tuned = {name: Tuned(degrees, 1.5, 0, 0) for name in names}
        write_profile(path, tuned, "x", method)
    else:
        path.write_text("".join(f"[{name}]\ntau_deg = {degrees}\n" for name in names))
    return path


@pytest.fixture
def by_paper(draws):
    clip = read_bvh(INJECTED)
    of_paper = {"method": "paper", "verdicts": Verdicts(), "seeds": range(draws)}
    tuning = prepare_clip_tuning(clip.motion, clip.name, **of_paper)
    return tuning.curve("RightArm")


# --- whose detector -----------------------------------------------------------------------------


@pytest.mark.parametrize("draws", [3], indirect=True)
def test_a_profile_is_costed_with_its_own_detector(qtbot, window, tuning, tmp_path, by_paper):
    path = write_tau(tmp_path / "p.toml", 1.5, "paper", ["RightArm"])
    window.tuning_actions.compare_with([path])
    qtbot.waitUntil(lambda: cells(window)[6][6] == "…", timeout=5_000)
    wait_measured(qtbot, window, "paper")
    remember(window.tuning.costs)
    fsr, counts = by_paper.at(np.radians(1.5))[0], by_paper.counts_at(np.radians(1.5))
    ours = tuning.costs.curves["RightArm"].at(np.radians(1.5))[0]
    assert abs(fsr - ours) > 0.01
    row = cells(window)[6]
    listed = f"{counts.listed:.0f} ({counts.automatic:.0f})"
    assert row[5:] == ["1.50°", f"{100 * fsr:.1f} %", listed, "0"]  # nothing was rejected
    assert row[2] == f"{100 * tuning.costs.curves['LeftForeArm'].at(np.radians(1.5))[0]:.1f} %"
    assert tuning.profiles.note.text() == "now: our detector · p.toml: the paper's detector"
    # The detector in use is another now: what is known stays known, and each keeps its own.
    act(window, "use_paper")
    qtbot.waitUntil(lambda: window.document.method == "paper", timeout=20_000)
    qtbot.waitUntil(lambda: "now: the paper's" in tuning.profiles.note.text())
    assert cells(window)[6][6] == row[6]
    tip = tuning.profiles.model.head_tips[2]
    assert tip.startswith("now: Share")
    assert tip.endswith("using the paper's detector")
    qtbot.wait(500)
    assert multiprocessing.active_children() == []


def test_a_profile_that_names_no_detector_says_so(qtbot, window, tuning, tmp_path):
    window.tuning_actions.compare_with([write_tau(tmp_path / "old.toml", 5.0)])
    qtbot.waitUntil(lambda: "old.toml" in tuning.profiles.note.text())
    said = (
        "The profile old.toml does not name a detector, so its costs are measured with our "
        "detector."
    )
    assert said in tuning.profiles.note.text()
    assert not tuning.costs.running  # nothing more to measure
    fsr = tuning.costs.curves["LeftForeArm"].at(np.radians(5.0))[0]
    assert cells(window)[2][6] == f"{100 * fsr:.1f} %"


def test_another_detector_is_measured_while_its_profile_is_compared(qtbot, window, tmp_path):
    """A comparison that ends takes what is under way for it along; the own detector goes on."""
    path = write_tau(tmp_path / "p.toml", 5.0, "paper")
    window.tuning_actions.compare_with([path])
    wait_measured(qtbot, window)
    qtbot.waitUntil(lambda: window.tuning.costs.coming("paper"), timeout=10_000)
    act(window, "close_comparison")
    assert multiprocessing.active_children() == []
    assert len(window.tuning.costs.by("paper")) < 10
    assert len(window.tuning.costs.curves) == 10


def test_both_detectors_side_by_side(qtbot, window, tuning, by_paper):
    act(window, "both_costs")
    model = tuning.profiles.detectors
    assert tuning.tabs.currentWidget() is tuning.profiles
    wait_measured(qtbot, window, "paper")
    rows = [[model.index(r, c).data() for c in range(7)] for r in range(model.rowCount())]
    assert len(rows) == 2 * 11  # chains and all of them, at the suggested and the automatic τ
    ours = tuning.costs.curves["RightArm"]
    assert by_paper.automatic == pytest.approx(np.radians(5.0))
    assert (ours.automatic, by_paper.floor) == (ours.floor, ours.floor)
    wanted = []
    for tau in ("suggested", "automatic"):
        for curve in (ours, by_paper):
            at = curve.suggested() if tau == "suggested" else curve.automatic
            cost = curve.cost(at)
            band = f"{100 * cost.low:.0f}–{100 * cost.high:.0f}"
            fsr = f"{100 * cost.fsr:.0f} ({band})"
            wanted += [f"{np.degrees(at):.2f}°", fsr, "0"]
    assert rows[12][0] == "Right Arm"
    assert [*rows[12][1:], *rows[13][1:]] == wanted
    assert rows[20][0] == "All chains"
    total = float(rows[20][2].split()[0])
    shares = [float(row[2].split()[0]) for row in rows[0:20:2]]
    assert min(shares) <= total <= max(shares)
    model_tip = model.index(4, 2).data(Qt.ItemDataRole.ToolTipRole)
    assert "95 % confidence" in model_tip
    assert model.heads[1:4] == ("Our\nτ", "Our\nFSR %", "Our\nalarms")
    act(window, "both_costs")
    assert cells(window)[2][0] == "Left ForeArm"


# --- how sure -----------------------------------------------------------------------------------


def test_the_band_is_drawn_and_said(qtbot, window, tuning):
    page, curve = tuning.curves, tuning.costs.curves["LeftForeArm"]
    tuning.set_tau_degrees(10.0)
    cost = curve.cost(np.radians(10.0))
    assert cost.low < cost.fsr - 0.02
    assert cost.high > cost.fsr + 0.02
    said = f"FSR {100 * cost.fsr:.1f} % ({100 * cost.low:.0f}–{100 * cost.high:.0f})"
    qtbot.waitUntil(lambda: said in page.state.text())
    assert page.cost.band.isVisible()
    low, high = (edge.getData()[1] for edge in page.cost._edges)
    np.testing.assert_allclose([low, high], 100.0 * np.array(curve.band))
    tuning.tabs.setCurrentWidget(tuning.profiles)
    qtbot.waitUntil(lambda: cells(window)[2][1] == "10.00°")
    tips = [tuning.profiles.model.index(2, c).data(Qt.ItemDataRole.ToolTipRole) for c in (2, 4)]
    assert f"between {100 * cost.low:.0f} and {100 * cost.high:.0f} %" in tips[0]
    assert "per minute (95 % confidence)" in tips[1]


def test_a_drag_says_what_it_changes_and_what_is_only_presumed(qtbot, window, tuning):
    document, page = window.document, tuning.curves
    assert page.presumed.text() == "3 confident intervals count as errors until you judge them"
    weakest = min(
        document.review.state.of_chain("LeftForeArm"), key=lambda j: abs(j.interval.delta)
    )
    document.decide(Decision.REJECTED, (weakest.id,))
    document.select_chain("LeftForeArm")
    wait_measured(qtbot, window)
    assert page.presumed.text() == "2 confident intervals count as errors until you judge them"
    tau, state = document.review.state.tau["LeftForeArm"], page.state
    assert state.text().startswith("τ 1.50°: 3 listed, 3 automatic · FSR ")
    assert state.text().endswith(" · 1 false alarm")
    before = tuning.costs.curves["LeftForeArm"].at(tau)[0]
    tuning._ask(60.0, True)  # as a plot asks during a drag
    qtbot.waitUntil(lambda: state.text().count(": 2 listed") == 1)
    now = tuning.costs.curves["LeftForeArm"].at(document.review.state.tau["LeftForeArm"])[0]
    points = f"{100 * (now - before):.1f}".replace("-", "−")
    assert state.text().startswith(f"{points} points, −1 false alarm · τ 60.00°: 2 listed, 2 auto")
    suggested = page.cost.mark.getData()[0][0]
    tuning._ask(90.0, True)
    qtbot.waitUntil(lambda: "τ 90.00°" in state.text())
    assert page.cost.mark.getData()[0][0] == suggested  # it does not follow the drag
    tuning._drop()
    qtbot.waitUntil(lambda: state.text().startswith("τ 90.00°:"))
    act(window, "undo")


def test_more_draws_make_a_narrower_band(qtbot, window, tuning):
    few = tuning.costs.curves["LeftForeArm"]
    tuning.suggestion.draws.setValue(4)
    assert tuning.costs.curves == {}
    wait_measured(qtbot, window)
    many = tuning.costs.curves["LeftForeArm"]
    assert many.errors > 2 * few.errors
    assert np.mean(np.subtract(*many.band)) > 0.75 * np.mean(np.subtract(*few.band))
    tuning.suggestion.draws.setValue(1)
    assert tuning.costs.curves["LeftForeArm"] is few  # it is remembered


def test_a_suggestion_follows_the_price_at_once_and_both_are_remembered(
    qtbot, window, tuning, settings_file
):
    """A false alarm that costs much moves the triangle; nothing is measured again."""
    document = window.document
    first = document.review.state.of_chain("LeftForeArm")[0].interval
    document.decide(Decision.REJECTED, (document.review.state.of_chain("LeftForeArm")[0].id,))
    document.select_chain("LeftForeArm")
    assert tuning.costs.curves == {}
    wait_measured(qtbot, window)
    curve = tuning.costs.curves["LeftForeArm"]
    tuning.suggestion.points.setValue(0.0)
    cheap = np.degrees(curve.suggested(price=0.0, present=np.radians(1.5)))
    qtbot.waitUntil(lambda: f"{cheap:.2f}–" in tuning.curves.cost_words.text())
    tuning.suggestion.points.setValue(100.0)
    dear = np.degrees(curve.suggested(price=1.0))
    assert dear > np.degrees(abs(first.delta)) > cheap
    qtbot.waitUntil(lambda: f"{dear:.2f}°" in tuning.curves.cost_words.text())
    assert 10 ** tuning.curves.cost.mark.getData()[0][0] == pytest.approx(dear)
    act(window, "suggest_tau")
    assert taus(window)["LeftForeArm"] == pytest.approx(dear)
    qtbot.wait(500)
    assert not tuning.costs.running
    assert tuning.costs.curves["LeftForeArm"] is curve
    tuning.suggestion.smallest.setValue(6.0)
    qtbot.waitUntil(lambda: SMALLEST.of(load_settings(settings_file)[0]) == 6.0, timeout=5_000)
    assert POINTS.of(load_settings(settings_file)[0]) == 100.0


@pytest.mark.parametrize("draws", [3], indirect=True)
def test_it_says_in_words_whether_one_tau_does_for_all(qtbot, window, tuning):
    tuning.tabs.setCurrentWidget(tuning.suggestion)
    degrees = np.degrees(tuning.costs.curves["LeftForeArm"].suggested())
    most, all_alike = (
        f" of 10 chains do best with {degrees:.2f}°",
        ": one τ is enough for all chains.",
    )
    qtbot.waitUntil(
        lambda: most in (said := tuning.suggestion.shared.text()) and said.endswith(all_alike)
    )
    act(window, "use_paper")
    qtbot.waitUntil(lambda: len(tuning.costs.by("paper")) == 10, timeout=60_000)
    qtbot.waitUntil(lambda: "need their own τ: " in tuning.suggestion.shared.text())
    assert "2.02°" in tuning.suggestion.shared.text()
    assert "Right ForeArm 1.83°" in tuning.suggestion.shared.text()


# --- frames -------------------------------------------------------------------------------------


def over_bar(plot, degrees):
    """Place in the viewport over the bar of a strength."""
    low, high = plot.view.viewRange()[1]
    scene = plot.view.mapViewToScene(QPointF(np.log10(degrees), 0.3 * (low + high)))
    return QPointF(plot.mapFromScene(scene))


def click(qtbot, plot, place):
    for kind, button in (
        (QEvent.Type.MouseButtonPress, LEFT),
        (QEvent.Type.MouseButtonRelease, NONE),
    ):
        send(plot, kind, place, LEFT, button)
    qtbot.wait(20)


def test_a_bar_leads_to_its_frames(qtbot, window, tuning):
    plot, document = tuning.curves.histogram, window.document
    strength = np.degrees(document.detector.strength("LeftForeArm"))
    bars = histogram_bar_index(strength)
    bar = int(bars.max())
    frames = np.flatnonzero(bars == bar)
    assert len(frames) == 2
    place = over_bar(plot, strength[frames[0]])
    send(plot, QEvent.Type.MouseMove, place, NONE, NONE)
    assert plot.words.text() == f"{histogram_bar_label(bar)}: 2 frames"
    visited, said = [], []
    for _ in range(3):
        click(qtbot, plot, place)
        visited.append(document.frame)
        said.append(plot.words.text())
        qtbot.wait(QApplication.doubleClickInterval() + 20)  # else it is one
    assert visited == [*frames, frames[0]]
    assert said[:2] == [
        f"frame {frames[0]}, 1 of 2 in {histogram_bar_label(bar)}",
        f"frame {frames[1]}, 2 of 2 in {histogram_bar_label(bar)}",
    ]
    assert plot.mark.isVisible()
    (low, high), _ = plot.mark.getData()
    assert 10**low <= strength[frames[0]] <= 10**high
    document.go_to(0)
    assert not plot.mark.isVisible()
    assert taus(window)["LeftForeArm"] == 1.5


def test_its_frames_are_reached_without_a_mouse(qtbot, window, tuning):
    document = window.document
    bars = histogram_bar_index(np.degrees(document.detector.strength("LeftForeArm")))
    document.set_first_frame(1)
    weakest, *_ = filled = sorted(set(bars[bars >= 0]))
    act(window, "next_bar")
    own = np.flatnonzero(bars == weakest)
    assert document.frame == own[0]
    act(window, "next_in_bar")
    assert document.frame == own[1 % len(own)]
    words = f"frame {document.frame + 1}, {1 + 1 % len(own)} of {len(own)} in "
    assert tuning.curves.histogram.words.text().startswith(words)
    act(window, "next_bar")
    assert document.frame == np.flatnonzero(bars == filled[1])[0]
    for _ in filled[1:]:
        act(window, "next_bar")
    assert document.frame == own[0]


def test_a_double_click_on_a_bar_sets_tau_and_leaves_the_playhead(qtbot, window, tuning):
    plot, document = tuning.curves.histogram, window.document
    document.go_to(17)
    strength = np.degrees(document.detector.strength("LeftForeArm")).max()
    place = over_bar(plot, strength)
    for kind, button in (
        (QEvent.Type.MouseButtonPress, LEFT),
        (QEvent.Type.MouseButtonRelease, NONE),
        (QEvent.Type.MouseButtonDblClick, LEFT),
        (QEvent.Type.MouseButtonRelease, NONE),
    ):
        send(plot, kind, place, LEFT, button)
    qtbot.wait(50)
    assert taus(window)["LeftForeArm"] == pytest.approx(strength, rel=0.05)
    assert document.frame == 17


def test_a_span_left_out_is_undone_saved_and_counts_for_nothing(qtbot, window, tuning, tmp_path):
    document = window.document
    before = tuning.costs.curves["LeftForeArm"]
    tuning.tabs.setCurrentWidget(tuning.suggestion)
    act(window, "leave_out_interval")
    assert window.bar.label.text()
    interval = document.review.state.of_chain("LeftForeArm")[0]
    document.select_interval(interval.id)
    act(window, "leave_out_interval")
    span = interval.interval.start, interval.interval.stop
    assert document.review.state.left_out == (span,)
    qtbot.waitUntil(lambda: tuning.costs.curves == {})
    wait_measured(qtbot, window)
    seconds = document.data.motion.frame_time * (span[1] - span[0])
    left = tuning.costs.curves["LeftForeArm"]
    assert left.minutes == pytest.approx(before.minutes - seconds / 60.0)
    frames = f"{span[0]}–{span[1]} ("
    qtbot.waitUntil(lambda: frames in tuning.suggestion.left_out.text())
    # Its edges are no longer among the frames by strength.
    drawn = tuning.curves.histogram
    strength = np.degrees(document.detector.strength("LeftForeArm"))
    inside = (strength[slice(*span)] >= 0.5).sum()
    assert inside
    counted = np.expm1(drawn.below.getData()[1] + drawn.above.getData()[1]).sum()
    assert round(counted) == (strength >= 0.5).sum() - inside
    visited = set()
    for _ in range(60):
        act(window, "next_bar")
        visited.add(document.frame)
    assert len(visited) >= 3
    assert not visited & set(range(*span))
    document.keeper.save(tmp_path / "s.twist.json")
    assert read_session(tmp_path / "s.twist.json").state.left_out == (span,)
    act(window, "leave_out_visible")
    assert window.bar.label.text()
    window.timeline.visible.show(200.0, 240.0)
    act(window, "leave_out_visible")
    assert document.review.state.left_out == (span, (200, 241))
    act(window, "undo")
    assert document.review.state.left_out == (span,)
    act(window, "take_all_in")
    assert document.review.state.left_out == ()
    assert tuning.costs.curves["LeftForeArm"] is before


def test_blends_at_the_ends_are_said_to_be_left_out(qtbot, window, tuning, tmp_path):
    text = (ASSETS / "walk.bvh").read_text().rstrip("\n").split("\n")
    head = next(k for k, line in enumerate(text) if line.startswith("Frame Time")) + 1
    held = [*text[:head], *20 * [text[head]], *text[head + 20 :]]
    path = tmp_path / "held.bvh"
    path.write_text("\n".join(held) + "\n")
    window.document.review.mark_saved()
    open_clip(qtbot, window, path)
    tuning.tabs.setCurrentWidget(tuning.suggestion)
    wait_measured(qtbot, window)
    capture = tuning.costs.capture
    assert capture.first > 1
    said = f"Ignored: frames 0–{capture.first} (the transition from the first pose)."
    qtbot.waitUntil(lambda: tuning.suggestion.left_out.text() == said)
