"""The teaching tab: numbers are the core's, a what-if leaves no trace."""

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QBuffer, QPoint, QRect, QSize, QSizeF, Qt
from PySide6.QtGui import QPainter
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QApplication

from inspector.bundled import LESSONS
from inspector.lessons.guided_exercise import make_exercise
from inspector.session.document import Document
from inspector.session.opening import analyse_file
from inspector.teaching.equation_table import SECTIONS
from inspector.teaching.equations import Equations
from inspector.teaching.symbols import SYMBOLS, symbol_family_colour
from inspector.teaching.taught_frame import TaughtFrame, padded_vector_text
from inspector.teaching.teaching_panel import TeachingPanel
from inspector.timeline.timeline import Timeline
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import DARK, LIGHT, Colours
from inspector.widgets.typeset import Typesetter
from tests.conftest import ASSETS
from tests.gui.other_fonts import other_font
from tests.gui.pictures import grabbed, near
from tests.gui.windows import act
from twistcore.analysis.decomposition import WhatIf, decompose, twist_times_swing_factors
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.review import Insert
from twistcore.skeleton.rotation import (
    multiply,
    quaternion_from_euler,
    rotate,
    swing_twist,
    twist_angle,
    wrap,
)
from twistcore.skeleton.signals import twist_signals

ONE_WINDOW = True
FRAMES = 10
CLIPS, CHAINS = 5, 10


def clips(folder_for_copy):
    """Five clips: those of a folder that TWIST_CLIPS names, else the samples and one injected."""
    if folder := os.environ.get("TWIST_CLIPS"):
        return [analyse_file(p) for p in sorted(Path(folder).glob("*.bvh"))[:CLIPS]]
    found = [analyse_file(p) for p in sorted(ASSETS.glob("*.bvh"))]
    dirty, _ = make_exercise(ASSETS / "dance.bvh", folder_for_copy, 3, "Judge")
    return [*found, dirty][:CLIPS]


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


def undefined(symbol, motion, chain, signals, frame):
    """Whether a value has no meaning, told from the clip's own signals."""
    two = [max(frame - 1, 0), frame]
    theta = signals.swing_reliability[two].min() < 1e-6
    azimuth = signals.azimuth_reliability[two].min() < 1e-6
    if symbol == "n":
        return theta or decompose(motion, chain, int(frame)).alpha < 1e-6
    return {"dtheta_p": theta, "theta_p": theta, "dtheta_c": azimuth}.get(symbol, theta or azimuth)


@pytest.mark.thorough
def test_every_number_is_the_cores(qtbot, tmp_path):
    rng = np.random.default_rng(7)
    seen = 0
    for data in clips(tmp_path):
        document = Document()
        document.show_clip(data)
        colours, taught = Colours(DARK), TaughtFrame(document)
        viewport = Viewport(document, colours)
        panel = TeachingPanel(taught, viewport, Timeline(document, colours), [], Typesetter())
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
                        assert undefined(symbol, data.motion, chain, signals, frame)
                        continue
                    shown, wanted = read(labels[symbol]), np.atleast_1d(value)
                    if symbol == "m":
                        shown = shown[:1]  # τ stands beside it
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
    rows = [e for section in SECTIONS for e in section.rows]
    assert {e.symbol for e in rows} == set(SYMBOLS)
    assert [e.number for e in rows if e.corrected] == ["7", "8", "9", "12"]
    assert len({e.number for e in rows if e.number}) == 15


@pytest.mark.thorough
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


@pytest.mark.thorough
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


@pytest.mark.thorough
def test_leaving_the_tab_ends_the_what_if(qtbot, taught):
    taught.teaching.what_if.sliders["twist"].setValue(900)
    taught.teaching.what_if.player.slider.setValue(50)
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not taught.taught.active and not taught.taught.what_if.changes)
    act(taught, "copy_place")
    assert "what-if" not in QApplication.clipboard().text()
    act(taught, "show_teaching")
    qtbot.waitUntil(lambda: taught.taught.active)
    assert taught.taught.stage is None
    assert not taught.taught.what_if.changes
    assert taught.teaching.what_if.sliders["twist"].value() == 0
    player = taught.teaching.what_if.player
    assert player.slider.value() == player.slider.maximum()


@pytest.mark.thorough
def test_a_window_put_aside_keeps_the_what_if(qtbot, taught):
    taught.teaching.what_if.sliders["twist"].setValue(900)
    taught.showMinimized()
    qtbot.waitUntil(taught.isMinimized)
    qtbot.wait(50)
    taught.showNormal()
    qtbot.waitUntil(lambda: not taught.isMinimized())
    qtbot.wait(50)
    assert taught.taught.active
    assert taught.teaching.what_if.sliders["twist"].value() == 900


@pytest.mark.thorough
def test_a_presentation_of_the_tab_keeps_the_what_if(qtbot, taught):
    taught.teaching.what_if.sliders["twist"].setValue(900)
    for _ in range(2):  # begin, and end
        act(taught, "presentation")
        qtbot.wait(100)
        assert taught.taught.active
        assert taught.teaching.what_if.sliders["twist"].value() == 900


@pytest.mark.thorough
def test_a_page_of_the_review_has_no_what_if(qtbot, at_forearm):
    at_forearm.taught.alter(twist=1.0)
    act(at_forearm, "copy_place")
    assert "what-if" not in QApplication.clipboard().text()


@pytest.mark.thorough
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
    assert frame.numbers.correction.whole == pytest.approx(1.0, abs=0.2)
    frame.alter(applied=1.0)
    right, same = frame.pose()
    assert same == pytest.approx(places, abs=1e-6)
    assert np.abs(right[parent] @ wrong[parent]) < 0.9


@pytest.mark.thorough
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
    assert box.words.text()


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("slider", "at", "angle", "named"),
    [("swing", 1790, "theta_p", "θp"), ("bend", 10, "dtheta_c", "θc")],
)
def test_each_singularity_is_met_and_told(taught, slider, at, angle, named):
    box, values = taught.teaching.what_if, taught.teaching.equations.values
    box.sliders[slider].setValue(at)
    assert f"{named} is nearly singular" in box.words.text()
    still = read(values[angle].text())[0]
    box.sliders["nudge"].setValue(10)  # one degree
    assert abs(read(values[angle].text())[0] - still) > 40.0
    box.reset.click()
    assert "singular" not in box.words.text()


# -- the other forms, what is taken off, the stages ---------------------------------------------


@pytest.mark.thorough
def test_one_page_s_rows_and_no_others(taught):
    panel = taught.teaching
    panel.scroll_area.ensureVisible(0, 0)
    taught.taught.set_rows({"theta_p", "check", "minus_q"})
    seen = {name for name, label in panel.equations.values.items() if label.isVisible()}
    assert seen == {"theta_p", "check"}
    heads = [head.isVisible() for head in panel.equations.heads]
    assert heads == [True, False, False, True]
    forms = panel.other_forms
    assert forms.values["q"].isVisible()
    assert not forms.values["n"].isVisible()
    taught.taught.set_rows(())
    assert all(label.isVisible() for label in panel.equations.values.values())
    assert not forms.values["q"].isVisible()


@pytest.mark.thorough
def test_heads_fold_their_rows_and_name_the_joints(qtbot, taught):
    equations = taught.teaching.equations
    assert "P = LeftForeArm" in equations.heads[0].text()
    assert "C = LeftHand, G = none" in equations.heads[1].text()
    taught.document.select_chain("LeftArm")
    assert "C = LeftForeArm, G = LeftHand" in equations.heads[1].text()
    qtbot.mouseClick(equations.heads[0], Qt.MouseButton.LeftButton, pos=QPoint(20, 6))
    assert not equations.values["q"].isVisible()
    assert equations.values["m"].isVisible()
    qtbot.mouseClick(equations.heads[0], Qt.MouseButton.LeftButton, pos=QPoint(20, 6))
    assert equations.values["q"].isVisible()


@pytest.mark.thorough
@pytest.mark.parametrize("font", [None, {"higher": 1.3}, {"wider": 1.2}], ids=str)
def test_m_is_in_sight_without_scrolling(qtbot, qapp, font, tmp_path, request):
    """Whatever font a system has: some have much room between lines, some wide letters."""
    if font is not None:
        usual = qapp.font()
        request.addfinalizer(lambda: qapp.setFont(usual))
        qapp.setFont(other_font(tmp_path, **font))
    taught = request.getfixturevalue("taught")
    taught.resize(1440, 900)
    area = taught.teaching.scroll_area

    def seen():
        for symbol in ("a", "m"):
            row = taught.teaching.equations.buttons[symbol]
            place = QRect(row.mapTo(area.viewport(), QPoint(0, 0)), row.size())
            assert area.viewport().rect().contains(place), symbol

    qtbot.waitUntil(seen)


@pytest.mark.thorough
@pytest.mark.parametrize("lesson", [False, True])
def test_nothing_scrolls_sideways_in_a_small_window(qtbot, taught, lesson):
    taught.resize(1024, 700)
    if lesson:  # its card takes of the width
        taught.lesson_actions.play(LESSONS / "3-2-extraction.md")
        qtbot.waitUntil(lambda: taught.lesson_actions.player.at == 0, timeout=20_000)
        act(taught, "show_teaching")
    taught.taught.set_rows(())
    panel = taught.teaching
    for what_if in (
        WhatIf(twist=-3.0, counter=True, swing=3.0, nudge=-0.05, applied=1.0),
        WhatIf(swing=np.pi),
        WhatIf(bend=0.0),
        WhatIf(bend=0.02, swing=3.1, nudge=0.01),
    ):
        taught.taught.set_what_if(what_if)
    for row in panel.equations.values.values():  # as wide as any number can be
        row.setText("(−0.123, −0.123, −0.123, −0.123)")
    qtbot.wait(100)
    for area in (taught.docks["teaching"].widget(), panel.scroll_area):
        assert area.widget().width() <= area.viewport().width()
    rows = panel.equations._rows
    edges = [row[3].geometry().right() for row in rows.values()]
    assert max(edges) <= panel.scroll_area.viewport().width()
    formula, value = panel.equations._rights[1], panel.equations.values["q"]
    assert value.width() >= value.fontMetrics().horizontalAdvance(value.text())
    assert value.geometry().top() > formula.geometry().top()  # below it
    if lesson:
        taught.lesson_actions.player.leave.click()


def test_apply_goes_from_wrong_to_right(qtbot, taught):
    document, box = taught.document, taught.teaching.what_if
    judged = next(j for j in document.intervals if j.interval.chain == "LeftForeArm")
    document.select_interval(judged.id)
    document.go_to(judged.interval.start + 1)
    values = taught.teaching.equations.values
    parent, wrong = taught.taught.chain.parent, document.pose(document.frame, after=False)[0]
    right = document.corrected.pose(document.frame)[0]
    assert np.abs(wrong[parent] @ right[parent]) < 0.999
    box.sliders["applied"].setValue(50)
    assert "50 %" in values["taken"].text()
    assert read(values["check"].text()) == [0.0]
    box.sliders["applied"].setValue(100)
    rotations, _ = taught.taught.pose()
    assert np.abs(rotations[parent] @ right[parent]) == pytest.approx(1.0, abs=1e-9)
    # Altered, the interval's offset is no longer that of the frame: the running sum's is.
    box.sliders["twist"].setValue(300)
    assert "interval" not in values["taken"].text()
    box.reset.click()
    assert box.sliders["applied"].value() == 0


def test_the_offset_of_an_error_that_is_no_twist_is_not_taken_off(taught):
    document, chain = taught.document, "LeftForeArm"
    offset = new_constant_offset_interval(chain, 100, 120, np.radians(80.0))
    document.select_chain(chain)
    for kind, own in ((Kind.COUNTER_TWIST, True), (Kind.LONE_JUMP, False)):
        document.do(Insert(replace(offset, kind=kind)))
        document.select_interval(max(j.id for j in document.intervals))
        document.go_to(110)
        assert document.interval.interval.kind == kind
        assert taught.taught.numbers.own is own
        document.undo()


def test_a_limb_has_no_values_and_no_sentence(qtbot, taught):
    document, box = taught.document, taught.teaching.what_if
    document.select_chain("LeftForeArm")
    box.sliders["applied"].setValue(50)
    assert box.words.text()
    document.select_chain(document.data.analysis.limbs[0].name)
    assert taught.taught.numbers is None
    assert not box.isEnabled()
    assert not box.words.text()
    assert {number.text() for number in box.numbers.values()} == {""}
    document.select_chain("LeftForeArm")
    assert box.words.text()
    assert all(number.text() for number in box.numbers.values())


def test_undefined_is_said_and_no_number(taught):
    values, frame = taught.teaching.equations.values, taught.taught
    frame.set_what_if(WhatIf(swing=np.pi))
    for symbol in ("n", "swing", "twist", "theta_p", "dtheta_p", "product", "m", "err"):
        assert values[symbol].text() == "undefined", symbol
    assert read(values["dtheta_c"].text())
    frame.set_what_if(WhatIf(bend=0.0))
    for symbol in ("dtheta_c", "product", "m", "err"):
        assert values[symbol].text() == "undefined", symbol
    assert "no\u00a0direction" in values["across"].text()
    assert read(values["theta_p"].text())
    frame.set_what_if(WhatIf(swing=np.radians(176.0)))
    assert "3 % reliable" in values["theta_p"].text()


@pytest.mark.thorough
def test_below_zero_is_answered_and_alarms_at_an_event_only(qtbot, taught):
    frame, equations = taught.taught, taught.teaching.equations

    def red(symbol):
        return (
            near(
                grabbed(qtbot, equations.buttons[symbol]),
                symbol_family_colour("error", DARK),
                by=70,
            )
            > 2
        )

    frame.set_what_if(WhatIf(twist=0.5))
    assert equations.values["product"].text().startswith("yes: −")  # the child's own motion
    assert "<" in equations.values["m"].text()
    assert not red("m")
    assert not red("product")
    frame.set_what_if(WhatIf(twist=-0.5))
    assert equations.values["product"].text().startswith("no")
    frame.set_what_if(WhatIf(twist=0.5, counter=True))
    assert equations.values["product"].text().startswith("yes: −")
    assert "≥" in equations.values["m"].text()
    assert red("m")
    assert red("product")


@pytest.mark.thorough
def test_other_forms_are_told_where_they_are_unfolded(qtbot, taught):
    forms, frame = taught.teaching.other_forms, taught.taught
    assert not any(label.text() for label in forms.values.values())
    qtbot.mouseClick(forms.head, Qt.MouseButton.LeftButton, pos=QPoint(20, 6))
    d = frame.quantities
    assert read(forms.values["n"].text()) == pytest.approx(d.n, abs=6e-4)
    _, after = twist_times_swing_factors(d.q, d.a)
    other = after[1:] / np.linalg.norm(after[1:])
    assert read(forms.values["n_after"].text()) == pytest.approx(other, abs=6e-4)
    plus = read(forms.values["theta_p"].text())
    forms.minus.click()
    assert read(forms.values["q"].text()) == pytest.approx(-d.q, abs=6e-4)
    minus = read(forms.values["theta_p"].text())
    assert abs(plus[0] - minus[0]) == pytest.approx(360.0, abs=0.011)
    assert plus[1] == minus[1]
    clip = taught.document.data.clip
    layout = clip.channels[frame.chain.parent]
    text = forms.values["parent"].text()
    assert [c for c in text if c in "XYZ"] == list(layout.order)
    assert read(text) == pytest.approx(clip.values[90, list(layout.rotation)], abs=0.006)
    assert not forms.values["lock"].isVisible()
    # P turned so that its middle channel is 90°: the first and the last axis coincide.
    q = quaternion_from_euler(layout.order, np.radians([20.0, 90.0, 10.0]))
    frame.set_what_if(WhatIf(toward=tuple(rotate(q, d.a))))
    d = frame.quantities
    twist = wrap(float(twist_angle(q, d.a)) - d.theta_p)
    frame.alter(twist=float(twist))
    assert "gimbal lock" in forms.values["lock"].text()
    assert forms.values["lock"].isVisible()


@pytest.mark.thorough
def test_the_player_goes_from_a_over_the_swing_to_the_twist(qtbot, taught):
    player, frame = taught.teaching.what_if.player, taught.taught
    stages = []
    frame.changed.connect(lambda: stages.append(frame.stage))
    player.speeds["2×"].trigger()
    player.play.click()
    qtbot.waitUntil(lambda: not player.playing, timeout=10_000)
    assert stages[0] == 0.0
    assert stages[-1] is None
    way = stages[:-1]
    assert way == sorted(way)
    assert any(0.1 < s < 0.9 for s in way)
    assert any(1.1 < s < 1.9 for s in way)
    # Again and again, until a person takes the slider, or the tab goes.
    player.loop.click()
    player.play.click()
    stages.clear()
    qtbot.waitUntil(lambda: stages.count(0.0) >= 2, timeout=15_000)
    player.slider.setValue(50)
    assert frame.stage == 0.5
    assert not player.playing
    assert taught.teaching.equations.values["m"].text() == "–"
    player.slider.setValue(player.slider.maximum())
    assert frame.stage is None
    player.play.click()
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not player.playing)


@pytest.mark.thorough
def test_the_list_paints_itself_as_lines_of_any_size(qtbot, taught, tmp_path):
    equations = Equations(taught.taught, taught.teaching.typesetter, Colours(LIGHT))
    equations.refresh()
    buffer = QBuffer()
    generator = QSvgGenerator()
    generator.setOutputDevice(buffer)
    generator.setSize(QSize(1600, 1600))
    painter = QPainter(generator)
    equations.paint_into(painter, QSizeF(1600.0, 1600.0))
    painter.end()
    drawn = bytes(buffer.data()).decode()
    assert "<image" not in drawn
    assert drawn.count("<path") >= 2 * len(SYMBOLS)
    assert "cos" not in drawn  # formulas are outlines, no text of a font that may be missing
    equations.deleteLater()


def test_values_of_a_quaternion_keep_their_length():
    """A zero has no sign; the tab must not become wider when it gets one."""
    assert len({len(padded_vector_text(q)) for q in ((1, 0, 0, 0), (0.5, -0.5, 0.5, -0.5))}) == 1
