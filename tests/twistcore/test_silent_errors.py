"""Errors that joints show which do not twist: how large they are, and whose."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.twistcore.test_silent_joints import DEGREE, read_only
from twistcore.detection.limbs import Limbs
from twistcore.detection.soft_errors import silent_joints
from twistcore.detection.soft_errors.silent_joints import (
    _farther,
    _left,
    _of_two_chains,
    _unanswered,
    extract_silent_joint_errors,
    find_silent_joints,
)
from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.surprise import Surprise
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle

FRAMES = 240


# How much farther a parent turns than a silent child turns back


def plain_farther(x, back):
    """By one fit of a cubic and both ways, instead of two."""
    way = int(np.argmax([abs(v) for v in np.cumsum(back)]))
    there = [v if t <= way else 0.0 for t, v in enumerate(back)]
    again = [v if t > way else 0.0 for t, v in enumerate(back)]
    t = np.linspace(-1.0, 1.0, len(x))
    cubic = np.stack([t**0, t, t * t, t**3], axis=1)
    both = np.stack([there, again], axis=1)
    rest = both - cubic @ np.linalg.lstsq(cubic, both, rcond=None)[0]
    if np.linalg.cond(rest.T @ rest) > 1e6:
        return 1.0
    every = np.hstack([cubic, both])
    fit = np.linalg.lstsq(every, x, rcond=None)[0]
    by_nature = np.linalg.lstsq(cubic, x, rcond=None)[0]
    if np.linalg.norm(x - every @ fit) > 0.1 * np.linalg.norm(x - cubic @ by_nature):
        return 1.0
    least, most = sorted(fit[4:])
    if least < 1.12 or most > min(1.05 * least, 1.0 / 0.3):
        return 1.0
    return 0.5 * (least + most)


@pytest.mark.parametrize("start", [0, 1, 4, 12, 60, 115, 128])
@pytest.mark.parametrize("frames", [12, 24, 31])
def test_how_much_farther_a_parent_turns_than_its_silent_child(start, frames):
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        course = np.zeros(141)
        stop = min(start + frames, 140)
        course[start:stop] = np.radians(20.0) * np.sin(np.linspace(0.1, 3.0, stop - start))
        steps = np.diff(course, prepend=0.0)[:140]
        t = np.arange(140) / 140.0
        there, again = rng.choice([1.0, 1.1, 1.13, 1.5, 3.3, 3.4], 2)
        if rng.random() < 0.8:
            again = there * rng.choice([0.94, 0.96, 1.0, 1.045, 1.06])
        times = np.where(np.arange(140) <= np.abs(course[:140]).argmax(), there, again)
        x = times * steps + 0.01 * (t - 0.4) ** 3
        x += rng.choice([0.0, 1e-3, 0.05]) * np.abs(steps).max() * rng.standard_normal(140)
        surprise = read_only(x[None], -steps[None])
        beside = max(8, (stop - start) // 2)
        at = slice(max(start - beside, 1), min(stop + beside, 140))
        found.append(_farther(surprise, 0, start, stop))
        assert found[-1] == pytest.approx(plain_farther(x[at], steps[at]), abs=1e-9)
    assert start in (0, 128) or (min(found) == 1.0 and max(found) > 1.4)


def test_a_silent_child_that_does_not_turn_tells_nothing_of_how_far():
    rng = np.random.default_rng(1)
    assert _farther(read_only(rng.standard_normal((1, 90)), np.zeros((1, 90))), 0, 40, 60) == 1.0


# Whose errors they are: two limbs of three chains, whose third joint is a hinge


def made(seed=0, moving=False, silent=2, unrest=0.1):
    """A surprise in which one joint of each limb turns about a hinge across both its bones."""
    rng = np.random.default_rng(seed)
    t = np.arange(FRAMES) / 120.0
    axes = rng.standard_normal((3, 2, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    joints = np.empty((4, 2, FRAMES, 4))
    for k, i in np.ndindex(4, 2):
        angle = rng.uniform(0.2, 0.6) * np.sin(rng.uniform(2.0, 5.0) * t + k)
        if k == silent:
            hinge = np.cross(axes[k - 1, i], axes[min(k, 2), i]) if 0 < k < 3 else None
            if hinge is None:
                hinge = np.cross(axes[min(k, 2), i], rng.standard_normal(3))
        else:
            hinge = rng.standard_normal(3)
            angle = angle + unrest * DEGREE * rng.standard_normal(FRAMES)
        hinge = np.broadcast_to(hinge / np.linalg.norm(hinge), (FRAMES, 3))
        joints[k, i] = quaternion_from_axis_angle(hinge, angle)
    if moving:
        axes = np.repeat(axes[:, :, None], FRAMES, axis=2)
    cut = np.zeros(FRAMES, dtype=bool)
    cut[0] = True
    return Surprise(Limbs(joints, axes), 120.0, cut)


def put_in(surprise, row, start, offset, followed=1.0):
    """A surprise with an error of P of a row, of which C turned back so much."""
    joints = surprise.joints.copy()
    k, i = divmod(row, 2)
    for n, angle in enumerate(offset):
        axis = surprise.limbs.axes[k, i]
        axis = axis if axis.ndim == 1 else axis[start + n]
        p, c = (
            np.array([math.cos(0.5 * a), *(math.sin(0.5 * a) * axis)])
            for a in (angle, -followed * angle)
        )
        joints[k, i, start + n] = multiply(joints[k, i, start + n], p)
        joints[k + 1, i, start + n] = multiply(c, joints[k + 1, i, start + n])
    return Surprise(Limbs(joints, surprise.limbs.axes), surprise.fps, surprise.cut)


def bump(frames=40, degrees=20.0):
    return degrees * DEGREE * np.sin(np.linspace(0.0, math.pi, frames + 2))[1:-1]


def test_a_hinge_is_silent_in_both_chains_that_share_it():
    assert find_silent_joints(made()) == {2: -1, 3: -1, 4: 1, 5: 1}
    assert find_silent_joints(made(silent=0)) == {0: 1, 1: 1}
    assert find_silent_joints(made(silent=3)) == {4: -1, 5: -1}


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize(("row", "start"), [(2, 30), (3, 100), (4, 60), (5, 190)])
def test_an_error_that_a_silent_joint_shows_is_taken_out(row, start, moving):
    clean = made(row, moving)
    surprise = put_in(clean, row, start, bump())
    (found,) = extract_silent_joint_errors(surprise, {2 + row % 2: -1, 4 + row % 2: 1})
    assert (found.row, found.gain, found.sigma) == (row, 200.0, pytest.approx(0.1 * DEGREE))
    assert (found.followed, found.unsure) == (1.0, False)
    assert start - 1 <= found.start <= start + 1
    wanted = np.zeros(FRAMES)
    wanted[start : start + 40] = bump()
    np.testing.assert_allclose(found.offset, wanted[found.start : found.stop], atol=0.06 * DEGREE)
    assert np.abs(found.offset[[0, -1]]).min() > 0.05 * DEGREE
    close = np.abs(surprise.x - clean.x).max(), np.abs(surprise.y - clean.y).max()
    assert max(close) < 0.12 * DEGREE  # what is taken out is taken out of what is looked at, too
    assert extract_silent_joint_errors(surprise, {3 - row % 2: -1, 5 - row % 2: 1}) == []


@pytest.mark.parametrize("followed", [0.4, 0.6, 0.8])
def test_a_silent_child_turns_back_only_a_part(followed):
    clean = made(3, moving=True, unrest=0.01)
    surprise = put_in(clean, 2, 80, bump(48, 30.0), followed)
    (found,) = extract_silent_joint_errors(surprise, {2: -1, 4: 1})
    assert (found.row, found.followed) == (2, pytest.approx(followed, abs=0.03))
    wanted = bump(48, 30.0)[found.start - 80 : found.stop - 80]
    np.testing.assert_allclose(found.offset, wanted, atol=1.5 * DEGREE)
    assert np.abs(surprise.x - clean.x).max() < 0.3 * DEGREE
    norms = np.linalg.norm(surprise.joints, axis=-1)
    np.testing.assert_allclose(norms, 1.0, atol=1e-12)


def test_errors_of_a_limb_are_taken_out_one_after_the_other():
    surprise = made(6)
    places = {(2, 30): 12.0, (4, 35): 0.0, (2, 120): -25.0, (4, 180): 18.0}
    for (row, start), degrees in places.items():
        surprise = put_in(surprise, row, start, bump(30, degrees))
    found = extract_silent_joint_errors(surprise, {2: -1, 4: 1})
    near = {(e.row, round((e.start - 15) / 30)): float(e.offset.sum()) for e in found}
    wanted = {(2, 0): 12.0, (2, 4): -25.0, (4, 6): 18.0}
    assert near.keys() == {(r, round((s - 15) / 30)) for r, s in ((2, 30), (2, 120), (4, 180))}
    for key, degrees in wanted.items():
        assert near[key] == pytest.approx(bump(30, degrees).sum(), abs=2.0 * DEGREE)


def test_no_more_errors_are_taken_out_than_are_allowed(monkeypatch):
    monkeypatch.setattr(silent_joints, "MOST", 2)
    surprise = made(5)
    for start in (20, 70, 120, 170):
        surprise = put_in(surprise, 2, start, bump(30))
    assert len(extract_silent_joint_errors(surprise, {2: -1, 4: 1})) == 2


def test_what_a_silent_joint_does_not_show_is_no_error_of_it():
    surprise = made(1)
    before = surprise.joints.copy()
    assert extract_silent_joint_errors(surprise, {2: -1, 4: 1}) == []
    assert extract_silent_joint_errors(surprise, {}) == []
    assert extract_silent_joint_errors(surprise, {0: 1}) == []  # that one twists all the time
    np.testing.assert_array_equal(surprise.joints, before)


def a_left_over(surprise, sides, error):
    """What silent joints turn around an error, by a copy of the limb without it."""
    taken = put_in(surprise, error.row, error.start, -error.offset, error.followed)
    at = range(max(error.start, 1), min(error.stop + 1, FRAMES))
    sums = []
    for s in (surprise, taken):
        rows = [r for r in (error.row - 2, error.row, error.row + 2) if r in sides]
        sums.append(sum(abs((s.x if sides[r] > 0 else s.y)[r, t]) for r in rows for t in at))
    return sums[1] / max(sums[0], 0.005 * DEGREE)


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("start", [0, 50, 200])
def test_what_is_left_without_an_error_and_all_is_as_before(start, moving):
    surprise = put_in(made(4, moving), 2, start, bump())
    for row, share, followed in ((2, 1.0, 1.0), (2, 0.5, 1.0), (4, -0.8, 1.0), (2, 0.7, 0.5)):
        error = SoftError(row, start, share * bump(), 9.0, 0.1, followed)
        for sides in ({2: -1, 4: 1}, {2: -1}, {4: 1, 3: -1}, {0: 1, 2: -1}):
            joints, x = surprise.joints.copy(), surprise.x.copy()
            found = _left(surprise, sides, error)
            assert found == pytest.approx(a_left_over(surprise, sides, error), abs=1e-9)
            np.testing.assert_allclose(surprise.joints, joints, atol=1e-12)
            np.testing.assert_allclose(surprise.x, x, atol=1e-12)
    still = read_only(np.zeros((1, 30)), np.zeros((1, 30)))
    assert silent_joints._turned(still, {0: 1}, SoftError(0, 4, bump(9), 9.0, 0.1)) == 0.0


def test_what_the_other_joint_leaves_unanswered():
    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((2, 3, 60))
    surprise = read_only(x, y)
    for start, frames in ((0, 9), (20, 12), (51, 9)):
        error = SoftError(1, start, bump(frames), 9.0, 0.1)
        at = range(max(start, 1), min(start + frames + 1, 60))
        for side, other in ((1, y), (-1, x)):
            wanted = sum(abs(x[1, t] + y[1, t]) for t in at) / sum(abs(other[1, t]) for t in at)
            assert _unanswered(surprise, error, side) == pytest.approx(wanted)
    nothing = read_only(np.full((1, 9), 1e-6), np.zeros((1, 9)))
    error = SoftError(0, 2, bump(3), 9.0, 0.1)
    assert _unanswered(nothing, error, 1) == pytest.approx(4e-6 / (0.005 * DEGREE))


@pytest.mark.parametrize(("left", "clearly"), [(0.2, True), (0.3, False)])
def test_of_two_chains_it_is_the_one_whose_other_joint_clearly_answers(left, clearly):
    x = np.zeros((2, 60))
    x[0, 20:31] = [1.0, -1.0] * 5 + [1.0]
    y = np.zeros((2, 60))
    x[1] = -(1.0 - left) * x[0]
    y[1] = x[0]
    surprise = read_only(x, y)
    sides = {0: -1, 1: 1}
    best = SoftError(0, 20, bump(10), 9.0, 0.1)
    assert _unanswered(surprise, best, -1) == 1.0
    other = SoftError(1, 20, bump(10), 9.0, 0.1)
    assert _unanswered(surprise, other, 1) == pytest.approx(left)
    chosen = _of_two_chains(surprise, sides, best, [best, other])
    assert chosen is (other if clearly else best)
    for start, frames in ((12, 10), (28, 10), (20, 18), (12, 26)):
        near = replace(other, start=start, offset=bump(frames))
        left_there = _unanswered(surprise, near, 1)
        assert (_of_two_chains(surprise, sides, best, [best, near]) is near) == (left_there < 0.25)
    for start, frames in ((11, 19), (29, 10), (20, 19)):
        far = replace(other, start=start, offset=bump(frames))
        assert _of_two_chains(surprise, sides, best, [best, far]) is best
