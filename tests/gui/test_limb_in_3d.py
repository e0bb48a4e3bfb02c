"""A selected limb in the 3D view: both bones before and after, its line, its circle."""

import shutil

import numpy as np
import pytest
from PySide6.QtCore import QPointF
from PySide6.QtWidgets import QToolTip

from inspector.bundled import FLIPPED
from inspector.session.open_clip import Show
from inspector.viewport.bone_colours import Role
from inspector.viewport.limb_circle import LEAST_RADIUS, find_limb_circle, limb_bones
from inspector.widgets.theme import DARK, LIGHT
from tests.gui.pictures import changed, picture, settle
from tests.gui.windows import act, open_clip
from twistcore.detection import Kind

LEG, ARM = "RightUpLeg-RightFoot", "RightArm-RightHand"
FRAME = 20  # within a flip
FLIPS = (20, 35, 40, 48, 74, 175)  # a frame of each
STRAIGHT = 158  # the arm is
PARTS = ("line", "circle", "swept", "way", "before", "after")


@pytest.fixture
def document(open_document):
    """The kick at a flip of the right leg, which is selected."""
    document = open_document(FLIPPED)
    document.select_chain(LEG)
    document.go_to(FRAME)
    return document


def shown(view):
    """Which parts of the limb's circle are drawn."""
    circle = view.scene._circle
    return {name for name in PARTS if circle is not None and getattr(circle, name).shown}


def points(view, name):
    """Where a part is drawn, (n, 3)."""
    return getattr(view.scene._circle, name).points.astype(float)


def off_the_line(point, limb, positions):
    """Vectors from the limb's line to points (…, 3)."""
    first, end = positions[limb.parent], positions[limb.end]
    axis = (end - first) / np.linalg.norm(end - first)
    away = point - first
    return away - (away @ axis)[..., None] * axis


# --- what is drawn --------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize("frame", FLIPS)
def test_the_knee_is_on_the_circle_before_and_after(qtbot, document, show_view, frame):
    view, limb = show_view(document), document.find_chain(LEG)
    document.go_to(frame)
    settle(qtbot, view)
    before, after = (document.pose(frame, after=a)[1] for a in (False, True))
    near = 1e-4 * view.scene.height  # single precision
    assert shown(view) == set(PARTS)
    radius = np.linalg.norm(off_the_line(before[limb.child], limb, before))
    assert radius > 0.03 * view.scene.height
    wider = max(1.0, LEAST_RADIUS * view.scene.height / radius)
    radius *= wider
    knees = [
        positions[limb.child] + (wider - 1.0) * off_the_line(positions[limb.child], limb, before)
        for positions in (before, after)
    ]
    ring = points(view, "circle")
    away = np.linalg.norm(off_the_line(ring, limb, before), axis=1)
    np.testing.assert_allclose(away, radius, atol=near)
    axis = before[limb.end] - before[limb.parent]
    level = (ring - before[limb.child]) @ (axis / np.linalg.norm(axis))
    np.testing.assert_allclose(level, 0.0, atol=near)
    for name, knee in zip(("before", "after"), knees, strict=True):
        mark = points(view, name)
        centre = (mark.min(axis=0) + mark.max(axis=0)) / 2.0
        np.testing.assert_allclose(centre, knee, atol=near)
        away = np.linalg.norm(off_the_line(knee, limb, before))
        assert away == pytest.approx(radius, abs=near)
    np.testing.assert_allclose(points(view, "line")[0], before[limb.parent], atol=near)
    np.testing.assert_allclose(points(view, "line")[-1], before[limb.end], atol=near)
    # What is swept begins before, ends after, and is as wide as the offset.
    rim = points(view, "swept")[1:]
    np.testing.assert_allclose(rim[0], knees[0], atol=near)
    np.testing.assert_allclose(rim[-1], knees[1], atol=near)
    length = np.linalg.norm(np.diff(rim, axis=0), axis=1).sum()
    offset = abs(document.offset(LEG)[frame])
    assert length == pytest.approx(radius * offset, rel=1e-3)


@pytest.mark.thorough
def test_both_bones_are_seen_before_and_after_where_they_are(qtbot, document, show_view):
    view, limb = show_view(document), document.find_chain(LEG)
    scene, bones = view.scene, view.scene.bones
    own = limb_bones(limb, document.data.motion.skeleton)
    assert own == [(limb.parent, limb.child), (limb.child, limb.end)]
    mine = np.array([(b.parent, b.child) in own for b in bones])
    flips = document.review.state.of_chain(LEG)
    document.select_interval(
        next(j.id for j in flips if j.interval.start <= FRAME < j.interval.stop)
    )
    pose = view.drawing.pose(scene)
    assert (pose.roles[mine] == Role.AFTER).all()
    assert pose.ghost[1][mine].all()
    # The ghost's knee is where the knee was, not where it is now.
    shape, faces, _ = scene._ghost.parts[0]
    shin = next(k for k, b in enumerate(bones) if (b.parent, b.child) == own[1])
    ghost = faces.points[shape.bone == shin]
    before, after = (document.pose(FRAME, after=a)[1][limb.child] for a in (False, True))
    apart = np.linalg.norm(before - after)
    assert np.linalg.norm(ghost - before, axis=1).min() < 0.3 * apart
    assert np.linalg.norm(ghost - after, axis=1).min() > 0.5 * apart
    document.go_to(100)  # nothing to correct
    pose = view.drawing.pose(scene)
    assert (pose.roles[mine] == Role.CHOSEN).all()
    settle(qtbot, view)
    assert shown(view) == {"line", "circle"}


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_the_circle_is_seen(qtbot, document, show_view, theme):
    view = show_view(document, theme)
    view.focus_chain()
    whole = picture(qtbot, view)
    for name, least in (("circle", 60), ("line", 40), ("swept", 150), ("way", 60)):
        piece = getattr(view.scene._circle, name)
        piece.show(False)
        view.view.update()
        assert changed(whole, picture(qtbot, view), by=12).sum() > least, name
        piece.show(True)
    for name in ("before", "after"):
        piece = getattr(view.scene._circle, name)
        piece.show(False)
        view.view.update()
        assert changed(whole, picture(qtbot, view), by=12).sum() > 20, name
        piece.show(True)


def test_what_is_shown_follows_before_after_and_both(qtbot, document, show_view):
    view = show_view(document)
    marks = {Show.BEFORE: {"before"}, Show.AFTER: {"after"}, Show.BOTH: set(PARTS[2:])}
    for show, more in marks.items():
        document.set_show(show)
        settle(qtbot, view)
        assert shown(view) == {"line", "circle"} | more
    document.set_show(Show.AFTER)
    view.look(split=True)
    settle(qtbot, view)
    assert shown(view) == set(PARTS)
    assert view.scene._circle.line._renderers == view.scene.renderers()[:1]  # only before
    view.look(split=False)
    settle(qtbot, view)
    assert shown(view) == {"line", "circle", "after"}


@pytest.mark.thorough
def test_a_straight_limb_has_no_circle_and_the_legend_says_so(qtbot, document, show_view):
    view = show_view(document)
    document.select_chain(ARM)
    settle(qtbot, view)
    assert shown(view) == {"line", "circle"}
    assert "straight" not in view.overlays.legend.text()
    document.go_to(STRAIGHT)
    settle(qtbot, view)
    assert shown(view) == set()
    assert "straight" in view.overlays.legend.text()
    view.focus_chain()  # to the bone's roll, as of a chain
    assert view.camera is not None
    document.select_chain("RightArm")
    settle(qtbot, view)
    assert shown(view) == set()
    assert "straight" not in view.overlays.legend.text()


@pytest.mark.thorough
def test_a_folded_limb_has_no_circle(document):
    limb = document.find_chain(LEG)
    positions = document.pose(FRAME, after=False)[1].copy()
    assert find_limb_circle(limb, positions) is not None
    positions[limb.end] = positions[limb.parent]
    assert find_limb_circle(limb, positions) is None


@pytest.mark.thorough
def test_colours_by_offset_show_the_whole_limb(document, show_view):
    view, limb = show_view(document), document.find_chain(LEG)
    view.look(by_offset=True)
    offsets = view.drawing.pose(view.scene).offsets
    skeleton = document.data.motion.skeleton
    own = limb_bones(limb, skeleton)
    alone = {skeleton.index(i.joint) for i in document.corrected.repairs(FRAME)}
    for bone, offset in zip(view.scene.bones, offsets, strict=True):
        if bone.parent in alone:
            continue  # an error of this joint alone has its own offset
        wanted = abs(document.offset(LEG)[FRAME]) if (bone.parent, bone.child) in own else 0.0
        assert offset == pytest.approx(wanted)


# --- the camera and the mouse ---------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize("frame", FLIPS)
def test_the_camera_sees_the_circle_open_and_the_knee_at_its_side(document, show_view, frame):
    view, limb = show_view(document), document.find_chain(LEG)
    document.go_to(frame)
    view.focus_chain()
    circle = find_limb_circle(limb, document.pose(frame, after=False)[1])
    assert 0.15 < abs(view.camera.direction @ circle.axis) < 0.85
    knees = np.stack([document.pose(frame, after=a)[1][limb.child] for a in (False, True)])
    seen, _ = view.camera.project(knees, view.width(), view.height())
    assert ((seen > 0) & (seen < (view.width(), view.height()))).all()
    apart, _ = view.camera.project(
        circle.at(np.linspace(0.0, 2.0 * np.pi, 24)), view.width(), view.height()
    )
    assert np.linalg.norm(seen[0] - seen[1]) > 0.7 * np.ptp(apart, axis=0).max()


@pytest.mark.thorough
def test_a_selected_interval_is_brought_into_the_picture_and_else_the_camera_stays(
    qtbot, window, tmp_path
):
    open_clip(qtbot, window, shutil.copy(FLIPPED, tmp_path / "mine.bvh"))
    document, view = window.document, window.viewport
    act(window, "group_errors")  # off: each interval has a row of its own
    flips = [j.id for j in document.intervals if j.interval.kind == Kind.LIMB_FLIP]
    view.set_view("front")

    def pick(number):
        rows = window.intervals.shown_ids()
        window.intervals.table.selectRow(rows.index(number))
        qtbot.wait(20)
        qtbot.waitUntil(lambda: not view.turning)
        assert view.sees_chain()

    side = view.camera.azimuth, view.camera.elevation, view.camera.distance
    pick(flips[0])
    assert (view.camera.azimuth, view.camera.elevation, view.camera.distance) == side
    for move in (lambda c: c.panned(3000.0, 0.0, 500), lambda c: c.zoomed(0.01)):
        view.steer(move)
        assert not view.sees_chain()
        pick(flips[1])
        pick(flips[0])


def test_clicks_on_a_bone_select_its_chain_then_the_limb(qtbot, document, show_view):
    view = show_view(document)
    document.select_chain("LeftArm")
    document.go_to(100)
    view.set_view("front")
    settle(qtbot, view)
    for chain, joints in (("RightUpLeg", (7, 8)), ("RightLeg", (8, 9))):
        middle = document.pose(100, after=True)[1][list(joints)].mean(axis=0)
        pixel, _ = view.camera.project(middle, view.width(), view.height())
        at = QPointF(*pixel)
        assert view.pointing.joint_at(at) == joints[0]
        view.pointing.hover(at)
        assert QToolTip.text() == chain
        for expected in (chain, LEG, chain):
            view.pointing.click(at)
            assert document.chain == expected
        view.pointing.hover(at)
        assert QToolTip.text() == f"{chain}\nClick to select the whole limb: Right leg"
        document.select_chain("LeftArm")
    QToolTip.hideText()


# --- teaching -------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_the_teaching_tab_takes_chains_apart_and_leaves_a_limb_in_view(qtbot, window, tmp_path):
    open_clip(qtbot, window, shutil.copy(FLIPPED, tmp_path / "mine.bvh"))
    document, drawing = window.document, window.viewport.drawing
    document.select_chain("RightUpLeg")
    document.go_to(FRAME)
    act(window, "show_teaching")
    assert drawing.guest is window.teaching.gizmo
    assert window.taught.quantities is not None
    window.taught.alter(twist=1.0)
    document.select_chain(LEG)
    qtbot.wait(50)
    assert drawing.guest is None
    assert shown(window.viewport) == set(PARTS)
    assert window.taught.quantities is None
    assert not window.teaching.what_if.isEnabled()
    assert window.teaching.title.text().startswith("Right leg")
    document.go_to(STRAIGHT)
    act(window, "focus_chain")
    document.select_chain("RightUpLeg")
    qtbot.wait(50)
    assert drawing.guest is window.teaching.gizmo
    assert not window.taught.what_if.changes
    assert shown(window.viewport) == set()
