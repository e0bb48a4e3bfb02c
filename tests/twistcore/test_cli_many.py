"""Commands over many clips and standard input, how much they say, and what a terminal gets."""

import csv
import io
import json
import os
import shutil
import sys
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from tests.twistcore.test_cli import run, run_json
from twistcore.analysis.clip_analysis import analyse
from twistcore.cli.output import terminal_text
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decide, Decision, Review, write_session

WALK, DIRTY = ASSETS / "walk.bvh", ASSETS / "walk_injected.bvh"
STICK = (
    "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0\n1 1 1\n"
)


@pytest.fixture
def stdin(monkeypatch):
    def give(data):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))

    return give


# -- many clips ------------------------------------------------------------------------------------


def test_one_bad_clip_of_many_is_listed_and_the_others_are_done(capsys, tmp_path):
    bad = tmp_path / "bad.bvh"
    bad.write_bytes(b"\x89PNG\r\n\x1a\n")
    code, out, err = run(capsys, "info", WALK, bad, DIRTY)
    assert code == 1
    assert names_in_one_line(err, f"{bad}: ", "BVH", "PNG")
    head, *rows = out.splitlines()
    assert head.split()[:2] == ["frames", "fps"]
    assert [row.split()[-1] for row in rows] == [str(WALK), str(DIRTY)]
    assert [row.split()[0] for row in rows] == ["344", "344"]
    code, out, err = run(capsys, "info", WALK, bad, "--json")
    document = json.loads(out)
    assert (code, document["schema"]) == (1, "twistcore.infos/1")
    assert [clip["schema"] for clip in document["clips"]] == ["twistcore.info/1"]
    assert document["failed"] == [{"clip": str(bad), "reason": err.strip()}]
    for command in (["info"], ["detect"], ["detect", "--json"], ["signals", "--json"]):
        code, out, err = run(capsys, *command, bad, tmp_path / "none.bvh")
        assert (code, out, err.count("\n")) == (2, "", 2)


def test_many_clips_are_searched_each_under_its_name(capsys, tmp_path):
    stick = tmp_path / "stick.bvh"
    stick.write_text(STICK)
    words = ["detect", DIRTY, WALK, "--method", "paper", "--tau", 5, "--kinds", "counter-twist"]
    code, out, err = run(capsys, *words)
    alone = run(capsys, "detect", DIRTY, *words[3:])[1]
    assert (code, err) == (0, "")
    assert out.startswith(f"{DIRTY}\n{alone}\n{WALK}\n")
    found = run_json(capsys, *words)[1]
    counts = [len(clip["intervals"]) for clip in found["clips"]]
    assert numbers(out.splitlines()[-1]) == [2, sum(counts)]
    assert found["clips"][0] == run_json(capsys, "detect", DIRTY, *words[3:])[1]
    assert run(capsys, *words, "--fail-over", sum(counts))[0] == 0
    assert run(capsys, *words, "--fail-over", sum(counts) - 1)[0] == 1
    code, _, err = run(capsys, "detect", stick, DIRTY)
    assert code == 1
    assert names_in_one_line(err, f"{stick}: ")


def test_signals_of_many_have_a_column_of_names(capsys, tmp_path):
    one, both = tmp_path / "one.csv", tmp_path / "both.csv"
    chain = ("--chain", "LeftArm")
    assert run(capsys, "signals", WALK, "--csv", one, *chain)[0] == 0
    assert run(capsys, "signals", WALK, tmp_path / "no.bvh", DIRTY, "--csv", both, *chain)[0] == 1
    rows = list(csv.reader(both.read_text().splitlines()))
    assert rows[0][:3] == ["clip", "chain", "frame"]
    of_walk = [row[1:] for row in rows if row[0] == str(WALK)]
    assert of_walk == list(csv.reader(one.read_text().splitlines()))[1:]
    document = run_json(capsys, "signals", WALK, DIRTY, *chain)[1]
    curves = document["clips"][0]["chains"][0]
    assert [f"{v:.6f}" for v in curves["m_deg"]] == [row[6] for row in of_walk]
    both.unlink()
    code, _, err = run(capsys, "signals", tmp_path / "no.bvh", tmp_path / "nor.bvh", "--csv", both)
    assert (code, err.count("\n"), both.exists()) == (2, 2, False)
    code, _, err = run(capsys, "signals", WALK)
    assert code == 2
    assert names_in_one_line(err, "--csv", "--json")


# -- standard input --------------------------------------------------------------------------------


def test_standard_input_is_a_clip(capsys, stdin):
    data = DIRTY.read_bytes()
    stdin(data)
    document = run_json(capsys, "detect", "-", "--method", "paper")[1]
    same = run_json(capsys, "detect", DIRTY, "--method", "paper")[1]
    assert document == same | {"clip": "-"}
    stdin(data)
    assert run_json(capsys, "diff", "-", DIRTY)[1]["joints"] == []
    stdin(b"%PDF-1.7")
    code, _, err = run(capsys, "info", "-")
    assert code == 2
    assert names_in_one_line(err, "BVH", "PDF")
    for words in (("info", "-", WALK, "-"), ("diff", "-", "-")):
        code, _, err = run(capsys, *words)
        assert code == 2
        assert names_in_one_line(err, "-")


def test_standard_input_is_corrected_as_the_file_is(capsys, tmp_path, stdin):
    outs = tmp_path / "a.bvh", tmp_path / "b.bvh"
    stdin(DIRTY.read_bytes())
    document = run_json(capsys, "refine", "-", "-o", outs[0], "--method", "paper")[1]
    assert (document["clip"], document["corrected"]) == ("-", 8)
    assert run(capsys, "refine", DIRTY, "-o", outs[1], "--method", "paper")[0] == 0
    assert outs[0].read_bytes() == outs[1].read_bytes()


def test_a_file_called_minus_is_named_with_its_folder(capsys, tmp_path, monkeypatch, stdin):
    monkeypatch.chdir(tmp_path)
    shutil.copy(WALK, tmp_path / "-")
    stdin(b"")
    assert run_json(capsys, "info", "./-")[1]["frames"] == 344


# -- one document a command ------------------------------------------------------------------------


def test_a_document_stands_for_what_would_be_remarked(capsys, tmp_path):
    out = tmp_path / "out.bvh"
    code, document = run_json(capsys, "refine", DIRTY, "-o", out, "--method", "paper")
    assert (code, document["schema"]) == (0, "twistcore.refine/1")
    assert (document["corrected"], document["repairable"]) == (8, 8)
    assert all(i["corrected"] for i in document["intervals"])
    _, document = run_json(
        capsys, "refine", DIRTY, "-o", out, "--method", "paper", "--min-confidence", 1
    )
    assert (document["corrected"], document["min_confidence"]) == (0, 1.0)
    assert not any(i["corrected"] for i in document["intervals"])
    code, text, err = run(capsys, "refine", DIRTY, "-o", "-", "--json")
    assert (code, text) == (2, "")
    assert names_in_one_line(err, "--json")


def test_a_report_that_gives_way_to_one_of_the_same_name_is_told(capsys, tmp_path):
    words = ["--method", "paper", "--report", tmp_path / "r", "-o", tmp_path / "o.bvh"]
    for folder, source, told in (("a", WALK, False), ("a", WALK, False), ("b", DIRTY, True)):
        (tmp_path / folder).mkdir(exist_ok=True)
        clip = shutil.copy(source, tmp_path / folder / "walk.bvh")
        code, _, err = run(capsys, "refine", clip, *words)
        said = f"{tmp_path / 'r'}: note: " in err
        assert (code, said) == (0, told)


def test_what_apply_and_inject_did_is_a_document(capsys, tmp_path):
    clip, session = read_bvh(DIRTY), tmp_path / "walk.twist.json"
    review = Review.of(analyse(clip).detect("paper"))
    first = review.state.intervals[0].id
    review.do(Decide((first,), Decision.ACCEPTED, "Kim", "2026-01-01T00:00:00+00:00"))
    write_session(clip, review.state, session)
    _, document = run_json(capsys, "apply", session, DIRTY, "-o", tmp_path / "o.bvh")
    taken = [i for i in document["intervals"] if i["applied"]]
    assert [(i["id"], i["decision"]) for i in taken] == [(first, "accepted")]
    assert (document["applied"], document["repairable"]) == (1, 8)
    words = ["-o", tmp_path / "i.bvh", "--truth", tmp_path / "t.json", "--seed", 48]
    _, document = run_json(capsys, "inject", WALK, *words)
    truth = json.loads((tmp_path / "t.json").read_text())
    assert document["errors"] == len(truth["errors"])
    assert document["chains"] == sorted({e["chain"] for e in truth["errors"]})


# -- how much is said ------------------------------------------------------------------------------


def test_quiet_leaves_results_and_errors(capsys, tmp_path):
    out = tmp_path / "o.bvh"
    assert run(capsys, "refine", DIRTY, "-o", out, "--quiet") == (0, "", "")
    told = run(capsys, "detect", DIRTY)
    assert run(capsys, "detect", DIRTY, "-q") == told
    code, text, err = run(capsys, "info", tmp_path / "no.bvh", "--quiet")
    assert (code, text, err.count("\n")) == (2, "", 1)


def test_verbose_says_steps_and_times_on_standard_error_alone(capsys):
    plain = run(capsys, "detect", DIRTY)
    code, out, err = run(capsys, "detect", DIRTY, "--verbose")
    assert (code, out) == plain[:2]
    steps = err.splitlines()
    assert [line.count(f"  {DIRTY}: ") for line in steps] == [1, 1, 0]
    assert all(line.endswith(" s") for line in steps)
    assert run(capsys, "detect", DIRTY, "-q", "-v")[0] == 2


# -- what a terminal gets --------------------------------------------------------------------------


@pytest.mark.thorough
@given(st.text())
def test_nothing_that_a_terminal_obeys_is_left(text):
    kinds = {unicodedata.category(c) for c in terminal_text(text)}
    assert not kinds & {"Cc", "Cs", "Zl", "Zp"}
    if text.isprintable():
        assert terminal_text(text) == text


@pytest.mark.skipif(os.name != "posix", reason="Windows allows no such names")
def test_names_that_would_steer_a_terminal_are_shown_escaped(capsys, tmp_path):
    folder = tmp_path / "a\x1b]0;x\x07b"
    folder.mkdir()
    clip = folder / "c\u202ed\x9b31m.bvh"
    text = DIRTY.read_text("utf-8").replace("LeftForeArm", "Left\x1b[31mFore\x9bArm")
    clip.write_text(text, "utf-8")
    for words in (
        ["info", clip],
        ["info", clip, clip],
        ["detect", clip],
        ["detect", clip, WALK, "--json"],
        ["diff", clip, clip],
        ["diff", clip, WALK],
        ["refine", clip, "-o", folder / "o.bvh", "-v"],
        ["info", folder / "none.bvh"],
        ["info", clip, "--fps", "\x1b[1m"],
        ["frob\x1bnicate"],
    ):
        _, out, err = run(capsys, *words)
        assert out or err
        left = {c for c in out + err if unicodedata.category(c) in ("Cc", "Cf")}
        assert left <= {"\n"}, words
    _, out, _ = run(capsys, "detect", clip)
    assert "Left\\x1b[31mFore\\x9bArm" in out
    document = run_json(capsys, "detect", clip)[1]
    assert document["clip"] == str(clip)
    assert "Left\x1b[31mFore\x9bArm" in document["tau_deg"]


@pytest.mark.parametrize(
    ("terminal", "environment", "colours"),
    [
        (True, {"TERM": "xterm"}, True),
        (True, {"TERM": "xterm", "NO_COLOR": "1"}, False),
        (True, {"TERM": "xterm", "NO_COLOR": ""}, True),
        (True, {"TERM": "dumb"}, False),
        (False, {"TERM": "xterm"}, False),
    ],
)
def test_colours_are_for_terminals_that_want_them(
    capsys, monkeypatch, tmp_path, terminal, environment, colours
):
    for name in ("NO_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setitem(os.environ, name, value)
    for stream in (sys.stdout, sys.stderr):
        monkeypatch.setattr(stream, "isatty", lambda: terminal)
    _, out, err = run(capsys, "info", WALK, tmp_path / "none.bvh")
    assert out.startswith("\x1b[1m") is colours
    assert err.startswith("\x1b[31m") is colours
    assert (out + err).count("\x1b[0m") == 2 * colours
