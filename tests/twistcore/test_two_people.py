"""A clip of two people: all limbs of both are examined, told apart and corrected."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.messages import names_in_one_line, numbers
from tests.tiers import parametrize
from tests.twistcore.reviews import spun
from tests.twistcore.test_smoothed_spans import smoothed
from tests.twistcore.two_people import CLEAN, WRONG, two_people
from twistcore import analyse, detect, find_chains, find_limbs, read_clip
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.cli.command_line import main
from twistcore.detection.soft_errors import soft_intervals
from twistcore.errors import TwistError
from twistcore.formats.bvh import parse_bvh
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.notes import NOISE, RESTLESS_CLIP, SMOOTHED
from twistcore.skeleton.rotation import normalise
from twistcore.synthesis import InjectedError, add_twist_from_opposite_side, inject

DANCE = Path("assets/dance.bvh")


@pytest.fixture(scope="module")
def pair():
    return parse_bvh(two_people(), "pair.bvh")


@pytest.fixture(scope="module")
def alone():
    """The errors of the second person, in a clip of their own."""
    found = detect(read_clip(WRONG))
    assert len(found) > 3
    return found


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "pair.bvh"
    path.write_bytes(two_people())
    return path


@pytest.mark.parametrize(
    ("pattern", "root", "names"),
    [("*_B", False, "AB"), ("B:*", False, "AB"), ("*_B", True, "AB"), ("*", False, "12")],
)
def test_every_limb_of_both_has_its_chains_and_limb(pattern, root, names):
    motion = parse_bvh(two_people(pattern, root=root), "pair.bvh").motion
    one = find_chains(read_clip(CLEAN).motion)
    chains = find_chains(motion)
    labels = [f"{name} · {c.label}" for name in names for c in one]
    assert [c.label for c in chains] == labels
    assert len({c.name for c in chains}) == len(chains)
    limbs = find_limbs(motion, chains)
    own = find_limbs(read_clip(CLEAN).motion, one)
    assert [x.label for x in limbs] == [f"{name} · {x.label}" for name in names for x in own]
    for chain, same in zip(chains, (*one, *one), strict=True):
        np.testing.assert_allclose(chain.axis, same.axis, atol=1e-9)


@parametrize(("pattern", "root"), [("*_B", False), ("B:*", True), ("*", False)])
def test_the_second_person_s_errors_are_found_and_nothing_else(pattern, root, alone):
    clip = parse_bvh(two_people(pattern, root=root), "pair.bvh")
    found = detect(clip)
    spans = [(i.chain, i.start, i.stop, round(np.degrees(i.delta), 1)) for i in alone]
    second = pattern if "#" in pattern or pattern != "*" else "* #2"
    assert [(i.chain, i.start, i.stop, round(np.degrees(i.delta), 1)) for i in found] == [
        (second.replace("*", name), *rest) for name, *rest in spans
    ]


def test_one_person_s_chains_by_name(pair):
    assert {c.person for c in analyse(pair).chains} == {"A", "B"}
    only = analyse(pair, people=["B"])
    assert {c.person for c in only.chains_and_limbs} == {"B"}
    assert only.people == ("A", "B")
    with pytest.raises(TwistError, match="A, B"):
        analyse(pair, people=["C"])
    with pytest.raises(TwistError, match="'A'"):
        analyse(read_clip(CLEAN), people=["A"])


def spans(found, person):
    """What matters of a person's finds."""
    whose = {c.name: c.person for c in found.analysis.chains_and_limbs}
    own = (i for i in found if whose[i.chain] == person)
    return [(i.chain, i.kind, i.start, i.stop, i.open, i.confidence, i.offset.sum()) for i in own]


@parametrize("people", [None, ["B"]])
def test_a_restless_person_leaves_the_other_s_finds_as_they_are(pair, people):
    motion = pair.motion
    for k in range(8):
        motion = spun("LeftFoot", 20 + 40 * k, 22 + 40 * k, 170.0, motion)
    calm, found = analyse(pair).detect(), analyse(motion, people=people).detect()
    assert found.analysis.restless() == (() if people else ("A",))
    assert automatic_corrections(found)
    assert spans(found, "B") == spans(calm, "B")
    said = [str(note) for note in found.notes if note.kind == RESTLESS_CLIP]
    assert [text.split()[0] for text in said] == ([] if people else ["A"])


def test_one_person_alone_has_the_same_finds_where_the_budget_is_spent(pair, monkeypatch):
    clean = pair.motion.sliced(1, pair.motion.frames)
    chains = find_chains(clean)
    motion = add_twist_from_opposite_side(clean, chains)
    ramp = np.minimum(1.0, np.minimum(np.arange(1, 31), np.arange(30, 0, -1)) / 9.0)
    errors = [
        InjectedError(chain.name, start, start + 30, 0.7 * ramp)
        for chain in chains
        if chain.segment == "ForeArm"
        for start in (60, 150, 240)
    ]
    motion = inject(motion, chains, errors)
    monkeypatch.setattr(soft_intervals, "BUDGET", 0.2)
    both = analyse(motion).detect()
    for person in "AB":
        alone = analyse(motion, people=[person]).detect()
        assert spans(alone, person) == spans(both, person)
        names = {c.name for c in alone.chains}
        left = both.analysis.by().left.items()
        assert {k: v for k, v in left if k in names} == alone.analysis.by().left != {}


@parametrize("chains", [None, ["LeftArm_B"]])
def test_notes_on_noise_and_smoothing_are_of_the_people_asked_for(pair, chains):
    rotations, names = pair.motion.rotations.copy(), pair.motion.skeleton.names
    rng = np.random.default_rng(1)
    for joint in ("LeftArm", "Neck", "Neck_B"):
        q = rotations[100:250, names.index(joint)]
        rotations[100:250, names.index(joint)] = normalise(q + rng.normal(0.0, 0.1, q.shape))
    motion = pair.motion.with_rotations(rotations)

    def said(people, kind):  # of `motion` as it is then
        notes = analyse(motion, chains, people=people).detect().notes
        return " ".join(str(note) for note in notes if note.kind == kind)

    assert "(Neck_B)" in said(["B"], NOISE)
    assert re.search(r"\bNeck\b", said(None, NOISE))
    assert "LeftArm" not in said(["B"], NOISE)
    dancers = parse_bvh(two_people(clips=(DANCE, DANCE)), "pair.bvh").motion
    motion = smoothed(names.index("LeftArm"), motion=dancers)
    assert "LeftArm is" in said(None, SMOOTHED)
    assert said(["B"], SMOOTHED) == ""


def test_a_restless_person_s_own_finds_are_left_open(pair):
    motion = pair.motion
    for k in range(8):
        motion = spun("LeftFoot_B", 20 + 40 * k, 22 + 40 * k, 170.0, motion)
    found = analyse(motion).detect()
    assert found.analysis.restless() == ("B",)
    assert not automatic_corrections(found)
    notes = {people: analyse(motion, people).detect().notes for people in (("LeftArm",), None)}
    assert [RESTLESS_CLIP in {n.kind for n in own} for own in notes.values()] == [False, True]


def test_a_limb_that_is_missing_is_named_with_its_person(pair):
    data = two_people().replace(b"LeftHand_B", b"Something_B").replace(b"LeftForeArm_B", b"Else_B")
    data = data.replace(b"LeftArm_B", b"Other_B").replace(b"LeftShoulder_B", b"Thing_B")
    analysis = analyse(parse_bvh(data, "pair.bvh"))
    if missing := analysis.unexamined:
        assert {u.person for u in missing} == {"B"}
        assert "of B" in str(missing[0])
    else:  # found by its shape
        assert [c.person for c in analysis.chains].count("B") == 10


def test_up_size_and_heading_are_one_person_s(pair):
    single = read_clip(CLEAN)
    seen = []
    for clip in (single, pair):
        positions = forward_kinematics(clip.motion)[1]
        chains = find_chains(clip.motion)
        up = guess_up(positions, chains, clip.motion.skeleton)
        size = figure_size(positions, clip.motion.skeleton)
        seen.append([size, *up, *figure_facing_direction(positions[100], chains, up)])
    np.testing.assert_allclose(seen[1], seen[0], rtol=1e-9, atol=1e-9)


def test_words_of_a_person_s_own_hold_for_both(tmp_path, file, capsys):
    """A hand of an unknown name is known under both people's names."""
    file.write_bytes(file.read_bytes().replace(b"LeftHand", b"LeftQuux"))
    words = tmp_path / "words.toml"
    words.write_text('[words]\nhand = ["quux"]\n')
    assert main(["info", str(file), "--joint-names", str(words), "--names", "--json"]) == 0
    names = {e["joint"]: e["taken_for"] for e in json.loads(capsys.readouterr().out)["names"]}
    assert names["LeftQuux"] == names["LeftQuux_B"] == "Left Hand"


# -- commands --------------------------------------------------------------------------------------


def said(capsys, *words):
    code = main([str(word) for word in words])
    return code, capsys.readouterr()


def test_detect_tells_whose_each_interval_is(file, alone, capsys):
    code, text = said(capsys, "detect", file)
    rows = text.out.splitlines()
    assert code == 0
    assert rows[0].split()[:2] == ["person", "chain"]
    assert all(row.split()[0] == "B" for row in rows[1:-1])
    assert numbers(rows[-1])[:3] == [len(alone), 20, 2]
    _, of_one = said(capsys, "detect", WRONG)
    assert of_one.out.splitlines()[0].split()[0] == "chain"


@pytest.mark.thorough
@pytest.mark.usefixtures("batch_here")
def test_person_chooses_in_every_command_that_takes_chains(file, alone, tmp_path, capsys):
    code, text = said(capsys, "detect", file, "--person", "A", "--json")
    assert (code, json.loads(text.out)["intervals"]) == (0, [])
    _, text = said(capsys, "detect", file, "--person", "B", "--json")
    assert {i["person"] for i in json.loads(text.out)["intervals"]} == {"B"}
    _, text = said(capsys, "detect", file, "--person", "A", "--person", "B")
    assert "2 people" in text.out
    table = tmp_path / "signals.csv"
    code, _ = said(capsys, "signals", file, "--person", "B", "--csv", table)
    chains = {row["chain"] for row in csv.DictReader(table.read_text().splitlines())}
    assert (code, len(chains)) == (0, 10)
    assert all(chain.endswith("_B") for chain in chains)
    out = tmp_path / "out.bvh"
    code, text = said(capsys, "refine", file, "--person", "A", "-o", out)
    assert (code, out.read_bytes()) == (0, file.read_bytes())
    code, text = said(capsys, "refine", file, "--person", "B", "-o", out)
    assert f"{len(alone)} of {len(alone)} intervals" in text.out + text.err
    assert len(detect(read_clip(out))) == 0
    code, text = said(capsys, "batch", file, "-o", tmp_path / "batch", "--person", "B",
                      "--jsonl", tmp_path / "b.jsonl", "--workers", "1")  # fmt: skip
    [record] = map(json.loads, (tmp_path / "b.jsonl").read_text().splitlines())
    assert {i["person"] for i in record["intervals"]} == {"B"}
    assert all(name.endswith("_B") or "_B-" in name for name in record["chains"])


def test_an_unknown_person_is_said_with_those_there_are(file, capsys):
    code, text = said(capsys, "detect", file, "--person", "Zoe")
    assert code == 2
    assert names_in_one_line(text.err, "'Zoe'", "A, B")
    assert text.out == ""


def test_info_lists_the_people(file, capsys):
    _, text = said(capsys, "info", file)
    assert "2 people: A, B" in text.out
    assert "B · Left ForeArm" in text.out
    _, text = said(capsys, "info", file, "--json")
    document = json.loads(text.out)
    assert document["people"] == ["A", "B"]
    assert [c["person"] for c in document["chains"]] == ["A"] * 10 + ["B"] * 10
    _, text = said(capsys, "info", CLEAN, "--json")
    document = json.loads(text.out)
    assert document["people"] == []
    assert "person" not in document["chains"][0]


def test_one_report_is_of_both(file, tmp_path, capsys):
    report = tmp_path / "report"
    said(capsys, "refine", file, "-o", tmp_path / "out.bvh", "--report", report)
    document = json.loads((report / "pair.report.json").read_text())
    assert [c["label"][0] for c in document["chains"]] == ["A"] * 10 + ["B"] * 10 + list("AAAABBBB")
    assert {i["person"] for i in document["intervals"]} == {"B"}
    page = (report / "pair.report.html").read_text()
    assert "B · Left" in page
    assert "A · Left" in page
