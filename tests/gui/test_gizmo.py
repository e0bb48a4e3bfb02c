"""The gizmo in the 3D view: lines where the vectors say, let go as it is taken, labels in place."""

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QImage, QMouseEvent
from PySide6.QtWidgets import QApplication

from inspector.teaching.gizmo_shapes import CLEAR, sketch_gizmo
from inspector.teaching.symbols import symbol_family_colour
from inspector.widgets.theme import DARK, LIGHT
from tests.gui.pictures import grabbed, near
from twistcore.analysis.decomposition import WhatIf, decompose


def test_the_gizmo_comes_and_goes_with_the_tab(qtbot, taught):
    inks = [symbol_family_colour(family, DARK) for family in ("swing", "twist", "azimuth")]
    with_it = grabbed(qtbot, taught.viewport)
    assert min(near(with_it, ink) for ink in inks) > 40
    taught.docks["intervals"].raise_()
    without = grabbed(qtbot, taught.viewport)
    assert all(near(without, ink) < 0.2 * near(with_it, ink) for ink in inks)


ONE_WINDOW = True
LEFT, RIGHT, NONE = (getattr(Qt.MouseButton, f"{name}Button") for name in ("Left", "Right", "No"))


def point(window, kind, offset=0, button=NONE, buttons=NONE):
    """An event of the mouse, so many pixels beside the tip of w."""
    view, hold = window.viewport, window.teaching.gizmo.hold
    (tip,), _ = view.camera.project(hold.places.tip[None], *view.picture_size())
    at = QPointF(*(tip + offset))
    event = QMouseEvent(
        kind, at, view.view.mapToGlobal(at), button, buttons, Qt.KeyboardModifier.NoModifier
    )
    QApplication.sendEvent(view.view, event)


def drag_w(window):
    """Take w and swing it; the button stays down."""
    point(window, QEvent.Type.MouseButtonPress, 0, LEFT, LEFT)
    point(window, QEvent.Type.MouseMove, 20, NONE, LEFT)
    assert window.teaching.gizmo.hold.held
    assert window.taught.what_if.toward is not None


@pytest.mark.thorough
def test_w_is_let_go_where_its_release_was_lost(taught):
    drag_w(taught)
    what_if = taught.taught.what_if
    point(taught, QEvent.Type.MouseMove, 50)
    assert not taught.teaching.gizmo.hold.held
    assert taught.taught.what_if == what_if


@pytest.mark.thorough
def test_w_is_let_go_with_the_window(taught):
    drag_w(taught)
    what_if = taught.taught.what_if
    QApplication.sendEvent(taught, QEvent(QEvent.Type.WindowDeactivate))
    assert not taught.teaching.gizmo.hold.held
    point(taught, QEvent.Type.MouseMove, 50, NONE, LEFT)
    assert taught.taught.what_if == what_if


@pytest.mark.thorough
def test_another_buttons_release_does_not_let_w_go(taught):
    drag_w(taught)
    point(taught, QEvent.Type.MouseButtonPress, 0, RIGHT, LEFT | RIGHT)
    point(taught, QEvent.Type.MouseButtonRelease, 0, RIGHT, LEFT)
    assert taught.teaching.gizmo.hold.held
    point(taught, QEvent.Type.MouseButtonRelease, 0, LEFT, NONE)
    assert not taught.teaching.gizmo.hold.held


@pytest.mark.thorough
def test_escape_puts_nothing_of_one_chain_on_another(qtbot, taught):
    taught.taught.alter(twist=1.0)
    drag_w(taught)
    taught.document.select_chain("RightArm")
    assert not taught.teaching.gizmo.hold.held
    qtbot.keyClick(taught, Qt.Key.Key_Escape)
    assert not taught.taught.what_if.changes


def test_lines_lie_where_the_vectors_say(taught):
    data, chain = taught.document.data, taught.taught.chain
    for frame in (1, 90, 206):
        d = decompose(data.motion, chain, frame)
        parent, child = (data.positions[frame, j] for j in (chain.parent, chain.child))
        shapes = sketch_gizmo(d, data.rotations[frame, chain.parent], parent, child, 0.0, 0.1)
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


@pytest.mark.thorough
def test_frames_only_move_the_points(taught):
    data, chain = taught.document.data, taught.taught.chain
    shapes = []
    for frame in (0, 90, 206):
        for what_if in (WhatIf(), WhatIf(swing=np.pi, bend=0.0), WhatIf(swing=0.0)):
            d = decompose(data.motion, chain, frame, what_if)
            places = (data.positions[frame, j] for j in (chain.parent, chain.child))
            whole = sketch_gizmo(d, data.rotations[frame, chain.parent], *places, 0.2, 0.1)
            assert all(np.isfinite(p.points).all() for p in whole.parts)
            shapes.append([(p.symbol, p.look, len(p.points)) for p in whole.parts])
    assert all(s == shapes[0] for s in shapes)


@pytest.mark.thorough
def test_labels_keep_apart_and_inside(qtbot, taught):
    taught.taught.set_what_if(WhatIf(twist=1.0, counter=True, bend=1.2))
    taught.viewport.focus_chain()
    qtbot.wait(100)
    boxes = [box for _, box, _, _ in taught.teaching.gizmo.labels._placed]
    assert len(boxes) >= 9
    for k, one in enumerate(boxes):
        assert taught.viewport.rect().adjusted(-4, -4, 4, 4).contains(one.toRect())
        assert not any(one.intersects(other) for other in boxes[k + 1 :])


@pytest.mark.thorough
def test_what_counters_is_in_view_too(qtbot, taught):
    document, viewport = taught.document, taught.viewport
    document.select_chain("LeftArm")
    document.go_to(200)
    taught.taught.set_what_if(WhatIf(twist=1.3))
    viewport.focus_chain()
    taught.taught.alter(counter=True)
    qtbot.wait(50)
    chain, size = taught.taught.chain, viewport.picture_size()
    joints = document.data.positions[200, [chain.parent, chain.child, chain.grandchild]]
    places, _ = viewport.camera.project(joints, *size)
    assert (places > 10.0).all()
    assert (places < np.array(size) - 10.0).all()


@pytest.mark.thorough
@pytest.mark.parametrize("swing", [90.0, 180.0])
def test_no_label_lies_over_the_legend(qtbot, taught, swing):
    """Where the gizmo is behind it, from all around; at 180° the legend has a line more."""
    viewport, legend = taught.viewport, taught.viewport.overlays.legend
    taught.taught.set_what_if(WhatIf(swing=np.radians(swing)))
    viewport.focus_chain()
    begin, placed = viewport.camera, 0
    for azimuth in np.radians(range(0, 360, 45)):
        viewport.steer(lambda _, turn=azimuth: begin.orbited(turn, 0.0))
        (tip,), _ = viewport.camera.project(
            taught.teaching.gizmo.hold.places.tip[None], *viewport.picture_size()
        )
        right, down = np.array(legend.geometry().center().toTuple()) - tip
        height = viewport.picture_size()[1]
        viewport.steer(lambda now, by=(right, -down), high=height: now.panned(*by, high))
        qtbot.wait(30)
        covered = legend.geometry()
        boxes = [box for _, box, _, _ in taught.teaching.gizmo.labels._placed]
        assert not any(box.intersects(QRectF(covered)) for box in boxes)
        near = QRectF(covered).adjusted(-80, -80, 80, 80)
        placed += sum(near.intersects(box) for box in boxes)
    assert placed > 10  # it was in their way


def test_a_click_on_a_symbol_lights_it_in_3d_and_in_the_plot(qtbot, taught):
    button = taught.teaching.equations.buttons["theta_p"]
    taught.teaching.scroll_area.ensureWidgetVisible(button)
    pane = taught.timeline.panes["theta"]
    width = pane.curves["p_after"].pen.widthF()
    other = near(grabbed(qtbot, taught.viewport), symbol_family_colour("swing", DARK))
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert taught.taught.lit == "theta_p"
    assert button.isChecked()
    assert pane.curves["p_after"].pen.widthF() > 2 * width
    assert pane.curves["c_after"].pen.widthF() == width
    lit = grabbed(qtbot, taught.viewport)
    assert near(lit, symbol_family_colour("twist", DARK)) > 40
    assert near(lit, symbol_family_colour("swing", DARK)) < 0.3 * other
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert taught.taught.lit == ""
    assert pane.curves["p_after"].pen.widthF() == width


@pytest.mark.thorough
def test_side_by_side_split_and_close_with_the_gizmo(qtbot, taught):
    taught.actions_by_id["side_by_side"].trigger()
    taught.taught.set_what_if(WhatIf(twist=1.0))
    halves = np.array_split(grabbed(qtbot, taught.viewport), 2, axis=1)
    ink = symbol_family_colour("twist", DARK)
    assert near(halves[1], ink) > 30 > near(halves[0], ink)
    taught.actions_by_id["side_by_side"].trigger()
    assert near(grabbed(qtbot, taught.viewport), ink) > 30


@pytest.mark.thorough
def test_symbols_stay_crisp_and_take_the_themes_colours(qtbot, taught):
    button = taught.teaching.equations.buttons["q"]
    taught.program.apply_theme(LIGHT)
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


@pytest.mark.thorough
def test_a_view_that_is_hidden_has_no_labels_left(qtbot, taught):
    labels = taught.teaching.gizmo.labels
    assert labels.isVisible()
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not labels.isVisible())
    assert taught.viewport.childAt(QPointF(5, 5).toPoint()) is not labels
    assert taught.viewport.size() != QSize()
