"""What the picture shows without words: the front, the side, the bone, and how far it is turned."""

import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtTest import QTest

from inspector.bundled import FLIPPED
from inspector.session.opening import analyse_file
from inspector.session.settings import Settings, load_settings
from inspector.viewport.bone_colours import Role
from inspector.viewport.crowding import Crowding
from inspector.viewport.head_and_chest import heads_and_chests
from inspector.viewport.limb_circle import Circle
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.striped_skin import FIN_PARTS
from tests.gui.pictures import FRAME, INJECTED, WALK, insert_twist, settle
from tests.gui.windows import act, open_clip
from tests.tiers import parametrize
from twistcore import read_clip
from twistcore.detection import Interval, Kind
from twistcore.review import Insert
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import normalise, rotate


def test_head_and_chest_look_ahead():
    motion = read_clip(WALK).motion
    rotations, positions = forward_kinematics(motion)
    chains, skeleton = find_chains(motion), motion.skeleton
    height, up = figure_size(positions, skeleton), guess_up(positions, chains, skeleton)
    chest, head = heads_and_chests(chains, skeleton, rotations, positions, height)
    assert [skeleton.names[front.bone.parent] for front in (chest, head)] == ["Spine1", "Head"]
    assert (chest.face, head.face) == (False, True)
    for frame in range(0, len(positions), 20):
        facing = figure_facing_direction(positions[frame], chains, up)
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


@parametrize("degrees", [-120.0, 40.0, 10.0, 4.0])
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
    hands = view.overlays.clock.hands
    assert view.overlays.clock.isVisible()
    assert hands.degrees == pytest.approx(degrees)
    assert hands.way[0] @ hands.way[-1] == pytest.approx(np.cos(np.radians(degrees)), abs=1e-6)
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


def test_the_hands_point_where_the_fins_do_in_the_picture(qtbot, document, show_view):
    insert_twist(document, degrees=50.0)
    view = show_view(document)
    view.focus_chain()
    for around in (0.0, 1.0, 2.5, 4.0):
        view.steer(lambda camera, around=around: camera.orbited(around, 0.1))
        settle(qtbot, view)
        circle, hands = view.drawing.turn(view.scene).circle, view.overlays.clock.hands
        if abs(view.camera.direction @ circle.axis) < 0.5:
            continue  # foreshortened
        ends = np.stack([circle.centre, circle.centre + circle.aside])
        start, stop = view.camera.project(ends, *view.picture_size())[0]
        arm = (stop - start) / np.linalg.norm(stop - start)
        assert arm @ hands.way[0] > 0.7


@parametrize("degrees", [70.0, -70.0])
def test_the_hand_of_the_clock_follows_the_mouse(qtbot, document, show_view, degrees):
    insert_twist(document, degrees=degrees)
    document.select_interval(document.intervals[-1].id)
    view = show_view(document)
    view.focus_chain()
    settle(qtbot, view)
    clock, before = view.overlays.clock, document.interval.interval
    middle, radius = np.array(clock.rect().center().toTuple()), 0.4 * clock.width()
    first = math.atan2(*clock.hands.way[-1][::-1])
    places = [
        QPoint(*np.round(middle + radius * np.array([math.cos(a), math.sin(a)])).astype(int))
        for a in first + np.radians(np.linspace(0.0, 40.0, 9))
    ]
    assert view.childAt(clock.geometry().center()) is clock
    QTest.mousePress(clock, Qt.MouseButton.LeftButton, pos=places[0])
    for place in places[1:]:
        QTest.mouseMove(clock, place)
        settle(qtbot, view)
    QTest.mouseRelease(clock, Qt.MouseButton.LeftButton, pos=places[-1])
    settle(qtbot, view)
    last = math.atan2(*clock.hands.way[-1][::-1])
    assert math.remainder(last - first, math.tau) == pytest.approx(math.radians(40.0), abs=0.06)
    change = math.degrees(document.interval.interval.delta - before.delta)
    assert abs(change) == pytest.approx(40.0, abs=3.0)
    document.undo()  # the whole drag
    assert document.interval.interval.delta == pytest.approx(before.delta)
    document.go_to(FRAME + 30)
    settle(qtbot, view)
    assert view.childAt(clock.geometry().center()) is not clock


def test_the_corrected_fin_and_limb_are_drawn_before_the_correction(qtbot, document, show_view):
    insert_twist(document, degrees=70.0)
    view = show_view(document)
    view.look(split=True, style=Style.SKIN)
    view.focus_chain()
    settle(qtbot, view)
    corrected, chain = view.scene._corrected, document.find_chain("LeftForeArm")
    assert corrected.fins.shown
    assert not corrected.line.shown  # a twist of a bone moves no joint
    _, positions = document.pose(document.frame, after=True)
    axis = positions[chain.child] - positions[chain.parent]
    turn = view.drawing.turn(view.scene)
    fin = corrected.fins.points[: len(FIN_PARTS)].mean(axis=0) - positions[chain.parent]
    fin -= (fin @ axis) / (axis @ axis) * axis
    goal = turn.after - turn.circle.centre
    assert fin @ goal == pytest.approx(np.linalg.norm(fin) * np.linalg.norm(goal), rel=1e-3)
    view.look(split=False)
    settle(qtbot, view)
    assert view.scene._corrected is None
    view.look(split=True)
    document.go_to(FRAME + 50)
    settle(qtbot, view)
    assert not view.scene._corrected.fins.shown


def test_a_line_shows_the_corrected_limb_of_a_flip(qtbot, document, show_view, tmp_path):
    view = show_view(document)
    view.look(split=True, style=Style.SKIN)
    document.show_clip(analyse_file(Path(shutil.copy(FLIPPED, tmp_path))))
    flip = next(j for j in document.intervals if j.interval.kind == Kind.LIMB_FLIP)
    document.select_interval(flip.id, jump=True)
    settle(qtbot, view)
    corrected, limb = view.scene._corrected, document.find_chain(flip.interval.chain)
    assert corrected.line.shown
    knee = document.pose(document.frame, after=True)[1][limb.child]
    pixel, depth = view.camera.project(knee, *view.picture_size())
    pixels, depths = view.camera.project(corrected.line.points.astype(float), *view.picture_size())
    assert np.abs(pixels - pixel).sum(axis=1).min() == pytest.approx(0.0, abs=0.1)
    assert (depths < 0.8 * depth).all()  # no body hides it
    assert not corrected.fins.shown  # they would be in the air


def test_a_jump_in_the_spine_marks_the_spine(qtbot, document, show_view):
    skeleton = document.data.motion.skeleton
    interval = Interval(
        "LeftShoulder", FRAME, FRAME + 1, np.array([0.7]), kind=Kind.JOINT_JUMP, joint="LowerBack",
        residual=0.7,
    )  # fmt: skip
    document.do(Insert(interval))
    document.select_interval(document.intervals[-1].id, jump=True)
    view = show_view(document)
    view.focus_chain()
    settle(qtbot, view)
    roles, back = view.drawing.pose(view.scene).roles, skeleton.index("LowerBack")
    marked = {b.parent for b, role in zip(view.scene.bones, roles, strict=True) if role}
    assert marked == {back}
    assert set(roles.tolist()) == {Role.PLAIN, Role.BEFORE}
    # The chest around the spine is translucent, and the spine is not.
    faint = view.drawing.left.faint
    count = len(view.scene.bones)
    assert [faint[count + k] for k, f in enumerate(view.scene.fronts) if not f.face] == [True]
    assert not faint[:count][roles == Role.BEFORE].any()
    spine = document.pose(FRAME, after=False)[1][back]
    pixel = view.camera.project(spine, *view.picture_size())[0]
    assert (np.abs(pixel / view.picture_size() - 0.5) < 0.3).all()
    assert view.sees_chain()


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


def test_only_the_side_of_a_wrong_limb_has_a_letter(qtbot, document, show_view):
    view = show_view(document)
    view.set_view("front")
    shown = []
    for degrees in (0.0, 50.0):
        if degrees:
            insert_twist(document, degrees=degrees)
        settle(qtbot, view)
        shown.append([side for side, label in view.overlays.sides.items() if label.isVisible()])
    assert shown == [["Left", "Right"], ["Left"]]


def test_a_limb_behind_the_selected_one_has_no_letter(qtbot, document, show_view):
    document.select_chain("LeftForeArm")
    view = show_view(document)
    _, positions = document.pose(document.frame, after=False)
    left, right = (positions[document.find_chain(f"{s}ForeArm").child] for s in ("Left", "Right"))
    view.steer(lambda camera: replace(camera, target=left).looking_from(normalise(left - right)))
    settle(qtbot, view)
    assert view.overlays.sides["Left"].isVisible()
    assert not view.overlays.sides["Right"].isVisible()


def test_the_weight_in_a_box_is_the_sum_of_its_pixels():
    rng = np.random.default_rng(1)
    pixels = rng.uniform(-20.0, 260.0, (400, 2))
    crowding = Crowding(240, 240)
    crowding.add(pixels, 3.0)
    low = 6.0 * rng.integers(0, 20, (30, 2))  # at the borders of cells
    high = low + 6.0 * rng.integers(1, 20, (30, 2))
    inside = ((pixels >= low[:, None]) & (pixels < high[:, None])).all(axis=2)
    np.testing.assert_allclose(crowding.within(low, high), 3.0 * inside.sum(axis=1))
    at = np.array([[60.0, 60.0]])
    before = crowding.within(at, at + 30.0)
    crowding.add_box(QRect(60, 60, 30, 30), 2.0)
    assert crowding.within(at, at + 30.0) == before + 2.0 * 25  # cells


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


@pytest.mark.thorough
def test_a_lesson_does_not_change_the_looks(qtbot, show_window, tmp_path):
    window = show_window(Settings(looks_by_kind={"counter-twist": []}))
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path))
    act(window, "next_interval")
    assert not window.actions_by_id["skin"].isChecked()
    for name in ("show_teaching", "next_interval", "next_interval"):
        act(window, name)
    assert not window.viewport.scene.split


def test_the_fan_of_an_almost_straight_limb_is_outside_its_skin():
    middle, across = np.array([0.0, 1.0, 0.0]), np.array([0.02, 0.0, 0.0])
    narrow = Circle(np.zeros(3), 2.0 * middle, middle, middle, across)
    wide = narrow.widened(0.1)
    assert np.linalg.norm(wide.at(np.array([1.0]))[0] - middle) == pytest.approx(0.1)
    assert wide.aside @ across == pytest.approx(0.1 * 0.02)  # the same direction
    assert narrow.widened(0.01) is narrow


@pytest.mark.thorough
def test_nothing_covers_the_scale_of_the_offset(qtbot, document, show_view):
    insert_twist(document)
    view = show_view(document)
    view.focus_chain()
    view.look(split=True, by_offset=True)
    settle(qtbot, view)
    over = view.overlays
    for _ in range(8):
        view.steer(lambda camera: camera.orbited(0.25 * np.pi, 0.0))
        settle(qtbot, view)
        parts = [over.whole, over.clock, over.angle, *over.sides.values()]
        shown = [part.geometry() for part in parts if part.isVisible()]
        assert shown
        assert not any(box.intersects(over.scale.geometry()) for box in shown)
