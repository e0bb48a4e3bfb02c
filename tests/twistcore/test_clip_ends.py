"""Errors at a clip's ends have one edge: what is sure of them is taken out unasked, at any rate."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore import detect
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle
from twistcore.synthesis import InjectedError, inject

FILE = read_bvh(ASSETS / "basketball.bvh").motion
CLIP = FILE.sliced(1, FILE.frames)
CHAINS = {c.label: c for c in find_chains(CLIP)}


def thinned(step):
    every = np.arange(0, CLIP.frames, step)
    return replace(CLIP.at(every), frame_time=CLIP.frame_time * step)


def level(chain, start, stop, degrees):
    return InjectedError(chain.name, start, stop, np.full(stop - start, np.radians(degrees)))


def found_in(motion, *errors):
    wrong = inject(motion, tuple(CHAINS.values()), errors)
    return detect(wrong, kinds={Kind.COUNTER_TWIST})


@pytest.mark.parametrize("step", [1, 2, 4])
@pytest.mark.parametrize("label", ["Left Arm", "Right ForeArm", "Left Leg"])
def test_twenty_frames_at_either_end_are_taken_out_at_any_rate(label, step):
    motion, chain = thinned(step), CHAINS[label]
    last = motion.frames
    errors = level(chain, 0, 20, 70.0), level(chain, last - 20, last, -40.0)
    applied = [i for i in automatic_corrections(found_in(motion, *errors)) if i.chain == chain.name]
    assert [(i.start, i.stop) for i in applied] == [(0, 20), (last - 20, last)]
    for interval, error in zip(applied, errors, strict=True):
        np.testing.assert_allclose(interval.offset, error.offset, atol=np.radians(3.0))


def test_equal_errors_at_both_ends_are_not_one_between_them():
    motion, chain = thinned(2), CHAINS["Left Arm"]
    last = motion.frames
    errors = level(chain, 0, 8, 70.0), level(chain, last - 7, last, 70.0)
    found = [(i.start, i.stop) for i in found_in(motion, *errors) if i.chain == chain.name]
    assert found == [(0, 8), (last - 7, last)]


@pytest.mark.parametrize("at_end", [False, True])
def test_what_is_no_shorter_than_half_of_the_rest_is_shown_only(at_end):
    motion, chain = CLIP.sliced(0, 60), CHAINS["Left Arm"]
    error = level(chain, 36, 60, 70.0) if at_end else level(chain, 0, 24, 70.0)
    (found,) = (i for i in found_in(motion, error) if i.chain == chain.name)
    assert (found.start, found.stop, found.open) == (error.start, error.stop, True)


def test_an_interval_that_one_joint_alone_shows_is_open():
    rng, chain = np.random.default_rng(0), CHAINS["Left Arm"]
    still = CLIP.at(np.zeros(200, dtype=int))
    rotations = still.rotations.copy()
    axis = chain.axis
    for joint in (chain.parent, chain.child):
        noise = np.radians(0.02) * rng.standard_normal(200)
        turn = quaternion_from_axis_angle(axis, noise)
        rotations[:, joint] = multiply(turn, rotations[:, joint])
    for against, expected in ((3.0, True), (9.0, False)):
        wrong, at = rotations.copy(), slice(80, 90)
        there, back = (quaternion_from_axis_angle(axis, np.radians(a)) for a in (15.0, -against))
        wrong[at, chain.parent] = multiply(wrong[at, chain.parent], there)
        wrong[at, chain.child] = multiply(back, wrong[at, chain.child])
        found = detect(still.with_rotations(wrong), kinds={Kind.COUNTER_TWIST})
        assert [(i.start, i.stop, i.open) for i in found] == [(80, 90, expected)]
        assert len(automatic_corrections(found)) == 1 - expected
