"""A first guess for an interval made by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.corrected import Corrected
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.bvh import read_bvh
from twistcore.review.proposal import propose_limb_flip_at_frame, proposed_interval
from twistcore.skeleton.limb import limb_middle_and_end_positions
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import wrap
from twistcore.skeleton.signals import TwistSignals

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
    just = 1.1 * np.radians(1.0)
    edges = [(90, just), (120, just)]
    found = proposed_interval("LeftArm", with_error(300, 90, 120, 0.5, edges), 100, FPS)
    assert (found.start, found.stop) == (90, 120)


def test_with_one_edge_the_other_lies_a_tenth_of_a_second_away():
    begins = proposed_interval("A", with_error(300, 90, 300, 0.5, [(90, 0.5)]), 95, FPS)
    assert (begins.start, begins.stop) == (90, 101)
    ends = proposed_interval("A", with_error(300, 0, 120, 0.5, [(120, 0.5)]), 115, FPS)
    assert (ends.start, ends.stop) == (109, 120)


def test_a_flip_lies_between_the_nearest_jumps(analysed_kick):
    limb = analysed_kick.flips.limbs[LEG]
    for found in limb.intervals(np.radians(55.0)):
        for frame in (found.start, found.stop - 1):
            flip = propose_limb_flip_at_frame(limb, frame)
            assert (flip.kind, flip.start, flip.stop) == (Kind.LIMB_FLIP, found.start, found.stop)
            assert flip.carried == found.carried
            assert abs(wrap(flip.delta - found.delta)) < np.radians(6.0)


def test_a_flip_is_proposed_anywhere(analysed_kick):
    for limb in analysed_kick.flips.limbs.values():
        for frame in range(analysed_kick.motion.frames):
            flip = propose_limb_flip_at_frame(limb, frame)
            assert 0 <= flip.start <= frame < flip.stop <= analysed_kick.motion.frames
            assert np.isfinite(flip.offset).all()


def test_the_swivel_after_correction_is_that_of_the_corrected_motion(analysed_kick):
    """Also where a shoulder, in whose frame φ is measured, is turned back."""
    arm = next(limb for limb in analysed_kick.limbs if limb.name == "LeftArm-LeftHand")
    flip = replace(new_constant_offset_interval(arm.name, 40, 90, 2.0), kind=Kind.LIMB_FLIP)
    chosen = [new_constant_offset_interval("LeftShoulder", 60, 120, 1.0), flip]
    corrected = Corrected(analysed_kick)
    corrected.take(chosen)
    refined = refine(analysed_kick.motion, analysed_kick.chains_and_limbs, chosen)
    swivel = analysed_kick.flips.limbs[arm.name].swivel
    predicted, true = (
        corrected.swivel(arm),
        swivel.angle_at(*limb_middle_and_end_positions(refined, arm)),
    )
    bent = swivel.height > 1e-3
    assert np.abs(wrap(predicted - true))[bent].max() < 1e-9
    assert np.abs(wrap(predicted - swivel.angle))[60:120].max() > 0.5


def test_a_shoulder_turned_back_beside_its_arm_moves_no_hand(analysed_kick):
    """In either order: the arm's line is where it is in the room."""
    arm = next(limb for limb in analysed_kick.limbs if limb.name == "LeftArm-LeftHand")
    flip = replace(new_constant_offset_interval(arm.name, 40, 90, 2.0), kind=Kind.LIMB_FLIP)
    chosen = [
        new_constant_offset_interval("LeftShoulder", 60, 120, 1.0),
        new_constant_offset_interval("LeftArm", 50, 80, 0.5),
        flip,
    ]
    motion, both = analysed_kick.motion, analysed_kick.chains_and_limbs
    before = forward_kinematics(motion)[1]
    for chains in (both, both[::-1]):
        off = np.abs(forward_kinematics(refine(motion, chains, chosen))[1] - before).max(
            axis=(0, 2)
        )
        assert [motion.skeleton.names[j] for j in np.flatnonzero(off > 1e-9)] == ["LeftForeArm"]


def flips(departures, angle=None, height=1.0, fps=100.0):
    """Only what a proposal of a flip looks at."""
    frames = len(departures)
    angle = np.zeros(frames) if angle is None else angle
    return SimpleNamespace(
        departures=departures,
        fps=fps,
        limb=SimpleNamespace(name=LEG),
        swivel=SimpleNamespace(angle=angle, height=np.full(frames, height)),
        end_carried=lambda start, offset: (start, len(offset)) == (90, 30),
    )


def with_jumps(frames, jumps):
    departures = np.zeros(frames)
    for at, degrees in jumps.items():
        departures[at] = np.radians(degrees)
    return departures


@pytest.mark.parametrize("frame", [90, 100, 119])
def test_a_flip_made_by_hand_lies_between_the_jumps_round_it(frame):
    angle = 0.01 * np.arange(300.0)
    angle[90:120] += 1.0
    jumps = {70: 60, 90: 57, 100: 20, 120: -57, 140: 60}
    flip = propose_limb_flip_at_frame(flips(with_jumps(300, jumps), angle), frame)
    assert (flip.chain, flip.kind, flip.start, flip.stop) == (LEG, Kind.LIMB_FLIP, 90, 120)
    assert flip.carried
    np.testing.assert_allclose(flip.offset, np.full(30, 1.0), atol=1e-12)


def test_a_jump_is_looked_for_within_half_a_second_and_25_degrees():
    def found(jumps, frame=150, frames=300, fps=100.0):
        flip = propose_limb_flip_at_frame(flips(with_jumps(frames, jumps), fps=fps), frame)
        return flip.start, flip.stop

    assert found({100: 30, 200: 30}) == (100, 200)
    assert found({99: 30, 201: 30}) == (145, 156)
    assert found({100: 24.9, 200: 30}) == (189, 200) or found({100: 24.9, 200: 30})[1] == 200
    assert found({100: 25.1}) == (100, 151)
    assert found({148: 30}) == (148, 159)
    assert found({155: 30}) == (144, 155)
    assert found({151: -30, 150: -30}) == (150, 151)
    assert found({8: 30}, frame=5, frames=10) == (0, 8)
    assert found({3: 30}, frame=5, frames=10) == (3, 10)
    # At two frames a second half a second is one frame: two are looked at.
    assert found({3: 30, 7: 30}, frame=5, frames=10, fps=2.0) == (3, 7)
    assert found({2: 30, 8: 30}, frame=5, frames=10, fps=2.0) == (4, 7)


def test_of_a_straight_limb_the_jump_at_its_start_counts():
    jumps = with_jumps(300, {90: 57, 120: -57})
    angle = np.zeros(300)
    angle[90:120] = 2.0
    straight = propose_limb_flip_at_frame(flips(jumps, angle, height=0.0), 100)
    np.testing.assert_allclose(straight.offset, np.full(30, np.radians(57.0)))
    np.testing.assert_allclose(
        propose_limb_flip_at_frame(flips(jumps, angle), 100).offset, np.full(30, 2.0)
    )


def test_edges_at_few_frames_a_second_and_at_the_ends_of_a_clip():
    def found(frame, edges, frames=20, fps=2.0):
        made = proposed_interval("A", with_error(frames, 0, 0, 0.0, edges), frame, fps)
        return made.start, made.stop

    assert found(10, [(8, 0.5), (12, 0.5)]) == (8, 12)
    assert found(10, [(7, 0.5), (13, 0.5)]) == (9, 12)  # two frames to either side, no more
    assert found(10, [(10, 0.5), (11, 0.5)]) == (10, 11)
    assert found(0, [(0, 0.5)]) == (0, 3)  # there is no step into the first frame
    assert found(0, [(1, 0.5)]) == (0, 1)
    assert found(19, [(18, 0.5)]) == (18, 20)
    assert found(19, []) == (18, 20)
