"""What was not examined is named by every command, in a batch, its rules and its reports."""

import csv
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from tests.tiers import parametrize
from tests.twistcore.batch_records import done
from tests.twistcore.made_records import record_of
from tests.twistcore.test_cli import run
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.examination import unexamined_frames, unexamined_joints_by_body_part
from twistcore.batch.clip_survey import survey_clip, survey_folder
from twistcore.batch.gates import broken_rules, parse_batch_rule
from twistcore.batch.junit import junit_xml
from twistcore.batch.manifest import Manifest
from twistcore.batch.result_files import clip_result_row
from twistcore.formats.bvh import read_bvh
from twistcore.formats.bvh.compose import write_motion
from twistcore.report.folder_page import clip_page_from_manifest
from twistcore.report.folder_report import Home
from twistcore.review import Review, write_session
from twistcore.skeleton.body import Unexamined
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.notes import NOT_EXAMINED
from twistcore.skeleton.rig import OwnChain, Rig
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle

WALK = read_bvh(ASSETS / "walk.bvh").motion
ARMS, LEGS = ("LeftShoulder", "RightShoulder"), ("LHipJoint", "RHipJoint")


def without(motion, *tops):
    """The motion without some joints and all that hangs on them."""
    skeleton, new = motion.skeleton, {-1: -1}
    for joint, name in enumerate(skeleton.names):
        if name not in tops and int(skeleton.parents[joint]) in new:
            new[joint] = len(new) - 1
    keep = [joint for joint in new if joint >= 0]
    placed = [k for k, joint in enumerate(motion.positioned) if joint in new]
    bare = Skeleton(
        tuple(skeleton.names[j] for j in keep),
        np.array([new[int(skeleton.parents[j])] for j in keep]),
        skeleton.offsets[keep],
        tuple((new[j], end) for j, end in skeleton.ends if j in new),
    )
    positioned = tuple(new[motion.positioned[k]] for k in placed)
    positions = motion.positions[:, placed]
    return Motion(bare, motion.rotations[:, keep], positioned, positions, motion.frame_time)


CLIPS = {
    "three": WALK.sliced(100, 103),
    "still": WALK.with_rotations(np.repeat(WALK.rotations[50:51], WALK.frames, axis=0)),
    "trunk": without(WALK, *ARMS, "LHipJoint", "RHipJoint", "LowerBack"),
    "one_arm": without(WALK, "LeftShoulder"),
    "whole": WALK,
}
BLIND = {"three": "3 frames", "still": "moves", "trunk": "no arm or leg"}


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    folder = tmp_path_factory.mktemp("unexamined")
    for name, motion in CLIPS.items():
        write_motion(motion, folder / f"{name}.bvh")
    return folder


def commands(clip, folder):
    session = folder / "clip.twist.json"
    read = read_bvh(clip)
    write_session(read, Review.of(analyse(read).detect()).state, session)
    return [
        ("info", clip),
        ("detect", clip),
        ("detect", clip, "--explain"),
        ("signals", clip, "--csv", folder / "signals.csv"),
        ("refine", clip, "-o", folder / "out.bvh", "--report", folder / "report"),
        ("apply", session, clip, "-o", folder / "out.bvh"),
    ]


@parametrize("name", BLIND)
def test_nothing_examined_is_one_sentence_and_exit_1(clips, tmp_path, capsys, name):
    clip = clips / f"{name}.bvh"
    for words in commands(clip, tmp_path):
        code, out, err = run(capsys, *words)
        assert code == 1, words
        (sentence,) = err.splitlines()
        assert names_in_one_line(sentence, f"{clip}: ", BLIND[name])
        for claim in ("interval", " 0 "):
            assert claim not in out, words


@parametrize("name", ["one_arm", "whole"])
def test_a_limb_that_is_not_examined_is_named_by_every_command(clips, tmp_path, capsys, name):
    blind = name == "one_arm"
    for words in commands(clips / f"{name}.bvh", tmp_path):
        code, out, err = run(capsys, *words)
        assert code == 0, words
        if words[0] in ("detect", "refine", "apply"):
            assert ("left arm" in out.splitlines()[-1]) == blind
        if words[0] != "info":
            assert err.count("left arm") == blind
        else:
            assert (err, out.count("eft arm")) == ("", 1)


@pytest.mark.thorough
def test_documents_have_what_was_not_examined(clips, tmp_path, capsys):
    for name in ("three", "one_arm", "whole"):
        for words in commands(clips / f"{name}.bvh", tmp_path):
            if "--explain" in words:
                continue
            words = [w for w in words if w not in ("--csv", tmp_path / "signals.csv")]
            document = json.loads(run(capsys, *words, "--json")[1])
            (found,) = document.get("clips", [document])
            assert ("3 frames" in (found["not_examined"] or "")) == (name == "three"), words
            limbs = [(limb["limb"], limb["side"]) for limb in found["unexamined"]]
            assert limbs == [("left arm", "Left")] * (name == "one_arm")
            assert all("hand" in limb["why"] for limb in found["unexamined"])
    (report,) = (tmp_path / "report").glob("whole*.json")
    assert json.loads(report.read_text("utf-8"))["not_examined"] is None


def test_of_several_clips_those_not_examined_are_counted(clips, capsys):
    code, out, err = run(capsys, "detect", clips / "three.bvh", clips / "whole.bvh")
    assert code == 1
    assert numbers(out.splitlines()[-1]) == [2, 0, 1]
    assert err.count("three.bvh: ") == 1
    code, out, err = run(capsys, "info", clips / "three.bvh", clips / "one_arm.bvh")
    assert (code, err.count("three.bvh: ")) == (1, 1)


def test_chains_that_a_person_chose_leave_nothing_out(clips, capsys):
    words = ("detect", clips / "one_arm.bvh", "--chain", "RightArm")
    code, out, err = run(capsys, *words)
    assert (code, "left arm" in out + err) == (0, False)


def test_what_is_found_in_a_short_clip_was_examined(tmp_path, capsys):
    motion = WALK.sliced(100, 120)
    rotations = motion.rotations.copy()
    (chain,) = (c for c in analyse(motion).chains if c.name == "LeftArm")
    for joint, degrees in ((chain.parent, 60.0), (chain.child, -60.0)):
        turn = quaternion_from_axis_angle(chain.axis, np.radians(degrees))
        pair = (rotations[8:13, joint], turn)
        rotations[8:13, joint] = multiply(*(pair if degrees > 0.0 else pair[::-1]))
    write_motion(motion.with_rotations(rotations), tmp_path / "short.bvh")
    code, out, err = run(capsys, "detect", tmp_path / "short.bvh")
    assert (code, "1 interval in" in out, "examined" in err) == (0, True, False)
    found = analyse(read_bvh(tmp_path / "short.bvh")).detect()
    assert found.analysis.not_examined
    assert NOT_EXAMINED not in {note.kind for note in found.notes}


# -- joints, limbs and frames ----------------------------------------------------------------------


def test_joints_outside_chains_are_listed_by_part(clips, capsys):
    analysis = analyse(WALK)
    outside = unexamined_joints_by_body_part(analysis.body, analysis.chains_and_limbs)
    assert outside["root"] == ("Hips",)
    assert set(outside["trunk"]) == {*LEGS, "LowerBack", "Spine", "Spine1"}
    assert outside["below the feet"] == ("LeftToeBase", "RightToeBase")
    assert len(outside["below the hands"]) == 6
    assert set(outside["others"]) == {"Neck", "Neck1", "Head"}
    inside = {WALK.skeleton.names[j] for c in analysis.chains for j in (c.parent, c.child)}
    assert inside.isdisjoint(name for names in outside.values() for name in names)
    assert len(inside) + sum(map(len, outside.values())) == len(WALK.skeleton)
    (line,) = (s for s in run(capsys, "info", clips / "whole.bvh")[1].splitlines() if "outs" in s)
    assert names_in_one_line(line, "LeftFingerBase … (6 joints)", "LeftToeBase")


def test_a_trunk_found_by_shape_hides_no_limb():
    """The spine of a figure without arms and legs is no arm."""
    analysis = analyse(without(WALK, *ARMS, *LEGS))
    (limb,) = analysis.unexamined
    assert (limb.side, limb.person) == ("", "")
    own = Rig(add=(OwnChain(("Neck1", "Head")),))
    assert not analyse(analysis.motion, rig=own).unexamined


def test_a_limb_is_named_with_its_person():
    limb = Unexamined("left arm", "no hand", "Left", "arm", "B")
    assert names_in_one_line(str(limb), "left arm", " B ", "no hand")
    row = clip_result_row(done("a.bvh", result={"unexamined": [limb.to_json()]}))
    assert row["unexamined"] == 1
    assert names_in_one_line(row["reason"], "left arm", " B ", "no hand")


def test_frames_between_two_cuts_that_are_too_few_are_listed(tmp_path, capsys):
    other = [read_bvh(ASSETS / f"{name}.bvh").motion.rotations for name in ("dance", "kick")]
    rows = [WALK.rotations[100:200], other[0][150:160], other[1][100:200]]
    motion = WALK.sliced(0, 210).with_rotations(np.concatenate(rows))
    assert unexamined_frames(motion) == ((100, 110),)
    write_motion(motion, tmp_path / "cuts.bvh")
    _, out, err = run(capsys, "detect", tmp_path / "cuts.bvh")
    assert (err + out).count(" 100–109") == 1


@pytest.mark.parametrize("clip", ["walk", "dance", "kick", "basketball"])
def test_a_t_pose_at_the_border_is_no_note(clip):
    assert unexamined_frames(read_bvh(ASSETS / f"{clip}.bvh").motion) == ()


# -- batches ---------------------------------------------------------------------------------------


@pytest.mark.usefixtures("batch_here")
def test_a_batch_lists_them_and_rules_fail(clips, tmp_path, capsys):
    out, table, lines = tmp_path / "out", tmp_path / "t.csv", tmp_path / "t.jsonl"
    words = ["batch", clips, "-o", out, "--workers", 1, "--csv", table, "--jsonl", lines]
    code, _, err = run(capsys, *words, "--fail-if", "unexamined>0")
    assert code == 1
    assert re.search("one_arm.bvh: .* 1.*'unexamined>0'", err)
    assert re.search(r"\b3 clips .*still.bvh", err)
    rows = {row["clip"]: row for row in csv.DictReader(table.read_text("utf-8").splitlines())}
    assert (rows["one_arm.bvh"]["unexamined"], rows["whole.bvh"]["unexamined"]) == ("1", "0")
    assert "left arm" in rows["one_arm.bvh"]["reason"]
    assert "3 frames" in rows["three.bvh"]["reason"]
    documents = map(json.loads, lines.read_text("utf-8").splitlines())
    limbs = {d["clip"]: d["unexamined"] for d in documents}
    assert limbs["one_arm.bvh"][0]["limb"] == "left arm"
    with Manifest.open(out) as manifest:
        glances = {one.name: one for one in manifest.glances()}
    assert (glances["one_arm.bvh"].unexamined, glances["whole.bvh"].unexamined) == (1, 0)
    run(capsys, "report", out, "-o", tmp_path / "pages", "--no-pictures", "--workers", 1)
    index = (tmp_path / "pages" / "index.html").read_text("utf-8")
    assert index.count("left arm") == 1
    pages = {
        name: (tmp_path / "pages" / "clips" / f"{name}.bvh.html").read_text("utf-8")
        for name in CLIPS
    }
    for name in BLIND:
        assert BLIND[name] in pages[name]
        assert "> interval" not in pages[name], name
    assert pages["one_arm"].count("left arm") == 1
    assert "left arm" not in pages["whole"]


def test_the_page_of_a_clip_that_is_gone_has_it(clips):
    home = Home("all", "index.html")
    page = clip_page_from_manifest(record_of(clips / "one_arm.bvh", "a.bvh"), "it is gone", home)
    assert page.count("left arm") == 1
    page = clip_page_from_manifest(record_of(clips / "three.bvh", "a.bvh"), "it is gone", home)
    assert page.count(": 3 frames") == 1


@pytest.mark.parametrize(("rule", "clip"), [("unexamined>1", "b.bvh"), ("total.unexamined>2", "")])
def test_rules_count_limbs_by_clip_or_over_the_run(rule, clip):
    limb = {"limb": "left arm", "side": "Left", "why": "no hand"}
    records = [
        done(f"{n}.bvh", result={"unexamined": [limb] * k})
        for n, k in zip("abc", (1, 2, 0), strict=True)
    ]
    (found,) = broken_rules([parse_batch_rule(rule)], [*records, done("older.bvh")])
    assert (found.clip, found.value) == (clip, 2 if clip else 3)


def test_junit_shows_no_clip_as_passed_that_was_not_examined():
    limb = {"limb": "left arm", "side": "Left", "why": "no hand"}
    records = [
        done("blind.bvh", result={"unchecked": "3 frames are too few"}),
        done("part.bvh", result={"unexamined": [limb]}),
        done("whole.bvh", result={"unexamined": []}),
    ]
    blind, part, whole = ElementTree.fromstring(junit_xml(records, [], ())).iter("testcase")
    (error,) = blind
    assert error.tag == "error"
    assert error.text == "3 frames are too few"
    [one] = part
    assert one.tag == "system-out"
    assert names_in_one_line(one.text, "left arm", "no hand")
    assert not [*whole]


def test_a_survey_counts_them(clips):
    assert survey_clip(clips / "one_arm.bvh").unexamined == 1
    found = {one.path.stem: one.unexamined for one in survey_folder(clips)}
    assert (found["one_arm"], found["whole"]) == (1, 0)
