"""The smoothing spline of a whole clip: its gain, its ends, its symmetry, what it leaves alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import make_smoothing_spline

from twistcore.errors import TwistError
from twistcore.quamo.bursts import NoisySpan, smooth_noise_burst_spans
from twistcore.quamo.spline import (
    PLACE_SHARE,
    default_spline_cutoff,
    rotations_smoothed_by_spline,
    smoothed_by_spline,
)
from twistcore.quamo.track_clip import smooth_captures_with_spline
from twistcore.skeleton.rotation import exponential, geodesic_angle, multiply, normalise

DT = 0.04
CUTOFFS = st.floats(0.5, 10.0)


def turning(seed, frames=60):
    """Rotations of two joints that wander."""
    steps = np.random.default_rng(seed).normal(0.0, 0.2, (frames, 2, 3))
    return exponential(np.cumsum(steps, axis=0))


def test_a_sine_of_the_cut_off_keeps_half_and_no_frequency_is_shifted():
    t = np.arange(2000) * DT
    middle = slice(500, 1500)
    for f, cutoff in ((4.0, 4.0), (2.0, 4.0), (1.0, 3.0), (8.0, 4.0)):
        wave = np.sin(2.0 * np.pi * f * t)
        ratio = (np.sin(np.pi * f * DT) / np.sin(np.pi * cutoff * DT)) ** 4
        found = smoothed_by_spline(wave, cutoff, DT)
        np.testing.assert_allclose(found[middle], wave[middle] / (1.0 + ratio), atol=1e-9)


def test_the_usual_cut_off_weighs_roughness_by_the_frame_time():
    assert default_spline_cutoff(DT) == 4.0
    assert default_spline_cutoff(1.0 / 120.0) == pytest.approx(4.0 * 4.8**0.25)
    roughness = [
        dt**4 * (2.0 * np.sin(np.pi * default_spline_cutoff(dt) * dt)) ** -4 for dt in (1e-3, 2e-3)
    ]
    assert roughness[1] / roughness[0] == pytest.approx(2.0, rel=1e-2)


def test_it_is_scipys_smoothing_spline_where_the_rate_is_high():
    t = np.arange(300) / 240.0
    y = np.cumsum(np.random.default_rng(0).normal(size=300)) * 0.1
    cutoff = 2.0
    theirs = make_smoothing_spline(t * 240.0, y, lam=(2.0 * np.sin(np.pi * cutoff / 240.0)) ** -4)
    np.testing.assert_allclose(
        smoothed_by_spline(y, cutoff, 1.0 / 240.0), theirs(t * 240.0), atol=2e-3
    )


@given(st.integers(0, 1000), CUTOFFS, st.integers(3, 40))
def test_a_straight_line_stays_to_its_ends_and_reversing_reverses(seed, cutoff, frames):
    rng = np.random.default_rng(seed)
    line = rng.normal(size=3) + rng.normal(size=3) * np.arange(frames)[:, None]
    np.testing.assert_allclose(smoothed_by_spline(line, cutoff, DT), line, atol=1e-6)
    any_way = rng.normal(size=(frames, 2))
    back = smoothed_by_spline(any_way[::-1], cutoff, DT)[::-1]
    np.testing.assert_allclose(back, smoothed_by_spline(any_way, cutoff, DT), atol=1e-9)


@given(st.integers(0, 1000), CUTOFFS)
def test_rotations_keep_length_and_commute_with_fixed_turns_and_signs(seed, cutoff):
    q = turning(seed)
    found = rotations_smoothed_by_spline(q, cutoff, DT)
    assert np.abs(np.linalg.norm(found, axis=-1) - 1.0).max() < 1e-12
    rng = np.random.default_rng(seed + 1)
    left, right = normalise(rng.normal(size=(2, 4)))
    signs = rng.choice([-1.0, 1.0], q.shape[:-1])[..., None]
    turned = rotations_smoothed_by_spline(signs * multiply(multiply(left, q), right), cutoff, DT)
    assert geodesic_angle(turned, multiply(multiply(left, found), right)).max() < 1e-6


def test_a_steady_turn_through_any_angle_stays():
    axis = np.array([0.36, 0.48, 0.8])
    q = exponential(8.0 * DT * np.arange(400)[:, None] * axis)[:, None]
    found = rotations_smoothed_by_spline(q, 4.0, DT)
    assert geodesic_angle(found, q)[40:-40].max() < 1e-6


@pytest.mark.parametrize("frames", [0, 1, 2])
def test_a_clip_too_short_to_bend_stays(frames):
    values = np.arange(3.0 * frames).reshape(frames, 3)
    np.testing.assert_array_equal(smoothed_by_spline(values, 4.0, DT), values)


@pytest.mark.parametrize("cutoff", [0.0, 4.0, 100.0])
def test_of_what_cannot_bend_no_cut_off_is_asked(cutoff):
    values = np.arange(6.0).reshape(2, 3)
    np.testing.assert_array_equal(smoothed_by_spline(values, cutoff, 0.2), values)


@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0, 5.0, 7.0, 10.0, 24.0])
def test_the_usual_cut_off_is_one_that_every_rate_can_have(rate):
    values = np.random.default_rng(0).normal(size=(9, 3))
    assert (
        np.abs(
            smoothed_by_spline(values, default_spline_cutoff(1.0 / rate), 1.0 / rate) - values
        ).max()
        > 1e-3
    )
    assert default_spline_cutoff(1.0 / rate) <= 0.4 * rate


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 12.5, np.nan, np.inf])
def test_a_cut_off_that_the_rate_cannot_have_is_refused(cutoff):
    with pytest.raises(TwistError, match=r"below 12\.5 Hz"):
        smoothed_by_spline(np.zeros((9, 3)), cutoff, DT)


def test_a_clip_is_changed_in_the_chosen_joints_and_from_the_first_frame_only(walk):
    motion = walk.motion
    joints = np.array([5, 18])
    found = smooth_captures_with_spline(motion, joints, 4.0, place=True, first=1)
    others = np.setdiff1d(np.arange(len(walk.skeleton)), joints)
    np.testing.assert_array_equal(found.rotations[:, others], motion.rotations[:, others])
    np.testing.assert_array_equal(found.rotations[:1], motion.rotations[:1])
    assert (found.rotations[1:, joints] != motion.rotations[1:, joints]).any(axis=(0, 2)).all()
    np.testing.assert_array_equal(
        found.positions[1:, 0],
        smoothed_by_spline(motion.positions[1:, 0], 4.0 * PLACE_SHARE, motion.frame_time),
    )
    np.testing.assert_array_equal(found.positions[:1], motion.positions[:1])
    held = smooth_captures_with_spline(motion, joints, 4.0, first=1)
    np.testing.assert_array_equal(held.positions, motion.positions)


@given(st.integers(0, 1000), CUTOFFS, st.integers(0, 40), st.integers(0, 40))
def test_a_span_alone_is_smoothed_and_continues_the_frames_around_it(seed, cutoff, start, frames):
    span = start, min(start + frames, 60)
    line = np.linspace(-1.0, 3.0, 60)[:, None] * [1.0, -2.0]
    noisy = line.copy()
    noisy[slice(*span)] += np.random.default_rng(seed).normal(size=noisy[slice(*span)].shape)
    found = smoothed_by_spline(noisy, cutoff, DT, span)
    outside = np.ones(60, dtype=bool)
    outside[slice(*span)] = False
    np.testing.assert_array_equal(found[outside], noisy[outside])
    np.testing.assert_allclose(smoothed_by_spline(line, cutoff, DT, span), line, atol=1e-6)


def test_the_spline_of_a_span_minimises_the_sum_with_the_other_frames_fixed():
    y, (start, stop), cutoff = np.random.default_rng(5).normal(size=30), (8, 21), 3.0
    weight = (2.0 * np.sin(np.pi * cutoff * DT)) ** -4

    def cost(x):
        return ((x - y) ** 2).sum() + weight * (np.diff(x, 2) ** 2).sum()

    found = smoothed_by_spline(y, cutoff, DT, (start, stop))
    for frame in range(start, stop):
        for step in (-1e-4, 1e-4):
            other = found.copy()
            other[frame] += step
            assert cost(other) > cost(found)


def test_bursts_keep_to_their_capture_and_to_frames_after_the_rest_pose(walk):
    motion = walk.motion
    found = smooth_noise_burst_spans(motion, [NoisySpan(5, 0, 30)], first=10)
    changed = (found.rotations != motion.rotations).any(axis=-1)
    assert changed[10:30, 5].all()
    changed[10:30, 5] = False
    assert not changed.any()
