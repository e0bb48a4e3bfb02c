"""Results as JSON lines, Parquet and CSV: what other programs read."""

import builtins
import csv
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.twistcore.batch_records import done, failed, interval
from twistcore.batch.result_files import (
    CLIP_COLUMNS,
    INTERVAL_COLUMNS,
    clips_csv,
    write_clip_table,
    write_interval_parquet,
    write_json_lines,
)
from twistcore.detection import Kind
from twistcore.errors import TwistError

LONE = interval(50, 51, 0.0, None, Kind.LONE_JUMP, joint="LeftArm", turn_deg=90.0)
WALK = replace(
    done("a/walk.bvh", interval(), LONE, severity=1.5, result={"applied": 1, "left": [interval()]}),
    corrected="corrected/a/walk.bvh",
    decisions={"accepted": 1, "rejected": 0, "undecided": 1, "reviewers": ["Ada", "Bo"]},
)
CLEAN = done("clean.bvh", result={"unchecked": "no chain of parent, child and grandchild"})
BAD = failed("bad \udcff.bvh", 'bad.bvh: expected "HIERARCHY",\nfound PK')
RECORDS = [WALK, CLEAN, BAD]


def test_a_clip_is_a_line_of_the_table(tmp_path):
    text = clips_csv(RECORDS)
    rows = list(csv.DictReader(io.StringIO(text)))
    assert list(rows[0]) == list(CLIP_COLUMNS)
    walk, clean, bad = rows
    assert (walk["clip"], walk["counter_twists"], walk["lone_jumps"]) == ("a/walk.bvh", "1", "1")
    assert (walk["limb_flips"], walk["affected_percent"], walk["left"]) == ("0", "10.0", "1")
    assert (walk["reviewers"], walk["undecided"]) == ("Ada; Bo", "1")
    assert (clean["left"], clean["accepted"]) == ("", "")
    assert clean["reason"] == "no chain of parent, child and grandchild"
    assert (bad["state"], bad["frames"], bad["reason"]) == ("failed", "", BAD.reason)
    write_clip_table(tmp_path / "clips.csv", RECORDS)
    assert "bad \\udcff.bvh" in (tmp_path / "clips.csv").read_text("utf-8")


def test_the_page_names_every_column():
    docs = Path(__file__).parents[2] / "docs"
    page = (docs / "gates.md").read_text("utf-8")
    assert "(tables/batch-columns.csv)" in page
    page += (docs / "tables" / "batch-columns.csv").read_text("utf-8")
    assert {*CLIP_COLUMNS, *INTERVAL_COLUMNS} <= set(re.findall(r"`(\w+)`", page))


def test_a_clip_is_a_document_a_line(tmp_path):
    path = tmp_path / "results.jsonl"
    write_json_lines(path, RECORDS)
    walk, clean, bad = map(json.loads, path.read_bytes().splitlines())
    known = {name: walk.pop(name) for name in ("source", "state", "reason", "corrected")}
    assert known["source"] == "/captures/a/walk.bvh"
    assert walk.pop("decisions") == WALK.decisions
    assert walk == WALK.result
    assert clean["state"] == "done"
    assert bad["schema"] == walk["schema"]
    assert (bad["clip"], bad["state"], bad["reason"]) == (BAD.name, "failed", BAD.reason)
    assert "intervals" not in bad


def test_parquet_has_a_row_an_interval_and_loses_no_clip(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "results.parquet"
    write_interval_parquet(path, RECORDS)
    table = parquet.read_table(path)
    assert table.column_names == [*CLIP_COLUMNS, "quality", *INTERVAL_COLUMNS]
    rows = table.to_pylist()
    assert [(r["clip"], r["interval"]) for r in rows] == [
        ("a/walk.bvh", 0), ("a/walk.bvh", 1), ("clean.bvh", None), ("bad \\udcff.bvh", None),
    ]  # fmt: skip
    assert (rows[0]["start"], rows[0]["delta_deg"], rows[0]["severity"]) == (10, 30.0, 1.5)
    assert (rows[1]["kind"], rows[1]["turn_deg"], rows[1]["confidence"]) == (
        "lone jump",
        90.0,
        None,
    )
    assert rows[0]["open"] is False
    assert json.loads(rows[1]["quality"]) == {"jitter": 0.5}
    write_interval_parquet(path, [])
    empty = parquet.read_table(path)
    assert (empty.num_rows, empty.schema) == (0, table.schema)


def test_without_pyarrow_a_sentence_names_the_extra(tmp_path, monkeypatch):
    real = builtins.__import__

    def without(name, *more):
        if name.split(".")[0] == "pyarrow":
            raise ImportError(name)
        return real(name, *more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(TwistError, match=r"twist-inspector\[parquet\]"):
        write_interval_parquet(tmp_path / "results.parquet", RECORDS)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("write", [write_json_lines, write_interval_parquet])
def test_a_run_that_ends_amid_the_file_leaves_the_one_before(tmp_path, write):
    if write is write_interval_parquet:
        pytest.importorskip("pyarrow")
    path = tmp_path / "results"
    path.write_bytes(b"before")

    def records():
        yield WALK
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write(path, records())
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == b"before"


def test_a_full_disk_is_told_by_the_name_that_was_given():
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("this system has no /dev/full")
    for write in (write_json_lines, write_clip_table):
        with pytest.raises(OSError, match="/dev/full"):
            write(full, RECORDS)
