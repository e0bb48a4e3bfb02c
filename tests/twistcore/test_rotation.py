"""Invariants of swing-twist, and scipy's Rotation as the independent source."""

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from tests.twistcore.strategies import angles, axes, orders, quaternions
from twistcore import rotation as rot


def same_rotation(p, q, tolerance=1e-9):
    return rot.geodesic_angle(p, q).max() < tolerance


@given(quaternions, quaternions)
def test_product_agrees_with_scipy(p, q):
    expected = Rotation.from_quat(p, scalar_first=True) * Rotation.from_quat(q, scalar_first=True)
    assert same_rotation(rot.multiply(p, q), expected.as_quat(scalar_first=True), 1e-7)


@given(quaternions, axes)
def test_rotated_vectors_and_matrices_agree_with_scipy(q, v):
    expected = Rotation.from_quat(q, scalar_first=True)
    np.testing.assert_allclose(rot.rotate(q, v), expected.apply(v), atol=1e-12)
    np.testing.assert_allclose(rot.matrix_from_quaternion(q), expected.as_matrix(), atol=1e-12)


@given(orders, angles, angles, angles)
def test_euler_agrees_with_scipy_and_comes_back(order, a, b, c):
    q = rot.quaternion_from_euler(order, [a, b, c])
    expected = Rotation.from_euler(order, [a, b, c]).as_quat(scalar_first=True)
    assert same_rotation(q, expected, 1e-7)
    back = rot.euler_from_quaternion(order, q)
    if np.cos(back[1]) > 1e-6:
        assert same_rotation(rot.quaternion_from_euler(order, back), q, 1e-7)
    held = rot.euler_with_third_held(order, q, np.asarray(c))
    assert same_rotation(rot.quaternion_from_euler(order, held), q, 1e-7)


@given(orders, angles, angles, angles)
def test_gimbal_lock_keeps_the_third_angle_that_is_asked_for(order, a, c, held):
    q = rot.quaternion_from_euler(order, [a, np.pi / 2, c])
    out = rot.euler_with_third_held(order, q, np.asarray(held))
    assert out[2] == held
    assert same_rotation(rot.quaternion_from_euler(order, out), q, 1e-7)


@given(quaternions, axes)
def test_swing_times_twist_is_the_rotation(q, a):
    swing, twist = rot.swing_twist(q, a)
    assert same_rotation(rot.multiply(swing, twist), q, 1e-7)
    if rot.twist_reliability(q, a) > 1e-6:
        # The swing turns a as q does, by an axis at a right angle to a: it twists nothing.
        np.testing.assert_allclose(rot.rotate(swing, a), rot.rotate(q, a), atol=1e-9)
        assert abs(swing[1:] @ a) < 1e-9


@given(quaternions, axes, angles)
def test_a_twist_from_the_right_adds_to_the_twist_angle(q, a, angle):
    if rot.twist_reliability(q, a) < 1e-3:
        return
    turned = rot.multiply(q, rot.quaternion_from_axis_angle(a, angle))
    gained = rot.wrap(rot.twist_angle(turned, a) - rot.twist_angle(q, a) - angle)
    assert abs(gained) < 1e-9


def test_twist_angle_keeps_the_sign_that_eq_8_loses():
    x = np.array([1.0, 0.0, 0.0])
    for degrees in (-170.0, -5.0, 5.0, 170.0):
        q = rot.quaternion_from_axis_angle(x, np.radians(degrees))
        assert np.degrees(rot.twist_angle(q, x)) == pytest.approx(degrees)
        assert np.degrees(rot.twist_angle(-q, x)) == pytest.approx(degrees)


def test_a_swing_of_180_degrees_has_no_twist_and_says_so():
    q = np.array([0.0, 0.0, 1.0, 0.0])
    assert rot.twist_angle(q, [1.0, 0.0, 0.0]) == 0.0
    assert rot.twist_reliability(q, [1.0, 0.0, 0.0]) == 0.0
    swing, twist = rot.swing_twist(q, np.array([1.0, 0.0, 0.0]))
    assert np.isfinite([*swing, *twist]).all()


@pytest.mark.parametrize(
    ("angle", "wrapped"), [(np.pi, np.pi), (-np.pi, np.pi), (0.0, 0.0), (7.0, 7.0 - 2 * np.pi)]
)
def test_wrap_is_into_the_half_open_turn(angle, wrapped):
    assert rot.wrap(angle) == pytest.approx(wrapped)
