"""A first guess for an interval made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis import analyse
from twistcore.bvh import read_bvh
from twistcore.detection import Kind
from twistcore.limb import places
from twistcore.motion import forward_kinematics
from twistcore.refinement import Corrected, refine
from twistcore.review.model import constant
from twistcore.review.proposal import proposed_flip, proposed_interval
from twistcore.rotation import wrap
from twistcore.signals import TwistSignals

FPS = 100.0
LEG = "RightUpLeg-RightFoot"


@pytest.fixture(scope="module")
def analysed_kick():
    """A dancer whose right knee flips six times."""
    return analyse(read_bvh(ASSETS / "kick.bvh"))


def signals(theta_p, strength):
    """Only what a proposal looks at; the rest would be seen if it were used."""
    nothing = np.full(len(theta_p), np.nan)
    return TwistSignals(theta_p, nothing, nothing, nothing, strength, nothing, nothing)


def with_error(frames, start, stop, delta, edges):
    """Twist that drifts, with an error of `delta` radians in [start, stop)."""
    theta_p = 0.002 * np.arange(frames)
    theta_p[start:stop] += delta
    strength = np.full(frames, 0.001)
    for at, size in edges:
        strength[at] = size
    return signals(theta_p, strength)


@pytest.mark.parametrize("frame", [90, 100, 119])
def test_the_strongest_counter_rotations_round_the_frame_are_the_edges(frame):
    edges = [(90, 0.5), (120, 0.5), (85, 0.1), (130, 0.1), (100, 0.05)]
    found = proposed_interval("LeftArm", with_error(300, 90, 120, 0.5, edges), frame, FPS)
    assert (found.chain, found.start, found.stop) == ("LeftArm", 90, 120)
    # The drift of twist that goes on under the error is not taken for a part of it.
    np.testing.assert_allclose(found.offset, np.full(30, 0.5), atol=1e-12)


def test_edges_further_than_half_a_second_are_not_taken():
    edges = [(90, 0.5), (200, 0.5), (120, 0.1)]
    found = proposed_interval("LeftArm", with_error(300, 90, 200, 0.5, edges), 100, FPS)
    assert (found.start, found.stop) == (90, 120)


def test_edges_of_less_than_a_degree_are_none():
    weak = 0.9 * np.radians(1.0)
    quiet = with_error(300, 90, 120, 0.0, [(90, weak), (120, weak)])
    assert proposed_interval("LeftArm", quiet, 100, FPS).frames == 11  # 0.1 s round the frame
    first = proposed_interval("LeftArm", quiet, 0, FPS)
    assert (first.start, first.stop) == (0, 11)
    last = proposed_interval("LeftArm", quiet, 299, FPS)
    assert (last.stop, 299 in range(last.start, last.stop)) == (300, True)


def test_with_one_edge_the_other_lies_a_tenth_of_a_second_away():
    begins = proposed_interval("A", with_error(300, 90, 300, 0.5, [(90, 0.5)]), 95, FPS)
    assert (begins.start, begins.stop) == (90, 101)
    ends = proposed_interval("A", with_error(300, 0, 120, 0.5, [(120, 0.5)]), 115, FPS)
    assert (ends.start, ends.stop) == (109, 120)


def test_a_flip_lies_between_the_nearest_jumps(analysed_kick):
    limb = analysed_kick.flips.limbs[LEG]
    for found in limb.intervals(np.radians(55.0)):
        for frame in (found.start, found.stop - 1):
            flip = proposed_flip(limb, frame)
            assert (flip.kind, flip.start, flip.stop) == (Kind.LIMB_FLIP, found.start, found.stop)
            assert flip.carried == found.carried
            assert abs(wrap(flip.delta - found.delta)) < np.radians(6.0)


def test_a_flip_is_proposed_anywhere(analysed_kick):
    for limb in analysed_kick.flips.limbs.values():
        for frame in range(analysed_kick.motion.frames):
            flip = proposed_flip(limb, frame)
            assert 0 <= flip.start <= frame < flip.stop <= analysed_kick.motion.frames
            assert np.isfinite(flip.offset).all()


def test_the_swivel_after_correction_is_that_of_the_corrected_motion(analysed_kick):
    """Also where a shoulder, in whose frame φ is told, is turned back."""
    arm = next(limb for limb in analysed_kick.limbs if limb.name == "LeftArm-LeftHand")
    flip = replace(constant(arm.name, 40, 90, 2.0), kind=Kind.LIMB_FLIP)
    chosen = [constant("LeftShoulder", 60, 120, 1.0), flip]
    corrected = Corrected(analysed_kick)
    corrected.take(chosen)
    refined = refine(analysed_kick.motion, analysed_kick.chains_and_limbs, chosen)
    swivel = analysed_kick.flips.limbs[arm.name].swivel
    told, true = corrected.swivel(arm), swivel.angle_at(*places(refined, arm))
    bent = swivel.height > 1e-3
    assert np.abs(wrap(told - true))[bent].max() < 1e-9
    assert np.abs(wrap(told - swivel.angle))[60:120].max() > 0.5


def test_a_shoulder_turned_back_beside_its_arm_moves_no_hand(analysed_kick):
    """In either order: the arm's line is where it is in the room."""
    arm = next(limb for limb in analysed_kick.limbs if limb.name == "LeftArm-LeftHand")
    flip = replace(constant(arm.name, 40, 90, 2.0), kind=Kind.LIMB_FLIP)
    chosen = [constant("LeftShoulder", 60, 120, 1.0), constant("LeftArm", 50, 80, 0.5), flip]
    motion, both = analysed_kick.motion, analysed_kick.chains_and_limbs
    before = forward_kinematics(motion)[1]
    for chains in (both, both[::-1]):
        off = np.abs(forward_kinematics(refine(motion, chains, chosen))[1] - before).max(
            axis=(0, 2)
        )
        assert [motion.skeleton.names[j] for j in np.flatnonzero(off > 1e-9)] == ["LeftForeArm"]
