"""Evidence of joints: each measure sees what it is for, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.quality.joint import (
    SLIDE_SPEED,
    ankle_and_toe_joints,
    joint_accelerations,
    joint_quality,
)
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.smpl.skeleton import metres_per_unit
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle

CLIP = read_bvh(ASSETS / "dance.bvh")
NAMES = CLIP.motion.skeleton.names
ARM = NAMES.index("LeftForeArm")


def looked_at(motion, clip=CLIP):
    changed = replace(clip)
    changed.__dict__["motion"] = motion
    return joint_quality(changed, forward_kinematics(motion)[1])


def turned(angles):
    """The clip with one joint turned by angles, radians, (frames,), on top of its rotation."""
    rotations = CLIP.motion.rotations.copy()
    extra = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), angles)
    rotations[:, ARM] = multiply(rotations[:, ARM], extra)
    return CLIP.motion.with_rotations(rotations)


def test_jitter_is_that_of_the_joint_and_has_the_size_of_what_was_put_in():
    rng = np.random.default_rng(7)
    before = looked_at(CLIP.motion).usual_jitter
    sigma = 2.0  # degrees; the third difference of white noise has sqrt(20) of it
    after = looked_at(turned(np.radians(rng.normal(0.0, sigma, CLIP.motion.frames)))).usual_jitter
    others = np.arange(len(NAMES)) != ARM
    np.testing.assert_array_equal(before[others], after[others])
    assert after[ARM] == pytest.approx(0.6745 * np.sqrt(20.0) * sigma, rel=0.12)


def test_a_level_shift_is_no_jitter():
    angles = np.zeros(CLIP.motion.frames)
    angles[200:220] = np.radians(90.0)
    before, after = looked_at(CLIP.motion), looked_at(turned(angles))
    assert after.usual_jitter[ARM] == pytest.approx(before.usual_jitter[ARM], rel=0.05)
    assert after.top_speed[ARM] > 80.0 * CLIP.motion.fps


def test_a_full_turn_in_the_numbers_is_a_jump_and_a_turned_joint_is_none():
    text = (ASSETS / "dance.bvh").read_text().split("\n")
    start = next(k for k, line in enumerate(text) if line.startswith("Frame Time")) + 1
    column = CLIP.channels[ARM].rotation[0]
    for line in range(start + 100, start + 150):
        numbers = text[line].split()
        numbers[column] = str(float(numbers[column]) + 360.0)
        text[line] = " ".join(numbers)
    jumping = parse_bvh("\n".join(text).encode(), CLIP.path)
    found = joint_quality(jumping, forward_kinematics(jumping.motion)[1])
    plain = looked_at(CLIP.motion)
    assert found.jumps[ARM] == plain.jumps[ARM] + 2
    assert np.flatnonzero(np.nan_to_num(found.excess[:, ARM]) > 90.0).tolist() == [100, 150]
    np.testing.assert_allclose(found.speed[1:], plain.speed[1:], atol=1e-4)


def test_a_foot_slides_only_on_the_ground():
    feet = ankle_and_toe_joints(CLIP.motion.skeleton)
    assert {NAMES[j] for j in feet} == {"LeftFoot", "RightFoot", "LeftToeBase", "RightToeBase"}
    frames = CLIP.motion.frames
    places = np.zeros((frames, len(NAMES), 3))
    foot = feet[0]
    unit = 0.056444
    places[:, foot, 0] = np.arange(frames) * (0.6 * CLIP.motion.frame_time / unit)  # 0.6 m/s
    places[frames // 2 :, foot, 1] = 1.0  # 5.6 cm up: in the air
    found = joint_quality(CLIP, places)
    assert found.slide[2, foot] == pytest.approx(0.6, rel=1e-6)
    assert found.slide[2, foot] > SLIDE_SPEED
    assert np.isnan(found.slide[frames // 2 :, foot]).all()
    assert found.slides[foot] == pytest.approx(50.0, abs=1.0)
    assert np.isnan(found.slides[ARM])


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_the_shortest_clips(frames):
    short = replace(CLIP, values=CLIP.values[:frames])
    short.__dict__.pop("motion", None)
    found = joint_quality(short, forward_kinematics(short.motion)[1])
    assert (found.usual_jitter == 0.0).all()
    assert np.isfinite(found.top_speed).all()


def test_the_acceleration_is_in_metres_per_second_squared_at_25_hz(walk):
    motion = walk.motion.sliced(1, walk.motion.frames)
    time = motion.frame_time * np.arange(motion.frames)
    metre = 1.0 / metres_per_unit(motion.skeleton)
    places = np.zeros((motion.frames, 1, 3))
    places[:, 0, 1] = metre * 0.5 * 9.81 * time**2
    found = joint_accelerations(motion, places)
    step = round(0.04 * motion.fps)
    np.testing.assert_allclose(found[step:-step], 9.81, rtol=1e-6)
    assert np.isnan(found[:step]).all()
    assert np.isnan(found[-step:]).all()
    assert np.isnan(joint_accelerations(motion.sliced(0, step), places[:step])).all()
