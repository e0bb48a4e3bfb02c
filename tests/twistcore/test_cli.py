"""The command line: its words, its exit codes, its one-line complaints."""

import gc
import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from tests.tiers import parametrize
from tests.twistcore.reviews import CARRIED, CLIP, find_flips, flip, flipped
from tests.twistcore.test_capture_faults import faulty_clip
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.clip_analysis import analyse as analysed
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import Decide, Decision, Review, read_session, write_session
from twistcore.review.model import APPLIED
from twistcore.skeleton.chain import find_chains

WALK, DIRTY = ASSETS / "walk.bvh", ASSETS / "walk_injected.bvh"
TRUTH = ASSETS / "walk_injected.truth.json"
EVIDENCE_DOUBT = "there is a burst of noise"
EVIDENCE = {
    "reading": "cheaper behind",
    "off_line_deg": 12.5,
    "closes": True,
    "jumps": [{"frame": 100, "jump_deg": 170.25}],
    "spread": None,
}


def run(capsys, *words):
    try:
        code = main([str(w) for w in words])
    except SystemExit as stop:
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, out, err


def run_json(capsys, *words):
    code, out, err = run(capsys, *words, "--json")
    assert err == ""
    return code, json.loads(out)


def test_info(capsys):
    code, document = run_json(capsys, "info", WALK)
    assert code == 0
    assert document["schema"] == "twistcore.info/1"
    assert (document["frames"], len(document["chains"])) == (344, 10)
    legs = {limb["label"]: limb for limb in document["limbs"]}
    assert legs["Right leg"] == {
        "limb": "RightUpLeg-RightFoot", "label": "Right leg", "parent": "RightUpLeg",
        "child": "RightLeg", "end": "RightFoot", "uncorrectable": [],
    }  # fmt: skip
    code, out, _ = run(capsys, "info", WALK)
    assert "Left ForeArm" in out
    assert "RightUpLeg → RightLeg → RightFoot\n" in out


def test_names_that_info_prints_are_taken_in_any_case(capsys):
    _, document = run_json(capsys, "info", WALK)
    _, out, _ = run(capsys, "info", WALK)
    rows = [line.split() for line in out.splitlines()]
    rows = [row for row in rows if "→" in row]
    assert len(rows) == len(document["chains"]) + len(document["limbs"])
    clip = read_bvh(WALK)
    for name, *_ in rows:
        for spelled in (name, name.lower(), name.upper()):
            assert name in {c.name for c in analyse(clip, spelled).chains_and_limbs}


def test_info_names_every_joint_and_by_which_word(capsys, tmp_path):
    code, out, _ = run(capsys, "info", WALK, "--names")
    rows = {line.split()[0]: line for line in out.splitlines() if line.startswith("  ")}
    assert code == 0
    assert "Left ForeArm" in rows["LeftForeArm"]
    assert "'forearm'" in rows["LeftForeArm"]
    assert "trunk" in rows["Spine"]
    _, document = run_json(capsys, "info", WALK, "--names")
    assert [entry["joint"] for entry in document["names"]] == document["joints"]


def test_words_of_ones_own_in_every_command_of_one_clip(capsys, tmp_path):
    clip = tmp_path / "paws.bvh"
    clip.write_bytes(WALK.read_bytes().replace(b"LeftHand", b"LeftQuux", 1))
    words = tmp_path / "names.toml"
    words.write_text('[ours]\nhand = ["Quux"]\n', "utf-8")
    _, without = run_json(capsys, "info", clip, "--names")
    _, document = run_json(capsys, "info", clip, "--names", "--joint-names", words)
    taken = {
        key: {e["joint"]: e["by"] for e in d["names"]}["LeftQuux"]
        for key, d in {"with": document, "without": without}.items()
    }
    assert taken["with"] != taken["without"]
    words.write_text('[ours]\nother = ["ForeArm", "Arm", "Shoulder", "hand"]\n', "utf-8")
    _, document = run_json(capsys, "info", clip, "--joint-names", words)
    assert not any("ForeArm" in chain["label"] for chain in document["chains"])
    words.write_text('[ours]\nhands = ["Quux"]\n', "utf-8")
    code, out, err = run(capsys, "detect", clip, "--joint-names", words)
    assert (code, out) == (2, "")
    assert f"{words}: line 2: expected" in err


def test_detect_json_is_the_contract(capsys):
    code, document = run_json(capsys, "detect", DIRTY, "--method", "paper", "--tau", "5")
    assert code == 0
    assert set(document) == {
        "schema", "clip", "frames", "missing_frames", "fps", "method", "tau_deg", "intervals",
        "warnings", "notes", "not_examined", "unexamined",
    }  # fmt: skip
    assert document["schema"] == "twistcore.detection/1"
    assert document["tau_deg"]["LeftForeArm"] == pytest.approx(5.0)
    keys = {"chain", "parent", "child", "start", "stop", "delta_deg", "confidence", "open", "kind"}
    assert all(set(i) == keys for i in document["intervals"])
    assert len(document["intervals"]) == 8
    assert {i["kind"] for i in document["intervals"]} == {"counter-twist"}


def test_flips_have_a_kind_a_limb_and_an_end(capsys, monkeypatch):
    found = flip(explain=lambda: EVIDENCE), CARRIED
    find_flips(monkeypatch, *found)
    code, document = run_json(capsys, "detect", DIRTY, "--tau", "175")
    assert (code, len(document["intervals"])) == (0, 2)
    last = document["intervals"][-1]
    assert last == {
        "chain": "RightUpLeg", "parent": "RightUpLeg", "child": "RightLeg", "start": 100,
        "stop": 108, "delta_deg": pytest.approx(170.0), "confidence": 0.97, "open": False,
        "kind": "limb flip", "limb": "RightUpLeg-RightFoot", "end": "RightFoot", "carried": False,
    }  # fmt: skip
    assert document["intervals"][0]["carried"] is True
    assert document["tau_deg"]["RightUpLeg"] == pytest.approx(175.0)
    assert document["tau_deg"]["RightUpLeg-RightFoot"] == pytest.approx(np.degrees(0.5))
    explained = run_json(capsys, "detect", DIRTY, "--tau", "175", "--explain")[1]
    assert explained["intervals"][-1]["evidence"] == EVIDENCE
    told = run(capsys, "detect", DIRTY, "--tau", "175", "--explain")[1].splitlines()
    assert told[0].split() == ["chain", "start", "–", "stop", "δ", "confidence"]
    assert told[1].split()[0] == "LeftUpLeg-LeftFoot"
    assert told[-4].split()[:6] == ["RightUpLeg-RightFoot", "100", "–", "108", "+170.00°", "0.97"]
    assert [numbers(line) for line in told[-3:]] == [[12.5], [100, 170.2], [2, 10, 2]]


def test_doubts_are_printed_once(capsys, monkeypatch):
    doubted = {**EVIDENCE, "doubts": [EVIDENCE_DOUBT]}
    find_flips(monkeypatch, flip(explain=lambda: doubted, open=True))
    told = run(capsys, "detect", DIRTY, "--tau", "175", "--explain")[1]
    assert told.count(EVIDENCE_DOUBT) == 1


def test_faults_of_the_capture_have_rows_and_are_counted_where_asked(capsys, tmp_path):
    clip = tmp_path / "walk.bvh"
    clip.write_bytes(faulty_clip().data)
    code, out, err = run(capsys, "detect", clip, "--fail-over", "0")
    assert code == 0
    assert "±8.66°  open  noise burst" in out
    assert re.search("frozen frames.*right arm", out)
    assert numbers(out.splitlines()[-1]) == [3, 10, 2, 1]
    assert numbers(err)[0] == 2
    kinds = "--kinds", "noise-burst,frozen-frames"
    code, document = run_json(capsys, "detect", clip, "--fail-over", "0", *kinds)
    assert code == 1
    noise, _, frozen = document["intervals"]
    assert (noise["kind"], noise["joint"], noise["delta_deg"]) == ("noise burst", "LeftArm", 0.0)
    assert noise["joints"] == ["LeftArm"]
    assert noise["sigma_deg"] > 5.0
    assert (frozen["kind"], frozen["part"]) == ("frozen frames", "right arm")
    code, out, err = run(capsys, "refine", clip, "-o", tmp_path / "out.bvh")
    assert code == 0
    assert "2 noise bursts, 1 frozen span" in out + err
    assert (tmp_path / "out.bvh").read_bytes() == clip.read_bytes()


@parametrize(
    ("words", "found", "counts"),
    [
        ([], (8, 2), [10, 10, 8, 2]),
        (["--kinds", "all"], (8, 2), [10, 10, 8, 2]),
        (["--kinds", "counter-twist"], (8, 0), [8, 10]),
        (["--kinds", "Limb flip"], (0, 2), [2, 4, 2]),
        (["--kinds", "lone-jump"], (0, 0), [0, 10]),
        (["--kinds", "lone jump, limb-flip,counter twist"], (8, 2), [10, 10, 8, 2]),
        (["--chain", "RightUpLeg-RightFoot"], (0, 1), [1, 1, 1]),
        (["--chain", "RightUpLeg", "--kinds", "limb-flip"], (0, 1), [1, 1, 1]),
    ],
    quick=2,
)
def test_kinds_and_chains_say_what_is_looked_for(capsys, monkeypatch, words, found, counts):
    find_flips(monkeypatch, flip(), CARRIED)
    code, document = run_json(capsys, "detect", DIRTY, *words)
    kinds = [i["kind"] for i in document["intervals"]]
    assert (code, kinds) == (0, ["counter-twist"] * found[0] + ["limb flip"] * found[1])
    assert numbers(run(capsys, "detect", DIRTY, *words)[1].splitlines()[-1]) == counts
    assert run(capsys, "detect", DIRTY, *words, "--fail-over", 9)[0] == int(sum(found) > 9)


def test_a_profile_may_name_a_limb(capsys, monkeypatch, tmp_path):
    find_flips(monkeypatch, flip(), CARRIED)
    profile = tmp_path / "p.toml"
    profile.write_text("[RightUpLeg-RightFoot]\ntau_deg = 171.0\n")
    _, document = run_json(capsys, "detect", DIRTY, "--profile", profile, "--kinds", "limb-flip")
    assert [i["limb"] for i in document["intervals"]] == ["LeftUpLeg-LeftFoot"]


def test_flips_are_refined_and_replayed_and_told_to_move_a_knee(capsys, monkeypatch, tmp_path):
    bad, out, again, session = (tmp_path / n for n in ("b.bvh", "o.bvh", "a.bvh", "s.json"))
    write_clip(CLIP, flipped(CLIP.motion, flip(), CARRIED), bad)
    find_flips(monkeypatch, flip(), CARRIED)
    words = ["refine", bad, "-o", out, "--kinds", "limb-flip", "--report", tmp_path]
    code, told, err = run(capsys, *words)
    assert (code, err) == (0, "")
    assert names_in_one_line(told, f"{out}: ", "2 of 2 intervals", "2 limb flips")
    document = run_json(capsys, "diff", CLIP.path, out)[1]  # the flips are out, nothing else is
    assert document["moved"] == []
    assert max((j["max_deg"] for j in document["joints"]), default=0.0) < 1e-3
    document = run_json(capsys, "diff", bad, out)[1]
    moved = {m["joint"]: m for m in document["moved"]}
    assert set(moved) == {"RightLeg", "LeftLeg", "LeftToeBase"}  # which was carried
    assert (moved["RightLeg"]["frames"], moved["LeftToeBase"]["frames"]) == (8, 6)
    assert 0.01 < moved["RightLeg"]["max_of_height"] < 0.3
    assert moved["RightLeg"]["max_of_height"] == pytest.approx(
        moved["RightLeg"]["max"] / read_bvh(bad).motion.skeleton.height
    )
    lines = run(capsys, "diff", bad, out)[1].splitlines()
    share = f"{moved['RightLeg']['max_of_height']:.2g}"
    assert names_in_one_line(lines[-2], "RightLeg", share, "8 frames")
    most = max(m["max_of_height"] for m in moved.values())
    assert lines[-1].endswith(f"move by at most {most:.2g} of the figure's height")
    clip = read_bvh(bad)
    review = Review.of(analysed(clip).detect(kinds=[Kind.LIMB_FLIP]))
    review.accept()
    write_session(clip, review.state, session)
    code, told, _ = run(capsys, "apply", session, bad, "-o", again)
    assert names_in_one_line(told, f"{again}: ", "2 of 2 intervals", "2 limb flips")
    assert again.read_bytes() == out.read_bytes()
    page = (tmp_path / "b.report.html").read_text("utf-8")
    assert re.search(f"RightLeg .*{share}.* 8 frames .limb flip", page)


def test_a_limb_without_channels_is_shown_and_not_corrected(capsys, monkeypatch, tmp_path):
    path, text = tmp_path / "w.bvh", CLIP.path.read_text("utf-8")
    at = text.index("CHANNELS", text.index("JOINT RightFoot"))
    channels = "CHANNELS 3 Zrotation Yrotation Xrotation"
    assert text[at:].startswith(channels)
    head, motion = text[:at] + "CHANNELS 0" + text[at + len(channels) :], []
    head, _, rows = head.partition("Frame Time")
    first, *rows = rows.splitlines()
    column = 3 * read_bvh(CLIP.path).motion.skeleton.index("RightFoot") + 3
    for row in rows:
        numbers = row.split()
        motion.append(" ".join(numbers[:column] + numbers[column + 3 :]))
    path.write_text("\n".join([head + "Frame Time" + first, *motion, ""]), "utf-8")
    find_flips(monkeypatch, flip(), CARRIED)
    words = ["refine", path, "-o", tmp_path / "o.bvh", "--kinds", "limb-flip"]
    code, told, err = run(capsys, *words)
    assert (code, "1 of 2 intervals" in told) == (1, True)
    assert names_in_one_line(err, "RightUpLeg-RightFoot ", " RightFoot")
    difference = run_json(capsys, "diff", path, tmp_path / "o.bvh")[1]
    assert {joint["joint"] for joint in difference["joints"]} == {"LeftUpLeg"}
    limbs = {limb["limb"]: limb for limb in run_json(capsys, "info", path)[1]["limbs"]}
    assert limbs["RightUpLeg-RightFoot"]["uncorrectable"] == ["RightFoot"]


def test_detect_limits_and_fails_over(capsys):
    code, document = run_json(capsys, "detect", DIRTY, "--chain", "LeftForeArm")
    assert (code, len(document["intervals"])) == (0, 3)
    assert run(capsys, "detect", DIRTY, "--fail-over", 7)[0] == 1
    assert run(capsys, "detect", DIRTY, "--fail-over", 8)[0] == 0


def test_a_profile_sets_tau_per_chain(capsys, tmp_path):
    profile = tmp_path / "p.toml"
    profile.write_text("[LeftForeArm]\ntau_deg = 110.0\n")
    _, document = run_json(capsys, "detect", DIRTY, "--profile", profile)
    assert document["tau_deg"]["LeftForeArm"] == pytest.approx(110.0)
    assert len([i for i in document["intervals"] if i["chain"] == "LeftForeArm"]) == 1
    profile.write_text("[LeftForeArm\n")
    code, _, err = run(capsys, "detect", DIRTY, "--profile", profile)
    assert (code, err.count("\n")) == (2, 1)


def test_the_whole_way_round(capsys, tmp_path):
    dirty, truth, refined = (tmp_path / n for n in ("d.bvh", "t.json", "r.bvh"))
    assert run(capsys, "inject", WALK, "-o", dirty, "--truth", truth, "--seed", 5)[0] == 0
    assert (
        run(capsys, "refine", dirty, "-o", refined, "--method", "paper", "--report", tmp_path)[0]
        == 0
    )
    words = ("evaluate", "--truth", truth, "--clean", WALK, "--refined", refined)
    code, document = run_json(capsys, *words)
    assert code == 0
    assert document["overall"]["fsr_percent"] >= 95.0
    code, out, _ = run(capsys, *words)
    assert "Overall" in out
    code, document = run_json(capsys, "diff", WALK, dirty)
    assert document["frames"] > 0
    assert document["max_position_of_height"] < 1e-6
    assert (tmp_path / "d.report.html").read_text(encoding="utf-8").count("<tr>") > 3


@pytest.fixture(scope="module")
def doubtful(tmp_path_factory):
    """The walk with two small errors and one that never ends: an open interval."""
    clip = read_bvh(WALK)
    offsets = {c: np.zeros(clip.motion.frames) for c in ("LeftArm", "RightForeArm", "RightLeg")}
    offsets["LeftArm"][200:] = 0.5
    offsets["RightForeArm"][120:131] = -0.03
    offsets["RightLeg"][35:43] = 0.05
    path = tmp_path_factory.mktemp("doubtful") / "walk.bvh"
    write_clip(clip, remove_twist(clip.motion, find_chains(clip.motion), offsets), path)
    return path


def test_refine_applies_what_is_confident_and_closed(capsys, tmp_path, doubtful):
    _, document = run_json(capsys, "detect", doubtful, "--tau", 1)
    found = {i["chain"]: i for i in document["intervals"]}
    assert {c: i["open"] for c, i in found.items()} == {
        "LeftArm": True, "RightForeArm": False, "RightLeg": False
    }  # fmt: skip
    low, high = found["RightForeArm"]["confidence"], found["RightLeg"]["confidence"]
    assert low < high
    for words, expected in (
        ([], {"RightForeArm", "RightLeg"}),
        (["--min-confidence", (low + high) / 2], {"RightLeg"}),
        (["--min-confidence", 1], set()),
        (["--include-open"], set(found)),
    ):
        out = tmp_path / "out.bvh"
        _, told, _ = run(capsys, "refine", doubtful, "-o", out, "--tau", 1, *words)
        assert f": {len(expected)} of 3 " in told
        _, changed = run_json(capsys, "diff", doubtful, out)
        assert {j["joint"] for j in changed["joints"]} == {
            joint for c in expected for joint in (found[c]["parent"], found[c]["child"])
        }
        out.unlink()


@pytest.mark.thorough
def test_a_session_of_refine_gives_the_same_bytes_and_keys(capsys, tmp_path, doubtful):
    refined, replayed, keys = (tmp_path / n for n in ("r.bvh", "a.bvh", "k.py"))
    session = tmp_path / "walk.twist.json"
    words = ("refine", doubtful, "-o", refined, "--tau", 1, "--session", session)
    assert run_json(capsys, *words)[1]["session"] == str(session)
    assert run(capsys, "apply", session, doubtful, "-o", replayed)[0] == 0
    assert replayed.read_bytes() == refined.read_bytes() != doubtful.read_bytes()
    state = read_session(session).state
    assert [j.verdict for j in state.intervals].count(APPLIED) == len(state.chosen()) == 2
    assert len(state.intervals) == 3  # the open one is there to be judged
    words = ("export", session, doubtful, "--script", "blender", "-o", keys)
    assert run(capsys, *words)[0] == 0
    assert "RightForeArm" in keys.read_text("utf-8")
    assert run(capsys, "report", session, "-o", tmp_path / "pages")[0] == 0


def test_refine_replaces_its_own_session_and_none_of_a_person(capsys, tmp_path):
    refined, session = tmp_path / "r.bvh", tmp_path / "walk.twist.json"
    words = ("refine", DIRTY, "-o", refined, "--method", "paper", "--session", session)
    assert run(capsys, *words, "--min-confidence", 0)[0] == 0
    assert run(capsys, *words, "--min-confidence", 1)[0] == 0
    clip, review = read_bvh(DIRTY), Review(read_session(session).state)
    review.do(Decide((1,), Decision.REJECTED, reviewer="Kim"))
    write_session(clip, review, session)
    refined.unlink()
    before = session.read_bytes()
    code, _, err = run(capsys, *words)
    assert (code, session.read_bytes(), refined.exists()) == (2, before, False)
    assert names_in_one_line(err, session)
    session.write_text("a shopping list")
    assert run(capsys, *words)[0] == 2
    assert (session.read_text(), refined.exists()) == ("a shopping list", False)


@pytest.mark.parametrize(("least", "corrected"), [("0", 8), ("0.99", 0)])
def test_where_no_confidence_is_known_none_is_relied_on(capsys, tmp_path, least, corrected):
    words = ["--method", "paper", "--min-confidence", least]
    told = run(capsys, "refine", DIRTY, "-o", tmp_path / "out.bvh", *words)[1]
    assert f": {corrected} of 8 intervals corrected" in told


def test_a_child_beside_the_axis_is_told_to_move(capsys, tmp_path):
    path = tmp_path / "share.bvh"
    lines = DIRTY.read_text("utf-8").split("\n")
    at = next(k for k, line in enumerate(lines) if line.strip() == "JOINT LeftForeArm") + 4
    beside = ["JOINT ShareBone", "{", "OFFSET 0.5 0.7 0", "CHANNELS 0", "}"]
    path.write_text("\n".join([*lines[:at], *beside, *lines[at:]]), "utf-8")
    told = run(capsys, "refine", path, "-o", tmp_path / "out.bvh")[2]
    assert re.search("ShareBone .*LeftForeArm", told)
    assert "RightUpLeg" not in told


def test_the_report_says_that_a_child_beside_the_axis_moved(capsys, tmp_path):
    path, clip = tmp_path / "share.bvh", read_bvh(DIRTY)
    column = 3 * clip.motion.skeleton.index("LeftForeArm") + 6
    lines = DIRTY.read_text("utf-8").splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("Frame Time")) + 1
    for k in range(first, len(lines)):
        numbers = lines[k].split()
        lines[k] = " ".join([*numbers[:column], "0", "0", "0", *numbers[column:]])
    at = next(k for k, line in enumerate(lines) if line.strip() == "JOINT LeftForeArm") + 4
    channels = "CHANNELS 3 Zrotation Yrotation Xrotation"
    lines[at:at] = ["JOINT ShareBone", "{", "OFFSET 0.5 0.7 0", channels, "}"]
    path.write_text("\n".join([*lines, ""]), "utf-8")
    code, told, _ = run(capsys, "refine", path, "-o", tmp_path / "out.bvh", "--report", tmp_path)
    assert (code, "8 of 8 intervals corrected\n" in told) == (0, True)
    changed = json.loads((tmp_path / "share.report.json").read_bytes())["changed"]
    assert [(m["joint"], m["why"]) for m in changed["moved"]] == [("ShareBone", "counter-twist")]
    assert changed["rest_of_height"] < 1e-6


def test_injection_is_the_same_for_a_seed(capsys, tmp_path):
    out, truth = tmp_path / "w.bvh", tmp_path / "t.json"
    assert run(capsys, "inject", WALK, "-o", out, "--truth", truth, "--seed", 48)[0] == 0
    assert out.read_bytes() == DIRTY.read_bytes()
    assert truth.read_bytes() == TRUTH.read_bytes()


def test_signals_csv(capsys, tmp_path):
    table = tmp_path / "s.csv"
    assert run(capsys, "signals", DIRTY, "--csv", table, "--chain", "LeftForeArm")[0] == 0
    lines = table.read_text().splitlines()
    assert lines[0].startswith("chain,frame,theta_p_deg")
    assert len(lines) == 345


def test_diff_of_a_clip_with_itself_is_nothing(capsys):
    code, document = run_json(capsys, "diff", WALK, WALK)
    assert (code, document["joints"], document["max_position"]) == (0, [], 0.0)


@pytest.mark.parametrize(
    "words",
    [
        ("detect", "none.bvh"),
        ("detect", TRUTH),
        ("detect", WALK, "--tau", "-1"),
        ("detect", WALK, "--tau", "many"),
        ("detect", WALK, "--chain", "Tail"),
        ("detect", WALK, "--kinds", "flip"),
        ("detect", WALK, "--kinds", ""),
        ("refine", WALK, "-o", "o.bvh", "--kinds", "limb-flip,all,"),
        ("signals", WALK, "--csv", "s.csv", "--chain", "RightUpLeg-RightFoot"),
        ("signals", WALK, "--csv", "s.csv", "--chain", "rightupleg-rightfoot"),
        ("refine", WALK, "-o", WALK),
        ("refine", WALK, "-o", ASSETS / "no" / "folder.bvh"),
        ("apply", WALK, WALK, "-o", "x.bvh"),
        ("evaluate", "--truth", WALK, "--clean", WALK, "--refined", WALK),
        ("evaluate", "--truth", TRUTH, "--clean", ASSETS / "dance.bvh", "--refined", WALK),
        ("diff", WALK, ASSETS / "dance.bvh"),
        ("signals", WALK, "--csv", WALK),
        ("inject", WALK, "-o", "o.bvh", "--truth", WALK, "--seed", "1"),
        ("inject", WALK, "-o", "x", "--truth", "x", "--seed", "1"),
        ("inject", WALK, "-o", "o.bvh", "--truth", "no/t.json", "--seed", "1"),
        ("inject", WALK, "-o", "o.bvh", "--truth", "t.json", "--seed", "-1"),
        ("inject", WALK, "-o", "o.bvh", "--truth", "t.json", "--seed", "1", "--protocol", "H99"),
        ("refine", WALK, "-o", "."),
        ("refine", WALK, "-o", "r.bvh", "--report", WALK),
        ("refine", WALK, "-o", "r.bvh", "--session", "r.bvh"),
        ("frobnicate",),
    ],
)
def test_refusals_are_one_line_and_exit_2(capsys, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = WALK.read_bytes()
    code, out, err = run(capsys, *words)
    assert code == 2
    assert err.strip()
    assert err.count("\n") == 1
    assert out == ""
    assert "Traceback" not in err
    assert WALK.read_bytes() == before
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["walk.npz", "walk.AMC"])
@pytest.mark.parametrize(
    "words",
    [
        ("inject", "CLIP", "-o", "o.bvh", "--truth", "t.json", "--seed", "1"),
        ("evaluate", "--truth", TRUTH, "--clean", "CLIP", "--refined", WALK),
        ("quamo", "noise", "CLIP", "-o", "o.bvh"),
    ],
)
def test_what_takes_a_bvh_alone_says_so_of_other_formats(capsys, tmp_path, name, words):
    clip = tmp_path / name
    clip.write_bytes(b"PK\x03\x04")
    code, _, err = run(capsys, *(clip if w == "CLIP" else w for w in words))
    assert code == 2
    assert names_in_one_line(err, f"{clip}: ", "BVH file", clip.suffix.lower())


def test_the_rate_that_is_given_counts_in_info_and_signals(capsys, tmp_path):
    assert run_json(capsys, "info", WALK, "--fps", "60")[1]["fps"] == 60.0
    tables = tmp_path / "as_it_is.csv", tmp_path / "at_60.csv"
    assert run(capsys, "signals", WALK, "--csv", tables[0])[0] == 0
    assert run(capsys, "signals", WALK, "--csv", tables[1], "--fps", "60")[0] == 0


def test_a_clip_without_a_chain_exits_1_and_says_so(capsys, tmp_path):
    clip = tmp_path / "stick.bvh"
    clip.write_text(
        "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
        "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0\n1 1 1\n"
    )
    for command in ("info", "detect", "signals --csv -"):
        words = command.split()
        code, _, err = run(capsys, words[0], clip, *words[1:])
        assert code == 1
        assert names_in_one_line(err, f"{clip}: ")


def test_the_core_starts_without_qt_or_vtk():
    heavy = "'PySide6', 'vtk', 'pyvista', 'pyqtgraph'"
    code = f"import sys, twistcore.cli; sys.exit(any(m in sys.modules for m in ({heavy})))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.thorough
def test_a_terminal_without_greek_and_a_closed_pipe_are_no_errors():
    code = "import sys; from twistcore.cli import main; sys.exit(main(sys.argv[1:]))"
    words = [sys.executable, "-c", code, "info", str(WALK)]
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(words, env=ascii_only, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    words = [sys.executable, "-c", code, "detect", str(DIRTY), "--json", "--explain"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.read(10)
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 0


def test_a_command_called_from_python_leaves_the_collector_as_it_is(capsys):
    """The window turns it off: garbage may contain Qt objects, which only its thread may delete."""
    gc.disable()
    try:
        assert main(["info", str(WALK)]) == 0
        assert not gc.isenabled()
    finally:
        gc.enable()
