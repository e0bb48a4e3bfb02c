"""Taking hold of w and the dial, in numbers: what is under a pixel, what a drag makes of it."""

import numpy as np
import pytest

from inspector.teaching.gizmo_handles import (
    DIAL,
    REACH,
    Handles,
    SwingDrag,
    TwistDrag,
    W,
    handle_at,
)
from inspector.viewport.camera import OrbitCamera
from twistcore.skeleton.rotation import normalise, quaternion_from_axis_angle, rotate

UP, AHEAD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
SIZE = (640, 480)
ROOT = np.array([0.2, 1.0, -0.1])
ABOVE = quaternion_from_axis_angle(normalise(np.array([1.0, 2.0, 0.5])), 0.9)


def camera(azimuth=0.4, elevation=0.3, distance=4.0):
    return OrbitCamera(ROOT, azimuth, elevation, distance, UP, AHEAD)


def handles_along(axis, hand=None):
    axis = normalise(np.asarray(axis, dtype=float))
    hand = normalise(np.cross(axis, [0.3, 0.2, 0.9])) if hand is None else hand
    at = ROOT + 0.6 * axis
    return Handles(ABOVE, ROOT, ROOT + 0.92 * axis, at, 0.25, axis, hand)


def pixel(view, point):
    return view.project(point, *SIZE)[0]


def test_a_ray_goes_through_what_is_seen_at_its_pixel():
    view = camera()
    for point in np.random.default_rng(1).normal(ROOT, 0.5, (20, 3)):
        ray = view.ray(pixel(view, point), *SIZE)
        assert ray == pytest.approx(normalise(point - view.position), abs=1e-9)


@pytest.mark.parametrize("distance", [2.0, 4.0, 9.0])
def test_what_can_be_taken_is_ten_pixels_wide_however_far_away(distance):
    view, held = camera(distance=distance), handles_along([1.0, 0.2, 0.3])
    tip, edge = pixel(view, held.tip), pixel(view, held.ring[8])
    away = edge - pixel(view, held.centre)
    away /= np.linalg.norm(away)
    assert REACH >= 10.0
    for step in (0.0, 10.0):
        for way in (np.array([1.0, 0.0]), np.array([0.0, -1.0])):
            assert handle_at(held, view, SIZE, tip + step * way) == W
        assert handle_at(held, view, SIZE, edge + step * away) in (DIAL, W)
    assert handle_at(held, view, SIZE, tip + 60.0 * (tip - pixel(view, ROOT)) / 60.0) == ""


def test_the_hand_takes_the_dial_and_the_middle_of_the_bone_takes_nothing():
    view, held = camera(distance=2.0), handles_along([1.0, 0.2, 0.1])
    assert handle_at(held, view, SIZE, pixel(view, held.hand_tip)) == DIAL
    assert handle_at(held, view, SIZE, pixel(view, 0.8 * ROOT + 0.2 * held.centre)) == ""


# -- w --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("toward", [[1.0, 0.2, 0.3], [0.4, -0.2, 0.9], [-0.3, 0.2, -0.9]])
def test_w_follows_the_mouse_on_its_side_of_the_sphere(toward):
    """From near to near, from far to far: where the mouse is, there is the tip."""
    view, held = camera(), handles_along(toward)
    drag = SwingDrag(held, view, SIZE, pixel(view, held.tip))
    assert drag.way(held, view, SIZE, pixel(view, held.tip)) == pytest.approx(held.axis, abs=1e-6)
    far = (held.axis @ view.direction) < 0.0
    for other in np.random.default_rng(2).normal(0.0, 1.0, (20, 3)):
        other = normalise(other)
        eye = normalise(view.position - (ROOT + 0.92 * other))
        if abs(other @ eye) < 0.1 or (other @ eye < 0.0) != far:
            continue
        at = pixel(view, ROOT + 0.92 * other)
        assert drag.way(held, view, SIZE, at) == pytest.approx(other, abs=1e-6)


def test_where_it_was_gripped_it_stays_gripped():
    """Taken beside its middle, the tip does not jump to the mouse."""
    view, held = camera(), handles_along([1.0, 0.2, 0.3])
    at = pixel(view, held.tip) + np.array([9.0, -6.0])
    drag = SwingDrag(held, view, SIZE, at)
    assert drag.way(held, view, SIZE, at) == pytest.approx(held.axis, abs=1e-9)


def test_over_the_edge_it_goes_on_to_the_other_side_and_comes_back():
    view, held = camera(), handles_along(camera().axes[0] + 0.3 * camera().direction)
    start = pixel(view, held.tip)
    drag = SwingDrag(held, view, SIZE, start)
    out = np.arange(0.0, 140.0, 0.5)[:, None] * [1.0, 0.0]
    ways = np.array([drag.way(held, view, SIZE, start + step) for step in out])
    assert np.isfinite(ways).all()
    assert np.linalg.norm(ways, axis=1) == pytest.approx(1.0)
    steps = np.degrees(np.arccos(np.clip((ways[1:] * ways[:-1]).sum(axis=1), -1.0, 1.0)))
    assert steps.max() < 8.0  # no jump at the edge, where half a pixel turns it most
    near = ways @ view.direction
    assert near[0] > 0.2
    assert near[-1] < -0.2
    back = [drag.way(held, view, SIZE, start + step) for step in out[::-1]]
    assert np.array(back)[::-1] == pytest.approx(ways)


def test_w_is_given_in_the_coordinates_of_ps_rotation():
    held = handles_along([1.0, 0.2, 0.3])
    assert rotate(ABOVE, held.own(held.axis)) == pytest.approx(held.axis)


# -- the dial -------------------------------------------------------------------------------------


def spun(held, angle):
    """A point on the ring, so far on about w from the hand."""
    across = np.cross(held.axis, held.hand)
    return held.centre + held.radius * (np.cos(angle) * held.hand + np.sin(angle) * across)


@pytest.mark.parametrize("axis", [[0.4, 0.3, 0.9], [-0.4, 0.3, -0.9], [0.9, 0.2, 0.4]])
def test_the_dial_turns_with_the_mouse_from_either_side(axis):
    view, held = camera(), handles_along(axis)
    assert abs(held.axis @ view.direction) > 0.25
    drag = TwistDrag(held, view, SIZE, pixel(view, spun(held, 0.3)))
    for angle in np.linspace(0.3, 1.8, 12):
        turned = drag.turn(held, view, SIZE, pixel(view, spun(held, angle)))
        assert turned == pytest.approx(angle - 0.3, abs=1e-6)


def test_turns_add_up_beyond_a_whole_one():
    view, held = camera(), handles_along([0.4, 0.3, 0.9])
    drag = TwistDrag(held, view, SIZE, pixel(view, spun(held, 0.0)))
    for angle in np.linspace(0.0, 3.0 * np.pi, 60):
        turned = drag.turn(held, view, SIZE, pixel(view, spun(held, angle)))
    assert turned == pytest.approx(3.0 * np.pi, abs=1e-6)


def test_over_its_middle_the_mouse_turns_nothing():
    view, held = camera(), handles_along([0.4, 0.3, 0.9])
    drag = TwistDrag(held, view, SIZE, pixel(view, spun(held, 0.0)))
    before = drag.turn(held, view, SIZE, pixel(view, spun(held, 0.5)))
    assert drag.turn(held, view, SIZE, pixel(view, held.centre) + 0.5) == before


def test_seen_edge_on_the_ring_rolls_under_the_mouse():
    """Near side: as the mouse moves by the radius, it has turned by a radian."""
    view = camera()
    held = handles_along(view.axes[0])
    near = held.centre + held.radius * view.direction
    drag = TwistDrag(held, view, SIZE, pixel(view, near))
    for angle in (0.05, 0.1, 0.2):
        point = rotate(quaternion_from_axis_angle(held.axis, angle), near - held.centre)
        turned = drag.turn(held, view, SIZE, pixel(view, held.centre + point))
        assert turned == pytest.approx(angle, rel=0.15)
