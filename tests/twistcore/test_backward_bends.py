"""Backward bends: a knee or an elbow that bends against its hinge without a jump."""

import json
from dataclasses import replace

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.twistcore.test_registry import run
from twistcore.analysis.clip_severity import measure_clip_severity
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.detection.backward_bends import Hinge, find_backward_bends, hinge_of
from twistcore.detection.evidence import ChainSignals
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import multiply, normalise, quaternion_from_axis_angle, rotate

WALK = tc.read_clip(ASSETS / "walk.bvh").motion
CHAINS = {chain.name: chain for chain in tc.find_chains(WALK)}
JOINTS = {"LeftUpLeg": "LeftLeg", "RightUpLeg": "RightLeg", "LeftArm": "LeftForeArm"}


def hinge(motion, name):
    return hinge_of(ChainSignals.of(motion, CHAINS[name]))


def eased(frames, border):
    """From 0 to 1 and back, with soft borders of so many frames."""
    t = np.arange(1, frames + 1)
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(np.minimum(t, t[::-1]) / border, 0.0, 1.0))


def bent(motion, name, degrees, start, stop, border=12):
    """The motion with the C of a chain at so many degrees behind straight in some frames."""
    chain, frames = CHAINS[name], slice(start, stop)
    bones = rotate(motion.rotations[:, chain.child], np.tile(chain.arm, (motion.frames, 1)))
    axis = normalise(np.cross(chain.axis, bones).sum(axis=0))
    turn = -np.radians(hinge(motion, name).flexion[frames] + degrees) * eased(stop - start, border)
    rotations = motion.rotations.copy()
    back = quaternion_from_axis_angle(axis, turn)
    rotations[frames, chain.child] = multiply(back, rotations[frames, chain.child])
    return motion.with_rotations(rotations)


def bends(motion, **more):
    return [i for i in tc.detect(motion, **more) if i.kind == tc.Kind.BACKWARD_BEND]


@pytest.mark.parametrize(
    ("name", "degrees"),
    [("LeftUpLeg", 15.0), ("RightUpLeg", 60.0), ("LeftArm", 15.0), ("LeftArm", 40.0)],
)
def test_it_is_listed_with_joint_frames_and_degrees_and_never_corrected(name, degrees):
    (found,) = bends(bent(WALK, name, degrees, 150, 200))
    assert (found.joint, found.chain) == (JOINTS[name], JOINTS[name])
    assert 150 < found.start < 162
    assert 188 < found.stop < 200
    assert np.degrees(found.residual) == pytest.approx(degrees, abs=0.1)
    assert (found.repairable, found.open, found.confidence) == (False, True, None)
    assert not found.offset.any()


def test_a_clip_may_begin_or_end_in_one():
    (found,) = bends(bent(WALK, "LeftUpLeg", 25.0, 250, 330).sliced(0, 290))
    assert (found.start, found.stop) == (pytest.approx(255, abs=5), 290)
    (found,) = bends(bent(WALK, "LeftUpLeg", 25.0, 20, 100).sliced(60, WALK.frames))
    assert (found.start, found.stop) == (0, pytest.approx(35, abs=5))


@pytest.mark.parametrize("clip", ["walk", "walk_injected", "dance", "kick", "basketball"])
def test_the_sample_clips_have_none(clip):
    assert not bends(tc.read_clip(ASSETS / f"{clip}.bvh").motion)


def test_a_few_degrees_are_natural():
    assert not bends(bent(WALK, "LeftUpLeg", 8.0, 150, 200))


def test_a_moment_is_no_bend():
    assert not bends(bent(WALK, "LeftUpLeg", 16.0, 150, 164, border=7))


def test_a_jump_is_an_error_of_another_kind():
    assert not bends(bent(WALK, "LeftUpLeg", 60.0, 150, 200, border=1))


def test_a_jump_near_the_start_of_a_clip_is_one_too():
    """Where jumps of joints are not searched for."""
    soft = bent(WALK, "LeftUpLeg", 60.0, 100, 160)
    assert bends(soft.sliced(114, 300))
    assert not bends(soft.at(np.r_[90:92, 114:300]))


def test_all_other_intervals_stay_as_they_are():
    dirty = tc.read_clip(ASSETS / "walk_injected.bvh").motion
    before = {(i.chain, i.start, i.stop, i.kind) for i in tc.detect(dirty)}
    after = {
        (i.chain, i.start, i.stop, i.kind) for i in tc.detect(bent(dirty, "LeftArm", 40, 5, 55))
    }
    (new,) = after - before
    assert before < after
    assert new[3] == tc.Kind.BACKWARD_BEND


@pytest.mark.parametrize(("start", "stop"), [(150, 170), (150, WALK.frames)])
def test_a_thigh_that_is_turned_around_is_not_listed_twice(start, stop):
    """Its knee seems to bend backward, whether the twist is corrected or left open."""
    offset = np.zeros(WALK.frames)
    offset[start:stop] = np.radians(-175.0)
    turned = remove_twist(WALK, [CHAINS["LeftUpLeg"]], {"LeftUpLeg": offset})
    found = tc.detect(turned)
    assert [i.chain for i in found if i.kind == tc.Kind.COUNTER_TWIST] == ["LeftUpLeg"]
    assert not [i for i in found if i.kind == tc.Kind.BACKWARD_BEND]


@pytest.mark.parametrize(
    ("chain", "start", "stop", "listed"),
    [
        ("LeftUpLeg", 140, 210, False),  # it covers the bend
        ("LeftUpLeg", 155, 250, False),  # it begins with it
        ("LeftUpLeg-LeftFoot", 100, 194, False),  # it ends with it
        ("LeftUpLeg", 170, 180, True),  # it is a part
        ("LeftLeg", 140, 210, True),  # it turns the shin about itself
        ("RightUpLeg", 140, 210, True),
    ],
)
def test_it_is_left_out_if_another_error_explains_it(chain, start, stop, listed):
    motion = bent(WALK, "LeftUpLeg", 30.0, 150, 200)
    analysis = tc.analyse(motion)
    error = Interval(chain, start, stop, np.ones(stop - start))
    search = KindSearch(
        motion,
        analysis.chains,
        analysis.chains,
        named=analysis.chains_and_limbs,
        errors=lambda: (error,),
        captured=KindSearch(motion, analysis.chains, analysis.chains),
    )
    assert bool(find_backward_bends(search)) == listed


def test_a_joint_with_play_may_bend_further_back():
    """An elbow that leaves the hinge plane in all its motion may also leave it backward."""
    chain = CHAINS["LeftArm"]
    wave = np.radians(20.0) * np.sin(np.arange(WALK.frames) / 20.0)
    rotations = WALK.rotations.copy()
    roll = quaternion_from_axis_angle(chain.axis, wave)
    rotations[:, chain.child] = multiply(roll, rotations[:, chain.child])
    loose = WALK.with_rotations(rotations)
    play = hinge(loose, "LeftArm").play
    assert 10.0 < play < 25.0
    assert not bends(bent(loose, "LeftArm", play + 5.0, 150, 200))
    assert [i.joint for i in bends(bent(loose, "LeftArm", play + 25.0, 150, 200))] == [
        "LeftForeArm"
    ]


def test_what_a_joint_does_all_the_time_is_no_error():
    flexion = np.tile([40.0, 20.0, -18.0, -18.0], 25)
    flexion[40:50] = -26.0
    assert not [*Hinge(flexion, 0.0, extended=18.0).backward(3)]
    flexion[40:50] = -35.0
    assert [*Hinge(flexion, 0.0, extended=18.0).backward(3)] == [(40, 50, 35.0)]
    assert not [*Hinge(flexion, 0.0, extended=18.0).backward(11)]


def test_a_clip_that_does_not_show_the_hinge_has_none():
    straight = np.flatnonzero(hinge(WALK, "LeftUpLeg").flexion < 20.0)
    assert hinge(WALK.at(straight), "LeftUpLeg") is None
    half = bent(WALK, "LeftUpLeg", 40.0, 60, 220)
    assert hinge(half, "LeftUpLeg") is None
    assert not bends(half)


def test_only_the_chosen_chains_are_listed():
    motion = bent(WALK, "LeftUpLeg", 30.0, 150, 200)
    assert len(bends(motion, chains="LeftLeg")) == 1
    assert not bends(motion, chains="RightLeg")


def test_it_is_found_at_a_low_rate():
    motion = WALK
    slow = replace(
        motion,
        rotations=motion.rotations[::4],
        positions=motion.positions[::4],
        frame_time=4.0 * motion.frame_time,
    )
    (found,) = bends(bent(slow, "RightUpLeg", 30.0, 40, 60, border=6))
    assert found.joint == "RightLeg"
    assert not bends(slow)


def test_the_commands_show_it_and_gates_count_it_only_on_request(tmp_path):
    clip = tc.read_clip(ASSETS / "walk.bvh")
    tc.write_clip(clip, bent(WALK, "LeftUpLeg", 30.0, 150, 200), path := tmp_path / "bent.bvh")
    code, out, _ = run("detect", path, "--json", "--fail-over", 0)
    (row,) = json.loads(out)["intervals"]
    assert (code, row["kind"], row["joint"], row["delta_deg"]) == (0, "backward bend", "LeftLeg", 0)
    assert row["backward_deg"] == pytest.approx(30.0, abs=0.1)
    assert row["limit_deg"] == pytest.approx(10.0, abs=0.1)
    code, out, _ = run("detect", path, "--kinds", "backward-bend", "--fail-over", 0)
    assert code == 1
    assert "30.0" in out
    assert "1 backward bend" in out


def test_it_counts_in_the_severity_for_its_whole_length():
    short, long = (
        measure_clip_severity(tc.detect(bent(WALK, "LeftUpLeg", 30.0, 150, stop)))
        for stop in (190, 230)
    )
    assert long > short > measure_clip_severity(tc.detect(WALK)) == 0.0
