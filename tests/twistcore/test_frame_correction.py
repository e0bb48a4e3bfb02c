"""What is taken off one frame, and the same rotation written otherwise."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.twistcore.strategies import axes, quaternions
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.analysis.decomposition import WhatIf, decompose, frame_motion_with_user_changes
from twistcore.analysis.decomposition.altered_frame import swing_then_twist_at_stage
from twistcore.analysis.decomposition.frame_correction import detect_and_correct_frame
from twistcore.analysis.decomposition.rotation_forms import (
    EulerChannels,
    decompose_into_euler_channels,
    double_cover_twist_angle,
    twist_times_swing_factors,
)
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.directions import (
    angle_between,
    perpendicular,
    unit_vector,
    vector_at_frame,
)
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    quaternion_from_euler,
    rotate,
    swing_twist,
    twist_angle,
    wrap,
)
from twistcore.skeleton.signals import twist_signals

MOTION = read_bvh(ASSETS / "dance.bvh").motion
CHAIN = next(c for c in find_chains(MOTION) if c.name == "RightArm")
SIGNALS = twist_signals(MOTION, CHAIN)
OPPOSED = np.flatnonzero(SIGNALS.strength > 0.001).tolist()
TURN = math.radians(70.0)


# Directions


@given(axes, axes)
def test_angles_between_directions_are_exact_near_0_and_180_degrees_too(u, v):
    assert angle_between(u, v) == pytest.approx(math.acos(np.clip(u @ v, -1.0, 1.0)), abs=1e-6)
    square = perpendicular(u)
    assert abs(square @ u) < 1e-12
    assert np.linalg.norm(square) == pytest.approx(1.0)
    for small in (1e-10, 1e-5):
        near = math.cos(small) * u + math.sin(small) * square
        assert angle_between(u, near) == pytest.approx(small, rel=1e-4)
        assert angle_between(u, -near) == pytest.approx(math.pi - small, abs=1e-12)


def test_what_has_no_length_has_no_direction():
    np.testing.assert_array_equal(unit_vector(np.array([0.0, 0.0, 9e-10])), np.zeros(3))
    np.testing.assert_allclose(unit_vector(np.array([0.0, 0.0, -2e-9])), [0.0, 0.0, -1.0])
    varying = np.arange(6.0).reshape(2, 3)
    assert vector_at_frame(varying, 1).tolist() == [3.0, 4.0, 5.0]
    assert vector_at_frame(varying[0], 1) is not None
    np.testing.assert_array_equal(vector_at_frame(varying[0], 1), varying[0])


# Forms


@given(quaternions, axes)
def test_the_factors_in_the_other_order_make_the_same_rotation(q, a):
    twist, swing = twist_times_swing_factors(q, a)
    np.testing.assert_allclose(multiply(twist, swing), q, atol=1e-12)
    np.testing.assert_allclose(np.abs(swing[0]), np.abs(swing_twist(q, a)[0][0]), atol=1e-9)
    if np.hypot(q[0], q[1:] @ a) > 1e-6:
        assert abs(swing[1:] @ a) < 1e-6
        angle = double_cover_twist_angle(q, a)
        assert abs(wrap(angle - float(twist_angle(q, a)))) < 1e-6
        assert abs(abs(angle - double_cover_twist_angle(-q, a)) - 2.0 * math.pi) < 1e-9


def test_a_twist_that_is_not_wrapped_goes_beyond_half_a_turn():
    x = np.array([1.0, 0.0, 0.0])
    for degrees in (-300.0, -100.0, 0.0, 170.0, 300.0):
        q = [math.cos(math.radians(degrees) / 2), math.sin(math.radians(degrees) / 2), 0.0, 0.0]
        assert math.degrees(double_cover_twist_angle(q, x)) == pytest.approx(degrees)


@given(
    st.sampled_from(["XYZ", "ZYX", "ZXY", "YZX"]),
    st.tuples(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0)),
)
def test_channels_are_the_angles_of_the_file_beside_those_that_are_near(order, angles):
    angles = np.array(angles)
    q = quaternion_from_euler(order, angles)
    near = angles + np.array([2.0 * math.pi, 0.01, -0.01])
    found = decompose_into_euler_channels(order, q, near)
    assert found.order == order
    assert float(geodesic_angle(quaternion_from_euler(order, found.angles), q)) < 1e-6
    if abs(angles[1]) < 1.4:
        whole = np.array([2.0 * math.pi, 0.0, 0.0])
        np.testing.assert_allclose(found.angles, angles + whole, atol=1e-6)
    first, last = (np.eye(3)["XYZ".index(order[k])] for k in (0, 2))
    turned = rotate(quaternion_from_axis_angle(np.eye(3)["XYZ".index(order[1])], angles[1]), last)
    apart = angle_between(first, turned)
    assert found.between == pytest.approx(min(apart, math.pi - apart), abs=1e-6)


def test_the_first_axis_and_the_last_lock_within_five_degrees():
    for degrees, locked in ((0.0, True), (4.9, True), (5.1, False), (90.0, False)):
        assert EulerChannels("XYZ", np.zeros(3), math.radians(degrees)).locked is locked


# Stages


@given(quaternions, axes, st.floats(-1.0, 3.0))
def test_a_stage_is_a_share_of_the_swing_then_one_of_the_twist(q, a, stage):
    swing, twist = swing_twist(q, a)
    found = swing_then_twist_at_stage(q, a, stage)
    part = min(max(stage, 0.0), 1.0)
    full = 2.0 * math.atan2(np.linalg.norm(swing[1:]), abs(swing[0]))
    if min(full, math.pi - full) < 1e-3:
        return
    rest, rolled = swing_twist(found, a)
    assert 2.0 * math.acos(min(abs(rest[0]), 1.0)) == pytest.approx(part * full, abs=1e-6)
    turn = min(max(stage - 1.0, 0.0), 1.0) * float(twist_angle(twist, a))
    assert abs(wrap(float(twist_angle(rolled, a)) - turn)) < 1e-6
    if stage >= 2.0:
        assert float(geodesic_angle(found, q)) < 1e-6


# Altered


def test_a_nudge_tips_the_bone_out_of_its_plane():
    frame, nudge = 40, 0.2
    before, after = (
        decompose(MOTION, CHAIN, frame, WhatIf(nudge=n, bend=1.0, swing=0.8)) for n in (0.0, nudge)
    )
    assert angle_between(before.w, after.w) == pytest.approx(nudge)
    assert abs(after.w @ before.n) == pytest.approx(math.sin(nudge))
    assert (after.w @ before.n) > 0.0
    assert angle_between(before.v, after.v) == pytest.approx(nudge)


def test_of_a_limb_without_a_swing_or_a_bend_some_plane_is_taken():
    straight = WhatIf(swing=0.0, bend=0.0)
    rotations = frame_motion_with_user_changes(MOTION, CHAIN, 40, straight).rotations
    still = MOTION.sliced(40, 41).with_rotations(rotations)
    axis = replace(CHAIN, axis=vector_at_frame(CHAIN.axis, 40), arm=vector_at_frame(CHAIN.arm, 40))
    for what_if, alpha, bend in (
        (WhatIf(swing=0.5), 0.5, 0.0),
        (WhatIf(bend=0.7), 0.0, 0.7),
        (WhatIf(nudge=0.3), 0.3, 0.3),
    ):
        d = decompose(still, axis, 0, what_if)
        assert d.alpha == pytest.approx(alpha, abs=1e-9)
        assert d.bend == pytest.approx(bend, abs=1e-9)


def test_a_bone_pointed_along_itself_keeps_the_plane_that_it_was_swung_in():
    captured = decompose(MOTION, CHAIN, 40)
    along = tuple(captured.a.tolist())
    d = decompose(MOTION, CHAIN, 40, WhatIf(toward=along, nudge=0.2))
    assert d.w @ captured.n == pytest.approx(math.sin(0.2))
    d = decompose(MOTION, CHAIN, 40, WhatIf(toward=along, swing=0.3))
    np.testing.assert_allclose(d.n, captured.n, atol=1e-9)


@pytest.mark.parametrize("counter", [False, True])
def test_what_is_altered_is_told(counter):
    assert not WhatIf(counter=counter).changes
    for some in ({"twist": 0.1}, {"swing": 0.0}, {"bend": 0.0}, {"nudge": 0.1}, {"applied": 0.5}):
        assert WhatIf(counter=counter, **some).changes
    assert WhatIf(toward=(1.0, 0.0, 0.0), counter=counter).changes


# What is defined


def test_where_an_angle_is_nothing_but_rounding_it_is_not_defined():
    one = decompose(MOTION, CHAIN, 40)
    assert one.swing_is_one
    assert one.n_is_defined
    assert one.strength_is_defined
    assert one.product == one.dtheta_p * one.dtheta_c
    still = replace(one, n=np.zeros(3))
    assert (still.n_is_defined, still.strength_is_defined) == (False, True)
    across = one.across / np.linalg.norm(one.across)
    for change, p, c in (
        ({"swing_reliability": 1e-6}, False, True),
        ({"swing_reliability_before": 1e-6}, False, True),
        ({"azimuth_reliability": 1e-6}, True, False),
        ({"across_before": 0.9e-6 * across}, True, False),
        ({"across_before": 1.1e-6 * across}, True, True),
    ):
        other = replace(one, **change)
        assert other.dtheta_p_is_defined is p
        assert other.dtheta_c_is_defined is c
        assert other.strength_is_defined is (p and c)
    assert not replace(one, swing_reliability=1e-6).n_is_defined


def test_frame_0_is_compared_with_itself():
    one = decompose(MOTION, CHAIN, 0)
    assert (one.dtheta_p, one.dtheta_c, one.strength) == (0.0, 0.0, 0.0)
    np.testing.assert_array_equal(one.v, one.v_before)
    np.testing.assert_array_equal(one.across, one.across_before)


def test_an_axis_that_varies_is_that_of_its_frame_and_of_the_one_before():
    tip = quaternion_from_axis_angle(np.eye(3)[2], 0.3 * np.sin(0.2 * np.arange(MOTION.frames)))
    moving = replace(CHAIN, axis=rotate(tip, CHAIN.axis), arm=rotate(tip, CHAIN.arm))
    whole = twist_signals(MOTION, moving)
    for frame in (0, 7, 40):
        one = decompose(MOTION, moving, frame)
        assert one.theta_p == pytest.approx(whole.theta_p[frame])
        assert one.dtheta_p == pytest.approx(whole.dtheta_p[frame])
        np.testing.assert_array_equal(one.a, moving.axis[frame])
        before = max(frame - 1, 0)
        v = rotate(MOTION.rotations[before, CHAIN.child], moving.arm[before])
        np.testing.assert_allclose(one.v_before, v)
        reliability = one.swing_reliability_before
        assert reliability == pytest.approx(whole.swing_reliability[before])
        fixed = replace(CHAIN, axis=moving.axis[frame], arm=moving.arm[frame])
        what_if = WhatIf(twist=0.5, counter=True, swing=0.8, bend=1.0)
        here, there = (
            frame_motion_with_user_changes(MOTION, c, frame, what_if) for c in (moving, fixed)
        )
        np.testing.assert_allclose(here.rotations, there.rotations, atol=1e-12)


# Corrections


@pytest.mark.parametrize("frame", [0, *OPPOSED[::40]])
@pytest.mark.parametrize("tau", [0.0005, 3.0])
@pytest.mark.parametrize("own", [None, 2.5])
def test_as_captured_what_is_taken_off_is_offset_or_the_intervals_own(frame, tau, own):
    strength = float(SIGNALS.strength[frame])
    found = detect_and_correct_frame(
        MOTION, CHAIN, frame, WhatIf(applied=0.5), tau=tau, offset_before=3.0, own=own
    )
    err = math.copysign(strength, SIGNALS.dtheta_p[frame]) if strength >= tau else 0.0
    assert found.err == pytest.approx(err, abs=1e-12)
    assert found.offset == pytest.approx(3.0 + err)
    whole = float(wrap(3.0 + err)) if own is None else own
    assert found.whole == pytest.approx(whole)
    assert found.taken == pytest.approx(0.5 * whole)
    assert found.difference < 1e-6
    assert (found.tau, found.applied, found.offset_before) == (tau, 0.5, 3.0)
    one = MOTION.sliced(frame, frame + 1)
    wanted = remove_twist(one, [CHAIN], {CHAIN.name: np.array([0.5 * whole])}).rotations[0]
    pairs = (
        (found.q_parent, MOTION.rotations[frame, CHAIN.parent]),
        (found.q_child, MOTION.rotations[frame, CHAIN.child]),
        (found.parent_after, wanted[CHAIN.parent]),
        (found.child_after, wanted[CHAIN.child]),
    )
    for mine, theirs in pairs:
        assert float(geodesic_angle(mine, theirs)) < 1e-7
    assert found.q_parent @ found.before.q == pytest.approx(1.0)
    none = detect_and_correct_frame(MOTION, CHAIN, frame, WhatIf(), tau=tau, offset_before=3.0)
    assert none.taken == 0.0
    np.testing.assert_array_equal(none.parent_after, none.q_parent)


def test_an_altered_frame_is_detected_as_altered_before_anything_is_taken_off():
    what_if = WhatIf(twist=TURN, counter=True, applied=1.0)
    captured = decompose(MOTION, CHAIN, 40)
    found = detect_and_correct_frame(MOTION, CHAIN, 40, what_if, tau=0.3, offset_before=0.0)
    assert found.before.theta_p == pytest.approx(float(wrap(captured.theta_p + TURN)), abs=1e-9)
    assert found.err == pytest.approx(TURN, abs=0.1)
    before = MOTION.rotations[40, CHAIN.parent]
    assert float(geodesic_angle(found.q_parent, before)) == pytest.approx(TURN, abs=1e-6)
    assert float(geodesic_angle(found.parent_after, before)) < 0.1
    assert found.difference < 1e-6


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_p_is_told_with_the_sign_of_its_swing_whatever_that_of_the_file(sign):
    rotations = MOTION.rotations.copy()
    rotations[:, CHAIN.parent] *= sign
    motion = MOTION.with_rotations(rotations)
    found = detect_and_correct_frame(motion, CHAIN, 40, WhatIf(), tau=0.3, offset_before=0.0)
    assert found.q_parent @ found.before.q == pytest.approx(1.0)
    np.testing.assert_array_equal(found.q_child, MOTION.rotations[40, CHAIN.child])


def test_where_m_is_not_defined_there_is_no_event():
    what_if = WhatIf(twist=TURN, counter=True, bend=0.0)
    found = detect_and_correct_frame(MOTION, CHAIN, 40, what_if, tau=0.0, offset_before=0.4)
    assert not found.before.strength_is_defined
    assert (found.err, found.whole) == (0.0, 0.4)


def test_the_angle_between_both_products_is_the_difference():
    found = detect_and_correct_frame(MOTION, CHAIN, 40, WhatIf(), tau=0.3, offset_before=0.0)
    turned = replace(
        found, child_after=multiply(found.child_after, quaternion_from_axis_angle(CHAIN.arm, 0.3))
    )
    assert turned.difference == pytest.approx(0.3)
