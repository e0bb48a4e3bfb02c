"""The taught limb in 3D: its joints' names, what stands by, the family of poses at 180°."""

import numpy as np
import pytest

from inspector.teaching.gizmo_family import MEMBERS, add_swing_axis_fan, equivalent_swing_axes
from inspector.teaching.gizmo_joints import name_joints, triads
from inspector.teaching.gizmo_shapes import CLEAR, sketch_gizmo
from inspector.widgets.theme import DARK
from tests.gui.pictures import grabbed
from tests.gui.windows import act
from twistcore.analysis.decomposition import WhatIf, decompose
from twistcore.skeleton.rotation import (
    matrix_from_quaternion,
    multiply,
    quaternion_from_axis_angle,
    rotate,
    wrap,
)

ONE_WINDOW = True
CHAINS = ("LeftArm", "RightUpLeg", "LeftForeArm")


@pytest.fixture
def taught(qtbot, taught):
    taught.document.select_chain("LeftArm")
    qtbot.wait(100)
    return taught


def shapes_of(data, name, what_if, frame=90, **kinds):
    chain = next(c for c in data.chains if c.name == name)
    d = decompose(data.motion, chain, frame, what_if)
    places = (data.positions[frame, j] for j in (chain.parent, chain.child))
    # An altered P hangs on an unaltered parent of its own.
    above = quaternion_from_axis_angle(np.array([0.0, 1.0, 0.0]), 0.4)
    return chain, d, above, sketch_gizmo(d, multiply(above, d.q), *places, 0.3, 0.1, **kinds)


def symbols(shapes):
    return [mark.symbol for mark in shapes.marks]


# -- the family -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CHAINS)
def test_at_half_a_turn_every_normal_of_the_fan_gives_the_one_pose(analysed, name):
    _, d, *_ = shapes_of(analysed, name, WhatIf(swing=np.pi, twist=0.7))
    normals, angles = equivalent_swing_axes(d)
    assert len(normals) == MEMBERS
    assert np.abs(normals @ d.a).max() < 1e-9
    for n, theta in zip(normals, angles, strict=True):
        half_turn = quaternion_from_axis_angle(n, np.pi)
        q = multiply(half_turn, quaternion_from_axis_angle(d.a, theta))
        assert abs(q @ d.q) == pytest.approx(1.0, abs=1e-9)


def test_as_n_turns_by_phi_the_twist_runs_by_twice_as_much(analysed):
    _, d, *_ = shapes_of(analysed, "LeftArm", WhatIf(swing=np.radians(179.0)))
    normals, angles = equivalent_swing_axes(d)
    assert normals[0] == pytest.approx(d.n)
    assert angles[0] == pytest.approx(d.theta_p)
    for n, theta in zip(normals, angles, strict=True):
        phi = np.arctan2(np.cross(d.n, n) @ d.a, d.n @ n)
        assert wrap(theta - d.theta_p - 2.0 * phi) == pytest.approx(0.0, abs=1e-9)


def test_all_hands_of_the_fan_point_where_the_dials_hand_does(analysed):
    _, d, above, shapes = shapes_of(analysed, "LeftArm", WhatIf(swing=np.pi, twist=0.7))
    hand = next(p for p in shapes.parts if p.symbol == "theta_p" and p.look == "bold").points
    own = len(shapes.parts)
    add_swing_axis_fan(shapes, d, multiply(above, d.q), np.zeros(3))
    hands = next(p for p in shapes.parts[own:] if p.look == "bold").points.reshape(-1, 2, 3)
    ways = hands[:, 1] - hands[:, 0]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    assert len(ways) == MEMBERS
    assert ways == pytest.approx(
        np.tile((hand[1] - hand[0]) / np.linalg.norm(hand[1] - hand[0]), (MEMBERS, 1)), abs=1e-6
    )


def test_the_fan_is_there_near_half_a_turn_and_only_there(analysed):
    for swing, seen in ((90.0, False), (160.0, False), (172.0, True), (180.0, True)):
        _, d, above, shapes = shapes_of(analysed, "LeftArm", WhatIf(swing=np.radians(swing)))
        own = len(shapes.parts)
        before = len(shapes.marks)
        add_swing_axis_fan(shapes, d, multiply(above, d.q), np.zeros(3))
        assert any(np.ptp(p.points) > 0.0 for p in shapes.parts[own:]) == seen
        words = [mark.words for mark in shapes.marks[before:]]
        assert len(words) == (MEMBERS if seen else 0)
        if seen:
            assert words[0] == words[MEMBERS // 2]  # n and −n: θp and θp + 360°


# -- what has no value, what is on its way ---------------------------------------------------------


def filled(shapes, symbol):
    """The largest area of a symbol's clear faces."""
    areas = []
    for part in shapes.parts:
        if part.symbol == symbol and part.look == CLEAR:
            a, b, c, e = (part.points[part.cells[:, k]] for k in range(4))
            areas.append(np.linalg.norm(np.cross(c - a, e - b), axis=1).max())
    return max(areas)


def test_an_angle_that_is_undefined_fills_no_dial(analysed):
    whole = shapes_of(analysed, "LeftArm", WhatIf(twist=1.0, counter=True, bend=0.8))[-1]
    assert min(filled(whole, s) for s in ("theta_p", "dtheta_p", "dtheta_c")) > 1e-4
    turned = shapes_of(analysed, "LeftArm", WhatIf(swing=np.pi, twist=1.0))[-1]
    assert max(filled(turned, s) for s in ("theta_p", "dtheta_p")) < 1e-9
    assert not {"theta_p", "dtheta_p"} & set(symbols(turned))
    straight = shapes_of(analysed, "LeftArm", WhatIf(bend=0.0, twist=1.0, counter=True))[-1]
    assert filled(straight, "dtheta_c") < 1e-9
    assert "dtheta_c" not in symbols(straight)


def test_on_its_way_nothing_is_compared_with_the_frame_before(analysed):
    staged = shapes_of(analysed, "LeftArm", WhatIf(twist=1.0, counter=True), staged=True)[-1]
    assert filled(staged, "theta_p") > 1e-4
    assert max(filled(staged, s) for s in ("dtheta_p", "dtheta_c")) < 1e-9
    assert not {"dtheta_p", "dtheta_c", "real", "ideal"} & set(symbols(staged))


def test_the_arc_grows_then_the_dial(taught):
    frame, guest, scene = taught.taught, taught.teaching.gizmo, taught.viewport.scene
    areas = []
    for stage in (0.0, 0.5, 1.0, 1.5, 2.0):
        frame.set_stage(stage)
        shapes = guest._shapes(scene, taught.viewport.drawing.pose(scene))
        areas.append([filled(shapes, "alpha"), filled(shapes, "theta_p")])
    arc, dial = np.array(areas).T
    assert (np.diff(arc[:3]) > 1e-5).all()
    assert np.ptp(arc[2:]) < 1e-8
    assert dial[:3].max() < 1e-9
    assert (np.diff(dial[2:]) > 1e-6).all()


@pytest.mark.thorough
def test_at_the_start_the_bone_lies_along_a(taught):
    chain, motion = taught.taught.chain, taught.document.data.motion
    taught.taught.set_stage(0.0)
    pose = taught.viewport.drawing.pose(taught.viewport.scene)
    above = pose.rotations[motion.skeleton.parents[chain.parent]]
    bone = pose.positions[chain.child] - pose.positions[chain.parent]
    assert bone / np.linalg.norm(bone) == pytest.approx(rotate(above, chain.axis), abs=1e-6)


# -- names and axes -------------------------------------------------------------------------------


def test_p_c_and_g_are_named_once(analysed):
    for name, extra, wanted in (
        ("LeftArm", WhatIf(), {"P", "C", "G"}),
        ("LeftArm", WhatIf(twist=1.0, counter=True), {"P", "C", "real", "ideal"}),
        ("LeftForeArm", WhatIf(), {"P", "C"}),  # its grandchild is invented
    ):
        chain, _, _, shapes = shapes_of(analysed, name, extra)
        name_joints(shapes, chain, analysed.positions[90])
        assert set(symbols(shapes)) & {"P", "C", "G", "real", "ideal"} == wanted


def test_axes_are_those_of_the_joints(analysed):
    chain = next(c for c in analysed.chains if c.name == "LeftArm")
    rotations, positions = analysed.rotations[90], analysed.positions[90]
    lines = triads(chain, rotations, positions, 1.0).reshape(3, 3, 2, 3)
    for k, joint in enumerate((chain.parent, chain.child, chain.grandchild)):
        axes = lines[k, :, 1] - lines[k, :, 0]
        assert lines[k, :, 0] == pytest.approx(np.tile(positions[joint], (3, 1)))
        length = np.linalg.norm(axes[0])
        assert axes.T / length == pytest.approx(matrix_from_quaternion(rotations[joint]))


# -- what stands by -------------------------------------------------------------------------------


@pytest.mark.thorough
def test_all_but_the_chain_is_faint_while_the_tab_is_shown(qtbot, taught):
    scene, chain = taught.viewport.scene, taught.taught.chain
    pose = taught.viewport.drawing.pose(scene)
    solid = [(b.parent, b.child) for b, f in zip(scene.bodies, pose.faint, strict=True) if not f]
    assert solid == [(chain.parent, chain.child), (chain.child, chain.grandchild)]
    whole = bones_seen(grabbed(qtbot, taught.viewport))
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not taught.taught.active)
    assert taught.viewport.drawing.pose(scene).faint is None
    assert bones_seen(grabbed(qtbot, taught.viewport)) > 1.8 * max(whole, 100)
    act(taught, "show_teaching")
    taught.viewport.look(style="skinned limbs")
    whole = bones_seen(grabbed(qtbot, taught.viewport))
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not taught.taught.active)
    taught.viewport.look(style="skinned limbs")
    assert bones_seen(grabbed(qtbot, taught.viewport)) > 1.5 * max(whole, 100)


def bones_seen(image):
    """How many pixels are as light and as grey as a bone that is not selected."""
    ink = np.array([int(DARK.bone[k : k + 2], 16) for k in (1, 3, 5)])
    grey = np.ptp(image - ink, axis=2) < 30
    return int((grey & (image.min(axis=2) > 0.6 * ink.min())).sum())
