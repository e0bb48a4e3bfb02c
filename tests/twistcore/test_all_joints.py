"""Spikes and jumps of any joint, jumps of places, steps of the body: shown, never corrected."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import twistcore as tc
from benchmarks.joint_spikes import draw_spikes, inject_spikes
from tests.conftest import ASSETS
from tests.tiers import parametrize
from tests.twistcore.two_people import two_people
from twistcore.analysis.clip_analysis import BODY_STEP_DOUBT, analyse
from twistcore.analysis.clip_severity import measure_clip_severity
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.batch.gates import broken_rules, parse_batch_rule
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.detection.all_joints import finders
from twistcore.detection.all_joints.joint_steps import StepLimits, jumps, spikes
from twistcore.export.detection_json import intervals_to_json
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.review import Review, read_session, write_session
from twistcore.skeleton import joint_owners
from twistcore.skeleton.rotation import exponential, multiply, normalise
from twistcore.synthesis.injection import InjectedError, clip_random_generator, inject

WALK = read_bvh(ASSETS / "walk.bvh").motion
NAMES = WALK.skeleton.names
KINDS = (Kind.SPIKE, Kind.JOINT_JUMP, Kind.PLACE_JUMP, Kind.BODY_STEP)
CLEAN = ("walk", "basketball")


def turned(motion, joint, start, stop, degrees, axis=(0.3, 0.9, -0.2)):
    """A joint that is turned about any axis in some frames; what hangs on it goes along."""
    at, joint = slice(start, stop), motion.skeleton.index(joint)
    rotations = motion.rotations.copy()
    turn = exponential(np.radians(degrees) * normalise(np.array(axis)))
    rotations[at, joint] = normalise(multiply(rotations[at, joint], turn))
    return motion.with_rotations(rotations)


def at_30_hz(motion):
    kept = motion.at(np.arange(0, motion.frames, 4))
    return replace(kept, frame_time=4.0 * motion.frame_time)


def finds(motion, *kinds, chains=None):
    found = analyse(motion, chains).detect(kinds=kinds or KINDS)
    return [(i.kind.value, i.joint, i.start, i.stop) for i in found]


@pytest.mark.parametrize("name", CLEAN)
def test_sound_clips_have_none(name):
    motion = read_bvh(ASSETS / f"{name}.bvh").motion
    assert finds(motion) == finds(at_30_hz(motion)) == []


def test_a_capture_with_faults_has_its_own():
    """Both feet of the dance turn by 13° to 29° for a frame, and twice all joints step by 5°."""
    assert finds(read_bvh(ASSETS / "dance.bvh").motion) == [
        ("body step", "Hips", 173, 174),
        ("body step", "Hips", 281, 282),
        ("spike", "LeftFoot", 428, 429),
        ("spike", "RightFoot", 41, 42),
        ("spike", "RightFoot", 293, 294),
    ]


@pytest.mark.parametrize("length", [1, 2, 3])
@parametrize("joint", ["LeftForeArm", "Spine1", "Neck", "Hips", "RightFoot"], quick=4)
def test_a_spike_of_any_joint_is_one_find_of_its_own(joint, length):
    motion = turned(WALK, joint, 150, 150 + length, 40.0)
    assert finds(motion) == [("spike", joint, 150, 150 + length)]


@pytest.mark.parametrize("frames", [12, 17, 22])
def test_a_short_clip_is_compared_with_the_frames_that_it_has(frames):
    start = 150 - frames // 2
    motion = turned(WALK, "Neck", 150, 151, 40.0).sliced(start, start + frames)
    assert finds(motion) == [("spike", "Neck", frames // 2, frames // 2 + 1)]


def test_its_angle_is_how_far_it_is_off_and_nothing_is_corrected():
    found = analyse(turned(WALK, "Neck", 150, 152, 40.0)).detect()
    (spike,) = found
    assert np.degrees(spike.residual) == pytest.approx(40.0, abs=1.0)
    assert spike.angle_text(0) == "±40°"
    assert spike.open
    assert not spike.offset.any()
    assert automatic_corrections(found, 0.0, include_open=True) == ()
    assert spike.evidence["times_usual"] > 8.0


def test_toes_and_fingers_have_a_limit_of_their_own():
    for joint in ("LeftToeBase", "RightHandIndex1"):
        assert finds(turned(WALK, joint, 150, 151, 25.0)) == []
        assert finds(turned(WALK, joint, 150, 151, 60.0)) == [("spike", joint, 150, 151)]


def test_a_movement_as_fast_as_others_around_it_is_no_spike():
    """A joint that trembles by half as much in every frame."""
    motion = turned(WALK, "Neck", 150, 151, 20.0)
    assert len(finds(motion)) == 1
    for frame in range(130, 171, 2):
        motion = turned(motion, "Neck", frame, frame + 1, 10.0, axis=(1.0, 0.0, 0.0))
    assert finds(motion, Kind.SPIKE) == []


def test_a_joint_that_only_makes_up_for_its_parent_is_not_listed():
    motion = turned(WALK, "LeftArm", 150, 151, 40.0)
    arm, below = WALK.skeleton.index("LeftArm"), WALK.skeleton.index("LeftForeArm")
    back = multiply(motion.rotations[150, arm] * (1.0, -1.0, -1.0, -1.0), WALK.rotations[150, arm])
    rotations = motion.rotations.copy()
    rotations[150, below] = multiply(back, rotations[150, below])
    found = finds(motion.with_rotations(rotations), Kind.SPIKE, Kind.JOINT_JUMP)
    assert {joint for _, joint, *_ in found} == {"LeftArm"}


def test_a_joint_that_stays_off_jumps_at_both_ends():
    motion = turned(WALK, "Spine1", 100, 160, 50.0)
    assert finds(motion) == [("joint jump", "Spine1", 100, 101), ("joint jump", "Spine1", 160, 161)]


def test_what_a_correction_takes_away_is_not_listed_twice():
    error = InjectedError("LeftForeArm", 150, 152, np.full(2, np.radians(60.0)))
    dirty = inject(WALK, [error])
    assert [i.kind for i in analyse(dirty).detect()] == [Kind.COUNTER_TWIST]


def test_a_place_that_jumps_is_found():
    positions = WALK.positions.copy()
    positions[150:, 0, 1] += 0.1 * WALK.skeleton.height
    motion = replace(WALK, positions=positions)
    assert finds(motion) == [("place jump", "Hips", 150, 151)]
    (jump,) = analyse(motion).detect()
    assert jump.evidence["way_percent"] == pytest.approx(10.0, abs=1.0)
    assert measure_clip_severity(analyse(motion).detect()) > 0.0


def stepping(frame, degrees=8.0):
    """A third of the joints and more turn by some degrees from a frame on, which stays."""
    motion = WALK
    for joint in NAMES[1::2]:
        motion = turned(motion, joint, frame, motion.frames, degrees)
    return motion


def test_a_step_of_the_whole_body_is_one_find():
    (found,) = finds(stepping(150))
    assert found == ("body step", "Hips", 150, 151)
    (alone,) = finds(stepping(150), chains=["LeftForeArm"])
    assert alone == found


def test_a_counter_twist_that_begins_in_a_body_step_is_left_to_a_person():
    def twist_of(motion, start):
        error = InjectedError("LeftForeArm", start, start + 20, np.full(20, np.radians(30.0)))
        found = analyse(inject(motion, [error])).detect(kinds="counter-twist")
        near = (i for i in found if i.chain == "LeftForeArm" and abs(i.start - start) <= 1)
        return next(near)

    stepped = twist_of(stepping(150), 150)
    assert stepped.open
    assert stepped.evidence["doubts"][0] == BODY_STEP_DOUBT
    assert not twist_of(WALK, 150).open
    assert not twist_of(stepping(260), 150).open


def test_twist_errors_in_many_chains_are_no_step_of_the_body():
    chains = [c for c in analyse(WALK).chains if c.segment in ("Shoulder", "ForeArm", "Leg")]
    errors = [
        InjectedError(chain.name, 200, 220, np.full(20, np.radians(60.0 + 5.0 * k)))
        for k, chain in enumerate(chains)
    ]
    found = analyse(inject(WALK, errors)).detect()
    assert not [i for i in found if i.kind == Kind.BODY_STEP]
    twists = {i.chain: i for i in found if i.kind == Kind.COUNTER_TWIST and i.start == 200}
    assert twists.keys() == {chain.name for chain in chains}
    assert not any(twist.open for twist in twists.values())


def test_frames_that_are_held_are_looked_at_once():
    slow = at_30_hz(WALK)
    held = turned(slow, "Neck", 40, 41, 60.0).at(np.repeat(np.arange(slow.frames), 4))
    held = replace(held, frame_time=WALK.frame_time)
    assert finds(held) == [("spike", "Neck", 160, 164)]
    held = turned(slow, "Neck", 40, slow.frames, 60.0).at(np.repeat(np.arange(slow.frames), 4))
    held = replace(held, frame_time=WALK.frame_time)
    assert finds(held) == [("joint jump", "Neck", 160, 161)]


def test_joints_without_three_rotations_are_left_out():
    rotatable = np.ones(len(NAMES), dtype=bool)
    rotatable[WALK.skeleton.index("Neck")] = False
    motion = turned(WALK, "Neck", 150, 151, 60.0)
    assert finds(motion) != []
    assert finds(replace(motion, skeleton=replace(WALK.skeleton, rotatable=rotatable))) == []


@pytest.mark.parametrize("block", [256, 1000, 9000])
def test_blocks_of_frames_give_the_finds_of_the_whole(monkeypatch, block):
    motion = WALK
    for k, joint in enumerate(("Neck", "LeftArm", "Spine", "Hips", "RightFoot")):
        motion = turned(motion, joint, 20 + 50 * k + k % 2, 22 + 50 * k, 50.0)
    motion = turned(motion, "Spine", 256, 257, 50.0)
    limits = StepLimits.of(len(NAMES), motion.fps, set())
    every = np.ones(motion.frames, dtype=bool)
    parents = motion.skeleton.parents
    whole = [f(motion.rotations, parents, every, limits) for f in (spikes, jumps)]
    assert len(whole[0]) == 6
    monkeypatch.setattr(finders, "_NUMBERS", block)
    found = finders._in_blocks(motion, limits)
    assert [[(s.joint, s.start, s.stop) for s in own] for own in found] == [
        [(s.joint, s.start, s.stop) for s in own] for own in whole
    ]


def test_every_joint_has_a_chain_that_lists_it():
    chains = tc.find_chains(WALK)
    owner = joint_owners.nearest_chain_by_joint(WALK.skeleton, chains)
    assert set(owner) == set(range(len(NAMES)))
    by_name = {NAMES[joint]: chain.name for joint, chain in owner.items()}
    assert by_name["LeftHandIndex1"] == by_name["LeftHand"] == "LeftForeArm"
    assert by_name["RightToeBase"] == by_name["RightFoot"] == "RightLeg"
    small = {NAMES[j] for j in joint_owners.joints_below_hands_and_feet(WALK.skeleton, chains)}
    assert {"LeftToeBase", "RThumb"} <= small
    assert not {"LeftFoot", "LeftHand", "Head", "Spine"} & small


def test_a_chain_alone_lists_what_it_lists_among_all():
    motion = turned(turned(WALK, "LeftToeBase", 150, 151, 70.0), "Head", 200, 201, 40.0)
    whole = analyse(motion).detect()
    (toe, head) = sorted(whole, key=lambda i: i.start)
    assert toe.chain == "LeftLeg"
    for one in (toe, head):
        (alone,) = analyse(motion, [one.chain]).detect()
        assert (alone.joint, alone.start, alone.chain) == (one.joint, one.start, one.chain)


def test_commands_name_them_and_gates_count_them_only_where_asked(tmp_path, capsys):
    path = tmp_path / "spike.bvh"
    write_motion(turned(WALK, "Neck", 150, 151, 40.0), path)
    assert main(["detect", str(path), "--fail-over", "0"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[-1].startswith("1 interval")
    assert said[-1].endswith("(1 spike)")
    assert said[1].split()[0] == "Neck"
    assert main(["detect", str(path), "--kinds", "spike", "--fail-over", "0"]) == 1
    capsys.readouterr()
    assert main(["detect", str(path), "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["intervals"]
    assert (row["kind"], row["joint"], row["start"], row["delta_deg"]) == ("spike", "Neck", 150, 0)
    assert row["angle_deg"] == pytest.approx(40.0, abs=1.0)


def test_rules_count_them_only_by_name():
    motion = turned(turned(WALK, "Neck", 150, 151, 40.0), "LeftToeBase", 200, 201, 70.0)
    found = analyse(motion).detect()
    result = {"intervals": intervals_to_json(found), "frames": WALK.frames, "unchecked": ""}
    result |= {"severity": measure_clip_severity(found), "affected_frames": 0}
    record = SimpleNamespace(name="walk.bvh", state="done", result=result)

    def is_broken(rule):
        return bool(broken_rules([parse_batch_rule(rule)], [record]))

    assert not is_broken("count>0")
    assert not is_broken("degrees>0")
    assert is_broken("count[spike]==2")
    assert is_broken("degrees[spike]>60")


def test_severity_counts_them_by_angle_and_by_what_hangs_on_the_joint():
    def bad(joint, degrees):
        return measure_clip_severity(analyse(turned(WALK, joint, 150, 151, degrees)).detect())

    assert bad("Spine", 60.0) > bad("Spine", 40.0) > 0.0
    assert bad("Spine", 60.0) > bad("LeftForeArm", 60.0) > bad("LeftToeBase", 60.0) > 0.0


def test_a_session_keeps_them(tmp_path):
    path = tmp_path / "spike.bvh"
    write_motion(turned(WALK, "Neck", 150, 151, 40.0), path)
    clip = read_bvh(path)
    review = Review.of(analyse(clip).detect())
    write_session(clip, review.state, tmp_path / "s.json")
    (back,) = read_session(tmp_path / "s.json").state.intervals
    assert (back.interval.kind, back.interval.joint) == (Kind.SPIKE, "Neck")
    assert np.degrees(back.interval.residual) == pytest.approx(40.0, abs=1.0)


@pytest.mark.parametrize("name", [*CLEAN, "dance"])
def test_nearly_all_injected_spikes_are_found(name):
    motion = read_bvh(ASSETS / f"{name}.bvh").motion
    drawn = draw_spikes(motion, clip_random_generator(3, name))
    assert len(drawn) >= 5
    found = analyse(inject_spikes(motion, drawn)).detect()
    every = motion.skeleton.names
    hit = [
        any(
            abs(i.start - s.start) <= 1
            and (i.joint == every[s.joint] or i.kind in (Kind.LIMB_FLIP, Kind.COUNTER_TWIST))
            for i in found
        )
        for s in drawn
    ]
    assert sum(hit) >= len(drawn) - 1


def test_each_person_has_joints_and_steps_of_their_own(tmp_path):
    path = tmp_path / "two.bvh"
    walk = ASSETS / "walk.bvh"
    path.write_bytes(two_people(root=True, clips=(walk, walk)))
    motion = read_bvh(path).motion
    own = [name for name in motion.skeleton.names if name.endswith("_B") and "Hips" not in name]
    spike = turned(motion, "Neck_B", 150, 151, 60.0)
    stepping_b = motion
    for joint in own[1::2]:
        stepping_b = turned(stepping_b, joint, 200, motion.frames, 15.0)
    for wrong, kind in ((spike, Kind.SPIKE), (stepping_b, Kind.BODY_STEP)):
        (found,) = (i for i in analyse(wrong).detect() if i.kind == kind)
        person = next(c.person for c in analyse(wrong).chains if c.name == found.chain)
        assert person == analyse(wrong, people="B").chains[0].person
        assert not [i for i in analyse(wrong, people="A").detect() if i.kind == kind]
