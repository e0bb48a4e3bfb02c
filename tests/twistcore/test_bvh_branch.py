"""The branch of Euler angles that is written is the shortest there is."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import examples, parametrize
from tests.twistcore.strategies import orders, quaternions
from twistcore.cli import main
from twistcore.formats.bvh import parse_bvh, read_bvh, write_motion
from twistcore.formats.bvh.euler_branch import (
    _cheapest_path,
    continuous_euler_angles,
    euler_jump_rows_and_channels,
)
from twistcore.formats.clip import changed_rotations, create_file_patch_for_motion
from twistcore.skeleton.rotation import (
    euler_from_quaternion,
    exponential,
    geodesic_angle,
    multiply,
    quaternion_from_euler,
    wrap,
)

TURNS = 2 * np.pi * np.arange(-3, 4)


def length(path):
    return np.abs(np.diff(path, axis=0)).sum()


def shortest(solutions, before, after):
    """By trying every branch, and every turn of every channel."""
    best = np.inf
    for branch in itertools.product((0, 1), repeat=len(solutions)):
        chosen = solutions[np.arange(len(solutions)), list(branch)]
        total = 0.0
        for c in range(3):
            cost = np.abs(chosen[0, c] + TURNS - before[c])
            for a, b in itertools.pairwise(chosen[:, c]):
                step = np.abs((b + TURNS)[None, :] - (a + TURNS)[:, None])
                cost = (cost[:, None] + step).min(axis=0)
            total += (cost + np.abs(after[c] - chosen[-1, c] - TURNS)).min()
        best = min(best, total)
    return best


edges = st.tuples(*[st.floats(-3.0, 3.0)] * 3)
SQUARES = [[0.0, 0.0, 1.0, 1.0], [0.5, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.75, 0.0, -1.0]]


@settings(max_examples=examples(120))
@given(
    orders,
    st.lists(quaternions, min_size=1, max_size=4),
    edges,
    edges,
    st.tuples(*[st.integers(-1, 1)] * 3),
)
# Steps of just half a turn: either way is the shortest.
@example(
    "ZYX",
    [np.array(q) / np.linalg.norm(q) for q in SQUARES],
    (2.0, -1.5702653289460513, 0.0),
    (-2, -1, 0),
    (0, 0, 0),
)
def test_no_way_between_the_fixed_edges_is_shorter(order, run, before, after, turns):
    q = np.array(run)
    before, after = np.array(before, float), np.array(after) + 2 * np.pi * np.array(turns)
    first = euler_from_quaternion(order, q)
    if np.abs(np.cos(first[:, 1])).min() < 1e-3:
        return
    second = np.stack([first[:, 0] + np.pi, np.pi - first[:, 1], first[:, 2] + np.pi], axis=1)
    found = continuous_euler_angles(order, q, np.zeros((len(q), 3)), before, after)
    assert geodesic_angle(quaternion_from_euler(order, found), q).max() < 1e-6
    least = shortest(np.stack([first, second], axis=1), before, after)
    assert length(np.vstack([before, found, after])) <= least + 1e-6


@settings(max_examples=examples(50))
@given(st.integers(1, 8), st.booleans(), st.booleans(), st.integers(0, 2**32))
def test_no_branch_costs_less(n, with_before, with_after, seed):
    rng = np.random.default_rng(seed)
    solutions = rng.uniform(-4.0, 4.0, (n, 2, 3))
    edges = [rng.uniform(-4.0, 4.0, (k, 3)) for k in (int(with_before), int(with_after))]
    extra = rng.uniform(0.0, 4.0, (n, 2)) * rng.integers(2)

    def total(branch):
        path = np.vstack([edges[0], solutions[np.arange(n), list(branch)], edges[1]])
        besides = extra[np.arange(n), list(branch)].sum()
        return np.abs(wrap(np.diff(path, axis=0))).sum() + besides

    found = _cheapest_path(solutions, *(edge[0] if len(edge) else None for edge in edges), extra)
    assert total(found) <= min(map(total, itertools.product((0, 1), repeat=n))) + 1e-9


def test_a_jump_that_must_stay_is_reported():
    """Both edges a turn apart and a constant pose between: one step has to take the turn."""
    q = np.tile([1.0, 0.0, 0.0, 0.0], (5, 1))
    before, after = np.zeros(3), np.array([0.0, 0.0, 2 * np.pi])
    found = continuous_euler_angles("ZYX", q, np.zeros((5, 3)), before, after)
    steps = np.diff(np.vstack([before, found, after]), axis=0)
    ((row, channel),) = euler_jump_rows_and_channels(found, before, after)
    assert channel == 2
    assert steps[row, channel] == pytest.approx(2 * np.pi)
    steps[row, channel] = 0.0
    np.testing.assert_allclose(steps, 0.0, atol=1e-12)  # and none but that


@pytest.mark.thorough
def test_a_long_run_with_a_turn_left_over_is_quick():
    t = np.linspace(0, 2 * np.pi, 3000)
    angles = np.stack([t, 0.3 * np.sin(t), 0 * t], axis=1)
    q = quaternion_from_euler("ZYX", angles)
    found = continuous_euler_angles("ZYX", q, np.zeros((len(q), 3)), np.zeros(3), np.zeros(3))
    assert len(euler_jump_rows_and_channels(found, np.zeros(3), np.zeros(3))) == 1


# -- every frame is written anew: only the file's own angles say which curves are meant -----------

HALF = np.array([180.0, 180.0, 180.0])


def other(angles):
    """The other solution of the same rotations, degrees."""
    return HALF + angles * [1.0, -1.0, 1.0]


def clip_of(path, *, order="ZXY", beyond=False):
    """Frames 100-160 of the walk, without a pose of rest; beyond: every middle angle beyond 90°."""
    motion = read_bvh(ASSETS / "walk.bvh").motion.sliced(100, 160)
    write_motion(motion, path)
    clip = read_bvh(path)
    named = [f"{letter}rotation" for letter in order]
    head, word, rest = clip.data.partition(b"Frame Time:")
    head = head.replace(b"Zrotation Xrotation Yrotation", " ".join(named).encode())
    rate = rest.partition(b"\n")[0]
    values = clip.values.copy()
    for joint, layout in enumerate(clip.channels):
        q = np.ascontiguousarray(motion.rotations[:, joint])
        angles = np.degrees(np.unwrap(euler_from_quaternion(order, q), axis=0))
        values[:, list(layout.rotation)] = other(angles) if beyond else angles
    rows = "\n".join(" ".join(f"{x:.6f}" for x in row) for row in values)
    path.write_bytes(head + word + rate + b"\n" + rows.encode() + b"\n")
    return read_bvh(path)


def furthest(before, after):
    """Of the numbers where a joint turned by less than 10°: the largest change, degrees."""
    turned = np.degrees(geodesic_angle(before.motion.rotations, after.motion.rotations))
    far = np.abs(after.values - before.values)
    return max(
        far[turned[:, joint] < 10.0][:, list(layout.rotation)].max(initial=0.0)
        for joint, layout in enumerate(before.channels)
    )


@pytest.mark.parametrize("beyond", [False, True])
@parametrize("words", [["--causal"], [], ["--method", "spline"]], quick=2)
def test_a_clip_tracked_from_its_first_frame_keeps_its_curves(beyond, words, tmp_path):
    clip, out = clip_of(tmp_path / "in.bvh", beyond=beyond), tmp_path / "out.bvh"
    assert main(["quamo", "refine", str(clip.path), "-o", str(out), *words]) == 0
    tracked = read_bvh(out)
    changed = changed_rotations(clip, tracked.motion)
    assert changed.all(axis=0).sum() > 5 or words == ["--causal"]
    assert furthest(clip, tracked) < 120.0


@pytest.mark.parametrize("beyond", [False, True])
@pytest.mark.parametrize("order", ["ZXY", "XYZ"])
def test_a_clip_turned_slightly_everywhere_keeps_its_curves(order, beyond, tmp_path):
    clip = clip_of(tmp_path / "in.bvh", order=order, beyond=beyond)
    middle = [layout.rotation[1] for layout in clip.channels]
    assert (np.abs(clip.values[:, middle]) > 90.0).all() == beyond
    for seed in range(4):
        rng = np.random.default_rng(seed)
        turn = exponential(np.radians(0.5) * rng.standard_normal((1, len(clip.channels), 3)))
        moved = clip.motion.with_rotations(multiply(turn, clip.motion.rotations))
        again = parse_bvh(create_file_patch_for_motion(clip, moved).data)
        assert furthest(clip, again) < 60.0
        assert geodesic_angle(again.motion.rotations, moved.rotations).max() < 1e-6


def smooth(rng, n):
    """A smooth curve of three angles away from the pole, radians, (n, 3)."""
    t = 0.1 * np.arange(n)[:, None]
    rate, phase = rng.uniform(0.5, 3.0, 3), rng.uniform(-np.pi, np.pi, 3)
    return rng.uniform(-np.pi, np.pi, 3) * [1, 0, 1] + [2.0, 1.2, 2.0] * np.sin(rate * t + phase)


@settings(max_examples=examples(60))
@given(orders, st.integers(1, 40), st.booleans(), st.sampled_from([0.0, np.pi, 1.0]), st.data())
def test_noise_of_rounding_does_not_change_the_branch(order, n, beyond, turn, data):
    """Not even where the rotations are as far from the file's as can be, in every frame."""
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    own = smooth(rng, n) + 2.0 * np.pi * rng.integers(-2, 3, 3)
    own = np.radians(other(np.degrees(own))) if beyond else own
    axis = turn * np.eye(3)[data.draw(st.integers(0, 2))]
    q = multiply(quaternion_from_euler(order, own), exponential(axis[None]))
    if np.abs(np.cos(euler_from_quaternion(order, q)[:, 1])).min() < 1e-2:
        return
    found = continuous_euler_angles(order, q, own, None, None)
    assert geodesic_angle(quaternion_from_euler(order, found), q).max() < 1e-6
    if turn == 0.0:
        np.testing.assert_allclose(found, own, atol=1e-6)
    noisy = multiply(exponential(1e-9 * rng.standard_normal((n, 3))), q)
    np.testing.assert_allclose(
        continuous_euler_angles(order, noisy, own, None, None), found, atol=1e-5
    )


@pytest.mark.parametrize("axis", range(3))
def test_frames_turned_over_do_not_choose_the_branch(axis):
    """Two thirds of the file are turned over by half a turn, the rest is as it should be."""
    right = smooth(np.random.default_rng(5), 90) + 4.0 * np.pi
    q = quaternion_from_euler("ZXY", right)
    over = q.copy()
    over[:60] = multiply(q[:60], exponential(np.pi * np.eye(3)[axis])[None])
    own = np.unwrap(euler_from_quaternion("ZXY", over), axis=0)
    own += right[-1] - own[-1] - wrap(right[-1] - own[-1])
    own[60:] = right[60:]
    np.testing.assert_allclose(continuous_euler_angles("ZXY", q, own, None, None), right, atol=1e-6)


def test_a_turn_over_the_pole_does_not_leave_the_file_behind():
    """The file goes round the pole, what is written as well could go over it and stay there."""
    s = np.radians(np.linspace(40.0, 140.0, 60))
    straight = quaternion_from_euler("ZXY", np.stack([0 * s, s, 0 * s], axis=1))
    tilted, q = (
        multiply(exponential(np.radians([[0.0, tilt, 0.0]])), straight) for tilt in (6.0, 0.5)
    )
    own = np.unwrap(euler_from_quaternion("ZXY", tilted), axis=0)
    assert own[-1, 1] < np.pi / 2  # though the rotations go on
    found = continuous_euler_angles("ZXY", q, own, None, None)
    away = np.abs(np.cos(s)) > 0.3
    assert np.degrees(np.abs(found - own)[away]).max() < 30.0
    assert not euler_jump_rows_and_channels(found, None, None)


def test_a_file_that_wraps_is_written_without_jumps_on_the_turn_of_most_frames():
    t = np.linspace(0.0, 1.5 * np.pi, 100)
    angles = np.stack([t, 0.3 * np.sin(t), 0.2 * t], axis=1)
    own = angles + 2 * np.pi * np.stack([-1.0 * (t > np.pi), 0 * t, 2 * (t > np.pi / 2)], axis=1)
    q = multiply(exponential(np.full((1, 3), 1e-3)), quaternion_from_euler("ZYX", angles))
    found = continuous_euler_angles("ZYX", q, own, None, None)
    assert not euler_jump_rows_and_channels(found, None, None)
    turns = np.array([0.0, 0.0, 4 * np.pi])
    np.testing.assert_allclose(found, angles + turns, atol=0.1)


def test_in_gimbal_lock_the_third_angle_is_the_file_s():
    own = np.stack([np.linspace(0.0, 2.0, 9), np.full(9, np.pi / 2), np.linspace(3.0, 4.0, 9)], 1)
    q = quaternion_from_euler("ZXY", own)
    for before in (None, own[0]):
        found = continuous_euler_angles("ZXY", q, own, before, None)
        np.testing.assert_allclose(found, own, atol=1e-6)
