"""Carried rolls: P rolls, C's bone stays, C rolls along; found and repaired."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection.carried_rolls import bent_frames, is_roll_carried_to_child
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.synthesis import InjectedError, inject
from twistcore.synthesis.truth import Truth, read_truth, write_truth

WALK = tc.read_clip(ASSETS / "walk.bvh")
CHAINS = {chain.name: chain for chain in tc.find_chains(WALK)}


def bent_place(name, length):
    """The first frames of this length in which a limb stays bent, well inside the clip."""
    bent = bent_frames(WALK.motion, CHAINS[name])
    starts = range(20, len(bent) - length - 20)
    return next(s for s in starts if bent[s - 2 : s + length + 2].all())


def roll(name, degrees, length=12):
    start = bent_place(name, length)
    offset = np.radians(np.full(length, float(degrees)))
    kind = tc.Kind.CARRIED_ROLL
    return InjectedError(name, start, start + length, offset, kind=kind, carried=True)


def with_error(error):
    return inject(WALK, list(CHAINS.values()), [error])


@parametrize("degrees", [-120.0, -30.0, 12.0, 60.0, 170.0], quick=2)
@pytest.mark.parametrize("name", ["LeftArm", "RightUpLeg"])
def test_a_carried_roll_is_found_and_taken_out_exactly(name, degrees):
    error = roll(name, degrees)
    found = tc.detect(with_error(error), name)
    (own,) = (i for i in found if i.kind == tc.Kind.CARRIED_ROLL)
    assert (own.start, own.stop, own.open) == (error.start, error.stop, False)
    assert own.confidence > 0.5
    assert abs(np.degrees(own.delta) - degrees) < 2.0
    apart = geodesic_angle(found.refined().rotations, WALK.motion.rotations)
    assert np.degrees(apart).max() < 2.0


def test_the_repair_moves_no_joint_of_the_chain():
    error = roll("LeftArm", 80.0)
    dirty = with_error(error)
    after = forward_kinematics(tc.refine(dirty, tc.detect(dirty)))[1]
    chain = CHAINS["LeftArm"]
    joints = [chain.parent, chain.child, chain.grandchild]
    np.testing.assert_allclose(
        after[:, joints], forward_kinematics(dirty)[1][:, joints], atol=1e-6 * 60.0
    )


@pytest.mark.parametrize("confidence", [0.5, 0.69, 0.7])
def test_a_less_sure_carried_roll_is_left_to_a_person(confidence):
    dirty = analyse(with_error(roll("LeftArm", 80.0)))
    (own,) = (i for i in dirty.detect() if i.kind == tc.Kind.CARRIED_ROLL)
    given = replace(own, confidence=confidence)
    left, info = dirty.protected(given), tc.Kind.CARRIED_ROLL.info
    assert left.open == (confidence < info.sure)
    assert (info.doubt in left.evidence.get("doubts", ())) == left.open
    assert (given in automatic_corrections([left])) != left.open


def test_a_counter_twist_in_the_same_frames_is_no_carried_roll():
    error = roll("LeftArm", 60.0)
    twist = InjectedError(error.chain, error.start, error.stop, error.offset)
    kinds = {i.kind for i in tc.detect(with_error(twist), "LeftArm")}
    assert kinds == {tc.Kind.COUNTER_TWIST}


def test_at_an_edge_the_motion_before_and_after_it_is_subtracted():
    turns = {name: np.zeros(40) for name in ("x", "azimuth_turns", "roll_turns")}
    signals = SimpleNamespace(frames=40, bend=np.full(40, 60.0), **turns)
    edges = {"edges": [{"start": 20, "stop": 21}]}
    found = tc.Interval("LeftArm", 20, 30, np.ones(10), explain=lambda: edges)
    signals.x[20] = signals.roll_turns[20] = 20.0
    signals.azimuth_turns[20] = -11.0
    assert not is_roll_carried_to_child(signals, found)
    for beyond in (slice(0, 20), slice(21, 40)):
        signals.azimuth_turns[beyond] = 18.0  # so that 9 of the 11 degrees are motion
        assert is_roll_carried_to_child(signals, found)
        signals.azimuth_turns[beyond] = 0.0
    grows = replace(found, explain=None, offset=np.minimum(np.arange(1.0, 11.0), 4.0))
    for name, sign in (("x", 1.0), ("azimuth_turns", -1.0), ("roll_turns", 1.0)):
        turns[name][20:24], turns[name][24:30] = 5.0 * sign, 0.0
    assert is_roll_carried_to_child(signals, grows)
    signals.roll_turns[24:26] = 10.0, -10.0  # after the largest offset
    assert is_roll_carried_to_child(signals, grows)
    signals.roll_turns[22:24] = 0.0  # C rolls along up to half of the largest offset only
    assert not is_roll_carried_to_child(signals, grows)


def test_a_sound_clip_has_none():
    assert len(tc.detect(WALK, kinds="carried roll")) == 0


def test_other_kinds_leave_it_out_and_the_paper_has_none():
    dirty = with_error(roll("LeftArm", 60.0))
    twists = tc.detect(dirty, "LeftArm", kinds="counter-twist")
    assert all(i.kind == tc.Kind.COUNTER_TWIST for i in twists)
    assert len(tc.detect(dirty, method="paper", kinds="carried roll")) == 0


def test_a_session_keeps_it(tmp_path):
    review = tc.Review(tc.detect(with_error(roll("LeftArm", 60.0)), "LeftArm"))
    path = tmp_path / "walk.twist.json"
    tc.write_session(WALK, review, path)
    kept = [j.interval for j in tc.read_session(path).state.intervals]
    assert [(i.kind, i.carried) for i in kept] == [(tc.Kind.CARRIED_ROLL, True)]


def test_a_truth_file_keeps_it(tmp_path):
    error = roll("LeftArm", 60.0)
    motion = WALK.motion
    write_truth(
        tmp_path / "truth.json", Truth("walk.bvh", "CR", 1, motion.frames, motion.fps, (error,))
    )
    (read,) = read_truth(tmp_path / "truth.json").errors
    assert (read.kind, read.carried, read.start) == (tc.Kind.CARRIED_ROLL, True, error.start)
