"""The survey of captures: what it counts, how it draws a sample, and what verdicts come to."""

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.atlas import (
    KINDS,
    VERDICTS,
    Find,
    Seen,
    look,
    main,
    precision,
    sample,
    table,
    wilson,
)
from benchmarks.blind_verdicts import agreed
from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import detect
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh

FIND = Find("a.bvh", "LeftArm", "counter-twist", 3, 5, 20.0, 0.9, False, True, "", (20.0, 20.0))


@pytest.fixture
def folder(tmp_path):
    """Two sets: one with an error in its clip, one whose only clip cannot be read."""
    (tmp_path / "good").mkdir()
    (tmp_path / "bad").mkdir()
    shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "good")
    (tmp_path / "bad" / "no.bvh").write_text("nothing\n")
    return tmp_path


def test_a_clip_that_fails_is_listed_and_stops_no_other(folder, capsys):
    output = folder / "found.json"
    assert main([str(folder), "--workers", "1", "--json", str(output)]) == 1
    told = capsys.readouterr()
    assert told.err.startswith("bad: ")
    assert "expected HIERARCHY" in told.err
    clips = {c["clip"]: c for c in json.loads(output.read_text())["clips"]}
    assert clips["no.bvh"]["problem"]
    assert not clips["walk_injected.bvh"]["problem"]
    assert "| good | 1 |" in told.out


def test_finds_are_those_of_the_detector():
    clip = ASSETS / "kick.bvh"  # flips, corrected unasked, and lone jumps, which are not
    found = [i for i in detect(read_bvh(clip)) if not i.kind.of_capture]
    finds = look(clip).finds
    assert [(f.chain, f.start, f.stop) for f in finds] == [
        (i.chain, i.start, i.stop) for i in found
    ]
    assert 0 < sum(f.applied for f in finds) == len(automatic_corrections(found)) < len(finds)
    assert all(len(f.offset) == f.stop - f.start for f in finds)


def test_an_hour_is_an_hour_of_capture():
    half = Seen("one", "a.bvh", frames=54_000, fps=30.0, chains=4, finds=(FIND, FIND))
    shown = replace(FIND, applied=False)
    rows = table([half, Seen("one", "b.bvh", problem="broken"), Seen("two", "c.bvh", 30, 30.0)])
    one = rows[0]
    assert (one["clips"], one["failed"], one["minutes"]) == (2, 1, 30.0)
    assert one["counter-twist an hour"] == 4.0
    assert rows[1]["no chain"] == 1
    assert rows[-1]["clips"] == 3
    assert table([replace(half, finds=(FIND, shown))])[0]["counter-twist applied"] == 1


def test_a_sample_takes_of_every_group_and_is_drawn_again_alike():
    many = tuple(replace(FIND, start=k) for k in range(50))
    rare = replace(FIND, kind="lone jump", applied=False)
    seen = [Seen("b", "a.bvh", finds=(*many, rare)), Seen("a", "a.bvh", finds=many[:2])]
    drawn = sample(seen, 10, seed=1)
    assert len(drawn) == len(set(drawn)) == 10
    assert [name for name, _ in drawn].count("a") == 2
    assert rare in [f for _, f in drawn]
    assert sample(reversed(seen), 10, seed=1) == drawn != sample(seen, 10, seed=2)
    assert len(sample(seen, 1000, seed=1)) == 53


def test_wilson_of_known_shares():
    assert wilson(9, 10) == pytest.approx((0.5958, 0.9821), abs=1e-3)  # Wilson 1927, as tabled
    assert wilson(0, 10)[0] == 0.0
    assert wilson(10, 10)[1] == 1.0
    assert wilson(0, 0) == (0.0, 1.0)


def test_verdicts_are_counted_by_kind():
    said = [("limb flip", "error")] * 3 + [("limb flip", "alarm"), ("lone jump", "doubtful")]
    rows = precision([{"kind": k, "verdict": v} for k, v in said], "kind")
    assert [(r["kind"], r["judged"], r["error"], r["alarm"]) for r in rows] == [
        ("limb flip", 4, 3, 1),
        ("lone jump", 1, 0, 0),
    ]
    assert rows[0]["errors %"] == 75.0
    assert rows[0]["from"] < 75.0 < rows[0]["to"]


@pytest.mark.thorough
def test_sheets_show_every_find_of_the_sample(folder, capsys):
    pictures = folder / "sheets"
    main([str(folder), "--workers", "1", "--pictures", str(pictures), "--most", "2"])
    assert (pictures / "0000.png").stat().st_size > 10_000
    with (pictures / "verdicts.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert 1 <= len(rows) <= 2
    assert {r["verdict"] for r in rows} == {""}
    assert all(r["set"] == "good" for r in rows)
    capsys.readouterr()


def test_the_tables_of_verdicts_are_whole():
    docs = Path(__file__).parents[2] / "docs"
    page = (docs / "atlas.md").read_text("utf-8")
    judged = {}
    for name in ("atlas-verdicts.csv", "atlas-blind.csv"):
        with (docs / name).open(encoding="utf-8", newline="") as file:
            judged[name] = list(csv.DictReader(file))
        assert {r["verdict"] for r in judged[name]} == set(VERDICTS)
        assert {r["kind"] for r in judged[name]} == set(KINDS) - {
            Kind.HELPER_ROLL,
            Kind.CARRIED_ROLL,
        }
    alone, blind = judged.values()
    for name in {r["picture"] for r in alone} - {""}:
        assert f"images/atlas-{name}.png" in page
        assert (docs / "images" / f"atlas-{name}.png").stat().st_size < 61_000
    assert all(r["verdict"] == agreed(r["first"], r["second"]) for r in blind)
    twists = [r for r in blind if r["kind"] == "counter-twist" and r["applied"] == "yes"]
    (row,) = precision(twists, "kind")
    counts = " | ".join(str(row[c]) for c in ("judged", *VERDICTS))
    assert f"| counter-twist, automatic | {counts} |" in page
