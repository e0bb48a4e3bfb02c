"""Limbs that stand still to the last digit are named, and what moves is not."""

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection.frozen_frames import frozen_spans
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.notes import FROZEN

WALK = read_bvh(ASSETS / "walk.bvh").motion


def frozen(start, stop, *words, motion=WALK):
    """The motion in which joints with one of the words hold what they have in frame `start`."""
    rotations = motion.rotations.copy()
    for j, name in enumerate(motion.skeleton.names):
        if any(word in name for word in words):
            rotations[start:stop, j] = rotations[start, j]
    return motion.with_rotations(rotations)


def spans(motion):
    return frozen_spans(motion, analyse(motion).chains)


@pytest.mark.parametrize("name", ["walk", "dance", "basketball", "kick", "walk_injected"])
def test_what_moves_is_not_frozen(name):
    assert spans(read_bvh(ASSETS / f"{name}.bvh").motion) == ()


def test_a_frozen_arm_is_named_with_its_frames():
    motion = frozen(100, 160, "LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand")
    assert spans(motion) == (("left arm", 100, 160),)
    (said,) = (str(n) for n in analyse(motion).notes if n.kind == FROZEN)
    assert "one span of frames" in said


def test_a_forearm_alone_and_a_short_stop_are_no_frozen_limb():
    assert spans(frozen(100, 160, "LeftForeArm")) == ()
    assert spans(frozen(100, 112, "Left")) == ()


def test_a_pose_that_is_held_at_an_end_is_none():
    every = WALK.skeleton.names
    assert spans(frozen(0, 60, *every)) == ()
    end = WALK.frames
    assert spans(frozen(end - 60, end, *every)) == ()
    assert len(spans(frozen(100, 160, *every))) == 4


def test_a_limb_whose_poses_are_held_again_and_again_is_drawn_by_hand_and_not_told():
    motion = WALK
    for start in range(10, 340, 50):
        motion = frozen(start, start + 35, "LeftShoulder", "LeftArm", "LeftForeArm", motion=motion)
    assert spans(motion) == ()


def test_a_limb_that_stands_still_for_most_of_the_clip_is_told():
    limbs = {limb for limb, start, stop in spans(frozen(10, 340, "Left"))}
    assert limbs == {"left arm", "left leg"}


def test_two_frames_are_too_few():
    two = WALK.sliced(0, 2)
    assert spans(two.with_rotations(np.repeat(two.rotations[:1], 2, axis=0))) == ()
