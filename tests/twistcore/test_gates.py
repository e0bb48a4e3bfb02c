"""Rules of a batch: how they are written, what they count, and what CI is told."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import names_in_one_line, refused
from tests.twistcore.batch_records import done, failed, interval, record
from twistcore.batch.annotations import github_annotations
from twistcore.batch.gates import GRAMMAR, broken_rules, parse_batch_rule
from twistcore.batch.junit import junit_xml
from twistcore.detection import Kind
from twistcore.errors import TwistError

FLIP = interval(30, 40, 170.0, 0.6, Kind.LIMB_FLIP)
LONE = interval(50, 51, 0.0, 0.95, Kind.LONE_JUMP, joint="LeftArm", turn_deg=90.0)
CLIP = done("a/walk.bvh", interval(), FLIP, LONE, interval(60, 65, -40.0, None), severity=5.5)
CLEAN = done("clean.bvh", frames=300)
BAD = failed("bad.bvh", "bad.bvh: expected HIERARCHY")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("severity>5", 5.5),
        ("count>3", 4),
        ("count[limb-flip]>0", 1),
        ("count[limb flip, lone-jump]==2", 2),
        ("count[Counter-Twist] >= 2", 2),
        ("count[confidence>=0.9]>2", 3),  # no confidence counts as 1
        ("count[confidence>=0.6,confidence<0.9]>0", 1),
        ("count[counter-twist,confidence<0.5]<=0", 0),
        ("degrees>100", 170.0),
        ("degrees[counter-twist]>30", 40.0),
        ("degrees[lone-jump]>45", 90.0),
        ("affected>2%", 25.0),
        ("affected[counter-twist]>=15 %", 15.0),
        ("affected[confidence>=0]>0%", 25.0),
        ("affected[lone-jump]>0%", 1.0),
    ],
)
def test_a_rule_measures_a_clip(text, value):
    (found,) = broken_rules([parse_batch_rule(text)], [CLIP])
    assert (found.clip, found.value) == ("a/walk.bvh", pytest.approx(value))
    assert repr(text) in str(found)
    assert str(found).startswith("a/walk.bvh: ")


@pytest.mark.parametrize(
    "text", ["severity>5.5", "count[limb-flip]>1", "degrees<170", "affected>25%", "count==3"]
)
def test_a_rule_that_holds_says_nothing(text):
    assert broken_rules([parse_batch_rule(text)], [CLIP]) == []


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("total.count>3", 4),
        ("total.count[limb-flip]==1", 1),
        ("total.degrees>100", 170.0),
        ("total.affected>6%", 6.25),
        ("total.severity>1", 5.5 / 2),
        ("failed>0", 1),
        ("total.failed>0", 1),
        ("unchecked>=1", 1),
    ],
)
def test_a_rule_over_the_run(text, value):
    empty = done("e.bvh", frames=0, result={"unchecked": "no chain"})
    records = [CLIP, BAD, CLEAN, record("w.bvh", state="waiting"), empty]
    (found,) = broken_rules([parse_batch_rule(text)], records)
    assert (found.clip, found.value) == ("", pytest.approx(value))


def test_frames_that_lie_in_two_intervals_are_counted_once():
    over = done("x.bvh", interval(10, 30), interval(12, 15), interval(20, 40), FLIP, frames=100)
    (found,) = broken_rules([parse_batch_rule("affected[counter-twist]>0%")], [over])
    assert found.value == pytest.approx(30.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "expected"),
        ("severity", "expected"),
        ("jitter>1", "severity, count"),
        ("severity>many", "'many'"),
        ("severity>nan", "'nan'"),
        ("severity=>5", "expected"),
        ("severity[limb-flip]>5", "severity"),
        ("failed[limb-flip]>0", "failed"),
        ("missing-frames[limb-flip]>0", "missing-frames"),
        ("unchecked[limb-flip]>0", "unchecked"),
        ("count[]>0", "''"),
        ("count[flip]>0", "'flip'"),
        ("count[confidence>high]>0", "'confidence>high'"),
        ("affected>2", "%"),
        ("count>2%", "'%'"),
        ("count>0 and severity>1", "expected"),
    ],
)
def test_what_is_no_rule_is_refused_in_a_sentence(text, expected):
    with refused(TwistError, f" {text!r}: ", expected):
        parse_batch_rule(text)


@given(st.text(alphabet="countdegrsvyaffil.[]<>=!,%- 0123456789e", max_size=30))
def test_any_text_is_a_rule_or_refused(text):
    try:
        rule = parse_batch_rule(text)
    except TwistError:
        return
    broken_rules([rule], [CLIP, BAD])


def test_the_help_shows_rules_that_are_read():
    examples = [word for word in GRAMMAR.split("Examples")[1].split() if word]
    assert len(examples) == 9
    for text in [*examples, "affected>2%", "failed>0", "severity>5"]:
        parse_batch_rule(text)


def test_the_page_shows_the_grammar_of_the_help():
    assert GRAMMAR in (Path(__file__).parents[2] / "docs" / "gates.md").read_text("utf-8")


def suite_of(records, *rules):
    rules = [parse_batch_rule(text) for text in rules]
    root = ElementTree.fromstring(junit_xml(records, rules, broken_rules(rules, records)))
    assert root.tag == "testsuites"
    (suite,) = root
    cases = {case.get("name"): case for case in suite}
    assert int(suite.get("tests")) == len(cases)
    for name in ("failure", "error", "skipped"):
        count = sum(case.find(name) is not None for case in cases.values())
        attribute = name if name == "skipped" else f"{name}s"
        assert int(suite.get(attribute)) == count
    return cases


def test_ci_sees_a_case_a_clip_and_one_a_rule_over_the_run():
    records = [CLIP, BAD, CLEAN, record("later.bvh", state="waiting", seconds=0.0)]
    cases = suite_of(records, "severity>5", "count>3", "failed>0", "total.count>100")
    assert set(cases) == {"failed>0", "total.count>100", *(r.name for r in records)}
    assert cases["a/walk.bvh"].get("classname") == "clips.a"
    (failure,) = cases["a/walk.bvh"]
    assert failure.get("message") == "severity>5, count>3"
    severe, many = failure.text.splitlines()
    assert names_in_one_line(severe, "a/walk.bvh: ", "5.5°", "'severity>5'")
    assert names_in_one_line(many, "a/walk.bvh: ", "4", "'count>3'")
    (error,) = cases["bad.bvh"]
    assert (error.tag, error.text) == ("error", "bad.bvh: expected HIERARCHY")
    assert [child.tag for child in cases["later.bvh"]] == ["skipped"]
    assert [child.tag for child in cases["failed>0"]] == ["failure"]
    assert not [*cases["clean.bvh"], *cases["total.count>100"]]


@given(st.text(), st.text())
def test_any_name_and_any_reason_make_a_document_that_can_be_read(name, reason):
    records = [failed(f"x{name}\udcff", f"{reason}\x00\x1b\ufffe")]
    (case,) = suite_of(records).values()
    assert "\\x00\\x1b\\ufffe" in case[0].text
    assert case.get("name").endswith("\\udcff")


def test_an_empty_run_is_a_document():
    assert suite_of([]) == {}


ANNOTATION = re.compile(r"::error (?:file=([^,:]*),)?title=([^,:]*)::(.*)")


def annotated(records, *rules, root="/captures"):
    """File, title and message of each annotation, as GitHub's runner reads them."""
    rules = [parse_batch_rule(text) for text in rules]
    text = github_annotations(records, broken_rules(rules, records), root)
    found = [ANNOTATION.fullmatch(line).groups("") for line in text.split("\n")[:-1]]
    plain = {"%0A": "\n", "%0D": "\r", "%3A": ":", "%2C": ",", "%25": "%"}
    return [tuple(re.sub("%..", lambda m: plain[m[0]], part) for part in one) for one in found]


def test_github_sees_an_annotation_a_clip_and_one_a_rule_over_the_run():
    empty = done("e.bvh", frames=0, result={"unchecked": "no chain"})
    records = [CLIP, BAD, CLEAN, record("later.bvh", state="waiting"), empty]
    found = annotated(records, "severity>5", "count>3", "affected>99%", "failed>0")
    (file, title, message), *others = found
    assert (file, title) == ("a/walk.bvh", "severity>5, count>3")
    assert [line.split(":")[0] for line in message.split("\n")] == ["a/walk.bvh"] * 2
    assert [one[0] for one in others] == ["bad.bvh", "e.bvh", ""]
    assert [one[2] for one in others[:2]] == [BAD.reason, "e.bvh: no chain"]
    assert others[2][1] == "failed>0"
    assert annotated([CLEAN], "severity>5") == []


@pytest.mark.parametrize("root", ["/capt", "/captures/a/walk.bvh/b", "/elsewhere"])
def test_a_file_outside_of_the_checkout_is_in_the_message_alone(root):
    [(file, _, message)] = annotated([CLIP], "severity>5", root=root)
    assert (file, message.split(":")[0]) == ("", "a/walk.bvh")


@given(st.text(), st.text())
def test_any_name_is_one_annotation_and_comes_back(name, reason):
    name = name.replace("/", "-").replace("\0", "-")
    records = [failed(f"x{name}\r\n::%0A,é\udcff", f"{reason}\n::stop-commands::x\x1b[31m")]
    text = github_annotations(records, [], "/captures")
    assert not set("\r\x1b\x85\u2028\u202e\udcff") & set(text)
    assert text.count("\n") == 1
    [(file, _, message)] = annotated(records)
    assert file.endswith("\r\n::%0A,é\\udcff")
    assert message.endswith("\n::stop-commands::x\\x1b[31m")
    if name.isprintable() and reason.isprintable():
        assert (file[1 : 1 + len(name)], message[: len(reason)]) == (name, reason)
