"""Jumps that no body makes: told with their speed, whatever else is wrong, and never taken out."""

import csv
import gc
import json
import re
import weakref
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from tests.twistcore.reviews import spun as spun_in
from twistcore.analysis.clip_analysis import RESTLESS, analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine, refiner
from twistcore.cli import main
from twistcore.detection import Interval, Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.detection.lone_jumps import largest_natural_turn, lone_jumps
from twistcore.detection.noise_bursts import NoiseBurst
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.review import (
    Decide,
    Decision,
    Insert,
    Redetect,
    Review,
    read_session,
    write_session,
)
from twistcore.review.model import overlapping_ids
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.notes import RESTLESS_CLIP
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle
from twistcore.synthesis.protocol import PROTOCOLS, prepare_clean_motion_for_injection

WALK = read_bvh(ASSETS / "walk.bvh")
CLEAN = ("walk", "dance", "basketball")


@pytest.fixture(autouse=True)
def no_stretches(monkeypatch):
    """A joint that is turned for ten frames is a stretch as well: see test_stretches.py."""
    monkeypatch.setattr("twistcore.detection.stretches.find_stretches", lambda _: {})


def spun(joint, start, stop, degrees, motion=WALK.motion):
    return spun_in(joint, start, stop, degrees, motion)


def jumps_of(motion):
    return [i for own in lone_jumps(motion, find_chains(motion)).values() for i in own]


@pytest.mark.parametrize("name", CLEAN)
def test_clips_at_their_best_have_none(name):
    assert jumps_of(read_bvh(ASSETS / f"{name}.bvh").motion.sliced(1, 300)) == []


@pytest.mark.parametrize("joint", ["LeftFoot", "RightForeArm", "LeftUpLeg", "RightHand"])
def test_a_joint_that_jumps_alone_is_told_at_both_jumps(joint):
    found = jumps_of(spun(joint, 100, 110, 140.0))
    assert [(i.joint, i.start, i.stop) for i in found] == [(joint, 100, 101), (joint, 110, 111)]
    chains = {c.name: c for c in find_chains(WALK.motion)}
    names = WALK.motion.skeleton.names
    for interval in found:
        chain = chains[interval.chain]
        assert joint in (names[chain.parent], names[chain.child])
        assert interval.kind == Kind.LONE_JUMP
        assert interval.open
        assert not interval.offset.any()
        assert abs(abs(np.degrees(interval.size)) - 140.0) < 8.0
        told = interval.evidence
        assert told["speed_deg_s"] == pytest.approx(abs(told["turn_deg"]) * 120.0, rel=1e-3)
        assert told["limit_deg_s"] == pytest.approx(7500.0)


def test_children_that_go_along_are_not_told():
    found = jumps_of(spun("LeftArm", 100, 110, 140.0))
    assert {i.joint for i in found} == {"LeftArm"}


@pytest.mark.parametrize(("degrees", "listed"), [(29.0, False), (34.0, True)])
def test_a_child_that_turns_a_little_more_than_its_parent_only_follows(degrees, listed):
    found = jumps_of(spun("LeftForeArm", 100, 110, degrees, spun("LeftArm", 100, 110, 140.0)))
    assert ("LeftForeArm" in {i.joint for i in found}) == listed


def test_jumps_between_held_frames_have_the_frames_of_the_clip():
    turned = spun("LeftFoot", 204, 260, -60.0, spun("LeftFoot", 200, 204, 150.0))
    (jump,) = jumps_of(turned.at(np.repeat(np.arange(0, turned.frames, 4), 4)))
    assert (jump.start, jump.stop, len(jump.offset)) == (200, 205, 5)


def test_frames_one_after_the_other_are_one_jump_of_the_fastest():
    motion = spun("LeftFoot", 101, 344, 80.0, spun("LeftFoot", 100, 344, 120.0))
    (jump,) = jumps_of(motion)
    assert (jump.start, jump.stop) == (100, 102)
    assert abs(np.degrees(jump.size) - 120.0) < 8.0


def test_the_limit_is_a_speed_but_not_of_noise_nor_of_slow_cameras():
    assert np.degrees(
        [largest_natural_turn(f) for f in (240.0, 120.0, 60.0, 30.0)]
    ) == pytest.approx([60.0, 62.5, 125.0, 120.0])
    assert jumps_of(spun("LeftFoot", 100, 110, 55.0)) == []
    slow = prepare_clean_motion_for_injection(
        WALK.motion, find_chains(WALK.motion), PROTOCOLS["H1"]
    )
    assert jumps_of(spun("LeftFoot", 30, 40, 100.0, slow)) == []
    assert len(jumps_of(spun("LeftFoot", 30, 40, 150.0, slow))) == 2


def test_what_an_interval_explains_is_no_lone_jump():
    walk = analyse(read_bvh(ASSETS / "walk_injected.bvh"))
    kick = analyse(read_bvh(ASSETS / "kick.bvh"))
    assert len(jumps_of(walk.motion)) > 0  # the injected ones, as they stand
    assert not any(walk.jumps().values())
    legs = [i for i in jumps_of(kick.motion) if i.joint == "RightUpLeg"]
    assert len(legs) > 10
    left = {i.joint for own in kick.jumps().values() for i in own}
    assert left == {"RightFoot"}  # which the capture has jump otherwise, too


def test_they_are_listed_and_never_taken_out():
    analysis = analyse(spun("LeftFoot", 100, 110, 140.0))
    found = analysis.detect()
    assert [i.kind for i in found] == [Kind.LONE_JUMP] * 2
    assert automatic_corrections(found, include_open=True) == ()
    review = Review.of(found)
    review.accept(include_open=True)
    assert review.accepted == ()
    refined = refine(analysis.motion, analysis.chains_and_limbs, found)
    assert (refined.rotations == analysis.motion.rotations).all()
    assert analysis.detect(kinds={Kind.COUNTER_TWIST}).intervals == ()
    only = analysis.detect(kinds={Kind.LONE_JUMP})
    assert [(i.start, i.joint) for i in only] == [(100, "LeftFoot"), (110, "LeftFoot")]


def test_a_session_keeps_who_jumped_and_by_how_much(tmp_path):
    path = tmp_path / "spun.bvh"
    write_motion(spun("LeftFoot", 100, 110, 140.0), path)
    clip = read_bvh(path)
    review = Review.of(analyse(clip).detect())
    write_session(clip, review.state, tmp_path / "s.json")
    document = json.loads((tmp_path / "s.json").read_text())
    assert document["schema"] == "twistcore.session/3"
    back = read_session(tmp_path / "s.json").state.intervals
    assert [(j.interval.joint, j.interval.kind) for j in back] == [("LeftFoot", Kind.LONE_JUMP)] * 2
    assert np.degrees(back[0].interval.size) == pytest.approx(
        np.degrees(review.state.intervals[0].interval.size), abs=1e-8
    )


def test_the_command_tells_the_speed_and_the_limit(tmp_path, capsys):
    path = tmp_path / "spun.bvh"
    write_motion(spun("LeftFoot", 100, 110, 140.0), path)
    assert main(["detect", str(path)]) == 0
    said = capsys.readouterr().out.splitlines()[1:]
    assert "LeftFoot" in said[0]
    assert "lone jump, " in said[0]
    assert "62°" in said[0]
    assert main(["detect", str(path), "--json"]) == 0
    first = json.loads(capsys.readouterr().out)["intervals"][0]
    assert (first["kind"], first["chain"], first["joint"]) == ("lone jump", "LeftLeg", "LeftFoot")
    assert first["speed_deg_s"] > first["limit_deg_s"] == pytest.approx(7500.0)
    assert main(["detect", str(path), "--kinds", "counter-twist,limb-flip"]) == 0
    assert capsys.readouterr().out.startswith("0 intervals")


def test_seen_ones_are_in_no_count_of_what_was_corrected(tmp_path, capsys):
    path, session, out = tmp_path / "spun.bvh", tmp_path / "s.json", tmp_path / "o.bvh"
    write_motion(spun("LeftFoot", 100, 110, 140.0), path)
    clip = read_bvh(path)
    review = Review.of(analyse(clip).detect())
    review.do(Decide((1,), Decision.ACCEPTED))
    review.do(Insert(new_constant_offset_interval("LeftForeArm", 10, 20, 0.5)))
    review.do(Insert(new_constant_offset_interval("LeftForeArm", 30, 40, 0.5)))
    review.do(Decide((3,), Decision.ACCEPTED))
    write_session(clip, review.state, session)
    assert [(i.chain, i.start) for i in review.accepted] == [("LeftForeArm", 10)]
    assert main(["apply", str(session), str(path), "-o", str(out)]) == 0
    told = capsys.readouterr().out
    assert names_in_one_line(told, f"{out}: ", "1 of 2 intervals", "1 counter-twist", "1 lone jump")
    review.do(Decide((1,), Decision.UNDECIDED))
    write_session(clip, review.state, session)
    assert main(["apply", str(session), str(path), "-o", str(out)]) == 0
    assert numbers(capsys.readouterr().out) == [1, 2, 1]
    assert main(["refine", str(path), "-o", str(out), "--report", str(tmp_path)]) == 0
    assert numbers(capsys.readouterr().out) == [0, 0, 2]


def test_the_report_tells_the_turn_the_speed_and_that_it_was_seen(tmp_path):
    path = tmp_path / "spun.bvh"
    write_motion(spun("LeftFoot", 100, 110, 140.0), path)
    clip, analysis = read_bvh(path), analyse(read_bvh(path))
    review = Review.of(analysis.detect())
    review.do(Decide((1,), Decision.ACCEPTED))
    review.do(Insert(new_constant_offset_interval("LeftForeArm", 10, 20, 0.5)))
    chains = analysis.chains_and_limbs
    page, table, markers, listing = write_clip_report(
        tmp_path, Report(clip, chains, review.state, clip.motion)
    )
    document = json.loads(listing.read_bytes())
    told = {"undecided": 2, "seen": 1}
    assert {what: count for what, count in document["decisions"].items() if count} == told
    seen = next(i for i in document["intervals"] if i["decision"] == "seen")
    jump = review.state.find(1).interval
    assert seen["delta_deg"] == pytest.approx(np.degrees(jump.size), abs=1e-4)
    assert abs(seen["delta_deg"]) > 130.0
    assert seen["speed_deg_s"] == pytest.approx(jump.evidence["speed_deg_s"], abs=0.1)
    assert seen["joint"] == "LeftFoot"
    twist = next(i for i in document["intervals"] if i["kind"] == "counter-twist")
    assert (twist["joint"], twist["speed_deg_s"]) == ("", None)
    rows = {row["id"]: row for row in csv.DictReader(table.read_text("utf-8").splitlines())}
    assert float(rows["1"]["speed_deg_s"]) == seen["speed_deg_s"]
    assert (rows["1"]["decision"], rows[str(twist["id"])]["speed_deg_s"]) == ("seen", "")
    text = page.read_text("utf-8")
    turn = f"{seen['delta_deg']:+.2f}° at {seen['speed_deg_s']:,.0f}°/s"
    assert re.search(f"<td>lone jump .*LeftFoot.*{re.escape(turn)}</td>", text)
    assert '<td class="seen">seen</td>' in text
    assert f"LeftFoot lone jump {np.degrees(jump.size):+.1f}" in markers.read_text("utf-8")


def test_a_jump_and_a_twist_in_the_same_frames_are_two_findings():
    """Detection anew at another τ neither swaps them nor lets one stand for the other."""
    analysis = analyse(spun("LeftFoot", 100, 110, 140.0))
    state = Review.of(analysis.detect()).state
    twist = Interval("LeftLeg", 100, 101, np.ones(1))
    assert {j.interval.kind for j in state.intervals} == {Kind.LONE_JUMP}
    state = Insert(twist).apply(state)
    assert overlapping_ids(state.intervals) == frozenset()
    again = analysis.detector().intervals("LeftLeg", np.radians(5.0))
    after = Redetect({"LeftLeg": np.radians(5.0)}, again).apply(state)
    assert sorted(j.interval.kind for j in after.intervals) == [
        Kind.COUNTER_TWIST,
        Kind.LONE_JUMP,
        Kind.LONE_JUMP,
    ]


def test_a_cut_is_no_jump_of_a_joint():
    motion = WALK.motion
    rotations = motion.rotations.copy()
    turn = quaternion_from_axis_angle(np.array([0.0, 1.0, 0.0]), np.radians(140.0))
    rotations[200:] = multiply(rotations[200:], turn)  # every joint, from one frame to the next
    assert jumps_of(motion.with_rotations(rotations)) == []


def test_in_a_clip_full_of_lone_jumps_nothing_is_corrected_unasked():
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    calm = analyse(motion).detect()
    assert automatic_corrections(calm)
    assert not analyse(motion).restless()
    for k in range(8):
        motion = spun("LeftFoot", 20 + 40 * k, 22 + 40 * k, 170.0, motion)
    clip = analyse(motion)
    found = clip.detect()
    assert clip.restless()
    assert sum(i.kind == Kind.LONE_JUMP for i in found) >= RESTLESS
    assert sum(i.repairable for i in found) >= sum(i.repairable for i in calm) // 2
    assert not automatic_corrections(found)
    assert RESTLESS_CLIP in {note.kind for note in found.notes}
    one = next(i for i in found if i.repairable)
    assert "lone jumps" in one.evidence["doubts"][0]
    again = clip.detector().intervals(one.chain, clip.detector().automatic_tau(one.chain))
    assert any(i is one for i in again)


def test_a_clip_full_of_lone_jumps_is_so_whatever_is_asked_of_it():
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    for k in range(8):
        motion = spun("LeftFoot", 20 + 40 * k, 22 + 40 * k, 170.0, motion)
    for kind in (Kind.COUNTER_TWIST, Kind.LIMB_FLIP):
        found = analyse(motion).detect(kinds={kind})
        assert all(i.open for i in found)
        assert RESTLESS_CLIP in {note.kind for note in found.notes}
    assert RESTLESS_CLIP in {n.kind for n in analyse(motion, ["LeftArm"]).detect().notes}


def test_asking_of_a_detector_without_confidence_keeps_nothing_alive():
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    for k in range(8):
        motion = spun("LeftFoot", 20 + 40 * k, 22 + 40 * k, 170.0, motion)
    clip = analyse(motion)
    first = weakref.ref(next(i for i in clip.detect("paper") if i.repairable))
    gc.collect()
    assert first() is None


def test_jumps_in_a_burst_of_noise_make_no_clip_restless():
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    jumpy = motion
    for k in range(8):
        jumpy = spun("LeftFoot", 20 + 40 * k, 22 + 40 * k, 170.0, jumpy)
    assert analyse(jumpy).restless()
    clip = analyse(jumpy)
    foot = motion.skeleton.index("LeftFoot")
    vars(clip)["bursts"] = (NoiseBurst(foot, 0, motion.frames, 10.0),)
    assert not clip.restless()


@pytest.mark.parametrize("block", [1, 7, 100, 101, 1000])
def test_blocks_of_frames_give_the_jumps_of_the_whole(monkeypatch, block):
    """Jumps at the borders of blocks, and next to errors that are taken out first."""
    motion = spun("LeftFoot", 100, 101, 140.0, spun("RightHand", 99, 107, 120.0))
    chains = find_chains(motion)
    known = [Interval(chains[k].name, s, s + 12, np.full(12, 1.0)) for k, s in ((0, 95), (3, 101))]
    motion = refine(motion, chains, [replace(i, offset=-i.offset) for i in known])
    whole = lone_jumps(refine(motion, chains, known), chains)
    assert sum(map(len, whole.values())) == 3  # one of them over two frames
    monkeypatch.setattr("twistcore.detection.lone_jumps._BLOCK", block)
    found = lone_jumps(motion, chains, refiner(motion, chains, known))
    for name, own in whole.items():
        ours = [(i.joint, i.start, i.stop, i.residual) for i in found[name]]
        assert ours == [(i.joint, i.start, i.stop, pytest.approx(i.residual)) for i in own]
