"""The state space and the tracker: what holds whatever the gains, the clip and the sign."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import twistcore as tc
from tests.messages import names_in_one_line
from twistcore.errors import TwistError
from twistcore.quamo import Gains, HandGains, Stepper, UnstableGainsError, check_stability, track
from twistcore.quamo.state_space import (
    FIRST_ORDER,
    next_quaternion,
    next_translation,
    tracker_reference_rotation_step,
)
from twistcore.quamo.tracker import LOST_AFTER, describe_joint_resets
from twistcore.skeleton.rotation import (
    exponential,
    geodesic_angle,
    logarithm,
    multiply,
    normalise,
    quaternion_from_axis_angle,
)
from twistcore.study.quamo.representations import (
    REPRESENTATIONS,
    has_root_discontinuity,
    integration_errors_exact_first_order,
    rotation_coordinates,
    rotations_from_coordinates,
    track_coordinates,
)

DT = 1.0 / 120.0
Z = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def reference(dirty_walk):
    motion = dirty_walk.motion.sliced(1, dirty_walk.motion.frames)
    return motion.rotations, motion.positions[:, 0]


@given(st.lists(st.floats(-4.0, 4.0), min_size=3, max_size=3))
def test_exponential_is_scipys_and_logarithm_undoes_it(vector):
    q = exponential(np.array(vector))
    theirs = Rotation.from_rotvec(vector).as_quat(scalar_first=True)
    assert abs(abs(float(q @ theirs)) - 1.0) < 1e-12
    assert geodesic_angle(exponential(logarithm(q)), q) < 1e-7


def test_one_step_by_hand():
    """Half a turn of Eq. 5 worked out on paper for a rotation about z."""
    turn = quaternion_from_axis_angle(Z, 0.2)
    tracker = Stepper(HandGains(Gains(kp=100.0, kd=5.0, root_kp=10.0, root_kd=2.0)))
    tracker.step([[1.0, 0.0, 0.0, 0.0]], [0.0, 0.0, 0.0], 0.1)
    step = tracker.step([turn], [1.0, 0.0, 0.0], 0.1)
    omega = 0.1 * 100.0 * np.sin(0.1)
    assert step.state.omega[0] == pytest.approx([0.0, 0.0, omega])
    assert step.state.q[0] == pytest.approx(quaternion_from_axis_angle(Z, 0.1 * omega))
    assert step.state.v == pytest.approx([1.0, 0.0, 0.0])
    assert step.state.r == pytest.approx([0.1, 0.0, 0.0])
    second = tracker.step([turn], [1.0, 0.0, 0.0], 0.1)
    error = np.sin(0.1 - 0.05 * omega)
    assert second.state.omega[0, 2] == pytest.approx(omega + 0.1 * (100.0 * error - 5.0 * omega))


def test_acceleration_term_starts_in_the_second_step_and_is_scaled_to_the_rate():
    def omega_after(frames, dt):
        tracker = Stepper(HandGains(Gains(kp=0.0, kd=1e-9, ka=100.0)))
        for frame in range(frames):
            angle = 0.01 * frame**2
            step = tracker.step([quaternion_from_axis_angle(Z, angle)], np.zeros(3), dt)
        return step.state.omega[0, 2]

    assert omega_after(2, 0.04) == 0.0
    # δ grows from sin(0.005) to sin(0.015).
    expected = 0.04 * 100.0 * (np.sin(0.015) - np.sin(0.005))
    assert omega_after(3, 0.04) == pytest.approx(expected)
    assert omega_after(3, 0.01) == pytest.approx(expected * 0.25 * 16.0)


def seconds_behind(dt, controller):
    """Of a joint that turns steadily at 0.5 rad/s and of a root that moves steadily at 1 m/s."""
    time = dt * np.arange(int(10.0 / dt))
    q = quaternion_from_axis_angle(Z, 0.5 * time)[:, None]
    r = time[:, None] * np.array([1.0, 0.0, 0.0])
    found = track(q, r, dt, controller)
    return geodesic_angle(found.q[-1], q[-1]).item() / 0.5, (r[-1] - found.r[-1])[0]


@pytest.mark.parametrize("dt", [0.04, 1.0 / 120.0])
def test_a_steady_turn_is_followed_two_kd_over_kp_less_a_frame_behind(dt):
    joint, root = seconds_behind(dt, HandGains(Gains(kp=600.0, kd=15.0)))
    assert joint == pytest.approx(2.0 * 15.0 / 600.0 - dt, rel=1e-3)
    assert root == pytest.approx(12.0 / 200.0 - dt, rel=1e-3)


@pytest.mark.parametrize(
    ("rate", "joint_ms", "root_ms"), [(25, 10.0, 20.0), (60, 12.9, 18.8), (120, 14.0, 18.4)]
)
def test_gains_of_hands_follow_the_rate_so_that_the_lag_stays_short(rate, joint_ms, root_ms):
    joint, root = seconds_behind(1.0 / rate, HandGains())
    assert 1000.0 * joint == pytest.approx(joint_ms, abs=0.1)
    assert 1000.0 * root == pytest.approx(root_ms, abs=0.1)


@pytest.mark.parametrize("rate", [0.5, 5, 10, 24, 25, 30, 60, 120, 240, 1000])
def test_gains_of_hands_are_stable_at_every_rate(rate):
    gains = Gains.by_hand(1.0 / rate)
    check_stability(gains, 1.0 / rate)
    assert 2.0 * gains.kd / gains.kp - 1.0 / rate < 0.015
    still = np.tile(quaternion_from_axis_angle(Z, 1.0), (200, 1))[:, None]
    still[0] = [1.0, 0.0, 0.0, 0.0]
    found = track(still, np.zeros((200, 3)), 1.0 / rate, HandGains())
    assert geodesic_angle(found.q[-1], still[-1]).item() < 0.02


def test_gains_of_hands_at_25_hz_are_the_specified_ones():
    assert vars(Gains.by_hand(0.04)) == vars(Gains())


def test_the_angular_velocity_is_bounded():
    tracker = Stepper(HandGains(Gains(clip=2.0)))
    tracker.step([[1.0, 0.0, 0.0, 0.0]], np.zeros(3), 0.04)
    step = tracker.step([quaternion_from_axis_angle(Z, 1.0)], np.zeros(3), 0.04)
    assert step.state.omega[0].tolist() == [0.0, 0.0, 2.0]


def test_a_still_reference_is_reached_from_anywhere():
    target = normalise(np.random.default_rng(1).standard_normal((400, 24, 4)))[:1].repeat(400, 0)
    target[0] = normalise(np.random.default_rng(2).standard_normal((24, 4)))
    place = np.ones((400, 3))
    place[0] = 0.0
    found = track(target, place, 0.04, HandGains())
    assert np.degrees(geodesic_angle(found.q[-1], target[-1])).max() < 1e-4
    assert found.r[-1] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.thorough
def test_unit_norm_over_10000_frames():
    rng = np.random.default_rng(0)
    walk = np.cumsum(0.1 * rng.standard_normal((10_000, 24, 3)), axis=0)
    found = track(exponential(walk), np.zeros((10_000, 3)), DT, HandGains(Gains(ka=300.0)))
    assert np.abs(np.linalg.norm(found.q, axis=-1) - 1.0).max() < 1e-12


def test_the_sign_of_a_reference_changes_no_bit(reference):
    q, r = reference
    flipped = np.where(np.random.default_rng(0).random((*q.shape[:2], 1)) < 0.5, -q, q)
    a, b = (track(x, r, DT, HandGains(Gains(ka=100.0))) for x in (q, flipped))
    assert (a.q == b.q).all()
    assert (a.r == b.r).all()


def test_a_prefix_and_single_steps_give_the_same_bits(reference):
    q, r = reference
    whole = track(q, r, DT, HandGains(Gains(ka=100.0)))
    part = track(q[:150], r[:150], DT, HandGains(Gains(ka=100.0)))
    assert (part.q == whole.q[:150]).all()
    assert (part.r == whole.r[:150]).all()
    tracker = Stepper(HandGains(Gains(ka=100.0)))
    for frame in range(150):
        step = tracker.step(q[frame], r[frame], DT)
        assert (step.state.q == whole.q[frame]).all()
        assert (step.state.r == whole.r[frame]).all()


@pytest.mark.parametrize(
    ("gains", "dt", "what"),
    [
        (Gains(kd=60.0), 0.04, "rotation"),
        (Gains(kd=0.0), 0.04, "rotation"),
        (Gains(kp=6000.0, kd=10.0), 0.04, "rotation"),
        (Gains(kp=-1.0), 0.04, "rotation"),
        (Gains(root_kp=3000.0, root_kd=10.0), 0.04, "translation"),
        (Gains(kp=np.nan), 0.04, "rotation"),
        (Gains(), 0.0, "frame time"),
        (Gains(ka=np.inf), 0.04, "κA"),
        (Gains(clip=0.0), 0.04, "bound"),
    ],
)
def test_unstable_gains_are_refused_in_one_sentence(gains, dt, what):
    with pytest.raises(UnstableGainsError, match=what) as caught:
        check_stability(gains, dt)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("inside", [True, False])
def test_the_bound_of_stability_is_where_the_step_diverges(inside):
    kd, dt = 10.0, 0.04
    kp = 2.0 * (4.0 - 2.0 * kd * dt) / dt**2 * (0.98 if inside else 1.02)
    if inside:
        check_stability(Gains(kp=kp, kd=kd), dt)
    q, omega = quaternion_from_axis_angle(Z, 1e-4), np.zeros(3)
    still = np.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(300):
        omega = omega + dt * (kp * tracker_reference_rotation_step(still, q) - kd * omega)
        q = next_quaternion(q, omega, dt)
    assert (geodesic_angle(q, still) < 1e-4) == inside


def test_a_joint_that_lost_the_input_is_set_back_and_flagged():
    lost = exponential(np.array([0.0, 0.0, 3.0]))
    q_hat = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (40, 2, 1))
    q_hat[10:, 1] = lost
    gains = Gains(kp=1.0, kd=15.0)  # far too weak to come there by itself
    found = track(q_hat, np.zeros((40, 3)), DT, HandGains(gains))
    frame = 10 + LOST_AFTER - 1
    assert np.argwhere(found.snapped).tolist() == [[frame, 1]]
    assert np.abs(found.q[frame, 1] @ lost) == pytest.approx(1.0)
    assert geodesic_angle(found.q[frame - 1, 1], lost) > np.pi / 2
    [sentence] = describe_joint_resets(found.snapped, ("a", "b"))
    assert names_in_one_line(sentence, "b ", str(frame))


@pytest.mark.parametrize("broken", [np.nan, np.inf, 0.0])
def test_numbers_that_are_no_pose_are_refused(broken):
    with pytest.raises(TwistError, match="expected"):
        Stepper(HandGains()).step(np.full((2, 4), broken), np.zeros(3), DT)


def test_parts_add_up_to_the_change_of_velocity(reference):
    q, r = reference
    steps = track(q[:40], r[:40], DT, HandGains(Gains(ka=100.0)), keep_steps=True).steps
    assert steps[0].parts is None
    for before, after in itertools.pairwise(steps):
        p = after.parts
        total = p.proportional + p.damping + p.bias + p.acceleration
        inside = np.abs(after.state.omega) < 25.0
        change = after.state.omega - before.state.omega
        assert change[inside] == pytest.approx(DT * total[inside])


def test_exact_integration_has_no_drift_and_first_order_has():
    for speed in (np.pi, 2 * np.pi, 12.0):
        exact, first_order = integration_errors_exact_first_order(speed, 0.04)
        assert exact < 1e-10
        # A tangent step of length x = ωΔt/2 turns by 2·atan(x) and not by 2x.
        x = 0.5 * speed * 0.04
        assert first_order == pytest.approx(abs(100 * (2 * x - 2 * np.arctan(x))), rel=1e-9)


def test_first_order_stays_close_for_small_steps(reference):
    q, r = reference
    a = track(q, r, DT, HandGains())
    b = track(q, r, DT, HandGains(), integration=FIRST_ORDER)
    assert np.degrees(geodesic_angle(a.q, b.q)).mean() < 0.05
    assert (a.q != b.q).any()


def test_the_place_arrives():
    r, v = np.zeros(3), np.zeros(3)
    one = next_translation(r, v, np.ones(3), Gains(), 0.04)[0]
    assert one[0] == pytest.approx(0.04**2 * 200.0)
    for _ in range(200):
        r, v = next_translation(r, v, np.ones(3), Gains(), 0.04)
    assert r == pytest.approx(np.ones(3), abs=1e-6)


@pytest.mark.parametrize("rep", REPRESENTATIONS, ids=lambda r: r.name)
def test_coordinates_are_of_the_same_rotation(rep, walk):
    q = walk.motion.rotations[::20]
    assert (
        np.degrees(
            geodesic_angle(rotations_from_coordinates(rotation_coordinates(q, rep), rep), q)
        ).max()
        < 1e-5
    )


def test_only_raw_coordinates_spin_at_a_full_turn():
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    q = quaternion_from_axis_angle(np.array([0.0, 1.0, 0.0]), angle)[:, None]
    assert has_root_discontinuity(q)
    assert not has_root_discontinuity(q[:60])
    worst = {
        rep.name: geodesic_angle(track_coordinates(q, 0.04, rep, Gains()), q).max()
        for rep in REPRESENTATIONS
    }
    ours = geodesic_angle(track(q, np.zeros((200, 3)), 0.04, HandGains()).q, q).max()
    assert ours < 0.2
    assert worst["axis-angle, raw"] > 1.0
    assert worst["Euler ZXY, raw"] > 1.0
    assert worst["Euler ZXY, wrapped"] < 0.2


def test_tracking_smears_a_level_shift_over_frames(walk):
    """Why detection comes first: an offset that sets in in one frame is spread over many."""
    joint = walk.motion.skeleton.index("LeftArm")
    q = walk.motion.rotations[1:, [joint]].copy()
    q[100:200, 0] = multiply(q[100:200, 0], quaternion_from_axis_angle(np.array([1.0, 0, 0]), 0.7))
    clean = track(walk.motion.rotations[1:, [joint]], np.zeros((len(q), 3)), DT, HandGains()).q
    found = track(q, np.zeros((len(q), 3)), DT, HandGains()).q
    shift = geodesic_angle(found[:, 0], clean[:, 0])
    assert np.abs(np.diff(shift)).max() < 0.2 * 0.7
    assert shift[160] > 0.6


def test_a_stream_gives_the_numbers_of_track(reference):
    q, r = reference
    tracker = tc.Tracker(fps=120)
    streamed = [tracker.step((q_hat, r_hat)) for q_hat, r_hat in zip(q, r, strict=True)]
    found = track(q, r, DT, HandGains())
    assert np.abs(np.array([rotations for rotations, _ in streamed]) - found.q).max() < 1e-12
    assert np.abs(np.array([position for _, position in streamed]) - found.r).max() < 1e-12


def test_a_stream_uses_the_gains_of_its_controller(reference):
    gains = Gains(kp=900.0, kd=40.0)
    tracker = tc.Tracker(120, HandGains(gains))
    for q_hat, r_hat in zip(*reference, strict=True):
        last, _ = tracker.step((q_hat, r_hat))
    assert np.abs(last - track(*reference, DT, HandGains(gains)).q[-1]).max() < 1e-12


@pytest.mark.parametrize("fps", [0, -60, np.nan, np.inf])
def test_a_stream_needs_a_rate(fps):
    with pytest.raises(TwistError):
        tc.Tracker(fps)
