"""The 3D view in a real window: roll is visible, nothing else moves, nothing is left behind."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
import shiboken6
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QSurface, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from inspector.session.document import Document
from inspector.session.open_clip import Show
from inspector.viewport import opengl
from inspector.viewport.bodies import BAND, SKIN, build_soup, find_bones, pose_soup_vertices
from inspector.viewport.bone_colours import Role, bone_role_colours
from inspector.viewport.camera import VIEWS, OrbitCamera
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import DARK, LIGHT, Colours
from tests.gui.pictures import (
    FRAME,
    INJECTED,
    WALK,
    changed,
    insert_twist,
    limb_pixels,
    picture,
    settle,
    show_instead,
)
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import Decision
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.figure import figure_size, guess_up
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import quaternion_from_axis_angle, rotate
from twistcore.synthesis import InjectedError, inject

# --- what the picture tells -----------------------------------------------------------------------


def test_a_twist_of_90_degrees_changes_the_limb_and_moves_no_joint(
    qtbot, document, show_view, tmp_path
):
    """Fig. 1 of the paper: the same joint positions, another orientation of the forearm."""
    clip = document.data.clip
    error = InjectedError("LeftForeArm", FRAME, FRAME + 1, np.array([np.pi / 2]))
    twisted = inject(clip.motion, document.data.chains, [error])
    path = tmp_path / "twisted.bvh"
    write_clip(clip, twisted, path)

    clean, clean_positions = document.pose(FRAME, after=False)
    view = show_view(document)
    view.look(triads=False)
    view.focus_chain()
    before = picture(qtbot, view)
    joint = document.find_chain("LeftForeArm").parent
    limb = limb_pixels(qtbot, view, joint)

    show_instead(document, view, path)
    after = picture(qtbot, view)
    limb |= limb_pixels(qtbot, view, joint)

    rotations, positions = document.pose(FRAME, after=False)
    height = clip.motion.skeleton.height
    np.testing.assert_allclose(positions, clean_positions, atol=1e-6 * height)  # the file's digits
    exact = forward_kinematics(twisted.sliced(FRAME, FRAME + 1))[1][0]
    np.testing.assert_allclose(exact, clean_positions, atol=1e-9 * height)
    assert abs(rotations[joint] @ clean[joint]) == pytest.approx(np.cos(np.pi / 4), abs=1e-5)

    change = changed(before, after)
    assert limb.sum() > 1000
    assert (change & limb).sum() >= 0.05 * limb.sum()
    # Only the limb changes: the rest of the figure and the ground are drawn as before. (Its own
    # shadow may.)
    assert (change & ~limb).sum() <= 0.002 * limb.size


def test_what_nobody_decided_is_suggested_until_it_is_selected_or_accepted(
    qtbot, open_document, show_view
):
    document = open_document(INJECTED)
    view = show_view(document)
    judged = document.intervals[0]
    document.go_to(judged.interval.seen_at)
    bone = document.find_chain(judged.interval.chain).parent
    mine = np.array([b.parent == bone for b in view.scene.bones])

    def shown(show=Show.AFTER):
        (role,) = set(view.drawing.pose(view.scene, show).roles[mine].tolist())
        return Role(role), "suggested" in view.drawing.legend(view.scene, DARK)

    document.set_show(Show.AFTER)
    qtbot.waitUntil(lambda: shown() == (Role.SUGGESTED, True))
    assert shown(Show.BEFORE)[0] == Role.BEFORE
    document.select_interval(judged.id)  # a preview
    qtbot.waitUntil(lambda: shown() == (Role.AFTER, False))
    document.select_interval(None)
    document.decide(Decision.ACCEPTED, [judged.id])  # goes to the next one
    document.select_interval(None)
    document.go_to(judged.interval.seen_at)
    qtbot.waitUntil(lambda: shown() == (Role.AFTER, False))
    document.set_show(Show.BEFORE)
    document.undo()
    qtbot.waitUntil(lambda: not shown()[1])  # nothing is suggested in the picture of before


def test_the_suggested_form_is_paler_than_after_and_has_its_stripes():
    for theme in (DARK, LIGHT):
        colours = bone_role_colours(theme)
        form = colours[Role.SUGGESTED]
        np.testing.assert_array_equal(form[BAND], colours[Role.AFTER, BAND])
        plain, after = colours[Role.PLAIN, SKIN], colours[Role.AFTER, SKIN]
        assert 0.0 < np.linalg.norm(form[SKIN] - plain) < np.linalg.norm(after - plain)


def test_before_and_after_differ_in_colour_and_form(qtbot, document, show_view):
    insert_twist(document)
    view = show_view(document)
    joint = document.find_chain("LeftForeArm").parent
    mine = np.array([b.parent == joint for b in view.scene.bones])
    shapes = {}
    for show in Show:
        document.set_show(show)
        pose = view.drawing.pose(view.scene)
        assert (pose.roles[~mine] <= Role.CHOSEN).all()
        shapes[show] = pose
    assert (shapes[Show.BEFORE].roles[mine] == Role.BEFORE).all()
    assert (shapes[Show.AFTER].roles[mine] == Role.AFTER).all()
    assert shapes[Show.BEFORE].ghost is None
    assert shapes[Show.AFTER].ghost is None
    _, drawn = shapes[Show.BOTH].ghost
    np.testing.assert_array_equal(drawn, mine)

    view.focus_chain()
    pictures = {}
    for show in Show:
        document.set_show(show)
        pictures[show] = picture(qtbot, view)
    for one, other in ((Show.BEFORE, Show.AFTER), (Show.AFTER, Show.BOTH)):
        assert changed(pictures[one], pictures[other]).sum() > 500


def test_a_clean_frame_is_neutral(document, show_view):
    view = show_view(document)
    pose = view.drawing.pose(view.scene)
    assert not pose.ghost[1].any()
    chain = document.find_chain("LeftForeArm")
    for bone, role in zip(view.scene.bones, pose.roles, strict=True):
        mine = (bone.parent, bone.child) == (chain.parent, chain.child)
        assert (role == Role.CHOSEN) == mine


def show_bodies(view, on):
    """Everything but the ground."""
    scene = view.scene
    figures = [f for f in (scene._solid, scene._ghost, scene._other) if f is not None]
    for piece in (*(p for f in figures for p in f.pieces), scene._triads):
        piece.show(on)
    view.view.update()


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_every_view_shows_the_figure(qtbot, document, show_view, theme):
    view = show_view(document, theme)
    for name in VIEWS:
        view.set_view(name)
        shown = picture(qtbot, view)
        show_bodies(view, False)
        empty = picture(qtbot, view)
        show_bodies(view, True)
        figure = changed(shown, empty, by=8)
        assert 0.005 < figure.mean() < 0.5, name
        rows, columns = np.nonzero(figure)
        legend = view.overlays.legend.geometry().bottom() * shown.shape[0] / view.height()
        assert rows.min() > legend, name  # framed: nothing is cut off, or under the legend
        assert rows.max() < shown.shape[0] - 1, name
        assert columns.min() > 0, name
        assert columns.max() < shown.shape[1] - 1, name


def test_the_theme_changes_while_open(qtbot, document, show_view):
    view = show_view(document, DARK)
    dark = picture(qtbot, view)
    view.colours.use(LIGHT)
    light = picture(qtbot, view)
    assert light.mean() > dark.mean() + 100


def test_the_legend_tells_the_offset(qtbot, document, show_view):
    view = show_view(document)

    def legend():
        return view.overlays.legend.text().replace("&nbsp;", " ")

    assert "off by 0.0°" in legend()
    insert_twist(document, degrees=-87.3)
    settle(qtbot, view)
    assert "Left ForeArm" in legend()
    assert "off by −87.3°" in legend()


@pytest.mark.thorough
@pytest.mark.parametrize("width", [160, 300, 421, 640, 1000])
def test_no_divider_runs_through_the_legend(qtbot, document, show_view, width):
    view = show_view(document)
    insert_twist(document, degrees=152.5)
    view.look(split=True)
    view.resize(width, 300)
    settle(qtbot, view)
    legend, divider = view.overlays.legend, view.overlays.divider
    assert not legend.geometry().intersects(divider.geometry())
    assert legend.height() >= legend.heightForWidth(legend.width())
    assert legend.geometry().right() < view.width() or width < 200


# --- the window around it -------------------------------------------------------------------------


def test_without_a_clip_it_says_what_to_do(qtbot, show_view, analysed):
    document = Document()
    view = show_view(document)
    assert view.overlays.notice.text()
    assert view.overlays.notice.isVisible()
    assert not view.overlays.legend.isVisible()
    view.set_view("front")
    view.focus_chain()
    document.show_clip(analysed)
    assert not view.overlays.notice.isVisible()
    assert view.overlays.legend.isVisible()


def test_without_opengl_it_says_so(qtbot, document, show_view, monkeypatch):
    monkeypatch.setattr(opengl, "renderer_name", lambda: "")
    view = show_view(document)
    assert view.overlays.notice.text() == opengl.missing_3d_view_message()
    assert view.overlays.notice.isVisible()
    view.set_view("front")
    view.focus_chain()
    view.colours.use(LIGHT)
    document.go_to(FRAME + 1)
    view.look(style=Style.SKIN, split=True, trails=True, by_offset=True)
    view.refresh()
    assert not view.overlays.legend.isVisible()
    assert view.pointing.joint_at(QPoint(10, 10)) is None


def test_many_changes_are_one_drawing(qtbot, document, show_view, monkeypatch):
    view = show_view(document)
    drawn = []
    monkeypatch.setattr(view.scene, "draw", drawn.append)
    for frame in range(FRAME + 1, FRAME + 30):
        document.go_to(frame)
    document.select_chain("RightLeg")
    settle(qtbot, view)
    assert len(drawn) == 1
    expected = document.data.rotations[FRAME + 29]
    np.testing.assert_array_equal(drawn[0].rotations, expected)


def test_the_camera_goes_along_with_the_figure(qtbot, document, show_view):
    view = show_view(document)
    for follow in (True, False):
        view.set_follow(follow)
        start, root = view.camera.position, document.data.positions[document.frame, 0]
        document.go_to(document.frame + 60)
        settle(qtbot, view)
        step = document.data.positions[document.frame, 0] - root
        step -= (step @ view.scene.up) * view.scene.up
        expected = step if follow else np.zeros(3)
        np.testing.assert_allclose(view.camera.position - start, expected, atol=1e-9)


def test_the_mouse_orbits_pans_zooms_and_keeps_up_up(qtbot, document, show_view):
    view = show_view(document)
    first = view.camera
    drag(view.view, (300, 200), (360, 230))
    orbited = view.camera
    assert orbited.azimuth < first.azimuth
    assert orbited.elevation > first.elevation
    np.testing.assert_array_equal(orbited.target, first.target)
    drag(view.view, (300, 200), (300, 4000))
    assert view.camera.elevation < np.pi / 2
    assert view.camera.axes[1] @ view.scene.up > 0.0
    before = view.camera
    drag(view.view, (300, 200), (330, 200), Qt.KeyboardModifier.ShiftModifier)
    moved = before.target - view.camera.target
    assert moved @ before.axes[0] > 0.0
    assert view.camera.azimuth == before.azimuth
    before = view.camera
    drag(view.view, (300, 200), (330, 200), button=Qt.MouseButton.MiddleButton)
    assert (before.target - view.camera.target) @ before.axes[0] > 0.0
    before = view.camera.distance
    wheel(view.view, 120)
    assert view.camera.distance < before
    # A person's own view is not thrown away when the window changes its size.
    mine = view.camera
    view.resize(500, 500)
    qtbot.wait(20)
    assert view.camera is mine


def test_a_click_on_a_bone_selects_its_chain(qtbot, document, show_view):
    view = show_view(document)
    view.set_view("front")
    for chain in document.data.chains:
        if chain.segment not in ("Arm", "ForeArm", "UpLeg", "Leg"):
            continue
        _, positions = document.pose(document.frame, after=True)
        ends = positions[[chain.parent, chain.child]]
        pixel, _ = view.camera.project(ends.mean(axis=0), view.width(), view.height())
        joint = view.pointing.joint_at(QPoint(*np.round(pixel).astype(int).tolist()))
        assert joint == chain.parent, chain.name
        qtbot.mouseClick(
            view.view,
            Qt.MouseButton.LeftButton,
            pos=QPoint(*np.round(pixel).astype(int).tolist()),
        )
        assert document.chain == chain.name
    selected = document.chain
    qtbot.mouseClick(view.view, Qt.MouseButton.LeftButton, pos=QPoint(5, 300))
    assert document.chain == selected


def test_focus_brings_the_limb_close_and_shows_its_roll(document, show_view):
    view = show_view(document)
    insert_twist(document)
    far = view.camera.distance
    for chain in document.data.chains:
        document.select_chain(chain.name)
        view.focus_chain()
        rotations, positions = document.pose(document.frame, after=True)
        bone = positions[[chain.parent, chain.child]]
        pixels, _ = view.camera.project(bone, view.width(), view.height())
        assert (pixels > 0).all(), chain.name
        assert (pixels < [view.width(), view.height()]).all(), chain.name
        assert view.camera.distance < far
        bone = next(b for b in view.scene.bones if b.parent == chain.parent)
        face = rotate(rotations[chain.parent], bone.normal)
        assert abs(face @ view.camera.direction) > 0.5, chain.name


def test_keys_go_past_the_view(qtbot, document, show_view):
    view = show_view(document)
    for key in (Qt.Key.Key_Q, Qt.Key.Key_E, Qt.Key.Key_W, Qt.Key.Key_3):
        qtbot.keyClick(view.view, key)  # VTK would quit, leave, draw wires, go stereo
    assert view.isVisible()
    picture(qtbot, view)


@pytest.mark.thorough
def test_nothing_is_left_after_closing(qtbot, analysed):
    def render_windows():
        gc.collect()
        return sum(type(o).__name__ == "vtkGenericOpenGLRenderWindow" for o in gc.get_objects())

    start, views, counts = render_windows(), [], []
    for _ in range(10):
        document = Document()
        view = Viewport(document, Colours(DARK))
        view.resize(320, 240)
        view.show()
        assert QTest.qWaitForWindowExposed(view, 60_000)
        document.show_clip(analysed)
        settle(qtbot, view)
        views += [weakref.ref(view), weakref.ref(view.view.ren_win), weakref.ref(view.scene)]
        view.close()
        view.close()  # as a window does that closes its children first
        view.deleteLater()
        document.deleteLater()
        del view, document
        qtbot.wait(10)
        counts.append(render_windows())
    assert [ref() for ref in views if ref() is not None] == []
    assert counts == [start] * 10


def test_a_closed_view_does_not_wait_for_the_collector(qtbot, analysed):
    """It would come while another view is drawing, and let OpenGL's memory go in its place."""
    document = Document()
    view = Viewport(document, Colours(DARK))
    view.show()
    assert QTest.qWaitForWindowExposed(view, 60_000)
    document.show_clip(analysed)
    settle(qtbot, view)
    gc.collect()
    assert any(type(w) is QSurface for w in shiboken6.getAllValidWrappers())
    left = weakref.ref(view), weakref.ref(view.scene)
    assert not gc.isenabled()
    view.close()
    view.deleteLater()
    del view
    qtbot.wait(10)
    assert [ref() for ref in left] == [None, None]
    known = shiboken6.getAllValidWrappers()
    assert [w for w in known if type(w) is QSurface] == []  # its address is used again
    document.deleteLater()


def test_another_clip_takes_the_place_of_the_first(qtbot, document, show_view, analysed):
    view = show_view(document)
    for _ in range(5):
        document.show_clip(analysed)
        settle(qtbot, view)
    assert view.view.renderer.GetActors().GetNumberOfItems() == 6


# --- the arithmetic -------------------------------------------------------------------------------


def test_bodies_follow_their_joint_rigidly():
    motion = read_bvh(WALK).motion
    rotations, positions = forward_kinematics(motion.sliced(FRAME, FRAME + 1))
    rotations, positions = rotations[0], positions[0]
    bones = find_bones(motion, np.array([0.0, 1.0, 0.0]), motion.skeleton.height)
    soup = build_soup(bones)
    expected = rotate(rotations[soup.joint], soup.vertices) + positions[soup.joint]
    np.testing.assert_allclose(pose_soup_vertices(soup, rotations, positions), expected, atol=1e-9)
    for bone in bones:
        if bone.child >= 0:
            tip = positions[bone.parent] + rotate(rotations[bone.parent], bone.tip)
            np.testing.assert_allclose(tip, positions[bone.child], atol=1e-6)
        assert bone.normal @ bone.tip == pytest.approx(0.0, abs=1e-9)
    # Hands, feet and End Sites have bodies; helper joints without a length have none.
    assert {b.parent for b in bones if b.child < 0} >= {j for j, _ in motion.skeleton.ends[:1]}
    assert all(np.linalg.norm(b.tip) > 0 for b in bones)


def test_faces_look_outwards():
    motion = read_bvh(WALK).motion
    bones = find_bones(motion, np.array([0.0, 1.0, 0.0]), motion.skeleton.height)
    soup = build_soup(bones)
    for face in soup.faces:
        corners, number = soup.vertices[face], soup.bone[face[0]]
        mine = soup.vertices[(soup.bone == number) & (soup.joint == soup.joint[face[0]])]
        if number >= 0 and soup.part[face[0]] in (0, 1):  # the broad faces
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            assert normal @ (corners.mean(axis=0) - mine.mean(axis=0)) > 0.0


def test_up_is_found_from_the_motion():
    clip = read_bvh(WALK)
    chains = find_chains(clip.motion)
    _, positions = forward_kinematics(clip.motion)
    skeleton = clip.motion.skeleton
    np.testing.assert_array_equal(guess_up(positions, chains, skeleton), [0, 1, 0])
    turn = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(np.pi / 2))
    np.testing.assert_array_equal(guess_up(rotate(turn, positions), chains, skeleton), [0, 0, 1])
    assert 0.0 < figure_size(positions, skeleton) <= skeleton.height


def test_the_camera_projects_as_a_pinhole():
    ahead, up = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    camera = OrbitCamera(np.array([1.0, 2.0, 3.0]), 0.4, 0.3, 10.0, up, ahead)
    pixel, depth = camera.project(camera.target, 800, 600)
    np.testing.assert_allclose(pixel, [400, 300], atol=1e-9)
    assert depth == pytest.approx(10.0)
    right, above = camera.axes[0], camera.axes[1]
    assert camera.project(camera.target + right, 800, 600)[0][0] > 400
    assert camera.project(camera.target + above, 800, 600)[0][1] < 300
    panned = camera.panned(50.0, -20.0, 600)
    np.testing.assert_allclose(panned.project(camera.target, 800, 600)[0], [450, 320], atol=1e-6)
    turned = camera.looking_from(camera.direction)
    np.testing.assert_allclose(turned.position, camera.position, atol=1e-9)
    cloud = np.random.default_rng(3).normal(size=(50, 3))
    framed = replace(camera, azimuth=2.0).framing(cloud, 800 / 600)
    pixels, _ = framed.project(cloud, 800, 600)
    assert (pixels > 0).all()
    assert (pixels < [800, 600]).all()


# --- mouse ----------------------------------------------------------------------------------------


def drag(
    widget,
    start,
    stop,
    modifiers=Qt.KeyboardModifier.NoModifier,
    button=Qt.MouseButton.LeftButton,
):
    kinds = (
        (QEvent.Type.MouseButtonPress, start, button, button),
        (QEvent.Type.MouseMove, stop, Qt.MouseButton.NoButton, button),
        (QEvent.Type.MouseButtonRelease, stop, button, Qt.MouseButton.NoButton),
    )
    for kind, at, which, held in kinds:
        place_ = QPointF(*at)
        event = QMouseEvent(kind, place_, widget.mapToGlobal(place_), which, held, modifiers)
        QApplication.sendEvent(widget, event)


def wheel(widget, delta):
    middle = widget.rect().center().toPointF()
    event = QWheelEvent(
        middle,
        widget.mapToGlobal(middle),
        QPoint(),
        QPoint(0, delta),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(widget, event)
