"""What the picture shows without words: the front, the side, the bone, and how far it is turned."""

import shutil

import numpy as np
import pytest

from inspector.bundled import FLIPPED
from inspector.session.settings import Settings, load_settings
from inspector.viewport.bone_colours import Role
from inspector.viewport.head_and_chest import heads_and_chests
from inspector.viewport.solid_and_ghost import Style
from tests.gui.pictures import FRAME, INJECTED, WALK, insert_twist, settle
from tests.gui.windows import act, open_clip
from twistcore import read_clip
from twistcore.detection import Kind
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.figure import figure_size, guess_up, heading
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import rotate


def test_head_and_chest_look_ahead():
    motion = read_clip(WALK).motion
    rotations, positions = forward_kinematics(motion)
    chains, skeleton = find_chains(motion), motion.skeleton
    height, up = figure_size(positions, skeleton), guess_up(positions, chains, skeleton)
    chest, head = heads_and_chests(chains, skeleton, rotations, positions, height)
    assert [skeleton.names[front.bone.parent] for front in (chest, head)] == ["Spine1", "Head"]
    assert (chest.face, head.face) == (False, True)
    for frame in range(0, len(positions), 20):
        facing = heading(positions[frame], chains, up)
        for front in (chest, head):
            ahead = rotate(rotations[frame, front.bone.parent], front.bone.normal)
            assert ahead @ facing > 0.7
    nose = head.body.vertices[np.argmax(head.body.vertices @ head.bone.normal)]
    assert (nose - head.bone.tip) @ head.bone.normal > 0.06 * height


def test_without_two_arms_there_is_no_head():
    motion = read_clip(WALK).motion
    rotations, positions = forward_kinematics(motion)
    legs = [c for c in find_chains(motion) if "Arm" not in c.segment]
    assert heads_and_chests(legs, motion.skeleton, rotations, positions, 1.0) == ()


@pytest.mark.parametrize("degrees", [-120.0, 40.0, 10.0, 4.0])
def test_a_fan_shows_how_far_the_bone_is_turned(qtbot, document, show_view, degrees):
    insert_twist(document, degrees=degrees)
    view = show_view(document)
    view.focus_chain()
    settle(qtbot, view)
    turn = view.drawing.turn(view.scene)
    assert turn.drawn == pytest.approx(np.radians(degrees))
    circle = view.scene._circle
    rim = circle.swept.points.astype(float)[1:]
    radius = np.linalg.norm(turn.circle.aside)
    length = np.linalg.norm(np.diff(rim, axis=0), axis=1).sum()
    assert length == pytest.approx(radius * abs(turn.drawn), rel=0.01)
    assert not circle.line.shown
    assert f"{abs(degrees):.0f}°" in view.overlays.angle.text()
    # The fan leads from the front of the bone before correction to its front after it.
    joint, frame = document.find_chain("LeftForeArm").parent, document.frame
    normal = next(b.normal for b in view.scene.bones if b.parent == joint)
    for after, angle in ((False, 0.0), (True, -turn.drawn)):
        front = rotate(document.pose(frame, after=after)[0][joint], normal)
        end = turn.circle.at(np.array([angle]))[0] - turn.circle.centre
        assert front @ end == pytest.approx(radius, rel=1e-3)
    # The best view sees the circle open.
    assert 0.25 < abs(view.camera.direction @ turn.circle.axis) < 0.8
    document.go_to(FRAME + 50)
    settle(qtbot, view)
    assert view.drawing.turn(view.scene) is None
    assert not circle.swept.shown


@pytest.mark.parametrize("style", list(Style))
def test_only_the_wrong_bone_is_coloured(document, show_view, style):
    insert_twist(document)
    view = show_view(document)
    view.look(style=style)
    view.refresh()
    roles = view.drawing.pose(view.scene).roles
    coloured = {view.scene.bones[k].parent for k in np.flatnonzero(roles != Role.PLAIN)}
    assert coloured == {document.find_chain("LeftForeArm").parent}


@pytest.mark.parametrize("split", [False, True])
def test_letters_name_the_sides(qtbot, document, show_view, split):
    view = show_view(document)
    view.look(split=split)
    view.set_view("front")
    settle(qtbot, view)
    pose = document.pose(document.frame, after=False)
    centres = {}
    for side, other in (("Left", "Right"), ("Right", "Left")):
        label = view.overlays.sides[side]
        assert label.isVisible()
        centres[side] = np.array(label.geometry().center().toTuple())
        joints = [document.find_chain(f"{s}ForeArm").child for s in (side, other)]
        own, far = view.camera.project(pose[1][joints], *view.picture_size())[0]
        assert np.linalg.norm(centres[side] - own) < np.linalg.norm(centres[side] - far)
    assert centres["Left"][0] > centres["Right"][0]  # seen from the front
    document.select_chain("RightUpLeg")
    settle(qtbot, view)
    assert abs(view.overlays.sides["Right"].geometry().center().y() - centres["Right"][1]) > 20


def test_the_whole_figure_is_drawn_if_the_picture_shows_a_part(qtbot, document, show_view):
    insert_twist(document)
    view = show_view(document)
    settle(qtbot, view)
    assert not view.overlays.whole.isVisible()
    view.focus_chain()
    settle(qtbot, view)
    small = view.overlays.whole
    assert small.isVisible()
    chain, size = document.find_chain("LeftForeArm"), view.picture_size()
    ends = document.pose(document.frame, after=False)[1][[chain.parent, chain.child]]
    for pixel in view.camera.project(ends, *size)[0]:
        assert not small.geometry().contains(*np.round(pixel).astype(int).tolist())
    drawn = small._miniature
    assert (drawn.bones > 0.0).all()
    assert (drawn.bones < (small.width(), small.height())).all()
    assert (drawn.roles == Role.AFTER).sum() == 1


def test_the_ground_of_the_last_clip_goes(document, show_view):
    view = show_view(document)
    view.look(split=True)
    view.refresh()
    count = view.view.renderer.GetActors().GetNumberOfItems()
    document.show_clip(document.data)
    view.refresh()
    assert view.view.renderer.GetActors().GetNumberOfItems() == count


def test_each_kind_of_error_keeps_its_look(qtbot, show_window, tmp_path):
    settings = tmp_path / "settings.json"
    window = show_window(Settings(), settings)
    open_clip(qtbot, window, shutil.copy(FLIPPED, tmp_path))
    document, skin = window.document, window.actions_by_id["skin"]
    flip, jump = (
        next(j.id for j in document.intervals if j.interval.kind == kind)
        for kind in (Kind.LIMB_FLIP, Kind.LONE_JUMP)
    )
    document.select_interval(jump)
    act(window, "side_by_side")
    document.select_interval(flip)
    act(window, "side_by_side")
    act(window, "skin")
    looks = []
    for chosen in (jump, flip):
        document.select_interval(chosen)
        looks.append((skin.isChecked(), window.viewport.drawing.looks.split))
    assert looks == [(True, False), (False, True)]
    window._kept_settings.write()
    kept, _ = load_settings(settings)
    assert kept.looks_by_kind == {"lone jump": ["skin"], "limb flip": ["side_by_side"]}


def test_a_lesson_does_not_change_the_looks(qtbot, show_window, tmp_path):
    window = show_window(Settings(looks_by_kind={"counter-twist": []}))
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path))
    act(window, "next_interval")
    assert not window.actions_by_id["skin"].isChecked()
    for name in ("show_teaching", "next_interval", "next_interval"):
        act(window, name)
    assert not window.viewport.scene.split
