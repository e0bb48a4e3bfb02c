"""Bursts of noise: found, and nothing corrected in them unasked."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.noise_bursts import at_rate, measure, with_noise
from tests.conftest import ASSETS
from tests.messages import numbers
from tests.twistcore.two_people import two_people
from twistcore.analysis.clip_analysis import REPAIRED, analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import noise_bursts as noise_module
from twistcore.detection.noise_bursts import (
    NoiseBurst,
    joint_noise_and_burst_threshold,
    largest_joint_and_ancestor_noise,
    noise_burst_sentences,
    noise_bursts,
)
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.skeleton.notes import NOISE
from twistcore.skeleton.rotation import multiply, normalise, quaternion_from_axis_angle

WALK = read_bvh(ASSETS / "walk.bvh").motion
ARM, HAND = WALK.skeleton.index("LeftArm"), WALK.skeleton.index("LeftForeArm")
START, STOP = 120, 260


def noisy(*joints, size=0.08, motion=WALK, stop=STOP):
    rng = np.random.default_rng(3)
    rotations, at = motion.rotations.copy(), slice(START, stop)
    noise = rng.normal(0.0, size, (stop - START, len(joints), 4))
    rotations[at, list(joints)] = normalise(rotations[at, list(joints)] + noise)
    return motion.with_rotations(rotations)


@pytest.mark.parametrize("size", [0.05, 0.1])
def test_a_burst_is_found_with_its_joint_and_frames(size):
    (burst,) = noise_bursts(noisy(ARM, size=size))
    assert burst.joint == ARM
    assert abs(burst.start - START) <= 2
    assert abs(burst.stop - STOP) <= 2
    # A component's noise turns the joint by twice as much.
    assert burst.degrees == pytest.approx(np.degrees(2.0 * size), rel=0.3)


@pytest.mark.parametrize("name", ["walk", "dance", "basketball", "walk_injected"])
@pytest.mark.parametrize("fps", [20.0, 30.0, 120.0])
def test_sound_motion_and_twist_errors_are_no_noise(name, fps):
    motion = at_rate(read_bvh(ASSETS / f"{name}.bvh").motion, fps)
    arms_and_legs = {j for c in analyse(motion).chains for j in (c.parent, c.child)}
    assert not largest_joint_and_ancestor_noise(motion, arms_and_legs).any()


def test_noise_of_a_twist_that_the_child_takes_back_is_a_twist_error():
    """What P and C do together is even."""
    angles = np.zeros(WALK.frames)
    angles[START:STOP] = np.random.default_rng(4).normal(0.0, np.radians(9.0), STOP - START)
    chain = next(c for c in analyse(WALK).chains if c.parent == ARM)
    turn, back = (quaternion_from_axis_angle(chain.axis, s * angles) for s in (1.0, -1.0))
    rotations = WALK.rotations.copy()
    rotations[:, ARM] = multiply(rotations[:, ARM], turn)
    for child in WALK.skeleton.children[ARM]:
        rotations[:, child] = multiply(back, rotations[:, child])
    assert noise_bursts(WALK.with_rotations(rotations)) == ()


def test_nothing_is_corrected_in_a_burst_and_the_clip_says_so():
    motion = noisy(ARM, HAND)
    clip = analyse(motion)
    for interval in automatic_corrections(clip.detect(kinds=REPAIRED)):
        assert interval.stop <= START or interval.start >= STOP
    (said,) = (str(n) for n in clip.notes if n.kind == NOISE)
    assert numbers(said)[0] == 2
    assert NOISE not in {n.kind for n in analyse(WALK).notes}


def test_the_benchmark_counts_a_burst():
    found = measure(WALK, np.random.default_rng(1), detect=True)
    assert found["bursts"] == 1
    assert found["hit"] > 20 * found["extra"]
    assert found["hit"] > 20 * found["missed"]
    assert found["inside"] == found["outside"] == 0
    assert with_noise(WALK.sliced(0, 60), np.random.default_rng(1)) is None


@pytest.mark.parametrize("name", ["walk", "basketball"])
def test_frames_that_are_held_are_no_noise(name):
    sound = at_rate(read_bvh(ASSETS / f"{name}.bvh").motion, 15.0)
    held = replace(
        sound,
        rotations=np.repeat(sound.rotations, 2, axis=0),
        positions=np.repeat(sound.positions, 2, axis=0),
        frame_time=sound.frame_time / 2.0,
    )
    assert noise_bursts(held) == noise_bursts(sound) == ()


def test_a_burst_in_held_frames_has_the_frames_of_the_clip():
    noise = at_rate(noisy(ARM), 60.0)
    held = noise.with_rotations(np.repeat(noise.rotations[::2], 2, axis=0)[: noise.frames])
    kept = replace(noise, rotations=noise.rotations[::2], positions=noise.positions[::2])
    (burst,) = noise_bursts(held)
    (once,) = noise_bursts(replace(kept, frame_time=2.0 * noise.frame_time))
    assert (burst.start, burst.stop) == (2 * once.start, 2 * once.stop)
    assert abs(burst.start - START // 2) <= 4
    assert abs(burst.stop - STOP // 2) <= 4


@pytest.mark.parametrize("width", [3, 4, 7, 21])
def test_the_quick_check_misses_no_window_that_is_mostly_true(width):
    rng = np.random.default_rng(width)
    before = width // 2
    for share in np.linspace(0.2, 0.6, 60):
        mask = rng.random(4 * width) < share
        padded = np.pad(mask, (before, width - 1 - before), mode="edge")
        most = np.lib.stride_tricks.sliding_window_view(padded, width).sum(axis=1).max()
        assert most <= width / 2 or noise_module._may_be_mostly_true(mask, width)
    assert not noise_module._may_be_mostly_true(np.zeros(4 * width, dtype=bool), width)


def test_notes_name_the_first_spans_outside_the_chains_and_count_the_others():
    bursts = [NoiseBurst(0, 50 * k, 50 * k + 20, 9.0) for k in range(7)]
    bursts.insert(1, NoiseBurst(1, 10, 30, 12.0))
    joined, *others, last = noise_burst_sentences(0, bursts, ("Head", "Neck"))
    assert "12° in frames 0–30 (Head, Neck)" in joined
    assert ("50–70 (Head)" in others[0], len(others)) == (True, 4)
    assert numbers(last) == [2]
    assert [numbers(said) for said in noise_burst_sentences(3, (), ())] == [[3]]
    assert len(noise_burst_sentences(1, (), ())) == 1


def test_a_quarter_of_a_second_of_noise_is_no_burst():
    short = noisy(ARM, stop=START + 30)
    assert noise_bursts(short) == ()
    curve, least = joint_noise_and_burst_threshold(short, ARM)
    assert curve.max() < least


def test_noise_of_one_person_leaves_another_in_peace():
    motion = parse_bvh(two_people(), "pair.bvh").motion
    clip = analyse(noisy(motion.skeleton.index("LeftArm_B"), motion=motion))
    noisy_chains = {name for name, known in clip.by().witnesses.items() if known.noise.any()}
    second = next(c.person for c in clip.chains if c.name == "LeftArm_B")
    assert noisy_chains == {c.name for c in clip.chains if c.person == second}
    assert 0 < len(noisy_chains) < len(clip.chains)
