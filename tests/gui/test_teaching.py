"""The teaching tab: numbers are the core's, a what-if leaves no trace."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QColor, QImage

from inspector.lessons.guided_exercise import make_exercise
from inspector.session.document import Document
from inspector.session.opening import analyse
from inspector.teaching.gizmo_shapes import CLEAR, sketch
from inspector.teaching.symbols import SECTIONS, SYMBOLS, colour
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.teaching_panel import TeachingPanel
from inspector.teaching.what_if import words
from inspector.timeline.timeline import Timeline
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import DARK, LIGHT
from tests.conftest import ASSETS
from tests.gui.windows import act
from twistcore.decomposition import WhatIf, decompose
from twistcore.rotation import multiply, rotate, swing_twist
from twistcore.signals import twist_signals

FRAMES = 20
CLIPS, CHAINS = 5, 10


def clips(folder_for_copy):
    """Five clips: those of a folder that TWIST_CLIPS names, else the samples and one injected."""
    if folder := os.environ.get("TWIST_CLIPS"):
        return [analyse(p) for p in sorted(Path(folder).glob("*.bvh"))[:CLIPS]]
    found = [analyse(p) for p in sorted(ASSETS.glob("*.bvh"))]
    dirty, _ = make_exercise(ASSETS / "dance.bvh", folder_for_copy, 3, "Judge")
    return [*found, dirty][:CLIPS]


@pytest.fixture
def taught(qtbot, at_forearm):
    act(at_forearm, "show_teaching")
    qtbot.waitUntil(lambda: at_forearm.teaching.typesetter.done, timeout=30_000)
    qtbot.wait(100)
    return at_forearm


def read(text):
    """Numbers of a label."""
    return [float(x) for x in re.findall(r"[+-]?\d+\.\d+", text.replace("−", "-"))]


def core_values(motion, chain, signals, frame):
    """What each row must show, computed over the whole clip and not by `decompose`."""
    q = motion.rotations[frame, chain.parent]
    swing, twist = swing_twist(q, chain.axis)
    if swing[0] < 0.0:
        q, swing = -q, -swing
    w = rotate(q, chain.axis)
    v = rotate(motion.rotations[frame, chain.child], chain.arm)
    normal = np.cross(chain.axis, w)
    p, c = (np.degrees(getattr(signals, s)[frame]) for s in ("dtheta_p", "dtheta_c"))
    return {
        "a": chain.axis,
        "q": multiply(swing, twist),
        "w": w,
        "n": normal / max(np.linalg.norm(normal), 1e-300),
        "alpha": np.degrees(2.0 * np.arccos(np.clip(swing[0], -1.0, 1.0))),
        "swing": swing,
        "twist": twist,
        "theta_p": np.degrees(signals.theta_p[frame]),
        "dtheta_p": p,
        "v": v,
        "across": v - (v @ chain.axis) * chain.axis,
        "dtheta_c": c,
        "product": p * c,
        "m": np.degrees(signals.strength[frame]),
    }


def test_every_number_is_the_cores(qtbot, tmp_path):
    rng = np.random.default_rng(7)
    seen = 0
    for data in clips(tmp_path):
        document = Document()
        document.show_clip(data)
        viewport, taught = Viewport(document, DARK), TaughtFrame(document)
        panel = TeachingPanel(taught, viewport, Timeline(document, DARK), [])
        taught.set_active(True)
        for chain in data.chains[:CHAINS]:
            document.select_chain(chain.name)
            signals = twist_signals(data.motion, chain)
            for frame in rng.choice(data.motion.frames, FRAMES, replace=False):
                document.go_to(int(frame))
                if document.frame == 0:
                    panel.refresh()
                labels = {k: label.text() for k, label in panel.equations.values.items()}
                for symbol, value in core_values(data.motion, chain, signals, frame).items():
                    if labels[symbol] == "undefined":
                        assert decompose(data.motion, chain, int(frame)).alpha < 1e-6
                        continue
                    shown, wanted = read(labels[symbol]), np.atleast_1d(value)
                    angle = symbol not in ("a", "q", "w", "n", "v", "across", "swing", "twist")
                    half = 0.005 if angle else 0.0005
                    assert shown == pytest.approx(wanted, abs=half + 1e-6), (symbol, frame)
                seen += 1
        document.close_clip()
        viewport.close()
        panel.close()
        panel.deleteLater()
        viewport.deleteLater()
        qtbot.wait(10)
    assert seen == CLIPS * CHAINS * FRAMES


def test_every_symbol_has_its_row_and_every_printed_slip_is_named():
    rows = [e for equations in SECTIONS.values() for e in equations]
    assert {e.symbol for e in rows} == set(SYMBOLS)
    assert [e.number for e in rows if e.corrected] == ["7", "8", "9", "12"]
    assert len({e.number for e in rows if e.number}) == 13


def test_nothing_is_typeset_and_no_ffmpeg_loaded_before_it_is_wanted(tmp_path):
    program = (
        "import sys\nfrom inspector.app import make_application\napp = make_application()\n"
        "from inspector.window.main_window import MainWindow\n"
        "from inspector.session.settings import Settings\n"
        "window = MainWindow(Settings(), None)\nwindow.show()\napp.processEvents()\n"
        "print('imageio_ffmpeg' in sys.modules, window.teaching.typesetter.started)\n"
        "window.close()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.split() == ["False", "False"], done.stderr


# -- what if --------------------------------------------------------------------------------------


def test_a_what_if_leaves_no_trace(qtbot, taught):
    document, box = taught.document, taught.teaching.what_if
    before = document.review.state
    folder = {p.name for p in document.data.clip.path.parent.iterdir()}
    for name, slider in box.sliders.items():
        slider.setValue(slider.maximum() if name != "bend" else 0)
    qtbot.mouseClick(box.counter, Qt.MouseButton.LeftButton)
    assert taught.taught.what_if.changes
    qtbot.wait(50)
    assert document.review.state is before
    assert document.review.saved
    assert not document.review.undo_text
    assert not taught.isWindowModified()
    assert {p.name for p in document.data.clip.path.parent.iterdir()} == folder
    qtbot.mouseClick(box.reset, Qt.MouseButton.LeftButton)
    assert not taught.taught.what_if.changes
    assert box.sliders["twist"].value() == 0
    assert box.sliders["swing"].value() == round(10 * np.degrees(taught.taught.quantities.alpha))


def test_the_what_if_pose_is_seen_while_the_tab_is_and_only_then(qtbot, taught):
    def seen():
        return taught.viewport.drawing.pose(taught.viewport.scene)

    captured = seen().rotations
    taught.teaching.what_if.sliders["twist"].setValue(900)
    assert np.abs(seen().rotations - captured).max() > 0.3
    assert seen().ghost is not None
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not taught.taught.active)
    whole, _ = taught.document.pose(90, after=True)
    assert np.array_equal(seen().rotations, whole)


def test_a_stage_and_what_is_taken_off_are_seen_in_the_pose(taught):
    frame = taught.taught
    assert frame.pose() is None
    told = []
    frame.changed.connect(lambda: told.append(frame.stage))
    frame.set_stage(0.0)
    assert told == [0.0]
    parent = frame.chain.parent
    above = taught.document.data.motion.skeleton.parents[parent]
    rotations, _ = frame.pose()
    # None of its rotation yet: it stands as its own parent does.
    assert np.abs(rotations[parent] @ rotations[above]) == pytest.approx(1.0)
    frame.reset()
    assert frame.stage is None
    frame.set_what_if(WhatIf(twist=1.0, counter=True))
    wrong, places = frame.pose()
    assert frame.offset == pytest.approx(1.0, abs=0.2)
    frame.alter(applied=1.0)
    right, same = frame.pose()
    assert same == pytest.approx(places, abs=1e-6)
    assert np.abs(right[parent] @ wrong[parent]) < 0.9


def test_another_chain_or_clip_starts_as_captured(taught):
    taught.teaching.what_if.sliders["swing"].setValue(1500)
    taught.document.select_chain("RightArm")
    assert not taught.taught.what_if.changes


def test_counter_twist_shows_the_products_sign_turn(taught):
    box, values = taught.teaching.what_if, taught.teaching.equations.values
    box.sliders["twist"].setValue(600)
    assert abs(read(values["m"].text())[0]) < 1.0
    assert "pure twist" in box.words.text()
    box.counter.click()
    assert read(values["product"].text())[0] < -3000.0
    assert read(values["m"].text())[0] == pytest.approx(60.0, abs=1.0)
    assert "against each other" in box.words.text()


@pytest.mark.parametrize(
    ("slider", "at", "angle", "named"),
    [("swing", 1790, "theta_p", "θp"), ("bend", 10, "dtheta_c", "θc")],
)
def test_each_singularity_is_met_and_told(taught, slider, at, angle, named):
    box, values = taught.teaching.what_if, taught.teaching.equations.values
    box.sliders[slider].setValue(at)
    assert f"Singularity of {named}" in box.words.text()
    still = read(values[angle].text())[0]
    box.sliders["nudge"].setValue(10)  # one degree
    assert abs(read(values[angle].text())[0] - still) > 40.0
    box.reset.click()
    assert "Singularity" not in box.words.text()


def test_words_fit_in_two_lines(taught):
    box, motion = taught.teaching.what_if, taught.document.data.motion
    chain = taught.taught.chain
    width = 480  # pixels, of the tab in a window 1280 wide
    for what_if in (
        WhatIf(),
        WhatIf(twist=1.0),
        WhatIf(twist=1.0, counter=True),
        WhatIf(swing=np.pi),
        WhatIf(bend=0.0),
        WhatIf(swing=np.pi, bend=0.0),
        WhatIf(nudge=0.01),
    ):
        text, role = words(decompose(motion, chain, 90, what_if), what_if, 0.03)
        assert hasattr(DARK, role)
        box.words.setText(text)
        assert box.words.heightForWidth(width) <= box.words.minimumHeight() + 2


# -- gizmo ----------------------------------------------------------------------------------------


def picture(qtbot, view):
    qtbot.wait(60)
    image = view.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


def near(image, ink, by=40):
    """How many pixels have a colour."""
    wanted = np.array([int(ink[k : k + 2], 16) for k in (1, 3, 5)])
    return int((np.abs(image - wanted).max(axis=2) < by).sum())


def test_the_gizmo_comes_and_goes_with_the_tab(qtbot, taught):
    inks = [colour(family, DARK) for family in ("swing", "twist", "azimuth")]
    with_it = picture(qtbot, taught.viewport)
    assert min(near(with_it, ink) for ink in inks) > 40
    taught.docks["intervals"].raise_()
    without = picture(qtbot, taught.viewport)
    assert all(near(without, ink) < 0.2 * near(with_it, ink) for ink in inks)


def test_lines_lie_where_the_vectors_say(taught):
    data, chain = taught.document.data, taught.taught.chain
    for frame in (1, 90, 206):
        d = decompose(data.motion, chain, frame)
        parent, child = (data.positions[frame, j] for j in (chain.parent, chain.child))
        shapes = sketch(d, data.rotations[frame, chain.parent], parent, child, 0.0, 0.1)
        first = {}
        for part in shapes.parts:
            first.setdefault((part.symbol, part.look), part.points)
        bone = (child - parent) / np.linalg.norm(child - parent)
        w = first["w", "bold"][1] - first["w", "bold"][0]
        a = first["a", "bold"][1] - first["a", "bold"][0]
        assert w / np.linalg.norm(w) == pytest.approx(bone, abs=1e-6)
        spread = np.arccos(a @ w / np.linalg.norm(a) / np.linalg.norm(w))
        assert spread == pytest.approx(d.alpha, abs=1e-6)
        dial = first["theta_p", CLEAR]
        centre, rim = dial[: len(dial) // 2], dial[len(dial) // 2 :]
        start, stop = rim[0] - centre[0], rim[-1] - centre[-1]
        turned = np.arctan2(np.cross(start, stop) @ bone, start @ stop)
        assert turned == pytest.approx(d.theta_p, abs=1e-6)


def test_frames_only_move_the_points(taught):
    data, chain = taught.document.data, taught.taught.chain
    shapes = []
    for frame in (0, 90, 206):
        for what_if in (WhatIf(), WhatIf(swing=np.pi, bend=0.0), WhatIf(swing=0.0)):
            d = decompose(data.motion, chain, frame, what_if)
            places = (data.positions[frame, j] for j in (chain.parent, chain.child))
            whole = sketch(d, data.rotations[frame, chain.parent], *places, 0.2, 0.1)
            assert all(np.isfinite(p.points).all() for p in whole.parts)
            shapes.append([(p.symbol, p.look, len(p.points)) for p in whole.parts])
    assert all(s == shapes[0] for s in shapes)


def test_labels_keep_apart_and_inside(qtbot, taught):
    taught.taught.set_what_if(WhatIf(twist=1.0, counter=True, bend=1.2))
    taught.viewport.focus_chain()
    qtbot.wait(100)
    boxes = [box for _, box, _, _ in taught.teaching.gizmo.labels._placed]
    assert len(boxes) >= 9
    for k, one in enumerate(boxes):
        assert taught.viewport.rect().adjusted(-4, -4, 4, 4).contains(one.toRect())
        assert not any(one.intersects(other) for other in boxes[k + 1 :])


def test_a_click_on_a_symbol_lights_it_in_3d_and_in_the_plot(qtbot, taught):
    button = taught.teaching.equations.buttons["theta_p"]
    taught.teaching.scroll_area.ensureWidgetVisible(button)
    pane = taught.timeline.panes["theta"]
    width = pane.curves["p_after"].pen.widthF()
    other = near(picture(qtbot, taught.viewport), colour("swing", DARK))
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert taught.taught.lit == "theta_p"
    assert button.isChecked()
    assert pane.curves["p_after"].pen.widthF() > 2 * width
    assert pane.curves["c_after"].pen.widthF() == width
    lit = picture(qtbot, taught.viewport)
    assert near(lit, colour("twist", DARK)) > 40
    assert near(lit, colour("swing", DARK)) < 0.3 * other
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert taught.taught.lit == ""
    assert pane.curves["p_after"].pen.widthF() == width


def test_side_by_side_split_and_close_with_the_gizmo(qtbot, taught):
    taught.actions_by_id["side_by_side"].trigger()
    taught.taught.set_what_if(WhatIf(twist=1.0))
    halves = np.array_split(picture(qtbot, taught.viewport), 2, axis=1)
    ink = colour("twist", DARK)
    assert near(halves[1], ink) > 30 > near(halves[0], ink)
    taught.actions_by_id["side_by_side"].trigger()
    assert near(picture(qtbot, taught.viewport), ink) > 30


def test_symbols_stay_crisp_and_take_the_themes_colours(qtbot, taught):
    button = taught.teaching.equations.buttons["q"]
    taught.apply_theme(LIGHT)
    image = button.grab().toImage()
    places = [(x, y) for x in range(image.width()) for y in range(image.height())]
    darkest = min(image.pixelColor(*place).lightness() for place in places)
    assert abs(darkest - QColor(LIGHT.text).lightness()) < 15
    larger = QImage(button.size() * 4, QImage.Format.Format_RGB32)
    larger.setDevicePixelRatio(4.0)
    larger.fill(QColor(LIGHT.surface))
    button.render(larger)
    # Outlines, not a scaled picture: of four times as many dots few lie between ink and paper.
    values = np.array(
        [
            larger.pixelColor(x, y).lightness()
            for x in range(larger.width())
            for y in range(larger.height())
        ]
    )
    dark, light = QColor(LIGHT.text).lightness(), QColor(LIGHT.surface).lightness()
    between = ((values > dark + 30) & (values < light - 30)).sum()
    assert between < (values <= dark + 30).sum()


def test_a_view_that_is_hidden_has_no_labels_left(qtbot, taught):
    labels = taught.teaching.gizmo.labels
    assert labels.isVisible()
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not labels.isVisible())
    assert taught.viewport.childAt(QPointF(5, 5).toPoint()) is not labels
    assert taught.viewport.size() != QSize()
