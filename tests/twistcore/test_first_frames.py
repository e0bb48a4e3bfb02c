"""Blends out of and into a rest pose: recognised, left out, and nothing else taken for one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tiers import parametrize
from twistcore import detect
from twistcore.detection.cuts import (
    count_leading_rest_frames,
    count_trailing_rest_frames,
    find_cuts,
    ignored_frames_notes,
)
from twistcore.detection.leading_blend import count_held_frames, leading_blend_end
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import (
    conjugate,
    euler_from_quaternion,
    exponential,
    logarithm,
    multiply,
    quaternion_from_euler,
)
from twistcore.synthesis import InjectedError, inject
from twistcore.tuning import prepare_clip_tuning

COURSES = {"even": lambda x: x, "eased": lambda x: x * x * (3.0 - 2.0 * x)}


@pytest.fixture(scope="module")
def capture(walk):
    """A walk without its T-pose."""
    return walk.motion.sliced(count_leading_rest_frames(walk.motion), walk.motion.frames)


def blended(motion, length, course="even", channels=True, moving=True):
    """The first frames blended out of a rest pose: on the sphere, or by Euler angles."""
    q = motion.rotations[:length] if moving else motion.rotations[:1].repeat(length, axis=0)
    s = COURSES[course](np.arange(length) / length)[:, None, None]
    if channels:
        angles = np.unwrap(euler_from_quaternion("ZYX", q), axis=0)
        start = quaternion_from_euler("ZYX", s * angles)
    else:
        start = exponential(s * logarithm(np.where(q[..., :1] < 0.0, -q, q)))
    rest = motion.sliced(length if moving else 0, motion.frames)
    positions = np.concatenate([motion.positions[:length], rest.positions])
    return replace(rest, rotations=np.concatenate([start, rest.rotations]), positions=positions)


def backwards(motion):
    return replace(motion, rotations=motion.rotations[::-1], positions=motion.positions[::-1])


@pytest.mark.parametrize("moving", [True, False])
@pytest.mark.parametrize("channels", [True, False])
@parametrize("course", COURSES, quick=4)
@parametrize("length", [8, 2, 3, 5, 10, 15, 20], quick=2)
def test_a_blend_is_left_out_and_little_else(capture, length, course, channels, moving):
    clip = blended(capture, length, course, channels, moving)
    assert length - 1 <= count_leading_rest_frames(clip) <= length + 4
    assert find_cuts(clip)[1 : count_leading_rest_frames(clip) + 1].all()
    assert all(i.start > length for i in detect(clip))


def test_what_follows_a_blend_is_found_as_without_it(capture):
    clip = blended(capture, 10)
    chains = detect(clip).chains
    chain = next(c for c in chains if c.label == "Left ForeArm")
    offset = np.full(20, np.radians(30.0))

    error = InjectedError(chain.name, 40, 60, offset)
    for motion in (clip, capture):
        (found,) = detect(inject(motion, [chain], [error]))
        assert (found.start, found.stop) == (40, 60)


def test_a_blend_at_30_hz(capture):
    slow = replace(capture.at(np.arange(0, capture.frames, 4)), frame_time=4 * capture.frame_time)
    assert count_leading_rest_frames(slow) == 0
    for length in (2, 3, 4, 6):
        assert length <= count_leading_rest_frames(blended(slow, length)) <= length + 1


@pytest.mark.parametrize("length", [1, 4, 10])
def test_a_pose_held_before_it_goes_too(capture, length):
    clip = blended(capture, length)
    held = clip.at(np.concatenate([np.zeros(30, dtype=int), np.arange(clip.frames)]))
    assert count_held_frames(held.rotations) == 30
    assert 30 + length <= count_leading_rest_frames(held) <= 30 + length + 4


def test_a_blend_into_a_rest_pose(capture):
    clip = backwards(blended(backwards(capture), 10))
    assert 10 <= count_trailing_rest_frames(clip) <= 14
    assert count_leading_rest_frames(clip) == 0
    last = clip.frames - count_trailing_rest_frames(clip)
    np.testing.assert_array_equal(np.flatnonzero(find_cuts(clip)), np.arange(last, clip.frames))
    assert not detect(clip).intervals


def test_natural_starts_are_no_blends(capture):
    for q in (capture.rotations, capture.rotations[::-1]):
        for first in range(0, len(q) - 80, 3):
            assert leading_blend_end(q[first:], capture.fps) == 0, first


def test_every_chain_wrong_at_once_is_no_blend(capture):

    chains = find_chains(capture)
    for stop, ramp in ((5, 0), (12, 0), (12, 4), (30, 6)):
        offset = np.full(stop, 0.8)
        offset[stop - ramp :] *= 1.0 - np.arange(1, ramp + 1) / (ramp + 1)
        errors = [InjectedError(c.name, 0, stop, offset) for c in chains]
        assert leading_blend_end(inject(capture, chains, errors).rotations, capture.fps) == 0


def test_a_still_clip_and_a_short_one(capture):
    still = capture.at(np.zeros(60, dtype=int))
    assert count_held_frames(still.rotations) == 59
    assert (count_leading_rest_frames(still), count_trailing_rest_frames(still)) == (0, 0)
    for frames in range(1, 12):
        assert count_leading_rest_frames(capture.sliced(0, frames)) == 0
        assert not ignored_frames_notes(capture.sliced(0, frames))


def test_it_is_said_and_left_out_of_tuning(walk, capture):
    clip = blended(capture, 10)
    first = count_leading_rest_frames(clip)
    (note,) = ignored_frames_notes(clip)
    assert note.startswith(f"Frames 0–{first - 1} ")
    assert prepare_clip_tuning(clip, "clip").clean.motion.frames == clip.frames - first
    assert not ignored_frames_notes(walk.motion)  # a T-pose in frame 0 alone
    assert prepare_clip_tuning(walk.motion, "walk").clean.motion.frames == walk.motion.frames


def test_the_sphere_and_a_sign_do_not_matter(capture):
    clip = blended(capture, 10, channels=False)
    signs = np.where(np.arange(clip.frames) % 3 == 1, -1.0, 1.0)[:, None, None]
    turned = multiply(conjugate(clip.rotations[:1]), clip.rotations)
    for q in (clip.rotations * signs, turned):
        assert leading_blend_end(q, clip.fps) == leading_blend_end(clip.rotations, clip.fps)
