"""Both directions of time: no lag, the same whichever way a clip runs, each pass as it is alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.messages import names_in_one_line
from tests.tiers import examples
from twistcore.quamo import Gains, HandGains, check_stability, track, track_both_ways
from twistcore.quamo.both_ways import halfway_rotations
from twistcore.quamo.network import read_network
from twistcore.quamo.state_space import FIRST_ORDER
from twistcore.quamo.track_clip import find_figure_position_joint, track_with_hand_gains
from twistcore.quamo.tracker import (
    LOST_AFTER,
    describe_diverging_tracker_passes,
    describe_joint_resets,
)
from twistcore.quamo.weights import default_gain_network_path
from twistcore.skeleton.rotation import (
    exponential,
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
)

Z = np.array([0.0, 0.0, 1.0])
WAYS = slice(None), slice(None, None, -1)
RATES = st.sampled_from([1.0 / 120.0, 1.0 / 30.0, 0.04])


def jittery(seed, frames, step, joints=3):
    """Rotations that wander by about `step` radians a frame, of either sign, and places."""
    rng = np.random.default_rng(seed)
    q = exponential(step * rng.standard_normal((frames, joints, 3)))
    for t in range(1, frames):
        q[t] = multiply(q[t], q[t - 1])
    sign = np.where(rng.random((frames, joints, 1)) < 0.5, -1.0, 1.0)
    return sign * q, np.cumsum(rng.standard_normal((frames, 3)), axis=0)


def same_rotations(a, b):
    """The largest difference of components, each pair in one hemisphere."""
    return np.minimum(np.abs(a - b).max(axis=-1), np.abs(a + b).max(axis=-1)).max()


@given(st.integers(0, 10**6), st.integers(1, 40), st.floats(0.0, 2.5), RATES)
@settings(max_examples=examples(60), deadline=None)
def test_the_reversed_clip_gives_the_reversed_result(seed, frames, step, dt):
    q, r = jittery(seed, frames, step)
    there = track_both_ways(q, r, dt, HandGains(Gains(kp=500.0, ka=50.0)))
    back = track_both_ways(q[::-1], r[::-1], dt, HandGains(Gains(kp=500.0, ka=50.0)))
    assert same_rotations(there.q, back.q[::-1]) < 1e-12
    assert np.abs(there.r - back.r[::-1]).max() < 1e-12
    assert (there.snapped == back.snapped[::-1]).all()


@given(st.integers(0, 10**6), st.floats(0.0, 2.5))
@settings(max_examples=examples(30), deadline=None)
def test_the_sign_of_a_reference_changes_no_bit(seed, step):
    q, r = jittery(seed, 20, step)
    found, other = (track_both_ways(x, r, 0.04, HandGains()) for x in (q, -q))
    assert (found.q == other.q).all()


@given(st.integers(0, 10**6), RATES, st.sampled_from(["exact", FIRST_ORDER]))
@settings(max_examples=examples(30), deadline=None)
def test_the_two_passes_are_the_causal_tracker_bit_for_bit(seed, dt, integration):
    q, r = jittery(seed, 30, 0.4)
    own = HandGains(Gains.by_hand(dt))
    ahead = track(q, r, dt, own, integration=integration)
    back = track(q[::-1], r[::-1], dt, own, integration=integration)
    both = track_both_ways(q, r, dt, own, integration=integration)
    assert (both.q == halfway_rotations(ahead.q, back.q[::-1])).all()
    assert (both.r == 0.5 * (ahead.r + back.r[::-1])).all()
    assert (both.snapped == (ahead.snapped | back.snapped[::-1])).all()


@given(st.integers(0, 10**6), st.floats(0.0, 1.0))
def test_half_way_lies_between_on_the_shorter_arc_whatever_the_signs(seed, size):
    rng = np.random.default_rng(seed)
    a = normalise(rng.standard_normal((50, 4)))
    b = multiply(exponential(size * 6.0 * rng.standard_normal((50, 3))), a)
    middle = halfway_rotations(a, b)
    apart = geodesic_angle(a, b)
    assert geodesic_angle(a, middle) == pytest.approx(0.5 * apart, abs=1e-7)
    assert geodesic_angle(middle, b) == pytest.approx(0.5 * apart, abs=1e-7)
    assert same_rotations(middle, halfway_rotations(-a, b)) == 0.0
    assert same_rotations(middle, halfway_rotations(b, a)) == 0.0
    assert np.abs(np.linalg.norm(middle, axis=-1) - 1.0).max() < 1e-12


@pytest.mark.parametrize("rate", [25, 60, 120])
def test_what_turns_and_moves_steadily_is_followed_without_lag(rate):
    dt = 1.0 / rate
    time = dt * np.arange(int(8.0 / dt))
    q = quaternion_from_axis_angle(Z, 0.5 * time)[:, None]
    r = time[:, None] * np.array([1.0, 0.0, 0.0])
    middle = len(time) // 2
    causal, both = (f(q, r, dt, HandGains()) for f in (track, track_both_ways))
    assert np.abs(both.r - r)[middle].max() / 1.0 < 1e-6  # of a second
    assert geodesic_angle(both.q, q)[middle, 0] / 0.5 < 1e-6
    assert np.abs(causal.r - r)[middle].max() > 0.015
    assert geodesic_angle(causal.q, q)[middle, 0] / 0.5 > 0.009


def overshoot(run, dt, gains=None):
    """By how much a step of 30° and one of a metre are overshot, as shares."""
    angle = np.where(np.arange(400) < 200, 0.0, np.radians(30.0))
    q = quaternion_from_axis_angle(Z, angle)[:, None]
    r = np.zeros((400, 3))
    r[200:] = 1.0
    found = run(q, r, dt, HandGains(gains))
    turned = 2.0 * np.arctan2(found.q[:, 0, 3], found.q[:, 0, 0])
    return max(turned.max() / angle[-1] - 1.0, -turned.min() / angle[-1]), found.r.max() - 1.0


@pytest.mark.parametrize("dt", [0.04, 1.0 / 120.0])
def test_a_step_is_overshot_by_half_and_by_less_with_the_gains_of_both_ways(dt):
    causal = Gains.by_hand(dt)
    once, place = overshoot(track, dt)
    assert 0.15 < once < 0.20
    assert overshoot(track_both_ways, dt, causal)[0] == pytest.approx(0.5 * once)
    turned, moved = overshoot(track_both_ways, dt)
    assert turned < 0.065
    assert moved < 0.4 * place


def test_gains_of_both_ways_are_stable_at_every_rate_and_the_causal_ones_stay():
    for rate in (0.5, 5, 10, 24, 25, 30, 60, 120, 240, 1000):
        check_stability(Gains.by_hand(1.0 / rate, causal=False), 1.0 / rate)
    assert vars(Gains.by_hand(0.04)) == vars(Gains())
    assert Gains.by_hand(0.04, causal=False).kp == 550.0


def test_a_joint_that_lost_the_input_in_either_pass_is_flagged():
    q = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (60, 2, 1))
    q[30:, 1] = exponential(np.array([0.0, 0.0, 3.0]))
    weak = HandGains(Gains(kp=1.0, kd=15.0))
    found = track_both_ways(q, np.zeros((60, 3)), 1.0 / 120.0, weak)
    expected = [[30 - LOST_AFTER, 1], [30 + LOST_AFTER - 1, 1]]
    assert np.argwhere(found.snapped).tolist() == expected
    (said,) = describe_joint_resets(found.snapped, ("a", "b"), causal=False)
    assert names_in_one_line(said, "b ", "90°")


def test_where_the_passes_lie_far_apart_is_flagged_and_said():
    angle = np.radians(np.where(np.arange(60) < 30, 0.0, 170.0))
    q = quaternion_from_axis_angle(Z, np.stack([angle, 0.2 * angle], axis=1))
    found, one = (f(q, np.zeros((60, 3)), 0.04, HandGains()) for f in (track_both_ways, track))
    ahead, back = (track(q[w], np.zeros((60, 3)), 0.04, HandGains(causal=False)).q[w] for w in WAYS)
    np.testing.assert_array_equal(found.apart, geodesic_angle(ahead, back) > np.pi / 2.0)
    at = np.flatnonzero(found.apart[:, 0])
    assert len(at)
    assert not found.apart[:, 1].any()
    assert one.apart is None
    said = describe_diverging_tracker_passes(found.apart, ("a", "b"))
    assert names_in_one_line(said, "90°", f"frames {at[0]}–{at[-1] + 1}")
    assert describe_diverging_tracker_passes(found.apart[:, 1:], ("b",)) == ""
    assert "3 more" in describe_diverging_tracker_passes(found.apart[:, [0] * 9], "abcdefghi")


def test_steps_are_those_of_each_direction_in_the_order_of_the_frames():
    q, r = jittery(5, 25, 0.2)
    found = track_both_ways(q, r, 0.04, HandGains(Gains(ka=30.0)), keep_steps=True)
    for steps, way in ((found.steps, slice(None)), (found.steps_back, slice(None, None, -1))):
        alone = track(q[way], r[way], 0.04, HandGains(Gains(ka=30.0)), keep_steps=True).steps[way]
        assert len(steps) == len(alone) == 25
        for ours, theirs in zip(steps, alone, strict=True):
            assert (ours.state.q == theirs.state.q).all()
            assert (ours.parts is None) == (theirs.parts is None)
            if ours.parts is not None:
                assert (ours.parts.acceleration == theirs.parts.acceleration).all()
                assert (ours.gains.kp == theirs.gains.kp).all()
    assert found.steps[0].gains is None
    assert found.steps_back[-1].gains is None


def test_learned_gains_go_both_ways_as_well(dirty_walk):
    from twistcore.formats.smpl.skeleton import CMU_UNIT, find_network_joints

    motion = dirty_walk.motion.sliced(1, 301)
    q = find_network_joints(motion.skeleton).reduced(motion.rotations)[::5]
    r = CMU_UNIT * motion.translation(0)[::5]
    network = read_network(default_gain_network_path())
    found = track_both_ways(q, r, 0.04, network.started(q, r), keep_steps=True)
    back = track_both_ways(q[::-1], r[::-1], 0.04, network.started(q[::-1], r[::-1]))
    assert same_rotations(found.q, back.q[::-1]) < 1e-5  # its gains are of single precision
    alone = track(q, r, 0.04, network.started(q, r))
    behind = track(q[::-1], r[::-1], 0.04, network.started(q[::-1], r[::-1]))
    assert same_rotations(found.q, halfway_rotations(alone.q, behind.q[::-1])) < 1e-5
    assert found.steps[5].gains.kp.shape == (24, 3)


def test_the_place_is_that_of_the_topmost_joint_that_moves(dirty_walk):
    motion = dirty_walk.motion.sliced(1, 60)
    hips = motion.translation(0)
    still = np.broadcast_to(hips[:1], hips.shape)
    assert find_figure_position_joint(motion) == 0
    back = motion.skeleton.index("LowerBack")  # 20 of 31 joints hang on it
    below = replace(motion, positioned=(0, back), positions=np.stack([still, hips], axis=1))
    assert find_figure_position_joint(below) == back
    found = track_with_hand_gains(
        below, np.zeros(0, dtype=np.int64), causal=False, place=True
    ).motion
    assert (found.positions[:, 0] == still).all()
    expected = track_both_ways(np.zeros((59, 0, 4)), hips, motion.frame_time, HandGains()).r
    assert np.abs(found.positions[:, 1] - expected).max() < 0.01
    assert np.abs(found.positions[:, 1] - hips).max() > 1e-4
    assert (
        find_figure_position_joint(replace(below, positions=np.stack([still, still], axis=1))) == 0
    )
    assert (
        find_figure_position_joint(replace(motion, positioned=(), positions=np.zeros((59, 0, 3))))
        is None
    )
