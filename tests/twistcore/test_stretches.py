"""Stretches: a joint that jumps about its own bone and stays turned."""

from dataclasses import replace

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.twistcore.reviews import spun
from twistcore.skeleton.own_axis import own_bone_axis, roll_about_own_bone
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    wrap,
)

WALK = tc.read_clip(ASSETS / "walk.bvh")
FRAMES = WALK.motion.frames


def turned(joint, degrees, start, stop):
    """The walk with a joint turned about its own bone in some frames; its children go along."""
    return spun(joint, start, stop, np.full(stop - start, float(degrees)), WALK.motion)


def stretches(motion):
    return [i for i in tc.detect(motion) if i.kind == tc.Kind.STRETCH]


def swung(axis, along, degrees, roll):
    """A swing of 80° about an axis across the bone, `degrees` from `along`, after a roll."""
    way = np.radians(degrees)
    across = np.cos(way) * along + np.sin(way) * np.cross(axis, along)
    return multiply(
        quaternion_from_axis_angle(across, np.radians(80.0)),
        quaternion_from_axis_angle(axis, np.radians(roll)),
    )


@pytest.mark.parametrize(
    ("joint", "degrees", "start", "stop"),
    [
        ("LeftFoot", 180.0, 200, FRAMES),
        ("RightFoot", -150.0, 0, 90),
        ("LeftFoot", 170.0, 60, 260),
        ("RightHand", 120.0, 100, 180),
    ],
)
def test_a_joint_that_stays_turned_is_listed_from_jump_to_jump(joint, degrees, start, stop):
    (found,) = stretches(turned(joint, degrees, start, stop))
    assert (found.joint, found.start, found.stop, found.open) == (joint, start, stop, True)
    turn = found.evidence["turn_deg"]
    assert abs(wrap(np.radians(turn - degrees))) < np.radians(0.3)
    assert abs(wrap(np.radians(found.evidence["roll_deg"] - degrees))) < np.radians(20.0)
    assert turn == found.evidence["correction_deg"] == pytest.approx(np.degrees(found.residual))
    assert (found.evidence["joint"], len(found.offset)) == (joint, stop - start)
    assert not found.repairable


def test_most_of_the_clip_upside_down_is_still_the_wrong_part():
    (found,) = stretches(turned("LeftFoot", 180.0, 80, FRAMES))
    assert (found.start, found.stop) == (80, FRAMES)
    assert "rest pose" in found.evidence["compared_with"]


@pytest.mark.parametrize("step", [1, 2])
def test_frames_that_are_right_are_left_out_if_the_joint_returns_about_another_axis(step):
    """At 60 frames a second, only the list of joint jumps shows that it returns."""
    motion = WALK.motion.at(np.arange(0, FRAMES, step))
    motion = replace(motion, frame_time=WALK.motion.frame_time * step)
    foot = motion.skeleton.names.index("LeftFoot")
    axis = own_bone_axis(motion.skeleton, foot)
    along = np.cross(axis, [1.0, 0.0, 0.0])
    along /= np.linalg.norm(along)
    wrong, right = swung(axis, along, 0.0, -150.0), swung(axis, along, 100.0, -30.0)
    rotations = motion.rotations.copy()
    edges = [t // step for t in (100, 180, 200, 260)]
    for start, stop, put in zip(edges[:-1], edges[1:], (wrong, right, wrong), strict=True):
        rotations[start:stop, foot] = multiply(rotations[start:stop, foot], put)
    turned = motion.with_rotations(rotations)
    listed = {
        kind: [(i.start, i.stop) for i in tc.detect(turned) if i.kind == kind]
        for kind in (tc.Kind.STRETCH, tc.Kind.LONE_JUMP, tc.Kind.JOINT_JUMP)
    }
    assert listed[tc.Kind.STRETCH] == [(edges[0], edges[1]), (edges[2], edges[3])]
    assert [at for at, _ in listed[tc.Kind.LONE_JUMP]] == [edges[0], edges[3]]
    assert [at for at, _ in listed[tc.Kind.JOINT_JUMP]] == [edges[1], edges[2]]


def test_the_sound_clip_and_smaller_turns_have_none():
    assert not stretches(WALK.motion)
    assert not stretches(turned("LeftFoot", 40.0, 100, 200))


def test_a_spike_is_no_stretch():
    assert not stretches(turned("LeftFoot", 170.0, 100, 102))


def test_fast_motion_at_a_low_rate_is_no_stretch():
    dance = tc.read_clip(ASSETS / "dance.bvh").motion
    for step in (3, 4):
        slow = replace(
            dance,
            rotations=dance.rotations[::step],
            positions=dance.positions[::step],
            frame_time=dance.frame_time * step,
        )
        assert not stretches(slow)


def test_a_joint_without_a_bone_has_no_roll():
    motion = turned("LeftFoot", 180.0, 200, FRAMES)
    toe = motion.skeleton.index("LeftToeBase")
    assert np.isfinite(roll_about_own_bone(motion, toe)).all()
    ends = tuple(end for end in motion.skeleton.ends if end[0] != toe)
    bare = replace(motion, skeleton=replace(motion.skeleton, ends=ends))
    assert np.isnan(roll_about_own_bone(bare, toe)).all()
    assert [i.joint for i in stretches(bare)] == ["LeftFoot"]


def test_held_frames_are_counted_as_written():
    held = turned("LeftFoot", 180.0, 200, FRAMES).at(np.repeat(np.arange(0, FRAMES, 4), 4))
    (found,) = stretches(held)
    assert (found.start, found.stop) == (200, held.frames)


def rolling(motion, joint, degrees):
    """Return a motion in which a joint also rolls naturally to and fro by an angle."""
    at = motion.skeleton.names.index(joint)
    roll = np.radians(degrees) * np.sin(np.linspace(0.0, 3.0 * np.pi, motion.frames))
    rotations = motion.rotations.copy()
    turn = quaternion_from_axis_angle(own_bone_axis(motion.skeleton, at), roll)
    rotations[:, at] = multiply(rotations[:, at], turn)
    return motion.with_rotations(rotations)


@pytest.mark.parametrize(("start", "stop"), [(125, 215), (0, 100), (290, FRAMES)])
def test_a_roll_of_its_own_does_not_hide_that_a_hand_stays_turned(start, stop):
    sound = rolling(WALK.motion, "RightHand", 70.0)
    assert not stretches(sound)
    (found,) = stretches(rolling(turned("RightHand", 100.0, start, stop), "RightHand", 70.0))
    assert (found.joint, found.start, found.stop) == ("RightHand", start, stop)
    assert found.evidence["turn_deg"] == pytest.approx(100.0, abs=2.0)
    assert found.evidence["roll_deg"] == pytest.approx(100.0, abs=2.0)


@pytest.mark.parametrize("step", [2, 4])
def test_at_a_low_rate_a_jump_in_calm_motion_begins_a_stretch(step):
    """The jump is slower than the fastest rotation of a body, but the joint was calm before."""
    motion = turned("LeftFoot", 100.0, 120, 200)
    slow = replace(motion.at(np.arange(0, FRAMES, step)), frame_time=motion.frame_time * step)
    assert not [i for i in tc.detect(slow) if i.kind == tc.Kind.LONE_JUMP]
    (found,) = stretches(slow)
    assert (found.joint, found.start * step, found.stop * step) == ("LeftFoot", 120, 200)
    assert found.evidence["turn_deg"] == pytest.approx(100.0, abs=3.0)


def test_a_second_jump_inside_a_stretch_divides_it():
    """The joint is off by 65° in the middle, which is listed because both jumps are clear."""
    at = WALK.motion.skeleton.names.index("LeftFoot")
    outer, inner = (turned("LeftFoot", degrees, *span) for degrees, span in (
        (175.0, (200, FRAMES)), (65.0, (240, 290)),
    ))  # fmt: skip
    rotations = outer.rotations.copy()
    rotations[240:290, at] = inner.rotations[240:290, at]
    found = stretches(WALK.motion.with_rotations(rotations))
    assert [(i.start, i.stop) for i in found] == [(200, 240), (240, 290), (290, FRAMES)]
    turns = [i.evidence["turn_deg"] for i in found]
    assert turns == pytest.approx([175.0, 65.0, 175.0], abs=3.0)
    made = WALK.motion.with_rotations(rotations)
    accepted = [
        replace(i, offset=np.full(i.frames, np.radians(i.evidence["turn_deg"]))) for i in found
    ]
    fixed = tc.refine(made, accepted).rotations[:, at]
    assert np.degrees(geodesic_angle(fixed, WALK.motion.rotations[:, at])).max() < 3.0


def test_spikes_elsewhere_do_not_hide_a_stretch():
    """At 30 Hz, spikes of 115° are slower than a body may be, and confirm no stretch."""
    slow = replace(WALK.motion.at(np.arange(0, FRAMES, 4)), frame_time=1.0 / 30.0)
    roll = np.zeros(slow.frames)
    roll[25:55] = 130.0
    roll[[5, 12, 62, 69, 76]] += np.array([115.0, -115.0, 115.0, -115.0, 115.0])
    found = stretches(spun("LeftFoot", 0, slow.frames, roll, slow))
    assert [(i.joint, i.start, i.stop) for i in found] == [("LeftFoot", 25, 55)]
