"""Noise bursts and frozen frames are finds of their own: listed, seen, and never corrected."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.messages import refused
from tests.tiers import parametrize
from tests.twistcore.test_frozen_frames import frozen
from tests.twistcore.test_noise_bursts import ARM, HAND, START, STOP, WALK, noisy
from twistcore.analysis.clip_analysis import REPAIRED, analyse
from twistcore.analysis.clip_severity import measure_clip_severity
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.analysis.why_not import Why, why_frame_bounds_no_interval
from twistcore.batch.gates import broken_rules, parse_batch_rule
from twistcore.cli.interval_words import error_kind_counts_text, uncorrectable_counts
from twistcore.detection import Kind
from twistcore.detection.capture_faults import burst_intervals
from twistcore.detection.noise_bursts import NoiseBurst
from twistcore.export.detection_json import intervals_to_json
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.review import Decide, Decision, Edit, Review
from twistcore.review.model import SEEN
from twistcore.review.session import read_session, write_session
from twistcore.skeleton.notes import FROZEN, NOISE

FAULTS = frozenset({Kind.NOISE_BURST, Kind.FROZEN})
NECK = WALK.skeleton.index("Neck")
ARM_JOINTS = "RightShoulder", "RightArm", "RightForeArm", "RightHand"


def faulty():
    """The walk with noise in the left arm and the neck, and a right arm that is held before it."""
    return frozen(50, 100, *ARM_JOINTS, motion=noisy(ARM, HAND, NECK))


def faulty_clip():
    """The same as a BVH file has it."""
    source = read_bvh(ASSETS / "walk.bvh")
    return parse_bvh(create_file_patch_for_motion(source, faulty()).data, source.path)


@pytest.fixture(scope="module")
def found():
    return analyse(faulty()).detect()


@pytest.fixture(scope="module")
def clip():
    return faulty_clip()


def of(found, kind):
    return [i for i in found if i.kind == kind]


def test_each_chain_lists_its_own_burst(found):
    bursts = of(found, Kind.NOISE_BURST)
    assert [(i.chain, i.joint) for i in bursts] == [
        ("LeftArm", "LeftArm"),
        ("LeftForeArm", "LeftForeArm"),
    ]
    for burst in bursts:
        assert abs(burst.start - START) <= 2
        assert abs(burst.stop - STOP) <= 2
        assert np.degrees(burst.residual) == pytest.approx(9.2, rel=0.3)
        assert (burst.open, burst.confidence, burst.offset.any()) == (True, None, False)


def test_a_frozen_arm_is_a_row_of_its_first_chain(found):
    (row,) = of(found, Kind.FROZEN)
    assert (row.chain, row.joint) == ("RightShoulder", "RightShoulder")
    assert (row.start, row.stop) == (50, 100)
    assert row.evidence["part"] == "right arm"
    assert row.angle_text(1) == "–"


def test_bursts_of_one_chain_that_overlap_are_one_row_named_by_the_noisiest():
    chains = [c for c in analyse(WALK).chains if c.parent == ARM]
    hand = chains[0].child
    bursts = [
        NoiseBurst(ARM, 10, 40, 5.0),
        NoiseBurst(hand, 30, 60, 9.0),
        NoiseBurst(ARM, 65, 80, 6.0),  # a gap of five frames is none
        NoiseBurst(ARM, 200, 230, 7.0),
        NoiseBurst(NECK, 10, 40, 20.0),
    ]
    (rows,) = burst_intervals(WALK, chains, bursts).values()
    names = WALK.skeleton.names
    assert [(i.start, i.stop, i.joint) for i in rows] == [
        (10, 80, names[hand]),
        (200, 230, names[ARM]),
    ]
    assert rows[0].evidence["joints"] == sorted({names[ARM], names[hand]})


def test_notes_count_the_rows_and_name_what_no_chain_has(found):
    said = [str(n) for n in found.notes if n.kind == NOISE]
    assert len(said) == 2
    assert said[0].startswith("2 bursts")
    assert "(Neck)" in said[1]
    assert "LeftArm" not in said[1]
    assert len([n for n in found.notes if n.kind == FROZEN]) == 1


def test_notes_are_true_where_nothing_is_listed(found):
    only = found.analysis.detect(kinds={Kind.COUNTER_TWIST})
    said = [str(n) for n in only.notes if n.kind in (NOISE, FROZEN)]
    assert said == [str(n) for n in found.notes if n.kind in (NOISE, FROZEN)]
    assert not any("listed" in text for text in said)
    for kind in FAULTS:
        assert any(f"kind '{kind}'" in text for text in said)


def test_sound_clips_have_none():
    for name in ("walk", "dance", "walk_injected"):
        assert not FAULTS & {i.kind for i in analyse(read_bvh(ASSETS / f"{name}.bvh")).detect()}


def test_kinds_are_chosen_by_name(found):
    only = found.analysis.detect(kinds=FAULTS)
    assert {i.kind for i in only} == FAULTS
    assert not FAULTS & {i.kind for i in found.analysis.detect(kinds=REPAIRED)}
    assert not FAULTS & {i.kind for i in found.analysis.detect(kinds={Kind.LONE_JUMP})}


def test_a_chain_alone_has_the_same_rows_as_the_whole_clip(found):
    (burst,) = of(analyse(faulty(), ["LeftForeArm"]).detect(), Kind.NOISE_BURST)
    whole = next(i for i in of(found, Kind.NOISE_BURST) if i.chain == "LeftForeArm")
    assert (burst.start, burst.stop, burst.joint) == (whole.start, whole.stop, whole.joint)


@parametrize("chain", ["RightArm", "RightForeArm"])
def test_a_frozen_limb_is_a_row_of_the_first_chain_that_was_asked_for(chain):
    several = analyse(faulty(), [chain, "LeftForeArm", "RightForeArm"]).detect()
    (row,) = of(several, Kind.FROZEN)
    assert (row.chain, row.joint, row.start, row.stop) == (chain, chain, 50, 100)


def test_a_noisy_joint_is_a_row_of_the_chain_that_ends_in_it():
    noise = noisy(HAND)  # a joint that LeftForeArm begins with, and LeftArm ends in
    (whole,) = of(analyse(noise).detect(), Kind.NOISE_BURST)
    (row,) = of(analyse(noise, ["LeftArm"]).detect(), Kind.NOISE_BURST)
    assert (row.chain, row.joint, row.start) == ("LeftArm", whole.joint, whole.start)
    both = analyse(noise, ["LeftArm", "LeftForeArm"]).detect()
    assert [i.chain for i in of(both, Kind.NOISE_BURST)] == [whole.chain] == ["LeftForeArm"]


@pytest.mark.parametrize(("arm", "kind"), [("Left", NOISE), ("Right", FROZEN)])
def test_a_limb_alone_has_a_note_on_its_faults(arm, kind):
    alone = analyse(faulty(), [f"{arm}Arm-{arm}Hand"]).detect()
    assert not FAULTS & {i.kind for i in alone}
    notes = [n.kind for n in alone.notes if "kind '" in str(n)]
    assert notes == [kind]


def test_nothing_is_taken_out_however_much_is_asked_for(found):
    assert not FAULTS & {i.kind for i in automatic_corrections(found, 0.0, include_open=True)}
    review = Review.of(found)
    review.accept(0.0, include_open=True)
    for judged in review.state.intervals:
        if judged.interval.kind in FAULTS:
            assert judged.decision == Decision.UNDECIDED


def test_accepted_is_seen_and_is_no_correction(found):
    review = Review.of(found)
    rows = [j for j in review.state.intervals if j.interval.kind in FAULTS]
    review.do(Decide(tuple(j.id for j in rows), Decision.ACCEPTED))
    assert {review.state.find(j.id).verdict for j in rows} == {SEEN}
    assert not FAULTS & {i.kind for i in review.state.chosen(undecided=True)}
    with refused(ValueError):
        Edit(rows[0].id, rows[0].interval.with_offset(3, np.ones(4))).apply(review.state)


def test_a_session_brings_the_rows_back(found, clip, tmp_path):
    review = Review.of(found)
    path = tmp_path / "walk.twist.json"
    write_session(clip, review.state, path)
    back = read_session(path).state.intervals
    assert [(j.interval.kind, j.interval.joint, j.interval.start) for j in back] == [
        (i.kind, i.joint, i.start) for i in (j.interval for j in review.state.intervals)
    ]
    was = [j.interval.residual for j in review.state.intervals]
    assert [j.interval.residual for j in back] == pytest.approx(was)


def test_counts_in_words(found):
    rows = [*of(found, Kind.NOISE_BURST), *of(found, Kind.FROZEN)]
    assert uncorrectable_counts(rows) == ", 2 noise bursts, 1 frozen span"
    assert error_kind_counts_text(rows) == " (2 noise bursts, 1 frozen span)"
    assert uncorrectable_counts(rows[:1], " seen") == ", 1 noise burst seen"


def test_gates_count_them_only_where_asked(found):
    faults = replace(found, intervals=tuple(i for i in found if i.kind in FAULTS))
    result = {"intervals": intervals_to_json(faults), "frames": WALK.frames, "unchecked": ""}
    result |= {"severity": 0.0, "affected_frames": 0}
    record = SimpleNamespace(name="walk.bvh", state="done", result=result)

    def is_broken(rule):
        return bool(broken_rules([parse_batch_rule(rule)], [record]))

    assert not is_broken("count>0")
    assert not is_broken("degrees>0")
    assert not is_broken("affected>0%")
    assert is_broken("count[noise-burst]>1")
    assert is_broken("count[frozen-frames]==1")
    assert is_broken("degrees[noise-burst]>5")
    assert is_broken("affected[noise-burst]>30%")


def test_severity_does_not_count_them(found):
    faults = replace(found, intervals=tuple(i for i in found if i.kind in FAULTS))
    assert measure_clip_severity(faults) == 0.0


def test_a_frame_in_a_burst_is_explained_by_it(found):
    reason = why_frame_bounds_no_interval(found, "LeftArm", (START + STOP) // 2)
    assert reason.why == Why.INTERVAL
    assert "noise burst" in reason.text
    held = why_frame_bounds_no_interval(found, "RightShoulder", 70)
    assert "frozen frames" in held.text


def test_the_report_lists_them_without_an_offset(found, clip, tmp_path):
    review = Review.of(found)
    report = Report(clip, found.chains_and_limbs, review.state, clip.motion)
    page, _, _, listing = write_clip_report(tmp_path, report)
    rows = json.loads(listing.read_bytes())["intervals"]
    noise = [r for r in rows if r["kind"] == "noise burst"]
    assert [r["joint"] for r in noise] == ["LeftArm", "LeftForeArm"]
    assert all(r["speed_deg_s"] is None and r["delta_deg"] > 5.0 for r in noise)
    text = page.read_text("utf-8")
    assert re.search(r"noise burst .*LeftArm.* ±", text)
    assert re.search(r"frozen frames .*RightShoulder", text)


def test_the_public_interface_finds_them():
    assert {i.kind for i in tc.detect(faulty())} >= FAULTS
