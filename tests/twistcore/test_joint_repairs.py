"""Corrections of a single joint: stretches and spikes, only after a person has accepted them."""

import json
from dataclasses import replace

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.tiers import parametrize
from tests.twistcore.reviews import spun
from tests.twistcore.test_registry import run
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.corrected import Corrected
from twistcore.analysis.correction.joint_repairs import JointRepairs, repair_moves_joints, repair_of
from twistcore.analysis.correction.protected_measures import protected_measures
from twistcore.detection.interval_offsets import resized_interval, with_offset_of_size
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.export.compare import compare_motions
from twistcore.formats.bvh import read_bvh
from twistcore.report.changes import check_fidelity_of_written_clip
from twistcore.report.document import Report, report_to_json
from twistcore.review import CarryOver, Decide, Decision, Edit, Journal, Redetect, replay_journal
from twistcore.review.proposal import propose_error_at_jump
from twistcore.skeleton.limb import limb_middle_and_end_positions
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rotation import (
    exponential,
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    slerp,
    twist_angle,
    wrap,
)
from twistcore.skeleton.signals import twist_signals

WALK = read_bvh(ASSETS / "walk.bvh")
MOTION = WALK.motion
SKELETON = MOTION.skeleton
FRAMES = MOTION.frames
DEGREES = 150.0


def turned(joint, start, stop, *, kept=False, degrees=DEGREES):
    """The walk with a joint turned about its own bone; kept: its children keep their place."""
    at = SKELETON.index(joint)
    turn = quaternion_from_axis_angle(own_bone_axis(SKELETON, at), np.radians(degrees))
    rotations = spun(joint, start, stop, degrees, MOTION).rotations.copy()
    for child in SKELETON.children[at] if kept else ():
        back = multiply(turn * (1.0, -1.0, -1.0, -1.0), rotations[start:stop, child])
        rotations[start:stop, child] = back
    return MOTION.with_rotations(rotations)


def spiked(joint, start, stop, degrees=40.0):
    rotations, at = MOTION.rotations.copy(), SKELETON.index(joint)
    off = exponential(np.radians(degrees) * normalise(np.array((0.3, 0.9, -0.2))))
    rotations[start:stop, at] = normalise(multiply(rotations[start:stop, at], off))
    return MOTION.with_rotations(rotations)


def the_only(state, kind):
    (judged,) = (j for j in state.intervals if j.interval.kind == kind)
    return judged


def accepted(motion, kind, angle=None):
    """A review in which the only interval of a kind is accepted, with another angle if given."""
    review = tc.Review(tc.detect(motion))
    judged = the_only(review.state, kind)
    if angle is not None:
        review.do(Edit(judged.id, with_offset_of_size(judged.interval, np.radians(angle))))
    review.do(Decide((judged.id,), Decision.ACCEPTED, "Ada", "2026-01-01T00:00:00+00:00"))
    return review


@pytest.fixture
def stretched(tmp_path):
    """A file with a foot that stays turned, and the review that accepts it."""
    path = tmp_path / "clip.bvh"
    tc.write_clip(WALK, turned("LeftFoot", 200, 260), path)
    clip = read_bvh(path)
    review = accepted(clip.motion, tc.Kind.STRETCH)
    return clip, review


# -- stretches -------------------------------------------------------------------------------------


@parametrize("kept", [False, True])
@parametrize(
    ("joint", "start", "stop"),
    [("LeftFoot", 200, FRAMES), ("LeftFoot", 0, 90), ("RightHand", 100, 180)],
)
def test_a_stretch_is_turned_back_to_what_it_was(joint, start, stop, kept):
    """With the injected angle; below the joint, whatever kept or changed its place is restored."""
    motion = turned(joint, start, stop, kept=kept)
    judged = the_only(tc.Review(tc.detect(motion)).state, tc.Kind.STRETCH)
    assert judged.interval.joint == joint
    assert judged.interval.carried == (not kept)
    refined = tc.refine(motion, accepted(motion, tc.Kind.STRETCH, DEGREES))
    assert geodesic_angle(refined.rotations, MOTION.rotations).max() < np.radians(1e-7)
    dots = np.abs((refined.rotations * MOTION.rotations).sum(axis=-1))
    np.testing.assert_allclose(dots, 1.0, atol=1e-9)
    same = (refined.rotations == motion.rotations).all(axis=-1)
    assert same[:start].all()
    assert same[stop:].all()
    own = SKELETON.index(joint)
    others = [k for k in range(len(SKELETON)) if k != own]
    if kept:
        others = [k for k in others if k not in SKELETON.children[own]]
    assert same[:, others].all()


def search_in(motion):
    return analyse(motion).search("consistency")


@pytest.mark.parametrize("degrees", [-170.0, 100.0, 150.0])
def test_its_angle_is_measured_at_the_jumps(degrees):
    motion = turned("LeftFoot", 120, 200, degrees=degrees)
    interval = the_only(tc.Review(tc.detect(motion)).state, tc.Kind.STRETCH).interval
    assert np.degrees(interval.delta) == pytest.approx(degrees, abs=2.0)
    assert np.ptp(interval.offset) == 0.0
    (found,) = (i for i in tc.detect(motion) if i.kind == tc.Kind.STRETCH)
    listed = found.size, np.radians(found.evidence["turn_deg"])
    assert listed == pytest.approx([interval.delta] * 2)  # the same everywhere
    assert found.evidence["correction_deg"] == found.evidence["turn_deg"]


@pytest.mark.parametrize(("start", "stop"), [(0, 90), (100, 150), (250, FRAMES)])
def test_a_lone_jump_suggests_the_shorter_side(start, stop):
    motion = turned("LeftFoot", start, stop, degrees=-170.0)
    jumps = [i for i in tc.detect(motion) if i.kind == tc.Kind.LONE_JUMP]
    for jump in jumps:
        made = propose_error_at_jump(search_in(motion), jump, jumps)
        assert (made.joint, made.start, made.stop, made.carried) == ("LeftFoot", start, stop, True)
        assert np.degrees(made.delta) == pytest.approx(-170.0, abs=2.0)


def test_a_lone_jump_suggests_the_side_that_is_off():
    """The longer one here: the right level between two errors is shorter than each of them."""
    motion = turned("LeftFoot", 120, 160, degrees=-170.0)
    stay = turned("LeftFoot", 175, 215, degrees=-170.0)
    rotations = motion.rotations.copy()
    rotations[175:215] = stay.rotations[175:215]
    both = motion.with_rotations(rotations)
    jumps = [
        replace(jump, start=at, stop=at + 1)
        for jump in [next(i for i in tc.detect(motion) if i.kind == tc.Kind.LONE_JUMP)]
        for at in (120, 160, 175, 215)
    ]
    spans = [(120, 160), (120, 160), (175, 215), (175, 215)]
    for jump, span in zip(jumps, spans, strict=True):
        made = propose_error_at_jump(search_in(both), jump, jumps)
        assert (made.start, made.stop) == span


def tilted(joint, start, stop, about, degrees=80.0):
    """The walk with a joint turned about an axis across its bone in some frames."""
    return spun(joint, start, stop, degrees, MOTION, about)


def jumps_of(motion, *kinds):
    return [i for i in tc.detect(motion) if i.kind in kinds]


BONE = own_bone_axis(SKELETON, SKELETON.index("LeftFoot"))
ACROSS = normalise(np.cross(BONE, (1.0, 0.0, 0.0)))


def test_a_suggested_angle_is_the_change_of_the_roll():
    """Far from the rest pose, a turn about the bone is only a part of this change."""
    foot = SKELETON.index("LeftFoot")
    bent = tilted("LeftFoot", 0, FRAMES, ACROSS)
    other = normalise(ACROSS + 1.2 * np.cross(BONE, ACROSS))
    rotations = bent.rotations.copy()
    rotations[100:110, foot] = multiply(
        tilted("LeftFoot", 100, 110, other).rotations[100:110, foot],
        quaternion_from_axis_angle(BONE, np.radians(130.0)),
    )
    motion = bent.with_rotations(rotations)
    roll = np.degrees(twist_angle(rotations[:, foot], BONE))
    change = np.median(roll[100:110]) - np.median(np.delete(roll, slice(100, 110)))
    jumps = jumps_of(motion, tc.Kind.LONE_JUMP)
    assert [jump.start for jump in jumps] == [100, 110]
    assert all(abs(np.degrees(jump.residual)) < abs(change) - 40.0 for jump in jumps)
    for jump in jumps:
        made = propose_error_at_jump(search_in(motion), jump, jumps)
        assert (made.kind, made.start, made.stop) == (tc.Kind.STRETCH, 100, 110)
        assert np.degrees(made.delta) == pytest.approx(change, abs=10.0)


def test_at_a_joint_jump_about_the_bone_a_stretch_is_suggested():
    motion = turned("LeftFoot", 100, 150, degrees=50.0)
    jumps = jumps_of(motion, tc.Kind.LONE_JUMP, tc.Kind.JOINT_JUMP)
    assert [(i.kind, i.start) for i in jumps] == [("joint jump", 100), ("joint jump", 150)]
    for jump in jumps:
        made = propose_error_at_jump(search_in(motion), jump, jumps)
        assert (made.kind, made.start, made.stop) == (tc.Kind.STRETCH, 100, 150)
        assert np.degrees(made.delta) == pytest.approx(50.0, abs=2.0)


@pytest.mark.parametrize(("stop", "kind"), [(110, tc.Kind.SPIKE), (160, None), (FRAMES, None)])
def test_at_another_joint_jump_a_spike_is_suggested_if_the_joint_soon_returns(stop, kind):
    motion = tilted("LeftFoot", 100, stop, ACROSS)
    jumps = jumps_of(motion, tc.Kind.JOINT_JUMP)
    assert [jump.start for jump in jumps] == [t for t in (100, stop) if t < FRAMES]
    for jump in jumps:
        made = propose_error_at_jump(search_in(motion), jump, jumps)
        assert (made and made.kind) == kind
        if made is not None:
            assert (made.start, made.stop, made.joint) == (100, stop, "LeftFoot")
            assert np.degrees(made.delta) == pytest.approx(80.0, abs=15.0)
            refined = tc.refine(motion, tc.find_chains(motion), [made])
            off = geodesic_angle(refined.rotations, MOTION.rotations)
            assert np.degrees(off).max() < 15.0


def test_no_stretch_is_suggested_that_would_not_remove_the_jump():
    """The roll differs, but the foot also swings to another side."""
    foot = SKELETON.index("LeftFoot")
    way = np.radians(100.0)
    other = np.cos(way) * ACROSS + np.sin(way) * np.cross(BONE, ACROSS)
    rotations = tilted("LeftFoot", 0, FRAMES, ACROSS).rotations.copy()
    rotations[100:160, foot] = multiply(
        tilted("LeftFoot", 100, 160, other).rotations[100:160, foot],
        quaternion_from_axis_angle(BONE, np.radians(120.0)),
    )
    motion = MOTION.with_rotations(rotations)
    roll = np.degrees(twist_angle(rotations[:, foot], BONE))
    assert np.median(roll[100:160]) - np.median(np.delete(roll, slice(100, 160))) > 100.0
    jumps = jumps_of(motion, tc.Kind.LONE_JUMP, tc.Kind.JOINT_JUMP, tc.Kind.STRETCH)
    assert [(i.kind, i.start) for i in jumps] == [("joint jump", 100), ("joint jump", 160)]
    assert [propose_error_at_jump(search_in(motion), jump, jumps) for jump in jumps] == [None, None]


def test_a_joint_that_is_kept_stays_where_it_is():
    motion = turned("RightHand", 100, 180, kept=True)
    refined = tc.refine(motion, accepted(motion, tc.Kind.STRETCH))
    assert compare_motions(motion, refined).max_position_of_height < 1e-9


def test_the_person_decides_what_happens_below():
    motion = turned("LeftUpLeg", 100, 180)
    review = accepted(motion, tc.Kind.STRETCH)
    judged = the_only(review.state, tc.Kind.STRETCH)
    (moving,) = review.accepted
    assert repair_moves_joints(motion, moving)
    review.do(Edit(judged.id, replace(moving, carried=False)))
    (moving,) = review.accepted
    assert not repair_moves_joints(motion, moving)
    knee = SKELETON.index("LeftLeg")
    before, _ = forward_kinematics(motion)
    after, _ = forward_kinematics(tc.refine(motion, review))
    assert geodesic_angle(before[:, knee], after[:, knee]).max() < 1e-7


def test_its_frames_and_its_angle_can_be_edited():
    motion = turned("LeftFoot", 100, 180)
    review = accepted(motion, tc.Kind.STRETCH, 90.0)
    judged = the_only(review.state, tc.Kind.STRETCH)
    review.do(Edit(judged.id, resized_interval(judged.interval, 90, 150)))
    foot, refined = SKELETON.index("LeftFoot"), tc.refine(motion, review)
    turn = geodesic_angle(motion.rotations[:, foot], refined.rotations[:, foot])
    np.testing.assert_allclose(np.degrees(turn[90:150]), 90.0)
    assert (refined.rotations[:90] == motion.rotations[:90]).all()
    assert (refined.rotations[150:] == motion.rotations[150:]).all()
    for _ in range(3):
        review.undo()
    assert review.accepted == ()
    assert np.degrees(the_only(review.state, tc.Kind.STRETCH).interval.delta) > 140.0


# -- spikes ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [1, 3])
@parametrize("joint", ["Spine1", "LeftForeArm", "Hips"], quick=2)
def test_a_spike_becomes_the_way_between_its_neighbours(joint, length):
    start, stop, at = 150, 150 + length, SKELETON.index(joint)
    motion = spiked(joint, start, stop)
    refined = tc.refine(motion, accepted(motion, tc.Kind.SPIKE))
    ends = MOTION.rotations[start - 1, at], MOTION.rotations[stop, at]
    for k in range(length):
        on_the_way = slerp(*ends, (k + 1) / (length + 1))
        assert geodesic_angle(refined.rotations[start + k, at], on_the_way) < 1e-9
    changed = (refined.rotations != motion.rotations).any(axis=-1)
    assert np.flatnonzero(changed.any(axis=1)).tolist() == list(range(start, stop))
    assert np.flatnonzero(changed.any(axis=0)).tolist() == [at]


def test_adjacent_spikes_are_bridged_as_one_and_an_end_of_the_clip_is_held():
    spike = tc.Interval(
        "LeftArm", 3, 5, np.ones(2), kind=tc.Kind.SPIKE, carried=True, joint="LeftArm"
    )
    arm, chains = SKELETON.index("LeftArm"), tc.find_chains(MOTION)
    refined = tc.refine(MOTION, chains, [spike, replace(spike, start=5, stop=7)])
    middle = slerp(MOTION.rotations[2, arm], MOTION.rotations[7, arm], 0.4)
    assert geodesic_angle(refined.rotations[4, arm], middle) < 1e-9
    refined = tc.refine(MOTION, chains, [replace(spike, start=0, stop=2)])
    assert geodesic_angle(refined.rotations[:2, arm], MOTION.rotations[2, arm]).max() < 1e-9


def test_any_part_of_the_clip_is_made_like_the_whole():
    from twistcore.analysis.correction.twist_removal import refiner

    motion = spiked("LeftForeArm", 150, 153)
    state = accepted(motion, tc.Kind.SPIKE).state
    made = refiner(motion, *state.to_correct(motion))
    whole = made(0, FRAMES).rotations
    for start, stop in ((151, 152), (149, 151), (152, 170), (0, 150)):
        np.testing.assert_array_equal(made(start, stop).rotations, whole[start:stop])


# -- nothing automatic -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("motion", "kind"),
    [
        (turned("LeftFoot", 200, 260), tc.Kind.STRETCH),
        (spiked("LeftForeArm", 150, 152), tc.Kind.SPIKE),
    ],
)
def test_nothing_corrects_it_but_a_person(motion, kind):
    found = tc.detect(motion)
    (one,) = (i for i in found if i.kind == kind)
    can = one.repairable, one.automatic, one.correctable, bool(one.offset.any())
    assert can == (False, False, False, False)
    row = next(row for row in found.to_rows() if row["kind"] == kind)
    assert row["delta_deg"] == 0.0
    alone = replace(found, intervals=(one,))
    review = tc.Review(alone)
    assert review.accept(0.0, include_open=True) == 0
    judged = the_only(review.state, kind)
    assert (judged.verdict, judged.counts) == ("undecided", False)
    for chosen in (alone, [one], review):
        np.testing.assert_array_equal(tc.refine(motion, chosen).rotations, motion.rotations)
    review.do(Decide((judged.id,), Decision.ACCEPTED))  # as a program does, without a name
    judged = the_only(review.state, kind)
    assert (judged.verdict, judged.counts) == ("accepted", True)
    assert (tc.refine(motion, review).rotations != motion.rotations).any()


def test_an_accepted_one_of_an_earlier_version_was_only_seen(stretched):
    """Its offset was 0: the same bytes are exported from its session."""
    clip, review = stretched
    state = tc.Review(review.state).state
    old = replace(
        state,
        intervals=tuple(
            replace(j, interval=j.interval.with_offset(j.interval.start, 0.0 * j.interval.offset))
            for j in state.intervals
        ),
    )
    judged = the_only(old, tc.Kind.STRETCH)
    assert (judged.verdict, judged.corrects, old.chosen()) == ("seen", False, ())
    assert (tc.refine(clip, tc.Review(old)).rotations == clip.motion.rotations).all()


def test_errors_of_two_joints_of_a_chain_stay_apart():
    """When τ changes, and when decisions are carried over to another take."""
    motion = turned("LeftFoot", 100, 180)
    review = accepted(motion, tc.Kind.STRETCH)
    judged = the_only(review.state, tc.Kind.STRETCH)
    found = [j.interval for j in review.state.intervals if j.interval.chain == "LeftLeg"]
    other = replace(judged.interval, joint="LeftLeg")
    review.do(Redetect({"LeftLeg": 0.1}, (*found, other)))
    own = [j for j in review.state.intervals if j.interval.kind == tc.Kind.STRETCH]
    assert [(j.interval.joint, j.decision) for j in own] == [
        ("LeftFoot", "accepted"),
        ("LeftLeg", "undecided"),
    ]
    fresh = tc.Review(tc.detect(motion))
    fresh.do(CarryOver(tuple(j for j in review.state.intervals if j.interval is other)))
    assert the_only(fresh.state, tc.Kind.STRETCH).decision == "undecided"
    fresh.do(CarryOver(review.state.intervals))
    assert the_only(fresh.state, tc.Kind.STRETCH).decision == "accepted"


def test_a_lone_jump_still_cannot_be_edited():
    motion = turned("LeftFoot", 40, 42, degrees=170.0)
    review = tc.Review(tc.detect(motion))
    judged = next(j for j in review.state.intervals if not j.interval.kind.correctable)
    with pytest.raises(ValueError, match="not corrected"):
        review.do(Edit(judged.id, judged.interval))


# -- files -----------------------------------------------------------------------------------------


def numbers(path):
    return [line.split() for line in path.read_bytes().split(b"\n")]


def test_only_the_joint_in_its_frames_is_written(stretched, tmp_path):
    clip, review = stretched
    session, out = tmp_path / "clip.twist.json", tmp_path / "out.bvh"
    tc.write_session(clip, review, session)
    assert json.loads(session.read_text("utf-8"))["schema"] == "twistcore.session/5"
    code, printed, _ = run("apply", session, clip.path, "-o", out)
    assert code == 0
    assert "1 of 1 intervals applied (1 stretch)" in printed
    own = tmp_path / "own.bvh"
    tc.write_clip(clip, tc.refine(clip, review), own)
    assert own.read_bytes() == out.read_bytes()
    before, after = numbers(clip.path), numbers(out)
    first = next(k for k, line in enumerate(before) if line[:1] == [b"Frame"]) + 1
    assert before[:first] == after[:first]
    foot = 3 + 3 * SKELETON.index("LeftFoot")
    for t, (old, new) in enumerate(zip(before[first:], after[first:], strict=True)):
        changed = {k for k, (a, b) in enumerate(zip(old, new, strict=True)) if a != b}
        assert changed <= set(range(foot, foot + 3)) if 200 <= t < 260 else not changed
    code, printed, _ = run("apply", session, clip.path, "-o", out, "--json")
    document = json.loads(printed)
    assert (document["applied"], document["repairable"]) == (1, 1)


def test_a_session_gives_back_the_decision(stretched, tmp_path):
    clip, review = stretched
    path = tmp_path / "clip.twist.json"
    tc.write_session(clip, review, path)
    again = tc.read_session(path)
    one, other = (the_only(s, tc.Kind.STRETCH) for s in (review.state, again.state))
    assert (other.decision, other.reviewer, other.interval.carried) == ("accepted", "Ada", True)
    np.testing.assert_array_equal(one.interval.offset, other.interval.offset)
    refined = [tc.refine(clip, tc.Review(s)).rotations for s in (review.state, again.state)]
    np.testing.assert_array_equal(*refined)
    review.do(Decide((one.id,), Decision.REJECTED))
    tc.write_session(clip, review, path)
    assert json.loads(path.read_text("utf-8"))["schema"] == "twistcore.session/3"


def test_a_journal_gives_back_the_decision(stretched, tmp_path):
    clip, _ = stretched
    state = tc.Review(tc.detect(clip)).state
    judged = the_only(state, tc.Kind.STRETCH)
    journal = Journal(tmp_path / "clip.journal", clip, state)
    journal.do(Edit(judged.id, replace(judged.interval, carried=False)))
    journal.do(Decide((judged.id,), Decision.ACCEPTED, "Ada", "2026-01-01T00:00:00+00:00"))
    journal.close()
    found = the_only(replay_journal(journal.path).review.state, tc.Kind.STRETCH)
    assert (found.verdict, found.interval.carried) == ("accepted", False)


def test_a_session_with_a_joint_of_another_clip_is_refused(stretched, tmp_path):
    clip, review = stretched
    path = tmp_path / "clip.twist.json"
    tc.write_session(clip, review, path)
    path.write_text(path.read_text("utf-8").replace('"joint": "LeftFoot"', '"joint": "Tail"'))
    code, _, err = run("apply", path, clip.path, "-o", tmp_path / "out.bvh")
    assert (code, "Tail" in err) == (2, True)
    with pytest.raises(TwistError, match="Tail"):
        tc.refine(clip, tc.Review(tc.read_session(path).state))
    assert issubclass(ClipMismatchError, TwistError)


def test_a_joint_without_three_channels_is_left_and_said(stretched):
    from twistcore.review.replay import uncorrected_and_moved_joint_sentences

    clip, review = stretched
    free = np.ones(len(SKELETON), dtype=bool)
    free[SKELETON.index("LeftFoot")] = False
    fixed = replace(clip.motion, skeleton=replace(clip.motion.skeleton, rotatable=free))
    assert (tc.refine(fixed, review).rotations == fixed.rotations).all()
    chains, chosen = review.state.to_correct(fixed)

    class Fixed:
        motion, path = fixed, clip.path

    (left,), moved = uncorrected_and_moved_joint_sentences(Fixed, chains, chosen)
    assert "LeftFoot" in left
    assert moved == ()


def test_notes_say_what_moves_along(tmp_path):
    path = tmp_path / "clip.bvh"
    tc.write_clip(WALK, spiked("LeftForeArm", 150, 152), path)
    clip = read_bvh(path)
    session = tmp_path / "clip.twist.json"
    tc.write_session(clip, accepted(clip.motion, tc.Kind.SPIKE), session)
    code, _, err = run("apply", session, path, "-o", tmp_path / "out.bvh")
    assert (code, "correcting LeftForeArm also moves the joints below it" in err) == (0, True)


# -- what people see -------------------------------------------------------------------------------


def test_the_report_lists_it_as_a_correction(stretched, tmp_path):
    clip, review = stretched
    refined = tc.refine(clip, review)
    report = Report(clip, review.state.to_correct(clip.motion)[0], review.state, refined)
    document = report_to_json(report)
    row = next(row for row in document["intervals"] if row["kind"] == "stretch")
    assert (row["decision"], row["end"], row["joint"]) == ("accepted", "carried", "LeftFoot")
    assert document["decisions"]["seen"] == 0
    assert document["changed"]["joints"] == ["LeftFoot"]
    assert {move["why"] for move in document["changed"]["moved"]} <= {"stretch"}
    session = tmp_path / "clip.twist.json"
    tc.write_session(clip, review, session)
    args = ("-o", tmp_path / "pages", "--clip", clip.path, "--no-pictures")
    assert run("report", session, *args)[0] == 0
    (page,) = (tmp_path / "pages").glob("*.html")
    text = page.read_text("utf-8")
    assert "stretch of LeftFoot, joints below carried" in text
    assert "Stretch of LeftFoot, +1" in text


def test_a_scene_script_sets_keys_for_the_joint_alone(stretched, tmp_path):
    clip, review = stretched
    session, script = tmp_path / "clip.twist.json", tmp_path / "keys.py"
    tc.write_session(clip, review, session)
    assert run("export", session, clip.path, "--script", "blender", "-o", script)[0] == 0
    names = {}
    text = script.read_text("utf-8")
    exec(text[text.index("INTERVALS") : text.index("# frames without")], names)
    assert list(names["KEYS"]) == ["LeftFoot"]
    assert [frame for frame, *_ in names["KEYS"]["LeftFoot"]] == list(range(200, 260))
    assert "stretch of LeftFoot" in names["INTERVALS"][0]


def test_the_written_file_is_checked_against_its_source(stretched, tmp_path):
    clip, review = stretched
    refined, out = tc.refine(clip, review), tmp_path / "out.bvh"
    tc.write_clip(clip, refined, out)
    checked = check_fidelity_of_written_clip(clip, refined, out)
    assert (checked.outside, checked.head) == (0, True)
    assert checked.total - checked.same <= 3


@pytest.mark.parametrize(
    ("motion", "kind"),
    [
        (turned("RightHand", 200, 260, kept=True), tc.Kind.STRETCH),
        (turned("LeftArm", 200, 260), tc.Kind.STRETCH),
        (spiked("LeftForeArm", 150, 153), tc.Kind.SPIKE),
        (spiked("LeftLeg", 150, 153), tc.Kind.SPIKE),
    ],
)
def test_views_show_the_corrected_motion(motion, kind):
    analysis, state = analyse(motion), accepted(motion, kind).state
    corrected, refined = Corrected(analysis), tc.refine(motion, tc.Review(state))
    corrected.take(state.chosen())
    rotations, positions = forward_kinematics(refined)
    for frame in (149, 151, 152, 199, 230, 259):
        shown = corrected.pose(frame)
        np.testing.assert_allclose(shown[0], rotations[frame], atol=1e-12)
        np.testing.assert_allclose(shown[1], positions[frame], atol=1e-9)
    interval = state.chosen()[0]
    assert corrected.repairs(interval.start) == (interval,)
    assert corrected.repairs(interval.stop) == ()
    for chain in analysis.chains:
        after, exact = corrected.angles(chain), twist_signals(refined, chain)
        np.testing.assert_allclose(wrap(after.theta_p - exact.theta_p), 0.0, atol=1e-9)
    for limb in analysis.limbs:
        true = analysis.flips.limbs[limb.name].swivel.angle_at(
            *limb_middle_and_end_positions(refined, limb)
        )
        off = wrap(corrected.swivel(limb) - true)[interval.start : interval.stop]
        np.testing.assert_allclose(off, 0.0, atol=1e-9)


def test_protected_measures_compare_before_and_after():
    motion = turned("LeftUpLeg", 200, 260)
    (interval,) = accepted(motion, tc.Kind.STRETCH).accepted
    measures = {m.name: m for m in protected_measures(motion, analyse(motion).chains, interval)}
    assert measures["ends"].after < 1e-9
    turns = measures["impossible turns"]
    assert (turns.before, turns.after, turns.worse) == (2.0, 0.0, False)
    motion = spiked("LeftForeArm", 150, 153)
    (interval,) = accepted(motion, tc.Kind.SPIKE).accepted
    names = {m.name for m in protected_measures(motion, analyse(motion).chains, interval)}
    assert "ends" not in names


def test_every_repair_can_be_loaded():
    kinds = [kind for kind in tc.Kind if kind.info.repairer]
    assert kinds == [tc.Kind.STRETCH, tc.Kind.TURNED_END, tc.Kind.SPIKE]
    assert [kind.by_angle for kind in kinds] == [True, False, False]
    assert all(repair_of(kind) for kind in kinds)
    assert repair_of(tc.Kind.LONE_JUMP) is None
    assert not any(kind.repairable or kind.info.automatic for kind in kinds)
    assert JointRepairs([tc.Interval("LeftArm", 0, 3, np.ones(3))]).intervals == ()
