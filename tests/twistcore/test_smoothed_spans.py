"""Smoothed spans are found with their joints and frames; sound and resting joints are not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from benchmarks.noise_bursts import at_rate
from benchmarks.smoothed_spans import found_in, measure, spans_in, with_smoothed
from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import smoothed_spans as smoothed_module
from twistcore.detection.smoothed_spans import smoothed_spans
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.notes import SMOOTHED
from twistcore.skeleton.rotation import continuous_quaternion_signs, normalise

DANCE = read_bvh(ASSETS / "dance.bvh").motion
ARM, OTHER = DANCE.skeleton.index("LeftArm"), DANCE.skeleton.index("RightLeg")
START, STOP = 150, 300


def smoothed(*joints, seconds=0.1, motion=DANCE):
    """The motion with joints smoothed by a Gaussian in [START, STOP)."""
    rotations, at = motion.rotations.copy(), slice(START, STOP)
    q = continuous_quaternion_signs(rotations[:, list(joints)])
    even = gaussian_filter1d(q, seconds * motion.fps, axis=0, mode="nearest")
    rotations[at, list(joints)] = normalise(even[at])
    return motion.with_rotations(rotations)


def notes_of(motion):
    return [str(n) for n in analyse(motion).notes if n.kind == SMOOTHED]


@pytest.mark.parametrize("seconds", [0.05, 0.1, 0.2])
def test_a_smoothed_span_is_found_with_its_joint_and_frames(seconds):
    (span,) = smoothed_spans(smoothed(ARM, seconds=seconds))
    assert span.joint == ARM
    assert abs(span.start - START) <= 8
    assert abs(span.stop - STOP) <= 8


@pytest.mark.parametrize("name", ["walk", "dance", "basketball", "kick", "walk_injected"])
@pytest.mark.parametrize("fps", [20.0, 30.0, 120.0])
def test_sound_motion_and_twist_errors_are_not_smooth(name, fps):
    assert smoothed_spans(at_rate(read_bvh(ASSETS / f"{name}.bvh").motion, fps)) == ()


@pytest.mark.parametrize("frames", [18, 20, 24])
def test_a_short_clip_of_a_frame_every_five_seconds_is_no_reason_to_fail(frames):
    slow = replace(DANCE.sliced(40, 40 + frames), frame_time=5.0)
    for start in range(0, frames - 10, 4):
        rotations, stop = slow.rotations.copy(), min(start + 12, frames - 1)
        share = np.linspace(0.0, 1.0, stop - start + 1)[:, None, None]
        even = (1.0 - share) * rotations[start] + share * rotations[stop]
        rotations[start : stop + 1] = normalise(even)
        assert isinstance(smoothed_spans(slow.with_rotations(rotations)), tuple)


def test_jumps_within_a_span_do_not_hide_it():
    motion = smoothed(ARM)
    rotations = motion.rotations.copy()
    rotations[220, ARM] = DANCE.rotations[40, ARM]
    (span,) = smoothed_spans(motion.with_rotations(rotations))
    assert span.joint == ARM


def test_a_joint_that_holds_still_is_not_smoothed():
    rotations = DANCE.rotations.copy()
    rotations[START:STOP, ARM] = rotations[START, ARM]
    assert smoothed_spans(DANCE.with_rotations(rotations)) == ()


def test_a_short_span_and_a_short_clip_show_nothing():
    at, rotations = slice(150, 190), DANCE.rotations.copy()
    rotations[at, ARM] = smoothed(ARM).rotations[at, ARM]
    assert smoothed_spans(DANCE.with_rotations(rotations)) == ()
    assert smoothed_spans(smoothed(ARM).sliced(START, STOP)) == ()
    assert smoothed_spans(DANCE.sliced(0, 2)) == ()


def test_nothing_is_said_of_coarse_notation():
    motion = smoothed(ARM)
    assert smoothed_spans(replace(motion, angle_step=np.radians(1.0))) == ()
    held = motion.at(np.arange(motion.frames) // 4 * 4)
    assert smoothed_spans(held) == ()
    assert found_in(motion).any()


def test_a_note_names_the_joints_and_frames():
    (one,) = notes_of(smoothed(ARM))
    assert "LeftArm" in one
    (both,) = notes_of(smoothed(ARM, OTHER))
    assert "LeftArm" in both
    assert "RightLeg" in both
    assert notes_of(DANCE) == []


def test_the_benchmark_counts_a_span():
    found = measure(DANCE, np.random.default_rng(2), 0.1, everything=True)
    assert found["spans"] == found["seen"] == 1
    assert found["hit"] > 20 * found["extra"]
    assert found["hit"] > 10 * found["missed"]
    assert (
        with_smoothed(DANCE.sliced(0, 60), np.random.default_rng(1), 0.1, everything=True) is None
    )
    assert spans_in(np.array([True, False, True])) == 2


@pytest.mark.parametrize("width", [1, 2, 5, 9, 12, 31, 48, 64])
def test_means_around_a_frame_are_those_of_a_box(width):
    values = np.random.default_rng(3).normal(size=(70, 4))
    for some in (values, values[:, 0]):
        wanted = uniform_filter1d(some, width, axis=0, mode="nearest")
        np.testing.assert_allclose(smoothed_module._mean_around(some, width), wanted, atol=1e-12)


def test_joints_a_few_at_a_time_have_the_spans_of_all_together(monkeypatch):
    motion = smoothed(ARM, OTHER)
    together = smoothed_spans(motion)
    assert {ARM, OTHER} <= {span.joint for span in together}
    monkeypatch.setattr(smoothed_module, "_NUMBERS", 3 * motion.frames)
    assert smoothed_spans(motion) == together
