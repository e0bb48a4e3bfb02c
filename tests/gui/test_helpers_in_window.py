"""A twist bone next to a chain: its roll in the table, the 3D view and the export."""

import numpy as np
import pytest
from PySide6.QtCore import Qt

from inspector.session.export_files import ExportChoice
from inspector.session.open_clip import Show
from inspector.session.settings import Settings
from inspector.tuning.tuning_panel import Scope
from inspector.viewport.bone_colours import Role
from inspector.viewport.limb_circle import helper_circle
from tests.gui.pictures import changed, picture, settle
from tests.gui.test_limb_in_3d import PARTS, shown
from tests.gui.windows import act, export, open_clip
from tests.twistcore.test_strangers import UNREAL, rolled
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.formats.bvh.compose import bvh_text
from twistcore.skeleton.rotation import geodesic_angle

HELPER = "upperarm_twist_01_l"
FRAME = 155  # within its error


@pytest.fixture(scope="module")
def popped(tmp_path_factory):
    """A walk on a rig with twist bones, of which one pops by 90°."""
    degrees = np.zeros(UNREAL.frames)
    degrees[150:165] = 90.0
    path = tmp_path_factory.mktemp("clip") / "popped.bvh"
    path.write_text(bvh_text(rolled(UNREAL, HELPER, degrees)), "utf-8")
    return path


@pytest.fixture
def document(open_document, popped):
    document = open_document(popped)
    document.select_interval(document.intervals[0].id)
    document.go_to(FRAME)
    return document


def title_of(pane):
    return "".join(text for text, _ in pane.front.title)


def middle(view, name):
    points = getattr(view.scene._circle, name).points.astype(float)
    return (points.min(axis=0) + points.max(axis=0)) / 2.0


def test_its_roll_is_marked_on_a_circle_about_the_bone(qtbot, document, show_view):
    view, helper = show_view(document), document.find_chain(HELPER)
    skeleton, height = document.data.motion.skeleton, view.scene.height
    assert shown(view) == set(PARTS)
    circles = [
        helper_circle(helper, skeleton, document.pose(FRAME, after=after), height)
        for after in (False, True)
    ]
    for name, circle in zip(("before", "after"), circles, strict=True):
        place = circle.centre + circle.aside
        np.testing.assert_allclose(middle(view, name), place, atol=1e-4 * height)
    before, after = (circle.aside / np.linalg.norm(circle.aside) for circle in circles)
    turn = np.degrees(np.arctan2(np.cross(before, after) @ circles[0].axis, before @ after))
    offset = np.degrees(document.offset(HELPER)[FRAME])
    assert turn == pytest.approx(-offset, abs=2.0)
    # What is swept begins before and ends after, the shorter way.
    rim = view.scene._circle.swept.points.astype(float)[1:]
    np.testing.assert_allclose(rim[0], circles[0].at(np.zeros(1))[0], atol=1e-4 * height)
    assert np.linalg.norm(rim[-1] - circles[1].at(np.zeros(1))[0]) < 0.1 * height * 0.06
    # The circle lies within the bone that the helper is in, not at the joint it hangs on.
    upper, end = (circles[0].first, circles[0].end)
    along = (circles[0].centre - upper) @ (end - upper) / ((end - upper) @ (end - upper))
    assert 0.2 < along < 0.8


@pytest.mark.thorough
def test_before_after_and_both_show_what_is_asked_for(qtbot, document, show_view):
    view = show_view(document)
    for show, more in ((Show.BEFORE, {"before"}), (Show.AFTER, {"after"}), (Show.BOTH, None)):
        document.set_show(show)
        settle(qtbot, view)
        assert shown(view) == ({"line", "circle"} | more if more else set(PARTS))
    document.go_to(100)  # nothing to correct
    settle(qtbot, view)
    assert shown(view) == {"line", "circle"}
    document.select_chain("upperarm_l")
    settle(qtbot, view)
    assert shown(view) == set()


@pytest.mark.thorough
def test_the_bone_that_it_lies_in_is_chosen(document, show_view):
    view, names = show_view(document), document.data.motion.skeleton.names
    document.go_to(100)
    roles = view.drawing.pose(view.scene).roles
    chosen = {
        (names[b.parent], names[b.child] if b.child >= 0 else "")
        for b, role in zip(view.scene.bones, roles, strict=True)
        if role == Role.CHOSEN
    }
    assert chosen == {("upperarm_l", "lowerarm_l"), (HELPER, "")}


def test_the_camera_frames_it_and_sees_its_circle_open(qtbot, document, show_view):
    view, helper = show_view(document), document.find_chain(HELPER)
    view.steer(lambda c: c.panned(3000.0, 0.0, 500))
    assert not view.sees_chain()
    view.focus_chain()
    assert view.sees_chain()
    pose = document.pose(FRAME, after=False)
    circle = helper_circle(helper, document.data.motion.skeleton, pose, view.scene.height)
    assert 0.15 < abs(view.camera.direction @ circle.axis) < 0.9
    ring = circle.at(np.linspace(0.0, 2.0 * np.pi, 24))
    seen, _ = view.camera.project(ring, view.width(), view.height())
    assert ((seen > 0) & (seen < (view.width(), view.height()))).all()
    whole = picture(qtbot, view)
    for name, least in (("before", 20), ("after", 20), ("circle", 60)):
        piece = getattr(view.scene._circle, name)
        piece.show(False)
        view.view.update()
        assert changed(whole, picture(qtbot, view), by=12).sum() > least, name
        piece.show(True)


@pytest.mark.thorough
def test_it_is_reviewed_to_the_end_and_exported(qtbot, show_window, tmp_path, popped):
    clip = tmp_path / "popped.bvh"
    clip.write_bytes(popped.read_bytes())
    window = show_window(Settings(), tmp_path / "settings.json")
    open_clip(qtbot, window, clip)
    document = window.document
    assert not document.automatic_ids()  # never without a person
    choice = window.intervals.filter
    choice.setCurrentIndex(choice.findData("Helper rolls"))
    assert len(window.intervals.shown_ids()) == 1
    choice.setCurrentIndex(choice.findData("Limb flips"))
    assert window.intervals.shown_ids() == ()
    choice.setCurrentIndex(choice.findData("All"))
    qtbot.keyClick(window, Qt.Key.Key_N)
    assert document.interval.interval.kind == Kind.HELPER_ROLL
    assert window.detail.why.text()
    assert window.detail.title.text().startswith(f"<b>Left Arm · {HELPER}</b>")
    act(window, "accept")
    assert "export" in window.bar.label.text()
    out = clip.with_name("out.bvh")
    export(window, ExportChoice(out))
    written, j = read_bvh(out).motion, UNREAL.skeleton.index(HELPER)
    assert np.degrees(geodesic_angle(written.rotations, UNREAL.rotations)[:, j].max()) < 4.0


@pytest.mark.thorough
def test_it_has_one_detector_and_the_plots_say_so(qtbot, show_window, tmp_path, popped):
    clip = tmp_path / "popped.bvh"
    clip.write_bytes(popped.read_bytes())
    window = show_window(Settings(), tmp_path / "settings.json")
    open_clip(qtbot, window, clip)
    document, other = window.document, window.timeline.panes["other"]
    act(window, "both_detectors")
    document.select_chain("upperarm_l")
    qtbot.waitUntil(lambda: "interval" in title_of(other), timeout=60_000)
    document.select_chain(HELPER)
    qtbot.waitUntil(lambda: "one detector" in title_of(other))
    assert other.intervals == ()


@pytest.mark.thorough
def test_tuning_measures_chains_and_leaves_twist_bones_their_own_tau(
    qtbot, show_window, tmp_path, popped
):
    clip = tmp_path / "popped.bvh"
    clip.write_bytes(popped.read_bytes())
    window = show_window(Settings(), tmp_path / "settings.json")
    open_clip(qtbot, window, clip)
    document, tuning = window.document, window.tuning
    document.select_chain("upperarm_l")
    tuning.set_scope(Scope.ALL)
    assert len(tuning.chains_in_scope()) == 10
    assert HELPER not in tuning.costs.names
    document.select_chain(HELPER)
    assert len(tuning.chains_in_scope()) == 12
    act(window, "show_tuning")
    qtbot.waitUntil(lambda: bool(tuning.costs.curves or tuning.costs.trouble), timeout=120_000)
    assert not tuning.costs.trouble
    assert not tuning.curves.cost.isVisible()
    assert "twist bone" in tuning.curves.cost_words.text()
