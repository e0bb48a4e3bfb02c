"""Invariants of swing-twist, and scipy's Rotation as the independent source."""

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from tests.twistcore.strategies import angles, axes, orders, quaternions
from twistcore.skeleton import rotation as rot
from twistcore.skeleton.angles import wrap_degrees


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


@given(axes, angles)
def test_logarithm_and_exponential_agree_with_scipy(a, angle):
    vector = rot.wrap(angle) * a
    q = rot.exponential(vector)
    expected = Rotation.from_rotvec(vector)
    assert same_rotation(q, expected.as_quat(scalar_first=True), 1e-7)
    assert np.linalg.norm(q) == pytest.approx(1.0)
    for same in (q, -q):
        assert same_rotation(rot.exponential(rot.logarithm(same)), q, 1e-7)
        assert np.linalg.norm(rot.logarithm(same)) <= np.pi + 1e-9
    if abs(rot.wrap(angle)) < 3.1:
        np.testing.assert_allclose(rot.logarithm(q), vector, atol=1e-7)


def test_logarithms_of_many_and_of_next_to_nothing():
    vectors = np.array([[0.0, 0.0, 0.0], [1e-14, 0.0, -2e-14], [1e-9, 0.0, 0.0], [0.0, 3.0, 0.0]])
    with np.errstate(all="raise"):
        back = rot.logarithm(rot.exponential(vectors))
    np.testing.assert_allclose(back, vectors, rtol=1e-9, atol=0)
    # Of one turn the vector, whichever of its two quaternions is given.
    half = rot.quaternion_from_axis_angle([0.0, 0.0, 1.0], [1.0, 1.0 - 2.0 * np.pi])
    np.testing.assert_allclose(rot.logarithm(half), [[0.0, 0.0, 1.0]] * 2, atol=1e-12)


def test_continuous_quaternions_never_change_their_side():
    turns = rot.quaternion_from_axis_angle([0.0, 0.0, 1.0], 0.3 * np.arange(40))
    signs = np.where(np.arange(40) % 3 == 1, -1.0, 1.0)[:, None]
    np.testing.assert_allclose(rot.continuous_quaternion_signs(signs * turns), turns)
    np.testing.assert_allclose(rot.continuous_quaternion_signs(-signs * turns), -turns)
    both = np.stack([signs * turns, turns], axis=1)
    np.testing.assert_allclose(
        rot.continuous_quaternion_signs(both), np.stack([turns, turns], axis=1)
    )
    right = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0]])  # at a right angle: left alone
    np.testing.assert_array_equal(rot.continuous_quaternion_signs(right), right)
    assert rot.continuous_quaternion_signs(turns[:1]).shape == (1, 4)


def test_the_largest_and_the_rms_of_angles_the_shorter_way_round():
    largest, rms = rot.largest_and_rms_angle_degrees(np.radians([3.0, -4.0, 360.0]))
    assert largest == pytest.approx(4.0)
    assert rms == pytest.approx(np.sqrt(25.0 / 3.0))
    assert rot.largest_and_rms_angle_degrees(np.radians([359.0])) == pytest.approx((1.0, 1.0))
    assert rot.largest_and_rms_angle_degrees([]) == (0.0, 0.0)


@pytest.mark.parametrize("count", [1, 63, 64, 200])
def test_few_angles_and_many_are_wrapped_alike(count):
    angles = np.linspace(-9.0, 9.0, count)
    angles[0], angles[count // 2], angles[-1] = -np.pi, np.pi, 3.0 * np.pi
    wrapped = rot.wrap(angles)
    assert (wrapped > -np.pi).all()
    assert (wrapped <= np.pi).all()
    turns = (angles - wrapped) / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)
    within = np.abs(angles) < np.pi
    np.testing.assert_array_equal(wrapped[within], angles[within])
    np.testing.assert_array_equal(rot.wrap(np.zeros(count)), np.zeros(count))


@given(orders, angles, angles, angles)
def test_the_middle_euler_angle_and_the_sign_of_all_three(order, a, b, c):
    """Angles of which the middle is within a quarter turn come back as they were."""
    given_angles = np.array([a, 0.49 * b, c])
    if np.cos(given_angles[1]) < 1e-3 or abs(given_angles[1]) > np.pi / 2:
        return
    q = rot.quaternion_from_euler(order, given_angles)
    np.testing.assert_allclose(
        rot.wrap(rot.euler_from_quaternion(order, q) - given_angles), 0.0, atol=1e-7
    )
    held = rot.euler_with_third_held(order, q, given_angles[2])
    np.testing.assert_allclose(rot.wrap(held - given_angles), 0.0, atol=1e-7)


@pytest.mark.parametrize("shapes", [((3,), (3,)), ((5, 3), (3,)), ((1, 3), (5, 3))])
def test_cross_products_are_those_of_numpy(shapes):
    u, v = (np.random.default_rng(k).normal(size=shape) for k, shape in enumerate(shapes))
    np.testing.assert_array_equal(rot.cross_products(u, v), np.cross(u, v))


@pytest.mark.parametrize("shape", [(3,), (4,), (0, 3), (50, 7, 4)])
def test_vector_lengths_equal_those_of_numpy_bit_for_bit(shape):
    rng = np.random.default_rng(8)
    v = rng.normal(size=shape) * 10.0 ** rng.integers(-9, 9, size=shape)
    found = rot.vector_lengths(v)
    assert found.shape == shape[:-1]
    assert np.array_equal(found, np.linalg.norm(v, axis=-1))


@pytest.mark.parametrize(
    "degrees",
    [30.0, 200.0, np.linspace(-170.0, 170.0, 30), np.linspace(-600.0, 600.0, 31), [np.nan, 400.0]],
)
def test_wrapped_degrees_equal_the_remainder_bit_for_bit(degrees):
    found = wrap_degrees(degrees)
    expected = (np.asarray(degrees) + 180.0) % 360.0 - 180.0
    assert found.shape == np.shape(degrees)
    assert np.array_equal(found, expected, equal_nan=True)


def test_leading_axes_broadcast():
    rng = np.random.default_rng(1)
    one, many = rot.normalise(rng.normal(size=4)), rot.normalise(rng.normal(size=(2, 3, 4)))
    np.testing.assert_allclose(np.linalg.norm(many, axis=-1), 1.0)
    vectors = rng.normal(size=(3, 3))
    for k in np.ndindex(2, 3):
        np.testing.assert_allclose(rot.multiply(one, many)[k], rot.multiply(one, many[k]))
        np.testing.assert_allclose(rot.multiply(many, one)[k], rot.multiply(many[k], one))
        np.testing.assert_allclose(rot.rotate(many, vectors)[k], rot.rotate(many[k], vectors[k[1]]))
        np.testing.assert_allclose(rot.rotate(one, vectors)[k[1]], rot.rotate(one, vectors[k[1]]))
        alone = rot.geodesic_angle(one, many[k])
        assert rot.geodesic_angle(one, many)[k] == pytest.approx(alone)
        apart = Rotation.from_quat(one, scalar_first=True).inv() * Rotation.from_quat(
            many[k], scalar_first=True
        )
        assert alone == pytest.approx(apart.magnitude())
        for order in ("XYZ", "YXZ"):
            of_one = rot.euler_from_quaternion(order, many[k])
            np.testing.assert_allclose(rot.euler_from_quaternion(order, many)[k], of_one)
            back = rot.quaternion_from_euler(order, rot.euler_from_quaternion(order, many))
            assert rot.geodesic_angle(back[k], many[k]) < 1e-7
            held = rot.euler_with_third_held(order, back, of_one[2])[k]
            np.testing.assert_allclose(held, of_one, atol=1e-9)
    np.testing.assert_allclose(rot.multiply(many, rot.conjugate(many))[..., 0], 1.0)
    turned = rot.quaternion_from_axis_angle([0.0, 1.0, 0.0], [[0.1], [0.2]])
    assert turned.shape == (2, 1, 4)
    np.testing.assert_allclose(rot.twist_angle(turned, [0.0, 1.0, 0.0]), [[0.1], [0.2]])


def test_how_far_a_twist_can_be_relied_on():
    x = np.array([1.0, 0.0, 0.0])
    for degrees in (0.0, 30.0, 90.0, 150.0, 180.0):
        swing = rot.quaternion_from_axis_angle([0.0, 1.0, 0.0], np.radians(degrees))
        both = rot.multiply(swing, rot.quaternion_from_axis_angle(x, 0.7))
        expected = np.cos(np.radians(degrees / 2.0))
        assert rot.twist_reliability(both, x) == pytest.approx(expected, abs=1e-12)


def test_single_precision_is_computed_in_double():
    rng = np.random.default_rng(2)
    p, q = (rot.normalise(rng.normal(size=(9, 4))).astype(np.float32) for _ in range(2))
    v, third = rng.normal(size=(9, 3)).astype(np.float32), np.float32(0.3)
    a = np.array([1.0, 2.0, 2.0], dtype=np.float32) / np.float32(3.0)
    turns = rng.normal(scale=9.0, size=80).astype(np.float32)
    for of, *given_values in (
        (rot.wrap, turns), (rot.wrap, turns[:9]), (rot.largest_and_rms_angle_degrees, turns),
        (rot.multiply, p, q), (rot.conjugate, q), (rot.rotate, q, v), (rot.normalise, v),
        (rot.continuous_quaternion_signs, q), (rot.quaternion_from_axis_angle, a, turns[:9]),
        (rot.exponential, v), (rot.logarithm, q), (rot.matrix_from_quaternion, q),
        (rot.twist_angle, q, a), (rot.twist_reliability, q, a), (rot.geodesic_angle, p, q),
    ):  # fmt: skip
        doubles = [np.asarray(value, dtype=np.float64) for value in given_values]
        found, expected = np.asarray(of(*given_values)), np.asarray(of(*doubles))
        assert found.dtype == np.float64, of
        np.testing.assert_array_equal(found, expected, err_msg=str(of))
        # Lists of whole numbers are numbers, too.
        whole = [np.round(4.0 * value).astype(int).tolist() for value in doubles]
        floats = [np.array(value, dtype=np.float64) for value in whole]
        with np.errstate(invalid="ignore", divide="ignore"):
            np.testing.assert_array_equal(of(*whole), of(*floats))
    for order in ("ZYX", "XZY"):
        for of in (rot.euler_from_quaternion, rot.euler_with_third_held):
            more = (third,) if of is rot.euler_with_third_held else ()
            expected = of(order, q.astype(np.float64), *(np.float64(t) for t in more))
            np.testing.assert_array_equal(of(order, q, *more), expected)
        expected = rot.quaternion_from_euler(order, v.astype(np.float64))
        np.testing.assert_array_equal(rot.quaternion_from_euler(order, v), expected)
