"""The table of odd files says what the reader does."""

import pytest

from benchmarks.odd_files import BEGIN, END, row, written_into
from tests.conftest import ASSETS

SMALL = b"""HIERARCHY
ROOT a { OFFSET 0 0 0 CHANNELS 3 Zrotation Xrotation Yrotation
JOINT a { OFFSET 0 1 0 CHANNELS 0 } }
MOTION
Frames: %d
Frame Time: .01
1 2 3
4 5 %s
"""


def test_a_clean_file_comes_back_whole():
    found = row(ASSETS / "walk.bvh")
    assert found.kept
    assert found.done == "read (344 frames, 31 joints, 10 chains)"


@pytest.mark.parametrize(
    ("count", "last", "done", "why"),
    [
        (2, b"6", "'a'", "names"),
        (2, b"nan", "line 8: ", "pose"),
        (3, b"6", "3 frames", "names"),
    ],
)
def test_what_is_odd_is_told_with_a_reason(tmp_path, count, last, done, why):
    path = tmp_path / "odd.bvh"
    path.write_bytes(SMALL % (count, last))
    found = row(path)
    assert done in found.done
    assert why in found.why


def test_the_table_replaces_the_one_before():
    rows = [row(ASSETS / "walk.bvh")]
    page = written_into(f"above\n{BEGIN}\nold\n{END}\nbelow\n", rows)
    assert "old" not in page
    assert page.startswith("above\n")
    assert page.endswith("below\n")
    assert "| `walk` |" in page
    assert written_into(page, rows) == page
    with pytest.raises(ValueError, match="marks"):
        written_into("no marks", rows)
