"""A file that ends before its header says: read, and shown wherever the clip is."""

import csv
import json

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore import amc_files
from tests.twistcore.amass_files import amass_arrays
from tests.twistcore.batch_records import done
from tests.twistcore.test_cli import run
from twistcore.analysis.clip_analysis import analyse
from twistcore.batch.gates import broken_rules, parse_batch_rule
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.reading import read_clip
from twistcore.review import Review, write_session

WALK = ASSETS / "walk.bvh"
KEPT, DECLARED = 58, 344
MISSING = DECLARED - KEPT


def cut(folder, rows=KEPT, name="cut.bvh"):
    """The walk with fewer rows than its header declares."""
    data = WALK.read_bytes()
    head, tail = data.split(b"MOTION", 1)
    lines = tail.split(b"\n")
    path = folder / name
    path.write_bytes(head + b"MOTION" + b"\n".join(lines[: 3 + rows]) + b"\n")
    return path


def test_a_clip_knows_how_many_frames_its_header_declares(tmp_path):
    clip = read_bvh(cut(tmp_path))
    assert (clip.frames, clip.declared_frames, clip.missing_frames) == (KEPT, DECLARED, MISSING)
    whole = read_bvh(WALK)
    assert (whole.declared_frames, whole.missing_frames) == (DECLARED, 0)
    more = parse_bvh(WALK.read_bytes().replace(b"Frames: 344", b"Frames: 3"))
    assert (more.frames, more.declared_frames, more.missing_frames) == (DECLARED, 3, 0)


def test_other_formats_declare_no_number(tmp_path):
    amc = read_clip(amc_files.written(tmp_path / "amc", True))
    np.savez(tmp_path / "walk.npz", **amass_arrays(read_bvh(WALK).motion))
    for clip in (amc, read_clip(tmp_path / "walk.npz")):
        assert (clip.declared_frames, clip.missing_frames) == (None, 0)


def test_what_concerns_the_whole_clip_is_the_first_warning(tmp_path):
    path = cut(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"OFFSET", b"OFFSET 0 0 0 OFFSET"))
    clip = read_bvh(path)
    assert len(clip.warnings) > 5
    assert str(MISSING) in clip.warnings[0].text


@pytest.mark.thorough
def test_every_command_says_so_once(tmp_path, capsys):
    path, out = cut(tmp_path), tmp_path / "out.bvh"
    session = tmp_path / "cut.twist.json"
    clip = read_bvh(path)
    write_session(clip, Review.of(analyse(clip).detect()).state, session)
    for words in (
        ("info", path),
        ("detect", path),
        ("detect", path, "--explain"),
        ("detect", path, WALK),
        ("signals", path, "--csv", tmp_path / "signals.csv"),
        ("refine", path, "-o", out, "--report", tmp_path / "report"),
        ("apply", session, path, "-o", out),
        ("report", session, "--clip", path, "-o", tmp_path / "pages", "--no-pictures"),
        ("diff", path, out),
    ):
        code, printed, errors = run(capsys, *words)
        assert code == 0, words
        count = 2 if words[0] == "diff" else 1  # both of its clips end early
        assert (printed + errors).count(f"{MISSING} are missing") == count, words
        assert ("missing" in errors) == (words[0] != "info")
        assert "missing" not in run(capsys, *words, "-q")[2]


def test_documents_hold_the_number(tmp_path, capsys):
    path = cut(tmp_path)
    for command in ("info", "detect"):
        document = json.loads(run(capsys, command, path, "--json")[1])
        assert document["missing_frames"] == MISSING
        assert any(str(MISSING) in warning for warning in document["warnings"])
    words = ("refine", path, "-o", tmp_path / "out.bvh", "--report", tmp_path / "r", "--json")
    document = json.loads(run(capsys, *words)[1])
    assert document["missing_frames"] == MISSING
    assert sum(str(MISSING) in note for note in document["notes"]) == 1
    [report] = (tmp_path / "r").glob("*.json")
    assert json.loads(report.read_text("utf-8"))["missing_frames"] == MISSING
    [page] = (tmp_path / "r").glob("*.html")
    assert f"({MISSING} missing)" in page.read_text("utf-8")


@pytest.mark.thorough
@pytest.mark.usefixtures("batch_here")
def test_a_batch_lists_them_and_a_rule_fails(tmp_path, capsys):
    folder, out, table = tmp_path / "in", tmp_path / "out", tmp_path / "t.csv"
    folder.mkdir()
    cut(folder)
    cut(folder, rows=DECLARED, name="whole.bvh")
    rule = "missing-frames>0"
    words = ("batch", folder, "-o", out, "--csv", table, "--workers", 1, "--fail-if", rule)
    for _ in range(2):  # a run that does nothing says so, too
        code, _, errors = run(capsys, *words)
        assert code == 1
        assert errors.count(f"cut.bvh: {MISSING} frames") == 1
        assert f"cut.bvh: missing-frames is {MISSING}" in errors
        assert "whole.bvh" not in errors.replace("2/2 whole.bvh", "").replace("1/2 whole.bvh", "")
        rows = list(csv.DictReader(table.read_text("utf-8").splitlines()))
        assert [row["missing_frames"] for row in rows] == [str(MISSING), "0"]
    run(capsys, "report", out, "-o", tmp_path / "pages", "--no-pictures")
    page = (tmp_path / "pages" / "index.html").read_text("utf-8")
    assert f"{MISSING} frames of {DECLARED} missing" in page
    assert "missing in 1 clip" in page
    of_clip = (tmp_path / "pages" / "clips" / "cut.bvh.html").read_text("utf-8")
    assert f"({MISSING} missing)" in of_clip


@pytest.mark.parametrize(
    ("rule", "value"), [("missing-frames>0", 286), ("total.missing-frames>300", 386)]
)
def test_rules_count_them_by_clip_or_over_the_run(rule, value):
    records = [done(f"{k}.bvh", result={"missing_frames": k}) for k in (0, 286, 100)]
    found = broken_rules([parse_batch_rule(rule)], records)
    assert found[0].value == value
    assert len(found) == (1 if rule.startswith("total") else 2)
    older = done("older.bvh")  # of a version that did not count them
    assert broken_rules([parse_batch_rule("missing-frames>0")], [older]) == []


@pytest.mark.usefixtures("batch_here")
def test_any_number_that_a_header_declares_can_be_noted(tmp_path, capsys):
    path = cut(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"Frames: 344", b"Frames: 999999999999999999"))
    assert run(capsys, "batch", path, "-o", tmp_path / "out", "--workers", 1)[0] == 0
    code, _, errors = run(capsys, "report", tmp_path / "out", "-o", tmp_path / "p", "--no-pictures")
    assert (code, "expected" in errors) == (0, False)
