"""The report replaces its own files and nobody else's."""

import pytest

from tests.conftest import ASSETS
from twistcore.bvh import read_bvh
from twistcore.chain import find_chains
from twistcore.cli import main
from twistcore.errors import TwistError
from twistcore.export.report import Report, write_report
from twistcore.review import start_review

CLIP = read_bvh(ASSETS / "walk_injected.bvh")
CHAINS = find_chains(CLIP.motion)
STATE = start_review("consistency", {c.name: 0.1 for c in CHAINS}, [], [])
ENDINGS = ("report.html", "intervals.csv", "markers.py", "report.json")


def write(folder):
    return write_report(folder, Report(CLIP, CHAINS, STATE, CLIP.motion))


def test_its_own_files_are_replaced(tmp_path):
    first = write(tmp_path)
    assert [p.name for p in first] == [f"walk_injected.{e}" for e in ENDINGS]
    first[0].unlink()
    assert write(tmp_path) == first
    assert first[0].exists()


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("after", [False, True])
def test_a_file_of_somebody_else_is_not(tmp_path, ending, after):
    """There before, or changed since by whoever makes notes in the table."""
    if after:
        write(tmp_path)
    path = tmp_path / f"walk_injected.{ending}"
    path.write_bytes(b"my own notes")
    before = {p: p.read_bytes() for p in tmp_path.iterdir()}
    with pytest.raises(TwistError, match="without the report"):
        write(tmp_path)
    assert {p: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_refine_says_so_before_it_writes_anything(tmp_path, capsys):
    (tmp_path / "walk_injected.intervals.csv").write_text("mine")
    out = tmp_path / "out.bvh"
    words = ["refine", str(CLIP.path), "-o", str(out), "--report", str(tmp_path)]
    assert main(words) == 2
    assert "walk_injected.intervals.csv" in capsys.readouterr().err
    assert not out.exists()
