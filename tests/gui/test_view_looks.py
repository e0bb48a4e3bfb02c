"""Skin, side by side, trails, colours by offset, the camera's way: seen in a real window."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QToolTip

from benchmarks.many_clips import alive, is_level, look, measure
from inspector.__main__ import main
from inspector.session.open_clip import Show
from inspector.viewport import opengl
from inspector.viewport.bodies import find_bones
from inspector.viewport.bone_colours import Role, rgb
from inspector.viewport.camera import OrbitCamera, interpolate_cameras
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.striped_skin import bone_twist_angles, build_skin, pose_skin
from inspector.viewport.trails import end_effectors
from inspector.widgets.theme import DARK, LIGHT
from inspector.window.action_table import MENUS
from inspector.window.actions import rows
from tests.gui.pictures import (
    FRAME,
    INJECTED,
    WALK,
    changed,
    insert_twist,
    picture,
    settle,
    show_instead,
)
from tests.gui.windows import act, open_clip, press
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import Decide, Decision
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import forward_kinematics
from twistcore.synthesis import InjectedError, inject

UP = np.array([0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def dressed():
    """The walk's skin, its motion and its pose at a frame."""
    motion = read_bvh(WALK).motion
    chains = find_chains(motion)
    height = motion.skeleton.height
    skin = build_skin(find_bones(motion, UP, height), chains, height)
    rotations, positions = forward_kinematics(motion.sliced(FRAME, FRAME + 1))
    return motion, chains, skin, rotations[0], positions[0]


def tubes(skin, vertices):
    """The vertices (bones, rings, M, 3) of the tubes, and (bones, F, 3) of the fins."""
    size = skin.radius.size * len(skin.circle)
    shape = (len(skin.parent), skin.radius.shape[1], -1, 3)
    return vertices[:size].reshape(shape), vertices[size:].reshape(len(skin.parent), -1, 3)


def skin_pixels(qtbot, view):
    """Pixels that the limbs' skin takes up."""
    whole = picture(qtbot, view)
    tubes = view.scene._solid.pieces[-2]
    tubes.show(False)
    view.view.update()
    without = picture(qtbot, view)
    tubes.show(True)
    return changed(whole, without, by=8)


def share_of(image, colour):
    """How many pixels have about the hue of a colour: parallel beside its grey part."""
    pixels = image - image.mean(axis=2, keepdims=True)
    wanted = rgb(colour) - rgb(colour).mean()
    along = pixels @ (wanted / np.linalg.norm(wanted))
    away = np.linalg.norm(pixels, axis=2)
    return int(((along > 0.9 * away) & (away > 30)).sum())


# --- the skin -------------------------------------------------------------------------------------


def test_a_twist_of_90_degrees_wrings_the_skin(qtbot, document, show_view, tmp_path):
    clip = document.data.clip
    error = InjectedError("LeftForeArm", FRAME, FRAME + 1, np.array([np.pi / 2]))
    path = tmp_path / "twisted.bvh"
    write_clip(clip, inject(clip.motion, document.data.chains, [error]), path)
    view = show_view(document)
    view.look(style=Style.SKIN)
    view.look(triads=False)
    view.focus_chain()
    before = picture(qtbot, view)
    limb = skin_pixels(qtbot, view)

    show_instead(document, view, path)
    after = picture(qtbot, view)
    change = changed(before, after)
    assert limb.sum() > 3000
    limb |= skin_pixels(qtbot, view)  # the fin now stands off elsewhere
    assert (change & limb).sum() >= 0.05 * limb.sum()
    assert (change & ~limb).sum() <= 0.002 * limb.size


def test_a_twist_runs_evenly_along_the_bone_and_back_on_the_next(dressed):
    motion, chains, skin, rotations, positions = dressed
    delta = np.pi / 2
    error = InjectedError("LeftForeArm", 0, 1, np.array([delta]))
    twisted = inject(motion.sliced(FRAME, FRAME + 1), chains, [error])
    wrong, places = (x[0] for x in forward_kinematics(twisted))
    np.testing.assert_allclose(places, positions, atol=1e-9 * motion.skeleton.height)
    change = np.angle(
        np.exp(1j * (bone_twist_angles(skin, wrong) - bone_twist_angles(skin, rotations)))
    )
    chain = next(c for c in chains if c.name == "LeftForeArm")
    expected = delta * ((skin.child == chain.parent) * 1.0 - (skin.parent == chain.parent))
    # The limb bends at the elbow: of the turn about the forearm the upper arm sees a part.
    own = skin.parent == chain.parent
    np.testing.assert_allclose(change[own], expected[own], atol=1e-9)
    above = skin.child == chain.parent
    assert change[above] == pytest.approx(delta, abs=np.radians(15))
    np.testing.assert_allclose(change[~own & ~above], 0.0, atol=1e-9)
    # The middle ring of the forearm has turned by half of it.
    first, fins = tubes(skin, pose_skin(skin, rotations, positions)[1])
    second, turned = tubes(skin, pose_skin(skin, wrong, positions)[1])
    middle = int(np.flatnonzero(own)[0]), 5
    angle = np.arccos(np.clip((first[middle] * second[middle]).sum(axis=-1), -1, 1))
    np.testing.assert_allclose(angle, delta * (1.0 - 0.42), atol=1e-6)
    # The fin of the forearm, and no other, has turned by all of it.
    edge = 6  # a vertex whose normal points out of the front
    angles = np.arccos(np.clip((fins * turned).sum(axis=-1), -1, 1))[:, edge]
    np.testing.assert_allclose(angles, np.abs(delta) * own, atol=1e-6)


def test_the_skin_is_whole_and_has_unit_normals(dressed):
    motion, _, skin, rotations, positions = dressed
    points, normals = pose_skin(skin, rotations, positions)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=0.3)
    rings, fins = tubes(skin, points)
    height = motion.skeleton.height
    starts, stops = positions[skin.parent][:, None], positions[skin.child][:, None]
    along = (stops - starts) / np.linalg.norm(stops - starts, axis=2, keepdims=True)
    out = np.linalg.norm(np.cross(fins - starts, along), axis=2)
    assert (out.max(axis=1) > 1.2 * skin.radius[:, 5]).all()  # every fin stands off its tube
    assert out.max() < 0.07 * height
    for bone, next_bone in enumerate(skin.below):
        if next_bone != bone:  # where one tube ends the next begins
            gap = np.linalg.norm(rings[bone, -1] - rings[next_bone, 0], axis=1).max()
            assert gap < 0.012 * motion.skeleton.height
    # Every vertex lies as far from the bone's line as its ring is wide, away from joints.
    assert np.isfinite(points).all()
    assert len(skin.covered) == 10
    assert skin.faces.reshape(-1, 5)[:, 1:].max() == len(points) - 1


def test_a_clip_without_limbs_has_no_skin(dressed):
    motion, _, _, rotations, positions = dressed
    skin = build_skin(find_bones(motion, UP, 1.0), (), 1.0)
    points, normals = pose_skin(skin, rotations, positions)
    assert points.shape == normals.shape == (0, 3)


@pytest.mark.thorough
@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_the_skin_is_orange_before_blue_after_and_neutral_when_clean(
    qtbot, document, show_view, theme
):
    view = show_view(document, theme)
    view.look(style=Style.SKIN)
    view.look(triads=False)
    document.select_chain("LeftForeArm")
    view.focus_chain()
    clean = picture(qtbot, view)
    insert_twist(document)
    shares = {}
    for show in Show:
        document.set_show(show)
        shown = picture(qtbot, view)
        shares[show] = share_of(shown, theme.before), share_of(shown, theme.after)
    assert share_of(clean, theme.before) < 50
    assert shares[Show.BEFORE][0] > 1500 > 100 > shares[Show.BEFORE][1]
    assert shares[Show.AFTER][1] > 1500 > 100 > shares[Show.AFTER][0]
    assert min(shares[Show.BOTH]) > 300
    roles = view.drawing.pose(view.scene, Show.AFTER).roles
    # The upper arm is wrung as well, but only the wrong bone is coloured.
    coloured = {view.scene.bones[k].parent for k in np.flatnonzero(roles != Role.PLAIN)}
    assert coloured == {document.find_chain("LeftForeArm").parent}


# --- side by side ---------------------------------------------------------------------------------


def test_side_by_side_shows_before_left_after_right_with_one_camera(qtbot, document, show_view):
    insert_twist(document)
    view = show_view(document, size=(800, 400))
    view.look(triads=False)
    view.look(split=True)
    view.focus_chain()
    settle(qtbot, view)
    for piece in view.scene._circle.pieces:  # has both colours
        piece.show(False)
    shown = picture(qtbot, view)
    left, right = shown[:, :396], shown[:, 404:]
    assert share_of(left, DARK.before) > 500 > 50 > share_of(left, DARK.after)
    assert share_of(right, DARK.after) > 500 > 50 > share_of(right, DARK.before)
    assert view.scene._left.GetActiveCamera() is view.scene._right.GetActiveCamera()
    # Without an error both halves are the same picture, from wherever it is seen.
    document.do(Decide(tuple(j.id for j in document.intervals), Decision.REJECTED))
    view.steer(lambda camera: camera.orbited(0.7, 0.2))
    shown = picture(qtbot, view)
    assert changed(shown[:, 2:398], shown[:, 402:798]).mean() < 0.002
    # A click means the same bone in both.
    view.set_view("front")
    settle(qtbot, view)
    chain = document.find_chain("RightLeg")
    _, positions = document.pose(document.frame, after=True)
    ends = positions[[chain.parent, chain.child]]
    pixel, _ = view.camera.project(ends.mean(axis=0), 400, 400)
    for side in (0, 400):
        at = QPoint(round(pixel[0]) + side, round(pixel[1]))
        assert view.pointing.joint_at(at) == chain.parent
    assert "◧" in view.overlays.legend.text()
    over = view.children()  # a later one lies above: the line must not make a minus of a plus
    assert over.index(view.overlays.legend) > over.index(view.overlays.divider)
    view.look(split=False)
    settle(qtbot, view)
    assert view.view.ren_win.GetRenderers().GetNumberOfItems() <= 2  # VTK's own and pyvista's
    assert "◧" not in view.overlays.legend.text()


# --- trails ---------------------------------------------------------------------------------------


def test_trails_tell_that_hands_and_feet_stay(qtbot, document, show_view):
    joints = end_effectors(document.data.motion, document.data.chains)
    names = {document.data.motion.skeleton.names[j] for j in joints}
    assert names == {"LeftHand", "RightHand", "LeftFoot", "RightFoot"}
    insert_twist(document, degrees=120.0)
    before = document.data.positions[FRAME - 20 : FRAME + 20, joints]
    after = document.corrected.joint_paths(joints, FRAME - 20, FRAME + 20)
    height = document.data.motion.skeleton.height
    np.testing.assert_allclose(after, before, atol=1e-9 * height)
    rotations = document.pose(FRAME, after=True)[0]
    assert not np.allclose(rotations, document.data.rotations[FRAME], atol=0.1)

    view = show_view(document)
    without = picture(qtbot, view)
    view.look(trails=True)
    shown = picture(qtbot, view)
    assert share_of(shown, DARK.before) > share_of(without, DARK.before) + 300
    assert share_of(shown, DARK.after) > share_of(without, DARK.after) + 100
    assert "&lt; 0.001 %" in view.overlays.legend.text()
    view.look(trails=False)
    assert not changed(picture(qtbot, view), without).any()


def test_trails_at_the_ends_of_the_clip(document, show_view):
    view = show_view(document)
    view.look(trails=True)
    for frame in (0, document.frames - 1, 3, 200):
        document.go_to(frame)
        view.refresh()
        trails = view.scene.trails
        ends = trails.before.points.reshape(4, -1, 3)[:, trails._length]
        joints = end_effectors(document.data.motion, document.data.chains)
        np.testing.assert_allclose(ends, document.data.positions[frame, joints], rtol=1e-5)


# --- colour by offset -----------------------------------------------------------------------------


def test_a_larger_offset_has_another_colour(qtbot, document, show_view):
    view = show_view(document)
    view.look(triads=False)
    view.focus_chain()
    document.set_show(Show.AFTER)
    assert not view.overlays.scale.isVisible()
    view.look(by_offset=True)
    pictures = [picture(qtbot, view)]
    for degrees in (60.0, 120.0):
        insert_twist(document, degrees=degrees)  # they add up: 60°, 180°
        pictures.append(picture(qtbot, view))
    assert view.overlays.scale.isVisible()
    number = next(
        k for k, b in enumerate(view.scene.bones)
        if b.parent == document.find_chain("LeftForeArm").parent
    )  # fmt: skip
    assert view.drawing.pose(view.scene).offsets[number] == pytest.approx(np.pi)
    for one, other in ((0, 1), (1, 2), (0, 2)):
        assert changed(pictures[one], pictures[other]).sum() > 500
    view.look(by_offset=False)
    settle(qtbot, view)
    assert not view.overlays.scale.isVisible()


# --- camera, names, driver ------------------------------------------------------------------------


def test_the_camera_turns_without_blocking_and_the_latest_wins(qtbot, document, show_view):
    view = show_view(document)
    document.select_chain("RightLeg")
    view.focus_chain()
    goal = view.camera
    view.set_view("iso")
    start = view.camera
    document.select_chain("LeftArm")
    view.focus_chain(150)
    np.testing.assert_allclose(view.camera.position, start.position)  # it has only set off
    qtbot.wait(40)
    document.select_chain("RightLeg")
    view.focus_chain(150)
    qtbot.waitUntil(lambda: view._turn is None, timeout=3000)
    np.testing.assert_allclose(view.camera.position, goal.position, atol=1e-6)
    # Who takes the mouse has the camera.
    view.set_view("iso")
    view.focus_chain(150)
    view.steer(lambda camera: camera.orbited(0.1, 0.0))
    mine = view.camera
    qtbot.wait(200)
    assert view.camera is mine


def test_the_way_of_the_camera_is_the_shorter_one():
    one = OrbitCamera(np.zeros(3), 3.0, 0.1, 4.0, UP, np.array([0.0, 0.0, 1.0]))
    other = replace(one, azimuth=-3.0, distance=1.0, target=np.ones(3))
    middle = interpolate_cameras(one, other, 0.5)
    assert np.cos(middle.azimuth) == pytest.approx(-1.0)
    assert middle.distance == pytest.approx(2.0)
    for share, camera in ((0.0, one), (1.0, other)):
        np.testing.assert_allclose(
            interpolate_cameras(one, other, share).position, camera.position, atol=1e-9
        )


def test_names_appear_under_the_mouse(qtbot, document, show_view):
    view = show_view(document)
    view.set_view("front")
    chain = document.find_chain("LeftLeg")
    _, positions = document.pose(document.frame, after=True)
    middle = positions[[chain.parent, chain.child]].mean(axis=0)
    pixel, _ = view.camera.project(middle, view.width(), view.height())
    at = QPoint(round(pixel[0]), round(pixel[1]))
    view.pointing.names = False
    qtbot.mouseMove(view.view, at)
    qtbot.wait(30)
    assert not QToolTip.isVisible()
    view.pointing.names = True
    qtbot.mouseMove(view.view, at + QPoint(0, 1))
    qtbot.waitUntil(QToolTip.isVisible)
    assert QToolTip.text() == "LeftLeg"
    QToolTip.hideText()


@pytest.mark.parametrize(
    ("name", "samples"),
    [("llvmpipe (LLVM 15)", 0), ("Mesa Intel(R) UHD", 4), ("NVIDIA GeForce RTX 4070/PCIe", 8)],
)
def test_samples_follow_the_driver(monkeypatch, name, samples):
    monkeypatch.setattr(opengl, "renderer_name", lambda: name)
    assert opengl.multisamples() == samples


def test_wayland_without_x_is_explained(monkeypatch):
    monkeypatch.setattr(QGuiApplication, "platformName", staticmethod(lambda: "wayland"))
    opengl.renderer_name.cache_clear()
    try:
        assert opengl.renderer_name() == ""
        assert "Xwayland" in opengl.missing_3d_view_message()
    finally:
        opengl.renderer_name.cache_clear()


def test_keys_and_the_next_interval_drive_the_view(qtbot, opened):
    window, view = opened, opened.viewport
    settle(qtbot, view)
    assert (view.scene.style, view.scene.split) == (Style.SKIN, True)  # of a new person
    act(window, "skin")
    act(window, "side_by_side")
    assert (window.settings.skin, window.settings.side_by_side) == (False, False)
    far = view.camera.distance
    qtbot.keyClick(window, Qt.Key.Key_N)
    assert view.camera.distance < far
    first = view.camera
    for _ in range(3):  # on to the thigh
        press(qtbot, window, Qt.Key.Key_A)
    assert window.document.interval.interval.chain == "RightUpLeg"
    assert np.linalg.norm(view.camera.target - first.target) > 0.1 * view.scene.height
    for key in (Qt.Key.Key_S, Qt.Key.Key_V, Qt.Key.Key_T):
        qtbot.keyClick(window, key)
    act(window, "colour_by_offset")
    qtbot.keyClick(window, Qt.Key.Key_H)
    settle(qtbot, view)
    assert view.scene.style == Style.SKIN
    assert view.scene.split
    assert view.scene.trails is not None
    assert view.overlays.scale.isVisible()
    assert not view.pointing.names
    for key in (Qt.Key.Key_S, Qt.Key.Key_V, Qt.Key.Key_T):
        qtbot.keyClick(window, key)
    settle(qtbot, view)
    assert view.scene.style == Style.WEDGES
    assert not view.scene.split
    assert view.scene.trails is None


# --- clip after clip ------------------------------------------------------------------------------


@pytest.mark.thorough
def test_clip_after_clip_stays_level(qapp):
    assert is_level(measure(12))


def test_looks_are_kept_for_the_next_clip(document, show_view, tmp_path):
    view = show_view(document)
    view.look(split=True)
    view.look(style=Style.SKIN)
    view.look(trails=True)
    view.refresh()
    count = alive()
    document.show_clip(document.data)
    view.refresh()
    assert view.scene.split
    assert view.scene.style == Style.SKIN
    assert view.scene.trails is not None
    assert alive() <= count
    look(document, view, document.data.clip.path)
    assert not view.scene.split


def test_without_a_screen_the_program_says_so(monkeypatch, capsys):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    assert main([]) == 2
    assert "no screen" in capsys.readouterr().err


@pytest.mark.thorough
def test_a_review_without_opengl(qtbot, show_window, monkeypatch):
    """Plots, tables and verdicts work; what means the figure is greyed out, and why is told."""
    monkeypatch.setattr(opengl, "renderer_name", lambda: "")
    window = show_window()
    open_clip(qtbot, window, INJECTED)
    assert window.viewport.overlays.notice.isVisible()
    for name in (row.id for row in rows(MENUS) if row.needs == "figure"):
        assert not window.actions_by_id[name].isEnabled(), name
    act(window, "next_interval")
    act(window, "accept")
    act(window, "both_detectors")
    act(window, "presentation")
    act(window, "presentation")
    assert sum(j.decision == Decision.ACCEPTED for j in window.document.intervals) == 1
